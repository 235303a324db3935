// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/span.hpp"
#include "mesh/half_face.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// Maps corner 4 * tet + k to its vertex, or to -1 in a free slot: a row function for build_csr().
struct VertexOfTetCorner {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const auto corner = static_cast<HalfFace>(item);
    const Tet& tet = tets[tet_of(corner)];
    return tet[0] == kFreeSlot ? -1 : tet[face_of(corner)];
  }
};

/// The vertices of a face in increasing order.
struct FaceKey {
  Index low, middle, high;
  bool odd;  ///< whether the permutation that sorted the vertices is odd

  /// The two larger vertices: identifies the face among those with the same lowest vertex.
  TETUNE_HD std::uint64_t pair() const {
    return (static_cast<std::uint64_t>(middle) << 32) | static_cast<std::uint32_t>(high);
  }
};

TETUNE_HD inline FaceKey face_key(const Tet& tet, int face) {
  const Index a = tet[face_vertex(face, 0)];
  const Index b = tet[face_vertex(face, 1)];
  const Index c = tet[face_vertex(face, 2)];
  const bool ab = b < a;
  const bool bc = c < b;
  const bool ac = c < a;
  const Index low_ab = ab ? b : a;
  const Index high_ab = ab ? a : b;
  const Index low = c < low_ab ? c : low_ab;
  const Index high = high_ab < c ? c : high_ab;
  return {low, a ^ b ^ c ^ low ^ high, high, (ab ^ bc ^ ac) != 0};
}

}  // namespace tetune
