// An L-shaped surface.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.03, Name "element size"} ];
Rectangle(1) = {0, 0, 0, 2, 0.8};
Rectangle(2) = {0, 0, 0, 0.8, 2};
BooleanUnion(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.Algorithm = 5; // Delaunay: irregular
