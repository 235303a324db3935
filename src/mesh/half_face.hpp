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

/// For each face of a tetrahedron the half-face across it.
struct alignas(16) FaceAdjacency {
  HalfFace across[4];
  TETUNE_HD HalfFace operator[](int face) const { return across[face]; }
  TETUNE_HD HalfFace& operator[](int face) { return across[face]; }
};

}  // namespace tetune
