// The shapes that bases.py takes from Gmsh: -setstring shape NAME.
SetFactory("OpenCASCADE");
DefineConstant[ shape = {"hole", Name "shape"} ];

// A bar with a hole through it.
If (StrCmp(shape, "hole") == 0)
  DefineConstant[ h = {0.075, Name "element size"} ];
  Box(1) = {-1, -0.5, -0.3, 2, 1, 0.6};
  Cylinder(2) = {0, 0, -1, 0, 0, 2, 0.22};
  BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
EndIf

// An L-shaped solid.
If (StrCmp(shape, "angle") == 0)
  DefineConstant[ h = {0.09, Name "element size"} ];
  Box(1) = {0, 0, 0, 2, 0.8, 0.7};
  Box(2) = {0, 0, 0, 0.8, 2, 0.7};
  BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
EndIf

// What lies between two spheres of one centre.
If (StrCmp(shape, "shell") == 0)
  DefineConstant[ h = {0.115, Name "element size"} ];
  Sphere(1) = {0, 0, 0, 1};
  Sphere(2) = {0, 0, 0, 0.45};
  BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
EndIf

// A long thin bar, 1 : 50.
If (StrCmp(shape, "bar") == 0)
  DefineConstant[ h = {0.26, Name "element size"} ];
  Box(1) = {0, 0, 0, 50, 1, 1};
EndIf

// A cube whose elements shrink 1 : 10^4 towards a corner.
If (StrCmp(shape, "graded") == 0)
  DefineConstant[ h = {0.17, Name "element size over distance"} ];
  Box(1) = {0, 0, 0, 1, 1, 1};
  Field[1] = MathEval;
  Field[1].F = Sprintf("%g * (1e-4 + sqrt(x^2 + y^2 + z^2))", h);
  Background Field = 1;
EndIf

// What lies between two circles of one centre.
If (StrCmp(shape, "ring") == 0)
  DefineConstant[ h = {0.03, Name "element size"} ];
  Disk(1) = {0, 0, 0, 1};
  Disk(2) = {0, 0, 0, 0.4};
  BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
EndIf

// An L-shaped surface.
If (StrCmp(shape, "corner") == 0)
  DefineConstant[ h = {0.03, Name "element size"} ];
  Rectangle(1) = {0, 0, 0, 2, 0.8};
  Rectangle(2) = {0, 0, 0, 0.8, 2};
  BooleanUnion(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
EndIf

// A square whose triangles shrink 1 : 10^4 towards a corner.
If (StrCmp(shape, "square") == 0)
  DefineConstant[ h = {0.06, Name "element size over distance"} ];
  Rectangle(1) = {0, 0, 0, 1, 1};
  Field[1] = MathEval;
  Field[1].F = Sprintf("%g * (1e-4 + sqrt(x^2 + y^2))", h);
  Background Field = 1;
EndIf

// A long strip, 1 : 50.
If (StrCmp(shape, "strip") == 0)
  DefineConstant[ h = {0.13, Name "element size"} ];
  Rectangle(1) = {0, 0, 0, 50, 1};
EndIf

// Elements of one size, or of that of the field.
If (StrCmp(shape, "graded") == 0 || StrCmp(shape, "square") == 0)
  Mesh.MeshSizeExtendFromBoundary = 0;
  Mesh.MeshSizeFromPoints = 0;
Else
  Mesh.MeshSizeMin = h;
  Mesh.MeshSizeMax = h;
EndIf
If (StrCmp(shape, "ring") == 0 || StrCmp(shape, "corner") == 0 || StrCmp(shape, "square") == 0 ||
    StrCmp(shape, "strip") == 0)
  Mesh.Algorithm = 5; // Delaunay: irregular
EndIf
