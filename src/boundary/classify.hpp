// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/constrained_edges.hpp"
#include "core/motion.hpp"
#include "core/rows.hpp"
#include "core/work_mesh.hpp"

namespace tetune {

/// Heights off a plane or line below this part of the local edge length count as none. A vertex that slides in such a
/// plane changes the surface by at most about that much.
inline constexpr double kFlat = 1e-6;

/// What the caller says of a vertex.
inline constexpr std::uint8_t kMovable = 0;
/// Must not move.
inline constexpr std::uint8_t kFrozen = 1;
/// Listed as a corner of the shape: must not move, unless the surface around it is flat, with one tag and no feature
/// edge, where there is no corner whatever the list says. (TetGen lists every input vertex.)
inline constexpr std::uint8_t kCorner = 2;

/// A triangle the caller's mesh lists, in work vertices.
struct ListedTriangle {
  Index v[3];
  int tag;
  std::uint8_t required;
};

/// What became of a listed triangle.
enum class Listed : std::uint8_t {
  surface,  ///< a face of the boundary, of an interface or of a constraint: stays
  loose,    ///< untagged, inside one region: no constraint
  absent,   ///< tagged or required, but not a face of any tetrahedron: kept in the list, its vertices frozen
};

/// The surfaces that the optimisation keeps: boundary, interfaces, constrained triangles; and what its vertices may do.
template <class Backend>
struct Surface {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  /// The faces as 4 * tet + face, each once, and the tag of each.
  Buffer<Index> faces;
  Buffer<int> tags;
  /// The corners 3 * face + k of each vertex.
  Rows<Backend> vertex2corner;
};

/// Finds the surface: boundary faces, locked faces, and the listed triangles inside regions that are tagged or
/// required, which it locks. `listed_state` receives a Listed for each listed triangle.
template <class Backend>
void build_surface(const Backend& par, WorkMesh<Backend>& mesh,
                   const typename Backend::template Buffer<ListedTriangle>& listed,
                   typename Backend::template Buffer<Listed>& listed_state, Surface<Backend>& surface);

/// Decides for each vertex where it may go so that the surface stays as it is (Sect. 4.2, Alg. 2):
///   free   not on the surface and on no constrained edge
///   plane  V_F: its triangles lie in one plane, none folded back on another, and have one tag
///   line   V_E: the planes of all its triangles contain one line, along which its two feature edges run. Feature edges
///          are folds, borders between tags, edges not on two triangles, and the constrained edges
///   fixed  V_C: all others; with `surface_fixed` all of the surface; and where `frozen` is kFrozen or kCorner
/// `edges` are the constrained edges, as pairs of work vertices.
template <class Backend>
void classify_vertices(const Backend& par, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                       Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                       bool surface_fixed, Span<Mobility> kind, Span<Vec3> axis);

}  // namespace tetune
