// What lies between two circles of one centre.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.03, Name "element size"} ];
Disk(1) = {0, 0, 0, 1};
Disk(2) = {0, 0, 0, 0.4};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.Algorithm = 5; // Delaunay: irregular
