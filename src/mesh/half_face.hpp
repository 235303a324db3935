// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "mesh/tet.hpp"

namespace tetune {

/// A face of a tetrahedron: the tetrahedron and the local index of the face. Face i lies opposite vertex i, so that the
/// same number 4 * tet + i also identifies a corner, that is, vertex i of the tetrahedron. As an entry of FaceAdjacency
/// it carries a flag that locks the face: a locked face belongs to the boundary, to an interface between regions or to
/// another constraint, and no operation may remove it.
/// Bits: 31 locked, 30..2 tetrahedron, 1..0 face. kNoHalfFace stands for the outside; it is locked too.
using HalfFace = std::uint32_t;
inline constexpr HalfFace kNoHalfFace = 0xffffffffU;
inline constexpr HalfFace kLocked = 0x80000000U;

TETUNE_HD TETUNE_INLINE HalfFace make_half_face(Index tet, int face) {
  return (static_cast<HalfFace>(tet) << 2) | static_cast<HalfFace>(face);
}
TETUNE_HD TETUNE_INLINE bool is_locked(HalfFace half_face) { return (half_face & kLocked) != 0; }
TETUNE_HD TETUNE_INLINE Index tet_of(HalfFace half_face) { return static_cast<Index>((half_face & ~kLocked) >> 2); }
TETUNE_HD TETUNE_INLINE int face_of(HalfFace half_face) { return static_cast<int>(half_face & 3U); }

/// Whether a list of locked faces, each once, has that of tetrahedron t: a face on the boundary, or one whose other
/// tetrahedron is in a higher slot.
TETUNE_HD inline bool lists_locked_face(Index t, HalfFace across) {
  return across == kNoHalfFace || (is_locked(across) && t < tet_of(across));
}

/// For each face of a tetrahedron the half-face across it.
struct alignas(16) FaceAdjacency {
  HalfFace across[4];
  TETUNE_HD HalfFace operator[](int face) const { return across[face]; }
  TETUNE_HD HalfFace& operator[](int face) { return across[face]; }
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
