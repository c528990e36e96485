#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0, 1, -6> look_at <0, 1, 0>
  aperture 0.5 focal_point <0, 1, 0> blur_samples 10
  bokeh { pigment { planar } } }
sphere { <0, 1, 0>, 1 pigment { rgb 1 } }
