// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

using backend::span_of;
using backend::to_index;

/// A triangle of the surface, in the order of face_vertex(). Corner 3 * triangle + k is at its vertex k; the edge of a
/// corner is the one opposite it.
struct SurfaceTriangle {
  Index v[3];
};

/// A triangle that the caller's mesh lists, in work vertices.
struct ListedTriangle {
  Index v[3];
  int tag;
  std::uint8_t required;
  std::uint8_t locks;  ///< remains a face where it lies inside one region
};

/// The caller's list, read in place.
struct ListedTriangles {
  Span<const Index> vertices;  ///< three per triangle, in the caller's ids
  Span<const int> tags;
  Span<const std::uint8_t> required;  ///< empty: no triangle is required
  Span<const int> frozen_patches;
  Span<const Index> original2vertex;
  bool tags_lock;  ///< tagged triangles remain faces where they lie inside one region

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

/// The role of a listed triangle.
enum class Listed : std::uint8_t {
  surface,  ///< a face of the boundary, of an interface or of a constraint: it remains
  loose,    ///< inside one region without locking anything: no constraint
  absent,   ///< it should lock, but is no face of any tetrahedron: it remains in the list and its vertices are frozen
};

/// The surfaces that the optimization preserves: boundary, interfaces and constrained triangles.
template <class Backend>
struct Surface {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  /// Each face once, and its tag.
  Buffer<SurfaceTriangle> triangles;
  Buffer<int> tags;
  /// The corners at each vertex.
  Csr<Backend> vertex2corner;
  /// The triangle of each entry of the caller's list, or -1.
  Buffer<Index> listed2triangle;
};

/// Collects the surface: boundary faces, locked faces, and the listed triangles inside regions that are tagged or
/// required; these it locks. `listed_state` receives the role of each listed triangle.
template <class Backend>
void build_surface(const Backend& backend, WorkMesh<Backend>& mesh, const ListedTriangles& listed,
                   typename Backend::template Buffer<Listed>& listed_state, Surface<Backend>& surface);

}  // namespace tetune
