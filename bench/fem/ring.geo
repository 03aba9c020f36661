// The surface of a torus; TetGen fills it and leaves slivers inside.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.08, Name "element size"} ];
Torus(1) = {0, 0, 0, 1, 0.4};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
