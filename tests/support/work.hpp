// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/mesh.hpp"

/// The working mesh of the optimizer, in the caller's order.
namespace tetune::test {

using CpuMesh = WorkMesh<backend::Cpu>;

inline CpuMesh to_work(const TetMesh& mesh) { return upload_mesh(backend::Cpu(1), mesh); }

inline void lock_interfaces(const backend::Cpu& cpu, CpuMesh& work, const TetMesh& original) {
  tetune::lock_interfaces(cpu, work, backend::Cpu::DeviceView<int>(cpu, original.tet_tags).span());
}

/// The inverse of to_work(); `original` is the mesh that `work` was made from.
inline TetMesh from_work(CpuMesh& work, const TetMesh& original) {
  TetMesh mesh;
  const MeshView view = work.view();
  for (Size v = 0; v < work.vertices(); ++v)
    mesh.points.push_back({view.points[v].x, view.points[v].y, view.points[v].z});
  for (Size t = 0; t < work.slots(); ++t) {
    if (!view.alive(t)) continue;
    const Tet tet = view.tet2vertex[t];
    mesh.tets.push_back({tet[0], tet[1], tet[2], tet[3]});
    mesh.tet_tags.push_back(original.tet_tags[static_cast<std::size_t>(view.tet2original[t])]);
  }
  mesh.point_tags.assign(mesh.points.size(), 0);
  return mesh;
}

/// Compares adjacency with a plain oracle, a map from sorted vertices to half-faces. Returns a description of the first
/// difference, or an empty string.
inline std::string check_adjacency(CpuMesh& work) {
  std::map<std::array<Index, 3>, std::vector<HalfFace>> faces;
  const MeshView view = work.view();
  for (Index t = 0; t < work.slots(); ++t) {
    if (!view.alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      std::array<Index, 3> key{};
      for (std::size_t k = 0; k < 3; ++k) key[k] = view.tet2vertex[t][face_vertex(f, static_cast<int>(k))];
      faces[ascending(key)].push_back(make_half_face(t, f));
    }
  }
  for (const auto& [key, half_faces] : faces) {
    if (half_faces.size() > 2) return "a face on three tetrahedra";
    for (std::size_t i = 0; i < half_faces.size(); ++i) {
      const Index tet = tet_of(half_faces[i]);
      const int face = face_of(half_faces[i]);
      const HalfFace across = view.tet2tet[tet][face];
      const HalfFace expected = half_faces.size() == 1 ? kNoHalfFace : half_faces[1 - i];
      if ((across == kNoHalfFace ? across : across & ~kLocked) != expected) {
        return "tetrahedron " + std::to_string(tet) + " has a wrong neighbor at face " + std::to_string(face);
      }
    }
  }
  return "";
}

}  // namespace tetune::test
