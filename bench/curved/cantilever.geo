SetFactory("OpenCASCADE");
// A round beam, 40 mm long and 10 mm thick, on a flange, with a fillet of 3 mm between them
DefineConstant[Size = 4, Fine = 0];
Cylinder(1) = {0, 0, 0, 8, 0, 0, 12}; Cylinder(2) = {8, 0, 0, 40, 0, 0, 5};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
root() = Curve In BoundingBox {7.99, -5.01, -5.01, 8.01, 5.01, 5.01};
f() = Fillet{3}{root()}{3};
Physical Volume("BEAM", 1) = {f()};
Physical Surface("FIXED", 2) = {Surface In BoundingBox {-0.01, -12.01, -12.01, 0.01, 12.01, 12.01}};
Physical Surface("TIP", 3) = {Surface In BoundingBox {47.99, -5.01, -5.01, 48.01, 5.01, 5.01}};
Mesh.MeshSizeMax = Size; Mesh.MeshSizeMin = Fine ? Size / 4 : Size; Mesh.MeshSizeFromCurvature = Fine ? 36 : 0;
Mesh.ElementOrder = 2; Mesh.HighOrderOptimize = 0; Mesh.Optimize = Fine;
