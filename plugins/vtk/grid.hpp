// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "plugin.hpp"

namespace tetune::plugin {

TetMesh from_grid(vtkUnstructuredGrid* grid, Warnings& warnings);
/// Of points in the very same place, one takes the elements of all: the parts of a file each have their own.
void merge_points(TetMesh& mesh);
vtkSmartPointer<vtkUnstructuredGrid> to_grid(TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
