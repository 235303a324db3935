// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

#include "backend/atomic.hpp"
#include "mesh/connect.hpp"
#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/error.hpp"

namespace tetune {

/// A triangle of the surface, in the order of face_vertex(). Corner 3 * triangle + k is at its vertex k; the edge of a
/// corner is the one opposite it.
struct SurfaceTriangle {
  Index v[3];
};

/// A triangle that the caller's mesh lists, in work vertices.
struct ListedTriangle {
  Index v[3];
  int tag;
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
    bool locks = (required.size() > 0 && required[i] != 0) || (tags_lock && t.tag != 0);
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
  using Buffer = BufferOf<Backend, T>;
  /// Each face once, and its tag.
  Buffer<SurfaceTriangle> triangles;
  Buffer<int> tags;
  /// The corners at each vertex.
  Csr<Backend> vertex2corner;
  /// The triangle of each entry of the caller's list, or -1.
  Buffer<Index> listed2triangle;
};

/// Corners are numbered by Index.
inline void check_surface_size(Size faces) {
  constexpr Size kMaxFaces = std::numeric_limits<Index>::max() / 3;
  if (faces <= kMaxFaces) return;
  throw MeshError("the mesh has " + std::to_string(faces) + " faces on its boundary and interfaces; at most " +
                  std::to_string(kMaxFaces) + " can be handled. Split the mesh, or weld the vertices that coincide.");
}

/// Stands for the corner across a feature edge, which no vertex crosses when it slides.
inline constexpr Index kFeatureEdge = -1;

/// The vertex at each corner 3 * triangle + k.
template <class Triangle>
struct VertexOfCorner {
  Span<const Triangle> triangles;
  TETUNE_HD Size operator()(Size corner) const { return triangles[corner / 3].v[corner % 3]; }
};

struct VertexOfEdgeEnd {
  Span<const Index> edges;
  TETUNE_HD Size operator()(Size item) const { return edges[item]; }
};

/// The corner across the edge of a corner; kFeatureEdge where that edge is not on exactly two triangles.
TETUNE_HD inline Index opposite_corner(Span<const SurfaceTriangle> triangles, const CsrView& vertex2corner,
                                       Size corner) {
  const Size triangle = corner / 3;
  const SurfaceTriangle t = triangles[triangle];
  const Index a = t.v[(corner + 1) % 3];
  const Index b = t.v[(corner + 2) % 3];
  const Index from = vertex2corner.shorter(a, b);
  const Index to = a ^ b ^ from;
  Index opposite = kFeatureEdge;
  for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
    const Size other = vertex2corner.items[c] / 3;
    if (other == triangle) continue;
    const SurfaceTriangle q = triangles[other];
    const int end = q.v[0] == to ? 0 : q.v[1] == to ? 1 : q.v[2] == to ? 2 : -1;
    if (end < 0) continue;
    if (opposite != kFeatureEdge) return kFeatureEdge;
    opposite = to_index(3 * other + 3 - end - vertex2corner.items[c] % 3);
  }
  return opposite;
}

/// Whether two triangles have the same vertices, in any order.
TETUNE_HD inline bool same_triangle(const Index a[3], const Index b[3]) {
  for (int k = 0; k < 3; ++k) {
    if (a[k] != b[0] && a[k] != b[1] && a[k] != b[2]) return false;
  }
  return true;
}

/// The triangle of three vertices, or -1.
template <class Triangle>
TETUNE_HD inline Index find_triangle(Span<const Triangle> triangles, const CsrView& vertex2corner, const Index v[3]) {
  const Index from = vertex2corner.shorter(vertex2corner.shorter(v[0], v[1]), v[2]);
  for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
    const Size triangle = vertex2corner.items[c] / 3;
    if (same_triangle(triangles[triangle].v, v)) return to_index(triangle);
  }
  return -1;
}

namespace surface_detail {

/// Finds the corners across the edges from a vertex to those of larger id, from the triangles at the vertex.
struct FindAcross {
  Span<const SurfaceTriangle> triangles;
  CsrView vertex2corner;
  Span<Index> across;

  TETUNE_HD void operator()(Size v) const {
    const Size begin = vertex2corner.begin(v);
    const Size size = vertex2corner.size(v);
    const bool fits = size <= kMaxLocal;
    FanTriangle fan[kMaxLocal];
    for (Size i = 0; fits && i < size; ++i) fan[i] = fan_triangle(begin + i);
    for (Size i = 0; i < size; ++i) {
      const FanTriangle own = fits ? fan[i] : fan_triangle(begin + i);
      for (Index side = 0; side < 2; ++side) {
        if (own.ends[side] < v) continue;
        const Index edge = own.edges[side];
        across[edge] = fits ? find(fan, size, i, own.ends[side]) : opposite_corner(triangles, vertex2corner, edge);
      }
    }
  }

 private:
  /// Most vertices have at most this number of triangles, which are then read once.
  static constexpr Size kMaxLocal = 16;
  /// The two other vertices of a triangle at a vertex, and the corners opposite the edges to them.
  struct FanTriangle {
    Index ends[2], edges[2];
  };
  TETUNE_HD FanTriangle fan_triangle(Size item) const {
    const std::uint32_t corner = vertex2corner.items[item];
    const Index first = to_index(corner / 3 * 3);
    const SurfaceTriangle t = triangles[corner / 3];
    const Index next = corner % 3 == 2 ? 0 : to_index(corner % 3) + 1;
    const Index last = next == 2 ? 0 : next + 1;
    return {{t.v[next], t.v[last]}, {first + last, first + next}};
  }
  /// The corner opposite the edge to vertex `end` in the only triangle beside `own` that has it.
  TETUNE_HD static Index find(const FanTriangle fan[], Size size, Size own, Index end) {
    int count = 0;
    Index opposite = kFeatureEdge;
    for (Size j = 0; j < size; ++j) {
      for (int side = 0; side < 2; ++side) {
        const bool is_end = j != own && fan[j].ends[side] == end;
        opposite = is_end ? fan[j].edges[side] : opposite;
        count += is_end ? 1 : 0;
      }
    }
    return count == 1 ? opposite : kFeatureEdge;
  }
};

/// Boundary faces, and one side of each locked face.
struct IsSurfaceFace {
  Span<const Tet> tets;
  Span<const FaceAdjacency> adjacency;
  TETUNE_HD bool operator()(Size item) const {
    const auto half_face = static_cast<HalfFace>(item);
    const Index tet = tet_of(half_face);
    if (tets[tet][0] == kFreeSlot) return false;
    return lists_locked_face(tet, adjacency[tet][face_of(half_face)]);
  }
};

struct TriangleOfFace {
  Span<const Tet> tets;
  Span<const Index> faces;
  Span<SurfaceTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    const Tet tet = tets[faces[s] >> 2];
    for (int k = 0; k < 3; ++k) triangles[s].v[k] = tet[face_vertex(faces[s] & 3, k)];
  }
};

/// Finds a listed triangle in the surface. Where several name one face, the last one with a tag gives it its tag.
struct MatchListed {
  Span<const SurfaceTriangle> triangles;
  CsrView vertex2corner;
  ListedTriangles listed;
  Span<Listed> state;
  Span<Index> listed2triangle;
  Span<std::uint32_t> triangle2listed;  ///< position + 1; 0: not listed with a tag
  TETUNE_HD Sum<Size> operator()(Size i) const {
    const ListedTriangle t = listed[i];
    const Index s = find_triangle(triangles, vertex2corner, t.v);
    listed2triangle[i] = s;
    if (s < 0) {
      state[i] = t.locks != 0 ? Listed::absent : Listed::loose;
      return {t.locks};
    }
    state[i] = Listed::surface;
    if (t.tag != 0) backend::atomic_max(triangle2listed[s], static_cast<std::uint32_t>(i + 1));
    return {};
  }
};

/// Locks the faces of constraining triangles inside regions, on both sides: both tetrahedra of such a face are in the
/// row of each of its vertices. Several entries of the list may name one face.
struct LockListed {
  MeshView mesh;
  CsrView vertex2tet;
  ListedTriangles listed;
  Span<const Listed> state;
  TETUNE_HD void operator()(Size i) const {
    if (state[i] != Listed::absent) return;
    const ListedTriangle t = listed[i];
    const Index from = vertex2tet.shorter(vertex2tet.shorter(t.v[0], t.v[1]), t.v[2]);
    for (Size c = vertex2tet.begin(from); c < vertex2tet.end(from); ++c) {
      const Index tet = to_index(vertex2tet.items[c] >> 2);
      for (int f = 0; f < 4; ++f) {
        Index v[3];
        for (int k = 0; k < 3; ++k) v[k] = mesh.tet2vertex[tet][face_vertex(f, k)];
        if (same_triangle(v, t.v)) backend::atomic_or(mesh.tet2tet[tet][f], kLocked);
      }
    }
  }
};

struct TagFaces {
  Span<const std::uint32_t> triangle2listed;
  ListedTriangles listed;
  Span<int> tags;
  TETUNE_HD void operator()(Size s) const {
    tags[s] = triangle2listed[s] == 0 ? 0 : listed[triangle2listed[s] - 1].tag;
  }
};

}  // namespace surface_detail

/// Lists the boundary faces and the locked faces, and the corners of these triangles at each vertex.
template <class Backend>
void collect_surface(const Backend& backend, WorkMesh<Backend>& mesh, Surface<Backend>& surface) {
  using namespace surface_detail;
  BufferOf<Backend, Index> faces(backend, 4 * mesh.slots());
  const Size count = backend.compact(4 * mesh.slots(), IsSurfaceFace{mesh.tet2vertex, mesh.tet2tet}, faces.span());
  check_surface_size(count);
  surface.triangles.resize(backend, count);
  backend.for_each(count, TriangleOfFace{mesh.tet2vertex, faces, surface.triangles});
  build_csr(backend, mesh.vertices(), 3 * count, VertexOfCorner<SurfaceTriangle>{surface.triangles},
            surface.vertex2corner, 3 * count);
}

/// Finds the corner across the edge of each corner, as opposite_corner() does.
template <class Backend>
void find_across(const Backend& backend, Span<const SurfaceTriangle> triangles, const CsrView& vertex2corner,
                 Span<Index> across) {
  backend.for_each(vertex2corner.offsets.size() - 1, surface_detail::FindAcross{triangles, vertex2corner, across});
}

/// Collects the surface: boundary faces, locked faces, and those listed triangles inside regions that lock
/// (ListedTriangle::locks), which become locked faces. `listed_state` receives the role of each listed triangle.
template <class Backend>
void build_surface(const Backend& backend, WorkMesh<Backend>& mesh, const ListedTriangles& listed,
                   BufferOf<Backend, Listed>& listed_state, Surface<Backend>& surface) {
  using namespace surface_detail;
  collect_surface(backend, mesh, surface);
  listed_state.resize(backend, listed.size());
  surface.listed2triangle.resize(backend, listed.size());
  BufferOf<Backend, std::uint32_t> triangle2listed;
  const auto match = [&]() {
    triangle2listed.resize(backend, surface.triangles.size());
    backend.fill(triangle2listed.span(), std::uint32_t{0});
    return backend
        .template reduce<Sum<Size>>(listed.size(), MatchListed{surface.triangles, surface.vertex2corner.view(), listed,
                                                               listed_state, surface.listed2triangle, triangle2listed})
        .value;
  };
  if (match() > 0) {
    Csr<Backend> vertex2tet;
    build_vertex2tet(backend, mesh, vertex2tet);
    backend.for_each(listed.size(), LockListed{mesh.view(), vertex2tet.view(), listed, listed_state});
    collect_surface(backend, mesh, surface);
    match();
  }
  surface.tags.resize(backend, surface.triangles.size());
  backend.for_each(surface.triangles.size(), TagFaces{triangle2listed, listed, surface.tags});
}

}  // namespace tetune
