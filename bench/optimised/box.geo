// A cube, for bench/optimised/run.
SetFactory("OpenCASCADE");
DefineConstant[ h = 0.1 ];
Box(1) = {0, 0, 0, 1, 1, 1};
Mesh.MeshSizeMax = h;
