// A cube of two regions, with a coarse mesh that is not optimised.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Box(2) = {0, 0, 0.5, 1, 1, 0.5};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("lower part") = {1};
Physical Volume("upper part") = {2};
Physical Surface("skin") = Surface{:};
Mesh.Optimize = 0;
Mesh.OptimizeNetgen = 0;
Mesh.MeshSizeMin = 0.28;
Mesh.MeshSizeMax = 0.28;
Mesh.SaveAll = 0;
