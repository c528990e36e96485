// SPDX-License-Identifier: Apache-2.0
#version 3.7;
#warning "this comes before"
camera { location <0, 0, -5> look_at 0 aperture 1 focal_point 0 }
sphere { 0, 1 pigment { image_map { png "lost.png" } } }
