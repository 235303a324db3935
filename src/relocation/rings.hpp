// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"
#include "mesh/connect.hpp"
#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// The rings of all vertices in a backend's memory.
template <class Backend>
struct Rings {
  BufferOf<Backend, std::uint32_t> offsets;
  BufferOf<Backend, LinkFace> faces;
  RingsView view() const { return {offsets.span(), faces.span()}; }
};

namespace rings_detail {

/// The face opposite a corner.
struct FaceOfCorner {
  Span<const Tet> tets;
  TETUNE_HD LinkFace operator()(std::uint32_t corner) const {
    const Tet tet = tets[corner >> 2];
    const int k = face_of(corner);
    return {{tet[face_vertex(k, 0)], tet[face_vertex(k, 1)], tet[face_vertex(k, 2)]}};
  }
};

/// The vertex of a corner of listed tetrahedra; -1 for vertices without a flag.
struct FlaggedVertexOfCorner {
  Span<const Tet> tets;
  Span<const Index> slots;
  Span<const std::uint8_t> flags;
  TETUNE_HD Size operator()(Size corner) const {
    const Index v = tets[slots[corner >> 2]][face_of(static_cast<HalfFace>(corner))];
    return flags[v] != 0 ? v : -1;
  }
};

/// Same as FaceOfCorner, for listed tetrahedra.
struct FaceOfListedCorner {
  FaceOfCorner face;
  Span<const Index> slots;
  TETUNE_HD LinkFace operator()(std::uint32_t corner) const {
    return face(4 * static_cast<std::uint32_t>(slots[corner >> 2]) + (corner & 3));
  }
};

}  // namespace rings_detail

template <class Backend>
void build_rings(const Backend& backend, WorkMesh<Backend>& mesh, Rings<Backend>& rings) {
  using namespace rings_detail;
  const Span<const Tet> tets = mesh.tet2vertex;
  build_csr_of<Backend, VertexOfTetCorner, FaceOfCorner, LinkFace>(
      backend,
      {.rows = mesh.vertices(), .items = 4 * mesh.slots(), .row_of = {tets}, .make = {tets}, .listed = 4 * mesh.tets()},
      rings.offsets, rings.faces);
}

/// Builds the rings of the flagged vertices alone; the others have empty ones. Requires that `tets` lists all
/// tetrahedra of the flagged vertices.
template <class Backend>
void build_rings_of(const Backend& backend, WorkMesh<Backend>& mesh, Span<const Index> tets,
                    Span<const std::uint8_t> flags, Rings<Backend>& rings) {
  using namespace rings_detail;
  const Span<const Tet> tet2vertex = mesh.tet2vertex;
  build_csr_of<Backend, FlaggedVertexOfCorner, FaceOfListedCorner, LinkFace>(backend,
                                                                             {.rows = mesh.vertices(),
                                                                              .items = 4 * tets.size(),
                                                                              .row_of = {tet2vertex, tets, flags},
                                                                              .make = {{tet2vertex}, tets}},
                                                                             rings.offsets, rings.faces);
}

}  // namespace tetune
