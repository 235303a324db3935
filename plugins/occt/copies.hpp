// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <TopTools_IndexedMapOfShape.hxx>
#include <vector>

namespace tetune::plugin {

/// For each entity, in numbers from 1, the first one that coincides with it.
struct FirstCopies {
  std::vector<int> vertices, edges, faces;
};

/// Finds vertices at one place, edges between the same vertices through the same places, and faces with the same edges
/// and the same bounding box.
FirstCopies find_copies(const TopTools_IndexedMapOfShape& vertices, const TopTools_IndexedMapOfShape& edges,
                        const TopTools_IndexedMapOfShape& faces, double tolerance);

}  // namespace tetune::plugin
