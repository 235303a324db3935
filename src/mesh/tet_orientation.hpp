// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/span.hpp"
#include "mesh/half_face.hpp"
#include "tetune/mesh.hpp"

/// Orientation of the tetrahedra of a TetMesh, in exact arithmetic, and of their faces. Host only.
namespace tetune {

/// The sign of a volume that is positive, but too small for floating-point arithmetic.
inline constexpr std::int8_t kTinyVolume = 2;

/// The exact sign of the volume of each tetrahedron: -1, 0, 1 or kTinyVolume. Requires a mesh that passes
/// validate_arrays(). `threads` 0 means all.
std::vector<std::int8_t> volume_signs(const TetMesh& mesh, int threads);

/// Whether one order of the same vertices is an even permutation of the other.
bool is_even_permutation(const std::array<Index, 4>& a, const std::array<Index, 4>& b);

/// A half-face with its vertices in increasing order.
struct SortedHalfFace {
  std::array<Index, 3> vertices;
  Index tet;
  bool odd;  ///< whether the tetrahedron lists the vertices in an odd permutation
};

/// All half-faces, sorted by their vertices and then by tetrahedron. `threads` 0 means all.
std::vector<SortedHalfFace> sorted_half_faces(const TetMesh& mesh, int threads = 1);

/// The half-faces of the boundary and of the faces between regions, sorted as sorted_half_faces() does, and both
/// half-faces of few other faces. Faces of more than two tetrahedra, which a valid mesh does not have, may be missing.
std::vector<SortedHalfFace> half_faces_at_surface(const TetMesh& mesh, int threads = 1);

/// Calls f(begin, end) for each group of half-faces of the same face.
template <class F>
void for_each_face(const std::vector<SortedHalfFace>& half_faces, const F& f) {
  for (auto begin = half_faces.begin(); begin != half_faces.end();) {
    auto end = begin + 1;
    while (end != half_faces.end() && end->vertices == begin->vertices) ++end;
    f(begin, end);
    begin = end;
  }
}

/// Calls f(half_face, is_boundary) for each face of the boundary and between regions, in the order of their vertices,
/// with its half-face in the region of the lower tag.
template <class F>
void for_each_surface_face(const TetMesh& mesh, int threads, const F& f) {
  for_each_face(half_faces_at_surface(mesh, threads), [&](auto begin, auto end) {
    const auto region = [&](const SortedHalfFace& face) { return span_of(mesh.tet_tags)[face.tet]; };
    const bool is_boundary = end - begin == 1;
    if (!is_boundary && region(begin[0]) == region(begin[1])) return;
    f(is_boundary || region(begin[0]) < region(begin[1]) ? begin[0] : begin[1], is_boundary);
  });
}

/// The vertices of these faces, each in increasing order.
std::vector<std::array<Index, 3>> find_surface_faces(const TetMesh& mesh);

}  // namespace tetune
