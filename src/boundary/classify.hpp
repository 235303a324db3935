// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/constrained_edges.hpp"

namespace tetune {

/// Vertices of the surface that may move within planes and along straight lines, so that its shape stays as it is.

/// Distances from a plane or line below this part of the local edge length count as zero. A vertex that moves in such a
/// plane changes the surface by at most about that much.
inline constexpr double kFlat = 1e-6;

/// The caller's constraint on a vertex.
inline constexpr std::uint8_t kMovable = 0;
/// It must not move.
inline constexpr std::uint8_t kFrozen = 1;
/// It is listed as a corner of the shape: see fix_corners().
inline constexpr std::uint8_t kCorner = 2;

/// Decides for each vertex where it may go without changing the surface (Sect. 4.2, Alg. 2):
///   free   not on the surface and on no constrained edge
///   plane  V_F: its triangles lie in one plane, none folded back on another, and have one tag
///   line   V_E: the planes of all its triangles contain one line, along which its two feature edges run. Feature edges
///          are folds, borders between tags, edges not on two triangles, and the constrained edges
///   fixed  V_C: all others; with `surface_fixed` the whole surface; and where `frozen` is kFrozen
/// `edges` are the constrained edges, as pairs of work vertices. `axis` receives the direction of the line or the
/// normal of the plane.
template <class Backend>
void classify_vertices(const Backend& backend, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                       Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                       bool surface_fixed, Span<VertexDof> dof, Span<Vec3> axis);

/// The number of corners, or junctions of feature lines, that only a list names and the geometry does not show.
/// Heuristic: where these are more than 10 and more than 5 % of the constrained vertices, the list is no list of
/// features (TetGen lists every vertex and edge of its input).
struct ListedOnlyCount {
  Size constrained = 0;  ///< vertices that are not free
  Size listed_only = 0;
  TETUNE_HD void merge(const ListedOnlyCount& other) {
    constrained += other.constrained;
    listed_only += other.listed_only;
  }
  bool are_features() const { return listed_only <= 10 || 20 * listed_only <= constrained; }
};

/// Whether the edges of a list from entry `first` of `ends` on can be feature lines, given where vertices may go
/// without them: feature lines meet in few places. (TetGen lists and tags all edges of its input.)
inline bool are_feature_lines(Span<const Index> ends, Size first, Span<const VertexDof> dof) {
  std::vector<std::uint8_t> degree(backend::to_size_t(dof.size()), 0);
  for (Size i = first; i < ends.size(); ++i) {
    std::uint8_t& d = span_of(degree)[ends[i]];
    if (d < 3) ++d;
  }
  ListedOnlyCount count;
  for (Size v = 0; v < dof.size(); ++v) {
    if (dof[v] != VertexDof::free) ++count.constrained;
    if (dof[v] != VertexDof::fixed && span_of(degree)[v] > 2) ++count.listed_only;
  }
  return count.are_features();
}

/// Fixes the listed corners, unless the list is not one of corners (see ListedOnlyCount): returns then the number of
/// listed vertices that it leaves movable, else 0.
template <class Backend>
Size fix_corners(const Backend& backend, Span<const std::uint8_t> frozen, Span<VertexDof> dof);

}  // namespace tetune
