// SPDX-License-Identifier: Apache-2.0
#include "vtk_arrays.hpp"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkSetGet.h>
#include <vtkStringArray.h>
#include <vtkType.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "mesh/whole_number.hpp"

namespace tetune::plugin {
namespace {

template <class T, class From>
std::vector<T> values_of(vtkDataArray* array) {
  std::vector<T> values(std::size_t(array->GetNumberOfValues()), T{});
  const auto* from = static_cast<const From*>(array->GetVoidPointer(0));
  std::transform(from, from + values.size(), values.begin(), [](From x) { return static_cast<T>(x); });
  return values;
}

/// Converts to the type of numbers of the same width and sign.
template <class From>
DataValues numbers_of(vtkDataArray* array) {
  if constexpr (std::is_floating_point_v<From>) {
    return values_of<From, From>(array);
  } else if constexpr (std::is_signed_v<From>) {
    if constexpr (sizeof(From) == 1) return values_of<std::int8_t, From>(array);
    if constexpr (sizeof(From) == 2) return values_of<std::int16_t, From>(array);
    if constexpr (sizeof(From) == 4) return values_of<std::int32_t, From>(array);
    if constexpr (sizeof(From) == 8) return values_of<std::int64_t, From>(array);
  } else {
    if constexpr (sizeof(From) == 1) return values_of<std::uint8_t, From>(array);
    if constexpr (sizeof(From) == 2) return values_of<std::uint16_t, From>(array);
    if constexpr (sizeof(From) == 4) return values_of<std::uint32_t, From>(array);
    if constexpr (sizeof(From) == 8) return values_of<std::uint64_t, From>(array);
  }
}

DataValues bits_of(vtkDataArray* array) {
  std::vector<std::uint8_t> values;
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c) {
      values.push_back(array->GetComponent(i, c) != 0 ? 1 : 0);
    }
  }
  return values;
}

/// The names under which meshio, Gmsh, the Python packages of TetGen and Mmg, and Mmg keep tags, in order of
/// preference.
constexpr std::array kTagNames{"medit:ref", "gmsh:physical", "tetgen:ref", "refs", "gmsh:geometrical"};

auto find(std::vector<DataArray>& data, const std::string& name) {
  return std::find_if(data.begin(), data.end(), [&name](const DataArray& a) { return a.name == name; });
}

}  // namespace

DataArray from_vtk(vtkDataArray* array) {
  DataArray result;
  result.name = array->GetName() != nullptr ? array->GetName() : "";
  result.components = array->GetNumberOfComponents();
  switch (array->GetDataType()) {
    vtkTemplateMacro(result.values = numbers_of<VTK_TT>(array));
    case VTK_BIT:
      result.values = bits_of(array);
      break;
    default:
      throw FileError("the data \"" + result.name + "\" is of type " + array->GetDataTypeAsString() +
                      ", which tetune does not read");
  }
  return result;
}

DataArray entries(const DataArray& array, const std::vector<vtkIdType>& positions) {
  DataArray result{array.name, array.components, {}};
  const std::size_t each = components_of(array);
  std::visit(
      [&](const auto& from) {
        std::remove_cvref_t<decltype(from)> to;
        to.reserve(positions.size() * each);
        for (const vtkIdType p : positions) {
          const auto entry = entry_of(from, p, each);
          to.insert(to.end(), entry.begin(), entry.end());
        }
        result.values = std::move(to);
      },
      array.values);
  return result;
}

vtkSmartPointer<vtkDataArray> to_vtk(const DataArray& array) {
  return std::visit(
      [&](const auto& values) -> vtkSmartPointer<vtkDataArray> {
        using T = typename std::remove_cvref_t<decltype(values)>::value_type;
        vtkSmartPointer<vtkDataArray> out;
        out.TakeReference(vtkDataArray::CreateDataArray(vtkTypeTraits<T>::VTK_TYPE_ID));
        out->SetName(array.name.c_str());
        out->SetNumberOfComponents(array.components);
        out->SetNumberOfTuples(std::ssize(values) / array.components);
        std::copy(values.begin(), values.end(), static_cast<T*>(out->GetVoidPointer(0)));
        return out;
      },
      array.values);
}

std::vector<int> take_tags(std::vector<DataArray>& data, std::string& name, Warnings& warnings) {
  for (const char* candidate : kTagNames) {
    const auto at = find(data, candidate);
    if (at == data.end()) continue;
    std::vector<int> tags;
    const bool whole = at->components == 1 && std::visit(
                                                  [&tags](const auto& values) {
                                                    for (const auto v : values) {
                                                      const std::optional<int> tag = whole_number(double(v));
                                                      if (!tag) return false;
                                                      tags.push_back(*tag);
                                                    }
                                                    return true;
                                                  },
                                                  at->values);
    if (!whole) {
      warnings.push_back("\"" + at->name + "\" does not hold integers of 32 bits: kept as data, not as tags");
      continue;
    }
    name = candidate;
    data.erase(at);
    return tags;
  }
  return {};
}

std::vector<vtkIdType> take_flags(std::vector<DataArray>& data, const std::string& name) {
  const auto at = find(data, name);
  if (at == data.end() || at->components != 1) return {};
  std::vector<vtkIdType> flagged;
  std::visit(
      [&flagged](const auto& values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (values[i] != 0) flagged.push_back(vtkIdType(i));
        }
      },
      at->values);
  data.erase(at);
  return flagged;
}

std::vector<DataArray> arrays_of(vtkDataSetAttributes* attributes, const char* where, Warnings& warnings) {
  std::vector<DataArray> data;
  std::set<std::string> names;
  const auto n = attributes->GetNumberOfTuples();
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* any = attributes->GetAbstractArray(i);
    const std::string name = any->GetName() != nullptr ? any->GetName() : "";
    vtkDataArray* array = vtkDataArray::SafeDownCast(any);
    if (array == nullptr) {
      warnings.push_back("the data \"" + name + "\" on " + where + " is not an array of numbers; it is not kept");
    } else if (!names.insert(name).second) {
      warnings.push_back("two arrays on " + std::string(where) + " are called \"" + name + "\"; the first is kept");
    } else if (array->GetNumberOfTuples() != n) {
      throw FileError("the data \"" + name + "\" on " + where + " has " + std::to_string(array->GetNumberOfTuples()) +
                      " entries for " + std::to_string(n));
    } else if (array->GetNumberOfComponents() > 0) {
      data.push_back(from_vtk(array));
    }
  }
  return data;
}

}  // namespace tetune::plugin
