// SPDX-License-Identifier: Apache-2.0
#version 3.7;
global_settings { assumed_gamma 1.0 }
sphere { z*5, 1 pigment { rgb 1 } finish { emission 1 } }
