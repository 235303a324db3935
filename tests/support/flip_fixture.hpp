// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "operators/flips/flip_pass.hpp"
#include "support/entities.hpp"
#include "support/work.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {

/// A mesh that flips are made in, under the harmonic energy, every tetrahedron active.
struct FlipFixture {
  TetMesh original;
  CpuMesh work;
  Criterion criterion;
  FlipState<backend::Cpu> state;
  backend::Cpu cpu{1};
  double energy = 0;
  std::vector<std::uint8_t> flipped;  ///< vertices whose ring has changed
  explicit FlipFixture(const TetMesh& mesh, const std::vector<std::array<Index, 2>>& constrained = {})
      : original(mesh), work(to_work(mesh)) {
    build_adjacency(cpu, work);
    lock_interfaces(cpu, work, mesh);
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> on_vertex(mesh.points.size(), 0);
    for (const auto& e : constrained) {
      keys.push_back(ConstrainedEdges::edge_key(e[0], e[1]));
      for (const Index v : e) on_vertex[static_cast<std::size_t>(v)] = 1;
    }
    std::sort(keys.begin(), keys.end());
    state.constrained_keys.upload(cpu, keys);
    state.constrained_vertex.upload(cpu, on_vertex);
    flipped.assign(mesh.points.size(), 0);
    energy = refresh_energy(cpu, work, criterion, state.energies);
    activate_all(cpu, work, criterion, state);
  }
  PassResult pass() { return flip_pass(cpu, work, criterion, state, flags()); }
  Span<std::uint8_t> flags() { return {flipped.data(), static_cast<Size>(flipped.size())}; }
  /// After passes near flips: activates all tetrahedra that may own a candidate changed by them. Returns false if there
  /// was no flip since the last call.
  bool activate_around_flips() {
    if (std::count(flipped.begin(), flipped.end(), 1) == 0) return false;
    activate_around(cpu, work, state, Span<const std::uint8_t>(flags()));
    std::fill(flipped.begin(), flipped.end(), std::uint8_t{0});
    return true;
  }
  /// Passes until there is no flip left.
  Size flip_to_the_last() {
    Size all = 0;
    do {
      for (Size found = 1; found > 0; all += found) found = pass().counts.flips();
    } while (activate_around_flips());
    return all;
  }
  TetMesh result() { return from_work(work, original); }
  void expect_consistent() {
    EXPECT_EQ(check_adjacency(work), "");
    for (const Index t : state.active.download()) EXPECT_TRUE(work.view().alive(t));
    const TetMesh mesh = result();
    const ValidationReport report = validate(mesh);
    EXPECT_TRUE(report.ok()) << report.message(false);
  }
};

/// The locked faces of a mesh, by their vertices.
inline std::set<std::array<Index, 3>> locked_faces(CpuMesh& work) {
  std::set<std::array<Index, 3>> faces;
  const MeshView view = work.view();
  for (Size t = 0; t < work.slots(); ++t) {
    for (int f = 0; f < 4 && view.alive(t); ++f) {
      if (!is_locked(view.tet2tet[t][f])) continue;
      std::array<Index, 3> face{};
      for (int k = 0; k < 3; ++k) face[static_cast<std::size_t>(k)] = view.tet2vertex[t][face_vertex(f, k)];
      faces.insert(ascending(face));
    }
  }
  return faces;
}

}  // namespace tetune::test
