// SPDX-License-Identifier: Apache-2.0
// A camera that passes thin things; lamps behind them; the focus between.
#version 3.7;
global_settings { assumed_gamma 1.0 }
#declare T = clock;
camera {
  perspective location <-0.25 + 0.5*T, 1, 0> direction z up y right 16/9*x
  look_at <-0.25 + 0.5*T + 0.15*(T-0.5), 1, 4> angle 44
  aperture 0.36 focal_point <-0.25 + 0.5*T, 1, 4>
}
light_source { <-4, 8, -3> rgb 1.2 }
background { rgb 0.15 }
// wall with fine pattern, far
plane { z, 11 pigment { checker rgb <0.75,0.6,0.4> rgb <0.15,0.25,0.4> scale 0.55 rotate 12*z } finish { ambient 0.25 diffuse 0.7 } }
plane { y, 0 pigment { checker rgb 0.7 rgb 0.25 scale 0.5 } finish { ambient 0.2 diffuse 0.7 } }
// things in focus
#declare R1 = seed(7);
#for (I, 0, 6)
  box { <-0.22,0,-0.22>, <0.22, 0.7+0.8*rand(R1), 0.22> rotate 40*I*y translate <-1.8+0.6*I, 0, 3.8+0.5*rand(R1)>
    pigment { gradient <1,1,0> color_map { [0 rgb <0.8,0.3,0.2>] [0.5 rgb <0.8,0.3,0.2>] [0.5 rgb <0.9,0.85,0.7>] [1 rgb <0.9,0.85,0.7>] } scale 0.15 } finish { ambient 0.2 diffuse 0.7 } }
#end
// lamps before the wall
#declare R2 = seed(3);
#for (I, 0, 15)
  sphere { <-4+8*rand(R2), 0.4+2.4*rand(R2), 9.5+rand(R2)>, 0.035 pigment { rgb <40+40*rand(R2),40+20*rand(R2),30> } finish { ambient 1 diffuse 0 } }
#end
// thin things, near
#declare R3 = seed(11);
#for (I, 0, 13)
  cylinder { <0,-1,0>, <0.5*(rand(R3)-0.5),3,0.3*(rand(R3)-0.5)>, 0.006+0.008*rand(R3) translate <-1.3+0.2*I+0.08*rand(R3),0,1.4+0.5*rand(R3)>
   pigment { rgb <0.1,0.3,0.1>+0.2*rand(R3) } finish { ambient 0.3 diffuse 0.6 } }
#end
