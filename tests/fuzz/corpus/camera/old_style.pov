// SPDX-License-Identifier: Apache-2.0
// Before 3.5 items take effect in their order; nothing says assumed_gamma.
#version 3.1
#declare Away = 7
camera {
    location <0, 2, -Away>
    angle 90
    right <2, 0, 0>
    focal_point <0, 2, -2> aperture 0.4 blur_samples 20
    translate <0, 1, 0>
}
#declare Ball = sphere { <0, 1, 0>, 1 pigment { color red 1 green 0.3 } }
object { Ball }
plane { y, 0 pigment { checker color rgb 1 color rgb 0.2 } }
light_source { <20, 30, -20> color rgb 1 }
