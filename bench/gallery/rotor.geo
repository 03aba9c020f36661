// A rotor with three blades in a round housing.
//   gmsh -2 rotor.geo -format msh41 -o rotor.msh
SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 1};
Disk(2) = {0, 0, 0, 0.18};
For i In {0:2}
  Disk(3 + i) = {0.42, 0, 0, 0.36, 0.06};
  Rotate {{0, 0, 1}, {0, 0, 0}, 2 * Pi * i / 3 + 0.3} { Surface{3 + i}; }
EndFor
BooleanUnion(10) = { Surface{2}; Delete; }{ Surface{3:5}; Delete; };
BooleanDifference(11) = { Surface{1}; Delete; }{ Surface{10}; Delete; };
Mesh.MeshSizeMin = 0.025;
Mesh.MeshSizeMax = 0.07;
Mesh.MeshSizeFromCurvature = 24;
