// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/connect.hpp"
#include "core/upload.hpp"
#include "par/cpu.hpp"
#include "tetune/mesh.hpp"

/// A mesh in the optimiser's inner form, in the caller's order.
namespace tetune::test {

using CpuMesh = WorkMesh<par::Cpu>;

inline CpuMesh to_work(const TetMesh& mesh) { return upload_mesh<par::Cpu>(mesh); }

inline void lock_interfaces(const par::Cpu& cpu, CpuMesh& work, const TetMesh& original) {
  tetune::lock_interfaces(cpu, work, par::Cpu::Loan<int>(original.tet_tags).span());
}

/// `original` is the mesh that it was made from.
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

/// Plain oracle of adjacency: every face by its sorted vertices. Returns the first difference in words, or nothing.
inline std::string check_links(CpuMesh& work) {
  std::map<std::array<Index, 3>, std::vector<Link>> sides;
  const MeshView view = work.view();
  for (Size t = 0; t < work.slots(); ++t) {
    if (!view.alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      std::array<Index, 3> key{};
      for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = view.tet2vertex[t][face_vertex(f, k)];
      std::sort(key.begin(), key.end());
      sides[key].push_back(make_link(static_cast<Index>(t), f));
    }
  }
  for (const auto& [key, links] : sides) {
    if (links.size() > 2) return "a face on three tetrahedra";
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Link across = view.tet2tet[link_tet(links[i])][link_face(links[i])];
      const Link expected = links.size() == 1 ? kNoLink : links[1 - i];
      const Link found = across == kNoLink ? across : across & ~kLocked;
      if (found != expected)
        return "tetrahedron " + std::to_string(link_tet(links[i])) + " links wrongly at face " +
               std::to_string(link_face(links[i]));
    }
  }
  return "";
}

}  // namespace tetune::test
