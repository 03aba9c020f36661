// A long strip, 1 : 50.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.13, Name "element size"} ];
Rectangle(1) = {0, 0, 0, 50, 1};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.Algorithm = 5; // Delaunay: irregular
