// A plate with three holes, for bench/badness and bench/untangle.
//   gmsh -2 plate.geo -format msh41 -o plate.msh
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.9, Name "element size"} ];
Rectangle(1) = {0, 0, 0, 16, 10};
Disk(2) = {4, 6.4, 0, 1.8};
Disk(3) = {8.2, 3.2, 0, 1.2};
Disk(4) = {12.2, 6.2, 0, 2.2};
BooleanDifference(5) = { Surface{1}; Delete; }{ Surface{2:4}; Delete; };
Physical Surface("plate") = {5};
Physical Curve("rim") = Curve{:};
Mesh.MeshSizeMin = 0.45 * h;
Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 16;
