// SPDX-License-Identifier: Apache-2.0
// The camera is in a file that another file includes; the clock moves it.
#version 3.7;
global_settings { assumed_gamma 1.8 }
#default { pigment { gradient y scale 3 rotate 20 } finish { ambient 0.5 } }
#include "outer.inc"
