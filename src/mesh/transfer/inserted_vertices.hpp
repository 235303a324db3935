// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// A vertex that a run has inserted, and the vertices of the edge, triangle or tetrahedron of the input on which it
/// lies: it is in the sets of nodes that all of them are in, and has the tag that all of them have.
struct InsertedVertex {
  Index id;
  /// In the input; all weights are 0 where no tetrahedron contains it.
  MeshPlace place;
  /// Where the vertex is inside the mesh and these are all on the surface, as between two sides of a thin part, also
  /// some vertices inside that share a tetrahedron with them, or none if there are none: a set of the nodes of the
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

/// The vertices of the edge, triangle or tetrahedron on which a place is, but for rounding.
std::vector<Index> support_of(const MeshPlace& place);

/// The places in a mesh of the vertices of `result` with these ids; an entry per vertex of `result`, with weights 0 for
/// the others.
std::vector<MeshPlace> find_places(const TetMesh& mesh, const TetMesh& result, const std::vector<Index>& ids);

/// 1 per vertex of one of the faces. `count`: the number of vertices.
std::vector<std::uint8_t> mark_vertices(const std::vector<std::array<Index, 3>>& faces, std::size_t count);

/// The vertices of `result` with these ids, which were inserted. `mesh`: the input. `on_surface`: 1 per vertex of the
/// result on its surface, as of find_surface_faces(). `places`: where each vertex of the result is in the input; empty:
/// at its position, as the mesh was not moved.
std::vector<InsertedVertex> find_inserted(const TetMesh& mesh, const TetMesh& result,
                                          const std::vector<std::uint8_t>& on_surface, const std::vector<Index>& ids,
                                          const std::vector<MeshPlace>& places);

}  // namespace tetune
