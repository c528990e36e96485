// SPDX-License-Identifier: Apache-2.0
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0, 0, -10> direction z*1.2 right x*4/3 up y
         aperture 2 focal_point <0, 0, 0> blur_samples 64 variance 0 confidence 0.9999 }
#macro Flat(C) pigment { C } finish { ambient 1 diffuse 0 } #end
/* The plane in focus. */
plane { z, 0 pigment { checker rgb <0.9, 0.6, 0.2> rgb <0.1, 0.15, 0.4> scale 0.5 }
        finish { ambient 1 diffuse 0 }
        clipped_by { box { <-4, -3.4, -1>, <4, 3.4, 1> } } }
/* Behind it, seen beside it, and before it. */
plane { z, 10 pigment { checker rgb 0.8 rgb 0.3 scale 2 } finish { ambient 1 diffuse 0 } }
sphere { <1.2, 0.8, -4>, 0.5 pigment { rgb <0.8, 0.1, 0.1> } finish { ambient 1 diffuse 0 } }
