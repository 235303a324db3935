// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/types.hpp"

namespace tetune {

/// What lies across a face: the neighbour tetrahedron and its local face, and whether the face is locked, that is
/// part of the boundary, of an interface between regions, or of another constraint, and must survive.
/// Bits: 31 locked, 30..2 tetrahedron, 1..0 face. kNoLink: the boundary (locked too).
using Link = std::uint32_t;
inline constexpr Link kNoLink = 0xffffffffU;
inline constexpr Link kLocked = 0x80000000U;

TETUNE_HD TETUNE_INLINE Link make_link(Index tet, int face) {
  return (static_cast<Link>(tet) << 2) | static_cast<Link>(face);
}
TETUNE_HD TETUNE_INLINE bool is_locked(Link link) { return (link & kLocked) != 0; }
TETUNE_HD TETUNE_INLINE Index link_tet(Link link) { return static_cast<Index>((link & ~kLocked) >> 2); }
TETUNE_HD TETUNE_INLINE int link_face(Link link) { return static_cast<int>(link & 3U); }

/// The links across the four faces of a tetrahedron.
struct alignas(16) Links {
  Link across[4];
  TETUNE_HD Link operator[](int face) const { return across[face]; }
  TETUNE_HD Link& operator[](int face) { return across[face]; }
};

}  // namespace tetune
