// SPDX-License-Identifier: Apache-2.0
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera {
    orthographic location <0, 4, -3> look_at 0 angle 53.13010235415598
    right x*4/3 up y aperture 0.3 focal_point 0
}
#include "world.inc"
