// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "boundary/surface.hpp"

namespace tetune {

/// A triangle of the boundary as boundary flips change it. "Boundary" is all that flips must preserve: the outer
/// boundary, interfaces and constrained triangles.
struct BoundaryTriangle {
  Index v[3];           ///< in the order of face_vertex()
  int tag;              ///< of its patch
  Index listed;         ///< its position in the caller's list, or -1
  std::uint8_t turned;  ///< the caller lists it in the opposite orientation
  std::uint8_t stays;   ///< it must not be flipped
};

template <class Backend>
struct BoundaryTriangles {
  typename Backend::template Buffer<BoundaryTriangle> triangles;
  /// The corners 3 * triangle + k at each vertex.
  Csr<Backend> vertex2corner;
  bool stale = true;  ///< vertex2corner must be rebuilt
  /// Tolerance of coplanarity: heights below this part of the edge length count as zero.
  double flat = 0;
};

/// Builds the boundary triangles from the surface and the caller's list.
template <class Backend>
void build_boundary(const Backend& backend, const Surface<Backend>& surface, const ListedTriangles& listed,
                    Span<const std::uint8_t> frozen, BoundaryTriangles<Backend>& boundary);

/// Replaces the caller's listed triangles by those that flips have made of them, each in the orientation it had.
inline void follow_flips(const std::vector<BoundaryTriangle>& boundary, const std::vector<Index>& vertex2original,
                         std::vector<std::array<Index, 3>>& triangles) noexcept {
  for (const BoundaryTriangle& t : boundary) {
    if (t.listed < 0) continue;
    std::array<Index, 3>& entry = span_of(triangles)[t.listed];
    const Span<const Index> ids = span_of(vertex2original);
    std::array<Index, 3> flipped{ids[t.v[0]], ids[t.v[1]], ids[t.v[2]]};
    if (std::is_permutation(flipped.begin(), flipped.end(), entry.begin())) continue;
    if (t.turned != 0) std::swap(flipped[1], flipped[2]);
    entry = flipped;
  }
}

}  // namespace tetune
