// The plate with holes, as a slab of prisms; with Mesh.SubdivisionAlgorithm 2 each becomes six hexahedra.
//   gmsh -3 slab.geo -setnumber Mesh.SubdivisionAlgorithm 2 -format mesh -o slab.mesh
Include "../plate.geo";
DefineConstant[ layers = {8, Name "layers of prisms"} ];
Physical Surface("plate") -= {5};
Physical Curve("rim") -= {Curve{:}};
slab[] = Extrude {0, 0, 3} { Surface{5}; Layers{layers}; Recombine; };
Physical Volume("slab") = {slab[1]};
