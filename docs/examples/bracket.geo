// The sample mesh: an angle bracket with four bolt holes, a pin bore and a stiffening rib.
//   gmsh -3 bracket.geo -format msh41 -o bracket.msh
// Gmsh's optimisation is off, so that the slivers of the Delaunay mesh stay in;
// -setnumber optimise 1 switches it on.
SetFactory("OpenCASCADE");
DefineConstant[ h = {4, Name "element size [mm]"},
                optimise = {0, Choices{0, 1}, Name "mesh optimisation"} ];

Box(1) = {0, 0, 0, 60, 40, 12};                      // base plate
Box(2) = {0, 0, 0, 12, 40, 50};                      // wall
Point(101) = {12, 15, 12, h};
Point(102) = {34, 15, 12, h};
Point(103) = {12, 15, 34, h};
Line(101) = {101, 102};
Line(102) = {102, 103};
Line(103) = {103, 101};
Curve Loop(101) = {101, 102, 103};
Plane Surface(101) = {101};
rib[] = Extrude {0, 10, 0} { Surface{101}; };        // rib between plate and wall
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2, rib[1]}; Delete; };

Cylinder(20) = {46, 9, -1, 0, 0, 14, 4};             // bolt holes of the plate
Cylinder(21) = {46, 31, -1, 0, 0, 14, 4};
Cylinder(22) = {-1, 9, 40, 14, 0, 0, 3.5};           // bolt holes of the wall
Cylinder(23) = {-1, 31, 40, 14, 0, 0, 3.5};
Cylinder(24) = {22, -1, 6, 0, 42, 0, 3};             // pin bore along the plate
BooleanDifference(30) = { Volume{10}; Delete; }{ Volume{20:24}; Delete; };

Physical Volume("bracket") = {30};
Physical Surface("skin") = Surface{:};

Mesh.Optimize = optimise;
Mesh.OptimizeNetgen = 0;
Mesh.MeshSizeMin = 0.6 * h;
Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 14;
