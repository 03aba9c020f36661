// An L-shaped solid.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.09, Name "element size"} ];
Box(1) = {0, 0, 0, 2, 0.8, 0.7};
Box(2) = {0, 0, 0, 0.8, 2, 0.7};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
