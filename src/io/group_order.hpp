// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The groups of one dimension, those of the fewest tags first: where a format has one name per element, that of the
/// most specific group says more than that of the whole mesh.
inline std::vector<const Group*> specific_first(const TetMesh& mesh, int dimension) {
  std::vector<const Group*> groups;
  for (const Group& group : mesh.groups) {
    if (group.dimension == dimension) groups.push_back(&group);
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group* a, const Group* b) { return a->tags.size() < b->tags.size(); });
  return groups;
}

}  // namespace tetune
