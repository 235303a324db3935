// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "plugin.hpp"

namespace tetune::plugin {

/// Pieces of a file repeat the points where they meet.
enum class Pieces { one, several };

/// Points of several pieces at the same position are merged.
TetMesh from_grid(vtkUnstructuredGrid* grid, Pieces pieces, Warnings& warnings);
vtkSmartPointer<vtkUnstructuredGrid> to_grid(TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
