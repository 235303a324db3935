// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "backend/cpu.hpp"
#include "backend/pack.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "quality/tet_measures.hpp"

/// Loops over the shapes of all tetrahedra, several per SIMD instruction.
namespace tetune {

using ShapePack = backend::Cpu::Pack;
inline constexpr int kShapeLanes = kLanesOf<ShapePack>;

/// Tetrahedra are measured in chunks; sums run over the chunks in order, so that they do not depend on the number of
/// threads.
inline Size shape_chunk_count(Size tets) { return std::clamp<Size>(tets / 512, 1, 64); }
inline Size shape_chunk_begin(Size tets, Size chunk) { return tets * chunk / shape_chunk_count(tets); }

/// Loads the vertices of kShapeLanes consecutive tetrahedra, one per SIMD lane, padding with the last.
inline void load_points(const TetMeshView& mesh, Size first, Size last, Vec3T<ShapePack> (&p)[4]) {
  for (int l = 0; l < kShapeLanes; ++l) {
    const Size t = std::min(first + l, last);
    mesh.prefetch_ahead(t);
    const Tet tet = mesh.tet(t);
    for (int k = 0; k < 4; ++k) {
      const Vec3 x = mesh.position(tet[k]);
      p[k].x[l] = x.x;
      p[k].y[l] = x.y;
      p[k].z[l] = x.z;
    }
  }
}

inline TetShapeT<ShapePack> load_shapes(const TetMeshView& mesh, Size first, Size last) {
  Vec3T<ShapePack> p[4];
  load_points(mesh, first, last, p);
  return TetShapeT<ShapePack>(p);
}

/// Calls visit(shapes, l, t) for each tetrahedron t of a chunk, in order; its shape is lane l of `shapes`.
template <class Visit>
void for_each_shape(const TetMeshView& mesh, Size chunk, const Visit& visit) {
  const Size end = shape_chunk_begin(mesh.tets.size(), chunk + 1);
  for (Size first = shape_chunk_begin(mesh.tets.size(), chunk); first < end; first += kShapeLanes) {
    const TetShapeT<ShapePack> shapes = load_shapes(mesh, first, end - 1);
    for (int l = 0; l < kShapeLanes && first + l < end; ++l) visit(shapes, l, first + l);
  }
}

}  // namespace tetune
