// A square with a round hole: triangles in the plane.
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 2, 1};
Disk(2) = {0.7, 0.5, 0, 0.2};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Physical Surface("plate") = {3};
Physical Curve("edge") = Curve{:};
Mesh.Algorithm = 5;
Mesh.Smoothing = 0;
Mesh.MeshSizeMin = 0.12;
Mesh.MeshSizeMax = 0.12;
