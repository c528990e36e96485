// SPDX-License-Identifier: Apache-2.0
// Items come from macros, one of them in an include file.
#version 3.7;
global_settings { assumed_gamma 2.2 }
#include "items.inc"
#macro Pick(A, B, UseA) (UseA ? A : B) #end
camera {
    Place(Pick(<0, 1, -6>, <0, 0, 0>, true), <0, 1, 0>)
    angle Pick(30, 60, false)
    right x*4/3
    Lens(0.2)
}
#include "world.inc"
