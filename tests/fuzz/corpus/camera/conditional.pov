// SPDX-License-Identifier: Apache-2.0
// The camera inside #if, with braces in both branches and words in odd places.
#version 3.7;
global_settings { assumed_gamma 1.0 }
#declare Text = "camera { location <9,9,9> } \" // not a comment /* ";
/* camera { location <8,8,8> } /* nested */ camera { fisheye } */
#declare Wide = yes;
#if (Wide)
camera { // camera { in a comment }
    location /* odd */ <1, 2, -8> // location <7,7,7>
    #if (Wide & strlen(Text) > 3) look_at <0, 1, 0> angle 40 #else look_at <5, 5, 5> } #end
    aperture #if (Wide) 0.4 #else 0.1 #end
    focal_point <1, 2, -8> + vnormalize(<0, 1, 0> - <1, 2, -8>) * 5
    right x*image_width/image_height
    blur_samples 7, 20
#else
camera { fisheye angle 100
#end
}
#include "world.inc"
