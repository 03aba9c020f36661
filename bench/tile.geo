// A cube of side 1, as Gmsh's Delaunay leaves it: bench/tiles makes large boxes of it.
//   gmsh -3 tile.geo -format msh41 -o tile.msh
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.0365, Name "element size"} ]; // about 100 000 tetrahedra
Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("box") = {1};
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.Optimize = 0;
Mesh.OptimizeNetgen = 0;
