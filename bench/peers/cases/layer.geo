// SPDX-License-Identifier: Apache-2.0
// A block (region 1) under a coat (region 2) of two layers of elements, each 20 times as wide as thick. The three planes of
// the coat are triangulated by three algorithms, so that no vertex stands above another one.
SetFactory("OpenCASCADE");
width = 0.025;
thick = width / 20;
Box(1) = {0, 0, -0.3, 1, 1, 0.3};
Box(2) = {0, 0, 0, 1, 1, thick};
Box(3) = {0, 0, thick, 1, 1, thick};
BooleanFragments{ Volume{1, 2, 3}; Delete; }{}

eps = 1e-4;
top() = Surface In BoundingBox{-eps, -eps, 2 * thick - eps, 1 + eps, 1 + eps, 2 * thick + eps};
middle() = Surface In BoundingBox{-eps, -eps, thick - eps, 1 + eps, 1 + eps, thick + eps};
interface() = Surface In BoundingBox{-eps, -eps, -eps, 1 + eps, 1 + eps, eps};
MeshAlgorithm Surface{ top() } = 5;
MeshAlgorithm Surface{ middle() } = 1;
MeshAlgorithm Surface{ interface() } = 6;
Physical Volume(1) = {1};
Physical Volume(2) = {2, 3};
all() = Surface{:};
all() -= middle();
Physical Surface(1) = { all() };

Mesh.MeshSizeMin = width;
Mesh.MeshSizeMax = width;
Mesh.Optimize = 0;
Mesh.SaveElementTagType = 2;
