// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "energy/dihedral_cots.hpp"
#include "mesh/connect.hpp"
#include "operators/stars/retriangulate.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"

namespace tetune::test {

/// The arguments of retriangulate_worst(); the vertices of the surface are fixed.
struct RetriangulationWork {
  CpuMesh mesh;
  Criterion criterion;
  FlipState<backend::Cpu> flips;
  VertexDofs<backend::Cpu> dofs;

  explicit RetriangulationWork(const TetMesh& m) : mesh(to_work(m)) {
    const backend::Cpu cpu(1);
    build_adjacency(cpu, mesh);
    lock_interfaces(cpu, mesh, m);
    criterion.objective = kShapeObjective;
    const std::size_t n = m.points.size();
    std::vector<Index> ids(n);
    for (std::size_t v = 0; v < n; ++v) ids[v] = static_cast<Index>(v);
    mesh.vertex2original.upload(cpu, ids);
    std::vector<VertexDof> kind(n, VertexDof::free);
    const MeshView view = mesh.view();
    for (Size t = 0; t < mesh.slots(); ++t) {
      for (int f = 0; f < 4; ++f) {
        for (int k = 0; k < 3 && is_locked(view.tet2tet[t][f]); ++k)
          kind[static_cast<std::size_t>(view.tet2vertex[t][face_vertex(f, k)])] = VertexDof::fixed;
      }
    }
    dofs.dof.upload(cpu, kind);
    dofs.axis.upload(cpu, std::vector<Vec3>(n, Vec3{0, 0, 0}));
    dofs.active.upload(cpu, std::vector<std::uint8_t>(n, 0));
    flips.constrained_vertex.upload(cpu, std::vector<std::uint8_t>(n, 0));
  }

  void constrain(Index a, Index b) {
    flips.constrained_keys.upload(backend::Cpu(1), {ConstrainedEdges::edge_key(a, b)});
    flips.constrained_vertex.span()[a] = flips.constrained_vertex.span()[b] = 1;
  }

  /// Around the tetrahedra with an angle whose cotangent is above `cot`.
  RetriangulationReport retriangulate(double cot = 0, Size most_tets = 1 << 20, int threads = 1,
                                      double vertex_cot = 0) {
    std::vector<Index> around;
    for (Size t = 0; t < mesh.slots(); ++t) {
      if (mesh.view().alive(t) && dihedral_cots(mesh.view(), t).max > cot) around.push_back(static_cast<Index>(t));
    }
    refresh_energy(backend::Cpu(1), mesh, criterion, flips.energies);
    return retriangulate_worst(backend::Cpu(threads), EditableMesh<backend::Cpu>{mesh, flips, dofs}, criterion,
                               {around.data(), static_cast<Size>(around.size())}, {most_tets, vertex_cot, 0.02});
  }
};

/// The faces on one tetrahedron, or between two of different tags, by the places of their corners.
inline std::multiset<std::array<Point3, 3>> surface_places(const TetMesh& m) {
  std::multiset<std::array<Point3, 3>> result;
  for (const auto& [face, tags] : face2tags(m)) {
    if (tags.size() == 2 && tags[0] == tags[1]) continue;
    std::array<Point3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = m.points[static_cast<std::size_t>(face[k])];
    std::sort(at.begin(), at.end());
    result.insert(at);
  }
  return result;
}

}  // namespace tetune::test
