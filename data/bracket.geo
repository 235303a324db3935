// SPDX-License-Identifier: Apache-2.0
// A bearing bracket of two materials: a foot with four screw holes, a rib, and a boss with a bushing pressed in.
// Unoptimised on purpose: it is what tetune is shown on.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 80, 50, 8};            // foot
Box(2) = {10, 21, 8, 60, 8, 24};          // rib
Cylinder(3) = {40, 5, 34, 0, 40, 0, 16};  // boss
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Cylinder(11) = {10, 10, -1, 0, 0, 10, 4};
Cylinder(12) = {70, 10, -1, 0, 0, 10, 4};
Cylinder(13) = {10, 40, -1, 0, 0, 10, 4};
Cylinder(14) = {70, 40, -1, 0, 0, 10, 4};
Cylinder(15) = {40, 4, 34, 0, 42, 0, 6};  // bore
BooleanDifference(20) = { Volume{4}; Delete; }{ Volume{11, 12, 13, 14, 15}; Delete; };
Cylinder(31) = {40, 5, 34, 0, 40, 0, 9};
Cylinder(32) = {40, 4, 34, 0, 42, 0, 6};
BooleanDifference(30) = { Volume{31}; Delete; }{ Volume{32}; Delete; };  // bushing
BooleanFragments{ Volume{20}; Delete; }{ Volume{30}; Delete; }
Mesh.MeshSizeMax = 2.1;
Mesh.MeshSizeMin = 1;
Mesh.MeshSizeFromCurvature = 18;
Mesh.Algorithm = 6;
Mesh.Algorithm3D = 1;
Mesh.Optimize = 0;
Mesh.SaveAll = 1;
