// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Prefix of the names of data on vertices that sets of nodes become, before the set's number and name: 1 for members,
/// 0 for others.
inline constexpr std::string_view kNodeSet = "node_set:";

inline bool is_node_set(const DataArray& array) {
  return array.components == 1 && array.name.starts_with(kNodeSet) &&
         std::holds_alternative<std::vector<std::uint8_t>>(array.values);
}

}  // namespace tetune
