// SPDX-License-Identifier: Apache-2.0
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { fisheye location <0, 1, -5> look_at 0 angle 120 aperture 1 focal_point 0 }
#include "world.inc"
