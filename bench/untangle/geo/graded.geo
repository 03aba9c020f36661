// A cube whose elements shrink 1 : 10^4 towards a corner.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.17, Name "element size over distance"} ];
Box(1) = {0, 0, 0, 1, 1, 1};
Field[1] = MathEval;
Field[1].F = Sprintf("%g * (1e-4 + sqrt(x^2 + y^2 + z^2))", h);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
