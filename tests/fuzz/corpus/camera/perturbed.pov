// SPDX-License-Identifier: Apache-2.0
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 1, -5> look_at 0 aperture 1 focal_point 0 normal { bumps 0.2 } }
#include "world.inc"
