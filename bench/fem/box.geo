// A cube, meshed well by Gmsh; bench/fem/run then spoils its inside. bench/optimised/run takes it as it is.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.045, Name "element size"} ];
Box(1) = {0, 0, 0, 1, 1, 1};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
