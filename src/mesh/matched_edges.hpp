// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "tetune/geometry.hpp"

namespace tetune {

/// An edge of the triangles of a surface that was matched with a CAD model.
struct MatchedEdge {
  std::array<Index, 2> vertices{};  ///< in ascending order
  /// The model's edge, or the face of all triangles at the edge; kNoEntity where it is neither.
  GeometryEntity entity{};
  std::array<std::int32_t, 2> faces{};  ///< of the triangles at the edge, the two smallest numbers; 0: none
};

/// The edges of all triangles, sorted by their vertices.
std::vector<MatchedEdge> edges_of(const GeometryMatch& match);

}  // namespace tetune
