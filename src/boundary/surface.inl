// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/atomic.hpp"
#include "backend/sum.hpp"
#include "boundary/surface.hpp"
#include "boundary/surface_corners.hpp"
#include "mesh/connect.hpp"

namespace tetune {
namespace surface_detail {

TETUNE_HD inline bool same_triangle(const Index a[3], const Index b[3]) {
  for (int k = 0; k < 3; ++k) {
    if (a[k] != b[0] && a[k] != b[1] && a[k] != b[2]) return false;
  }
  return true;
}

/// Boundary faces, and one side of each locked face.
struct IsSurfaceFace {
  Span<const Tet> tets;
  Span<const FaceAdjacency> adjacency;
  TETUNE_HD bool operator()(Size item) const {
    if (tets[item >> 2].v[0] == kFreeSlot) return false;
    const HalfFace across = adjacency[item >> 2][item & 3];
    return across == kNoHalfFace || (is_locked(across) && (item >> 2) < tet_of(across));
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

/// The number of listed triangles that lock a face which is not in the surface yet.
/// Finds a listed triangle in the surface. Where several name one face, the last one with a tag gives it its tag.
struct MatchListed {
  Span<const SurfaceTriangle> triangles;
  CsrView vertex2corner;
  ListedTriangles listed;
  Span<Listed> state;
  Span<Index> listed2triangle;
  Span<std::uint32_t> triangle2listed;  ///< position + 1; 0: not listed with a tag
  TETUNE_HD backend::Sum<Size> operator()(Size i) const {
    const ListedTriangle t = listed[i];
    const Index s = find(t.v);
    listed2triangle[i] = s;
    if (s < 0) {
      state[i] = t.locks != 0 ? Listed::absent : Listed::loose;
      return {t.locks};
    }
    state[i] = Listed::surface;
    if (t.tag != 0) backend::atomic_max(triangle2listed[s], static_cast<std::uint32_t>(i + 1));
    return {};
  }

 private:
  TETUNE_HD Index find(const Index v[3]) const {
    const Index from = vertex2corner.shorter(vertex2corner.shorter(v[0], v[1]), v[2]);
    for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
      const std::uint32_t s = vertex2corner.items[c] / 3;
      if (same_triangle(triangles[s].v, v)) return to_index(s);
    }
    return -1;
  }
};

/// Locks the faces of constraining triangles inside regions. Both tetrahedra of such a face are in the row of the same
/// vertex and find the triangle there, so each thread writes only its own side.
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

template <class Backend>
void collect_surface(const Backend& backend, WorkMesh<Backend>& mesh, Surface<Backend>& surface) {
  using namespace surface_detail;
  typename Backend::template Buffer<Index> faces(backend, 4 * mesh.slots());
  const Size count =
      backend.compact(4 * mesh.slots(), IsSurfaceFace{mesh.tet2vertex.span(), mesh.tet2tet.span()}, faces.span());
  check_surface_size(count);
  surface.triangles.resize(backend, count);
  backend.for_each(count, TriangleOfFace{mesh.tet2vertex.span(), faces.span(), surface.triangles.span()});
  build_csr(backend, mesh.vertices(), 3 * count, VertexOfSurfaceCorner{surface.triangles.span()},
            surface.vertex2corner);
}

template <class Backend>
void build_surface(const Backend& backend, WorkMesh<Backend>& mesh, const ListedTriangles& listed,
                   typename Backend::template Buffer<Listed>& listed_state, Surface<Backend>& surface) {
  using namespace surface_detail;
  collect_surface(backend, mesh, surface);
  listed_state.resize(backend, listed.size());
  surface.listed2triangle.resize(backend, listed.size());
  typename Backend::template Buffer<std::uint32_t> triangle2listed;
  const auto match = [&]() {
    triangle2listed.resize(backend, surface.triangles.size());
    backend.fill(triangle2listed.span(), std::uint32_t{0});
    return backend
        .template reduce<backend::Sum<Size>>(
            listed.size(), MatchListed{surface.triangles.span(), surface.vertex2corner.view(), listed,
                                       listed_state.span(), surface.listed2triangle.span(), triangle2listed.span()})
        .value;
  };
  if (match() > 0) {
    Csr<Backend> vertex2tet;
    build_vertex2tet(backend, mesh, vertex2tet);
    backend.for_each(listed.size(), LockListed{mesh.view(), vertex2tet.view(), listed, listed_state.span()});
    collect_surface(backend, mesh, surface);
    match();
  }
  surface.tags.resize(backend, surface.triangles.size());
  backend.for_each(surface.triangles.size(), TagFaces{triangle2listed.span(), listed, surface.tags.span()});
}

}  // namespace tetune
