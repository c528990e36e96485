#version 3.7;
// A camera that POV-Ray writes to a file, and reads.
global_settings { assumed_gamma 1 }
#include "strings.inc"
Parse_String("camera { location <0, 2, -6> look_at y angle 50 aperture 0.4 }")
light_source { <5, 9, -9> rgb 1 }
sphere { <0, 1, 0>, 1 pigment { rgb x } }
