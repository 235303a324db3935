// SPDX-License-Identifier: Apache-2.0
// Vertices inserted and removed in whole meshes, against plain checks.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "retriangulate_fixture.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Divides some tetrahedra by a vertex close to one of their faces.
TetMesh with_needless_vertices(TetMesh m, std::size_t every) {
  const std::size_t tets = m.tets.size();
  for (std::size_t t = 0; t < tets; t += every) {
    const std::array<Index, 4> tet = m.tets[t];
    Point3 p{};
    for (std::size_t k = 0; k < 4; ++k) {
      const Point3& q = m.points[static_cast<std::size_t>(tet[k])];
      for (std::size_t i = 0; i < 3; ++i) p[i] += (k == 0 ? 0.1 : 0.3) * q[i];
    }
    const auto v = static_cast<Index>(m.points.size());
    m.points.push_back(p);
    m.point_tags.push_back(0);
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<Index, 4> part = tet;
      part[k] = v;
      if (k == 0) {
        m.tets[t] = part;
      } else {
        m.tets.push_back(part);
        m.tet_tags.push_back(m.tet_tags[t]);
      }
    }
  }
  return m;
}

/// Revises a mesh pass by pass, and checks all that must hold after each.
RetriangulationReport check_retriangulations(const TetMesh& before, int passes, double cot, double vertex_cot = 0) {
  test::RetriangulationWork work(before);
  const auto old_surface = test::surface_places(before);
  const Quality old_quality = quality(before);
  double angle = old_quality.dihedral_min;
  RetriangulationReport sum;
  for (int pass = 0; pass < passes; ++pass) {
    const RetriangulationReport r = work.retriangulate(cot, 1 << 20, 1, vertex_cot);
    sum.others += r.others;
    sum.inserted += r.inserted;
    sum.removed += r.removed;
    EXPECT_EQ(test::check_adjacency(work.mesh), "");
    const TetMesh after = test::from_work(work.mesh, before);
    const ValidationReport valid = validate(after);
    EXPECT_TRUE(valid.ok()) << valid.message(false);
    EXPECT_EQ(test::surface_places(after), old_surface);
    // The energies are those of the new tetrahedra.
    std::vector<double> energies = work.flips.energies.download();
    refresh_energy(backend::Cpu(1), work.mesh, work.criterion, work.flips.energies);
    for (std::size_t t = 0; t < energies.size(); ++t) {
      const double exact = work.flips.energies.span()[static_cast<Size>(t)];
      EXPECT_NEAR(energies[t], exact, 1e-12 * exact);
    }
    const Quality now = quality(after);
    EXPECT_NEAR(now.volume, old_quality.volume, 1e-12 * old_quality.volume);
    EXPECT_GE(now.dihedral_min, angle * (1 - 1e-12));
    angle = now.dihedral_min;

    // Ids and arrays.
    std::vector<std::uint8_t> used(after.points.size(), 0);
    for (const auto& t : after.tets) {
      for (const Index v : t) used[static_cast<std::size_t>(v)] = 1;
    }
    Size inserted = 0;
    Size removed = 0;
    for (Size v = 0; v < work.mesh.vertices(); ++v) {
      const Index original = work.mesh.vertex2original.span()[v];
      const bool gone = original == kRemoved;
      EXPECT_EQ(used[static_cast<std::size_t>(v)], gone ? 0 : 1);
      inserted += v >= static_cast<Size>(before.points.size()) ? 1 : 0;
      removed += gone ? 1 : 0;
      EXPECT_TRUE(original < 0 || original == v);
    }
    EXPECT_EQ(inserted, sum.inserted);
    EXPECT_EQ(removed, sum.removed);
    for (const Size size : {work.dofs.dof.size(), work.dofs.axis.size(), work.dofs.active.size(),
                            work.flips.constrained_vertex.size(), work.mesh.vertex2original.size()}) {
      EXPECT_EQ(size, work.mesh.vertices());
    }
    if (r.inserted + r.removed + r.others == 0) break;
  }
  return sum;
}

TEST(Retriangulate, KeepsAMeshAMesh) {
  RetriangulationReport sum;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh m =
        seed % 2 == 0 ? test::two_materials(4, 0.15) : test::scrambled(test::cube(3, 0.25, seed), 2, seed);
    const RetriangulationReport r = check_retriangulations(with_needless_vertices(m, 8), 4, 2);
    sum.inserted += r.inserted;
    sum.removed += r.removed;
  }
  EXPECT_GT(sum.inserted, 5);
  EXPECT_GT(sum.removed, 20);
}

TEST(Retriangulate, KeepsTheVerticesWhereItRemovesEdgesAlone) {
  Size edges = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const TetMesh m = seed % 2 == 0 ? test::two_materials(6, 0.2) : test::scrambled(test::cube(5, 0.25, seed), 2, seed);
    const RetriangulationReport r = check_retriangulations(with_needless_vertices(m, 12), 4, 1.5, kInfeasible);
    EXPECT_EQ(r.inserted + r.removed, 0);
    edges += r.others;
  }
  EXPECT_GT(edges, 40);
}

/// Edges that must stay are not lost inside a cavity.
TEST(Retriangulate, KeepsConstrainedEdges) {
  Size edges = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const TetMesh m = with_needless_vertices(test::cube(4, 0.25, seed), 8);
    test::RetriangulationWork work(m);
    std::vector<std::uint64_t> keys;
    for (std::size_t t = 0; t < m.tets.size(); t += 7) {
      keys.push_back(ConstrainedEdges::edge_key(m.tets[t][0], m.tets[t][1]));
      for (int k = 0; k < 2; ++k) work.flips.constrained_vertex.span()[m.tets[t][static_cast<std::size_t>(k)]] = 1;
    }
    std::sort(keys.begin(), keys.end());
    work.flips.constrained_keys.upload(backend::Cpu(1), keys);
    for (int pass = 0; pass < 3; ++pass) edges += work.retriangulate(1.5, 1 << 20, 1, kInfeasible).others;
    std::set<std::uint64_t> left;
    for (const auto& t : test::from_work(work.mesh, m).tets) {
      for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t l = 0; l < k; ++l) left.insert(ConstrainedEdges::edge_key(t[k], t[l]));
      }
    }
    for (const std::uint64_t key : keys) EXPECT_EQ(left.count(key), 1U);
  }
  EXPECT_GT(edges, 10);
}

TEST(Retriangulate, IsTheSameForAnyNumberOfThreads) {
  const TetMesh m = with_needless_vertices(test::cube(6, 0.2), 20);
  std::vector<TetMesh> results;
  for (const int threads : {1, 2, 5}) {
    test::RetriangulationWork work(m);
    const RetriangulationReport r = work.retriangulate(2, 1 << 20, threads);
    EXPECT_GT(r.inserted, 0);
    EXPECT_GT(r.removed, 10);
    EXPECT_GT(r.others, 0);
    results.push_back(test::from_work(work.mesh, m));
  }
  for (const TetMesh& r : results) {
    EXPECT_EQ(r.points, results[0].points);
    EXPECT_EQ(r.tets, results[0].tets);
  }
}

}  // namespace
}  // namespace tetune
