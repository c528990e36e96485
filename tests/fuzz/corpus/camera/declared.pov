// SPDX-License-Identifier: Apache-2.0
// A declared camera, used with transformations; an earlier camera loses.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <50, 50, 50> look_at 0 }
#declare Turn = transform { rotate y*90 translate <0, 1, 0> }
#declare First = camera {
    location <0, 0, -10> right x*4/3 angle 30
    aperture 0.5 focal_point <0, 0, -2> blur_samples 10
}
#declare Second = camera { location <3, 3, 3> }
camera { First transform Turn rotate <0, 0, 10> matrix <1,0,0, 0,1,0, 0,0,1, 0.5,0,0> }
#include "world.inc"
