// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "tetune/mesh.hpp"

namespace tetune {

/// Whether the values of an array are of a floating-point type: samples of a field, which have values in between.
inline bool is_floating(const DataArray& array) {
  return std::holds_alternative<std::vector<double>>(array.values) ||
         std::holds_alternative<std::vector<float>>(array.values);
}

}  // namespace tetune
