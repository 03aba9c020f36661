// A bar with a hole through it.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.075, Name "element size"} ];
Box(1) = {-1, -0.5, -0.3, 2, 1, 0.6};
Cylinder(2) = {0, 0, -1, 0, 0, 2, 0.22};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
