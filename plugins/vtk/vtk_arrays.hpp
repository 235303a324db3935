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

std::size_t length(const DataArray& array);

/// Takes the array with the first of the names under which programs store tags out of `data`; empty when there is none
/// that holds whole numbers of 32 bits.
std::vector<int> take_tags(std::vector<DataArray>& data, std::string& name, Warnings& warnings);

/// Takes the array of this name out and lists the entries that are not 0.
std::vector<vtkIdType> take_flags(std::vector<DataArray>& data, const std::string& name);

/// All arrays of numbers; other ones are named in a warning.
std::vector<DataArray> arrays_of(vtkDataSetAttributes* attributes, const char* where, Warnings& warnings);

}  // namespace tetune::plugin
