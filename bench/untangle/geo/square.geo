// A square whose triangles shrink 1 : 10^4 towards a corner.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.06, Name "element size over distance"} ];
Rectangle(1) = {0, 0, 0, 1, 1};
Field[1] = MathEval;
Field[1].F = Sprintf("%g * (1e-4 + sqrt(x^2 + y^2))", h);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 5; // Delaunay: irregular
