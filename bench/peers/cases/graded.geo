// SPDX-License-Identifier: Apache-2.0
// A block around a small spherical cavity, with elements 200 times as small there as at its corners.
SetFactory("OpenCASCADE");
radius = 0.006;
Box(1) = {-0.5, -0.5, -0.5, 1, 1, 1};
Sphere(2) = {0, 0, 0, radius};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Physical Volume(1) = {3};
Physical Surface(1) = Boundary{ Volume{3}; };

Field[1] = MathEval;
Field[1].F = Sprintf("0.001 + 0.18 * (sqrt(x * x + y * y + z * z) - %g)", radius);
Background Field = 1;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 5;
Mesh.Optimize = 0;
Mesh.SaveElementTagType = 2;
