// A long thin bar, 1 : 50.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.26, Name "element size"} ];
Box(1) = {0, 0, 0, 50, 1, 1};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
