// SPDX-License-Identifier: Apache-2.0
// No #version at all, and the syntax of old.
camera {
   location  <0, 1, -5>
   direction <0, 0,  2>
   up        <0, 1,  0>
   right   <1.3333, 0,  0>
   look_at <0 1 0>
   aperture 0.4 blur_samples 10
   focal_point <0, 1,0>
}
light_source{<3,9,-5> color red 1 green 1 blue 1}
sphere{<0 1 0> 1 pigment{color red 1}}
