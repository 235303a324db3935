// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "plugin.hpp"

namespace tetune::plugin {

TetMesh from_grid(vtkUnstructuredGrid* grid, Warnings& warnings);
/// Merges points at the same position, as the parts of a file have.
void merge_points(TetMesh& mesh);
vtkSmartPointer<vtkUnstructuredGrid> to_grid(TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
