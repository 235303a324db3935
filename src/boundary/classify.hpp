// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/constrained_edges.hpp"
#include "core/motion.hpp"
#include "core/rows.hpp"
#include "core/work_mesh.hpp"
#include "surface/reference.hpp"

namespace tetune {

/// Heights off a plane or line below this part of the local edge length count as none. A vertex that slides in such a
/// plane changes the surface by at most about that much.
inline constexpr double kFlat = 1e-6;

/// What the caller says of a vertex.
inline constexpr std::uint8_t kMovable = 0;
/// Must not move.
inline constexpr std::uint8_t kFrozen = 1;
/// Listed as a corner of the shape: see hold_corners().
inline constexpr std::uint8_t kCorner = 2;

/// A triangle the caller's mesh lists, in work vertices.
struct ListedTriangle {
  Index v[3];
  int tag;
  std::uint8_t required;
  std::uint8_t locks;  ///< stays a face where it lies inside one region
};

/// The caller's list, read in place.
struct ListedTriangles {
  Span<const Index> vertices;  ///< three each, in the caller's numbers
  Span<const int> tags;
  Span<const std::uint8_t> required;  ///< empty: none is
  Span<const int> frozen_patches;
  Span<const Index> original2vertex;
  bool tags_lock;  ///< tagged triangles stay faces where they lie inside one region

  TETUNE_HD Size size() const { return tags.size(); }
  TETUNE_HD ListedTriangle operator[](Size i) const {
    ListedTriangle t;
    for (int k = 0; k < 3; ++k) t.v[k] = original2vertex[vertices[3 * i + k]];
    t.tag = tags[i];
    t.required = required.size() > 0 ? required[i] : 0;
    bool locks = t.required != 0 || (tags_lock && t.tag != 0);
    for (Size p = 0; p < frozen_patches.size() && !locks; ++p) locks = frozen_patches[p] == t.tag;
    t.locks = locks ? 1 : 0;
    return t;
  }
};

/// What became of a listed triangle.
enum class Listed : std::uint8_t {
  surface,  ///< a face of the boundary, of an interface or of a constraint: stays
  loose,    ///< inside one region and locks nothing: no constraint
  absent,   ///< locks, but not a face of any tetrahedron: kept in the list, its vertices frozen
};

/// The surfaces that the optimisation keeps: boundary, interfaces, constrained triangles; and what its vertices may do.
template <class Backend>
struct Surface {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  /// Each face once, and its tag.
  Buffer<SurfaceTriangle> triangles;
  Buffer<int> tags;
  /// The corners 3 * triangle + k of each vertex.
  Rows<Backend> vertex2corner;
  /// The triangle that each of the caller's list is; -1: none.
  Buffer<Index> listed2triangle;
};

/// Finds the surface: boundary faces, locked faces, and the listed triangles inside regions that are tagged or
/// required, which it locks. `listed_state` receives a Listed for each listed triangle.
template <class Backend>
void build_surface(const Backend& par, WorkMesh<Backend>& mesh, const ListedTriangles& listed,
                   typename Backend::template Buffer<Listed>& listed_state, Surface<Backend>& surface);

/// Decides for each vertex where it may go so that the surface stays as it is (Sect. 4.2, Alg. 2):
///   free   not on the surface and on no constrained edge
///   plane  V_F: its triangles lie in one plane, none folded back on another, and have one tag
///   line   V_E: the planes of all its triangles contain one line, along which its two feature edges run. Feature edges
///          are folds, borders between tags, edges not on two triangles, and the constrained edges
///   fixed  V_C: all others; with `surface_fixed` all of the surface; and where `frozen` is kFrozen
/// `edges` are the constrained edges, as pairs of work vertices.
template <class Backend>
void classify_vertices(const Backend& par, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                       Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                       bool surface_fixed, Span<Mobility> kind, Span<Vec3> axis);

/// Corners, or junctions of feature lines, that a list names where nothing else says so. Real ones are few; many mean
/// that the list holds all there is: TetGen lists every vertex and edge of its input.
struct PlainCount {
  Size constrained = 0;  ///< vertices that are not free
  Size plain = 0;
  TETUNE_HD void merge(const PlainCount& other) {
    constrained += other.constrained;
    plain += other.plain;
  }
  bool few() const { return plain <= 10 || 20 * plain <= constrained; }
};

/// Fixes the listed corners that could move so far, unless the list is not one of corners. Returns the number of those
/// that it leaves alone then.
template <class Backend>
Size hold_corners(const Backend& par, Span<const std::uint8_t> frozen, Span<Mobility> kind);

}  // namespace tetune
