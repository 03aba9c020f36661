// Between two spheres: layers of prisms on the inner one, tetrahedra outside, not optimised.
//   gmsh -3 layers.geo -format msh41 -o layers.msh
Macro Ball // of radius r and element size h: surfaces s[]
  p = newp;
  Point(p) = {0, 0, 0, h};
  Point(p + 1) = {r, 0, 0, h};
  Point(p + 2) = {0, r, 0, h};
  Point(p + 3) = {-r, 0, 0, h};
  Point(p + 4) = {0, -r, 0, h};
  Point(p + 5) = {0, 0, r, h};
  Point(p + 6) = {0, 0, -r, h};
  s[] = {};
  c = newc;
  For i In {0:3} // quarters of the equator, then those to both poles
    Circle(c + i) = {p + 1 + i, p, p + 1 + (i + 1) % 4};
    Circle(c + 4 + i) = {p + 1 + i, p, p + 5};
    Circle(c + 8 + i) = {p + 1 + i, p, p + 6};
  EndFor
  For i In {0:3}
    j = (i + 1) % 4;
    l = newll;
    Curve Loop(l) = {c + i, c + 4 + j, -(c + 4 + i)};
    Curve Loop(l + 1) = {c + 8 + i, -(c + 8 + j), -(c + i)};
    n = news;
    Surface(n) = {l};
    Surface(n + 1) = {l + 1};
    s[] += {n, n + 1};
  EndFor
Return

r = 1; h = 0.2;
Call Ball;
layers[] = Extrude { Surface{s[]}; Layers{ {1, 1, 1, 1, 1}, {0.02, 0.05, 0.1, 0.18, 0.3} }; Using Index[0]; Recombine; };
inner[] = {};
For i In {0:7}
  inner[] += layers[5 * i];
EndFor
r = 2.4; h = 0.5;
Call Ball;
Surface Loop(1001) = {s[]};
Surface Loop(1002) = {inner[]};
Volume(1003) = {1001, 1002};
Mesh.Optimize = 0;
Mesh.OptimizeNetgen = 0;
