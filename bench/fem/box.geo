// A cube, meshed well by Gmsh; bench/fem/run then spoils its inside.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.045, Name "element size"} ];
Box(1) = {0, 0, 0, 1, 1, 1};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
