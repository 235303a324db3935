// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

#include "plugin.hpp"

namespace tetune::plugin {

/// All tuples of a VTK array, in its own type.
DataArray from_vtk(vtkDataArray* array);
/// The entries of `array` at `positions`.
DataArray entries(const DataArray& array, const std::vector<vtkIdType>& positions);
vtkSmartPointer<vtkDataArray> to_vtk(const DataArray& array);

/// Moves the first array with a name under which programs store tags out of `data`; empty where none holds integers of
/// 32 bits.
std::vector<int> take_tags(std::vector<DataArray>& data, std::string& name, Warnings& warnings);

/// Erases the array of this name; returns the positions of its entries that are not 0.
std::vector<vtkIdType> take_flags(std::vector<DataArray>& data, const std::string& name);

/// Returns all arrays of numbers; warns of others.
std::vector<DataArray> arrays_of(vtkDataSetAttributes* attributes, const char* where, Warnings& warnings);

}  // namespace tetune::plugin
