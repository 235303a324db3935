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

struct VertexOfBoundaryCorner {
  Span<const BoundaryTriangle> triangles;
  TETUNE_HD Size operator()(Size corner) const { return triangles[corner / 3].v[corner % 3]; }
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

/// Lists the corners at each vertex, if they are out of date.
template <class Backend>
void list_corners(const Backend& backend, const WorkMesh<Backend>& mesh, BoundaryTriangles<Backend>& boundary) {
  if (!boundary.stale) return;
  build_csr(backend, mesh.vertices(), 3 * boundary.triangles.size(), VertexOfBoundaryCorner{boundary.triangles.span()},
            boundary.vertex2corner);
  boundary.stale = false;
}

/// The caller's listed triangles after changes of the boundary.
struct ChangedTriangles {
  std::vector<std::array<Index, 3>> triangles;  ///< one per entry of the list
  std::vector<std::uint8_t> is_present;         ///< per entry: a triangle of the boundary has it
  /// More triangles that descend from an entry, and that entry.
  std::vector<std::array<Index, 3>> more;
  std::vector<Index> origin;
};

/// Finds what operations have made of the caller's listed triangles, each in the orientation it had.
inline ChangedTriangles follow_changes(const std::vector<BoundaryTriangle>& boundary,
                                       const std::vector<Index>& vertex2original,
                                       const std::vector<std::array<Index, 3>>& triangles) {
  ChangedTriangles changed{triangles, std::vector<std::uint8_t>(triangles.size(), 0), {}, {}};
  const Span<const Index> ids = span_of(vertex2original);
  for (const BoundaryTriangle& t : boundary) {
    if (t.listed < 0) continue;
    std::array<Index, 3>& entry = span_of(changed.triangles)[t.listed];
    std::array<Index, 3> now{ids[t.v[0]], ids[t.v[1]], ids[t.v[2]]};
    const bool is_same = std::is_permutation(now.begin(), now.end(), entry.begin());
    if (t.turned != 0) std::swap(now[1], now[2]);
    std::uint8_t& is_present = span_of(changed.is_present)[t.listed];
    if (is_present != 0) {
      changed.more.push_back(now);
      changed.origin.push_back(t.listed);
    } else if (!is_same) {
      entry = now;
    }
    is_present = 1;
  }
  return changed;
}

}  // namespace tetune
