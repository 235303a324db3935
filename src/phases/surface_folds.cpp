// SPDX-License-Identifier: Apache-2.0
#include "phases/surface_folds.hpp"

#include <algorithm>

#include "math/orient.hpp"

namespace tetune {
namespace {

Point3 to_array(const Point& p) { return {p.x, p.y, p.z}; }

/// Calls f(slot, v, normal) for each vertex v of each boundary face.
template <class F>
void for_boundary_corners(const HostMesh& mesh, const F& f) {
  const auto points = backend::span_of(mesh.points);
  const auto tet2tet = backend::span_of(mesh.tet2tet);
  Index slot = -1;
  for (const Tet& tet : mesh.tets) {
    ++slot;
    if (tet[0] == kFreeSlot) continue;
    for (int face = 0; face < 4; ++face) {
      if (tet2tet[slot][face] != kNoHalfFace) continue;
      const Vec3 origin = vec(points[tet[face_vertex(face, 0)]]);
      const Vec3 normal =
          cross(vec(points[tet[face_vertex(face, 1)]]) - origin, vec(points[tet[face_vertex(face, 2)]]) - origin);
      for (int k = 0; k < 3; ++k) f(slot, tet[face_vertex(face, k)], normal);
    }
  }
}

}  // namespace

std::vector<Index> exactly_tangled(const HostMesh& mesh, std::vector<Index> slots) {
  const auto points = backend::span_of(mesh.points);
  const auto tets = backend::span_of(mesh.tets);
  std::erase_if(slots, [&](Index slot) {
    const Tet& t = tets[slot];
    return orient_sign(to_array(points[t[0]]), to_array(points[t[1]]), to_array(points[t[2]]), to_array(points[t[3]])) >
           0;
  });
  return slots;
}

std::vector<std::uint8_t> folded_vertices(const HostMesh& mesh, const std::vector<VertexDof>& kind) {
  std::vector<Vec3> first_normal(kind.size(), Vec3{});
  std::vector<std::uint8_t> folded(kind.size(), 0);
  for_boundary_corners(mesh, [&, kind = backend::span_of(kind), first = backend::span_of(first_normal),
                              flags = backend::span_of(folded)](Index, Index v, const Vec3& normal) {
    if (kind[v] != VertexDof::plane) return;
    if (dot(first[v], first[v]) == 0) first[v] = normal;
    if (dot(first[v], normal) < 0) flags[v] = 1;
  });
  return folded;
}

std::vector<Index> newly_folded(const HostMesh& mesh, const std::vector<VertexDof>& kind,
                                const std::vector<std::uint8_t>& before) {
  const std::vector<std::uint8_t> folded = folded_vertices(mesh, kind);
  std::vector<Index> slots;
  if (std::find(folded.begin(), folded.end(), 1) == folded.end()) return slots;
  for_boundary_corners(mesh, [&slots, now = backend::span_of(folded), then = backend::span_of(before)](
                                 Index slot, Index v, const Vec3&) {
    if (now[v] != 0 && then[v] == 0) slots.push_back(slot);
  });
  return slots;
}

}  // namespace tetune
