// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The name of the group that is written for a tag in no group is one of these, by dimension, and the tag.
inline constexpr std::array<const char*, 4> kUnvTagNames{"", "Edge", "Surface", "Volume"};

/// Elements of one dimension with one property number that are in the same groups.
struct UnvClass {
  int dimension, property;
  std::vector<std::int32_t> groups;  ///< positions, in ascending order
  friend auto operator<=>(const UnvClass&, const UnvClass&) = default;
};

/// A tag for each class of elements: its property number, unless that is the number of classes in other groups too, as
/// in the files of Salome, where all elements have the same one. Then it is the number of its group, if it is in
/// exactly one that gives no other class its number, or else a free one.
std::map<UnvClass, int> tags_of_unv_classes(const std::vector<UnvClass>& classes,
                                            const std::vector<std::int64_t>& group_numbers);

/// The number of classes whose tag is not their property number, in dimensions where this number differs between
/// elements.
std::size_t count_changed_properties(const std::map<UnvClass, int>& class2tag);

/// The groups of a mesh with these classes, one for each dimension of each group of the file. `names` and `numbers` are
/// those of the groups of the file, which they keep. But a group that the writer named for a tag, and could not give
/// this number, has it: other formats keep the number of a group as the tag.
std::vector<Group> unv_groups(const std::map<UnvClass, int>& class2tag, const std::vector<std::string>& names,
                              const std::vector<std::int64_t>& numbers);

}  // namespace tetune
