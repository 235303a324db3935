// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/rows.hpp"
#include "flips/flip_pass.hpp"

/// Flips of boundary edges between coplanar triangles of one patch: the tetrahedra (a, r_m, r_m+1, b) around such an
/// edge (a, b) are a fan from one triangle (a, b, r_0) to the other (a, b, r_n), and its removal triangulates the
/// polygon r_0, ..., r_n, whose last side lies in the boundary. With two tetrahedra it is the 2-2 flip. Where the
/// triangles have tetrahedra on both sides, as those of interfaces do, there is a fan on each side, and both go
/// together. "Boundary" here is all that flip_pass() must keep: the outer boundary, interfaces, constrained triangles.
namespace tetune {

/// A triangle of the boundary.
struct BoundaryTriangle {
  Index v[3];           ///< in the order of face_vertex()
  int tag;              ///< of its patch
  Index listed;         ///< its position in the caller's list; -1: it is not there
  std::uint8_t turned;  ///< it is listed the other way round
  std::uint8_t stays;   ///< must stay as it is
};

/// The boundary, as flips change it.
template <class Backend>
struct BoundaryTriangles {
  typename Backend::template Buffer<BoundaryTriangle> triangles;
  /// The corners 3 * triangle + k of each vertex.
  Rows<Backend> vertex2corner;
  bool stale = true;  ///< these have to be built
  /// What counts as coplanar: heights below this part of the edge.
  double flat = 0;
};

/// One pass over all edges of the boundary: like flip_pass(), with a flip for each edge that may go. It needs no active
/// set; what it makes is active for flip_pass() afterwards. Only FlipReport::boundary_flips and the like are set.
template <class Backend>
FlipReport boundary_flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                              BoundaryTriangles<Backend>& boundary, Span<std::uint8_t> awake);

}  // namespace tetune
