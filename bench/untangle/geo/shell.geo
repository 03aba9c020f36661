// What lies between two spheres of one centre.
SetFactory("OpenCASCADE");
DefineConstant[ h = {0.115, Name "element size"} ];
Sphere(1) = {0, 0, 0, 1};
Sphere(2) = {0, 0, 0, 0.45};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
