// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>

#include "math/packed_table.hpp"
#include "math/vec3.hpp"

namespace tetune {

/// A vertex position as stored: padded to 32 bytes, so that it lies in one cache line and is loaded at once.
struct alignas(32) Point {
  double x, y, z, pad;
};
TETUNE_HD TETUNE_INLINE Vec3 vec(const Point& p) { return {p.x, p.y, p.z}; }
TETUNE_HD TETUNE_INLINE Point point(const Vec3& v) { return {v.x, v.y, v.z, 0}; }

/// The four vertices of a tetrahedron.
struct alignas(16) Tet {
  Index v[4];
  TETUNE_HD Index operator[](int i) const { return v[i]; }
  TETUNE_HD Index& operator[](int i) { return v[i]; }
};

/// First vertex of a slot that holds no tetrahedron.
inline constexpr Index kFreeSlot = -1;

/// Both vertices of an edge, the lower one first.
inline std::array<Index, 2> ascending(Index a, Index b) { return a < b ? std::array{a, b} : std::array{b, a}; }
/// Vertices in increasing order.
template <std::size_t N>
std::array<Index, N> ascending(std::array<Index, N> vertices) {
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// The vertices of the face opposite vertex i of a tetrahedron, in increasing order.
inline std::array<Index, 3> ascending_face(const std::array<Index, 4>& tet, std::size_t i) {
  return ascending(std::array{tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]});
}

/// Local index of vertex k of a face; face i lies opposite vertex i. The vertices of a face are counter-clockwise seen
/// from outside a positively oriented tetrahedron: (i, face_vertex(i, 0), face_vertex(i, 1), face_vertex(i, 2)) is an
/// even permutation.
TETUNE_HD TETUNE_INLINE int face_vertex(int face, int k) {
  constexpr PackedTable<2> kFaceVertices({1, 2, 3,  //
                                          0, 3, 2,  //
                                          0, 1, 3,  //
                                          0, 2, 1});
  return kFaceVertices[3 * face + k];
}

/// Local index of a vertex of a tetrahedron, computed without branches, which would be unpredictable.
TETUNE_HD TETUNE_INLINE int local_index(const Tet& tet, Index vertex) {
  return static_cast<int>(tet[1] == vertex) + 2 * static_cast<int>(tet[2] == vertex) +
         3 * static_cast<int>(tet[3] == vertex);
}

}  // namespace tetune
