// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// A vertex that a run has inserted, and the vertices of the edge, triangle or tetrahedron of the input on which it
/// lies: it is in the sets of nodes that all of them are in, and has the tag that all of them have.
struct InsertedVertex {
  Index id;
  /// Where the vertex is inside the mesh and these are all on the surface, as between two sides of a thin part, also
  /// the vertices inside that share a tetrahedron with them, or none if there are none: a set of the nodes of the
  /// surface does not get it.
  std::vector<Index> support;

  /// The value that all of the support have; 0 where they differ.
  template <class ValueOf>
  int common_value(const ValueOf& value_of) const {
    const int value = support.empty() ? 0 : value_of(support.front());
    for (const Index v : support) {
      if (value_of(v) != value) return 0;
    }
    return value;
  }
};

/// The vertices of `result` with an id of at least the number of those of `mesh`, the input, whose tetrahedra must be
/// valid. `place_of`: where each of these is in the input, in the order of their ids; empty: at its position, as the
/// mesh was not moved. Vertices of no tetrahedron are left out.
std::vector<InsertedVertex> find_inserted(const TetMesh& mesh, const TetMesh& result,
                                          const std::vector<MeshPlace>& place_of);

}  // namespace tetune
