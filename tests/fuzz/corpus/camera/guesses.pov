// SPDX-License-Identifier: Apache-2.0
// Declared cameras that go through a macro's parameter and an array.
#version 3.7;
global_settings { assumed_gamma 1.0 }
#declare Views = array[3];
#declare Views[0] = camera { location <0, 1, -5> look_at y aperture 0.1 focal_point y }
#declare Views[1] = camera { location <4, 1, -5> look_at y aperture 0.2 focal_point y }
#declare Views[2] = camera { fisheye location <9, 1, -5> look_at y }
#macro Use(View) camera { View translate 0.5*y } #end
Use(Views[1])
#include "world.inc"
