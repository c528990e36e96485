#version 3.7;
// Cameras that are written out in an array.
global_settings { assumed_gamma 1 }
#declare Views = array[2][1] { // of two
  { camera { location <0, 1, -6> look_at <0, 1, 0> angle 50
      aperture 0.2 focal_point <0, 1, 0> blur_samples 10 } },
  { camera { location <2, 1, -6> look_at <0, 1, 0> angle 40 // the one that is used
      aperture 0.4 focal_point <0, 1, 1> blur_samples 10 translate y } }
};
camera { Views[1][0] }
light_source { <5, 9, -9> rgb 1 }
sphere { <0, 1, 0>, 1 pigment { rgb x } }
