// SPDX-License-Identifier: Apache-2.0
// Vertices inserted and removed: on cavities made by hand, and against plain checks on whole meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "mesh/connect.hpp"
#include "operators/stars/retriangulate.hpp"
#include "relocation/minimize_angle_cost.hpp"
#include "relocation/rings.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The arguments of retriangulate_worst(); the vertices of the surface are fixed.
struct Work {
  test::CpuMesh mesh;
  Criterion criterion;
  FlipState<backend::Cpu> flips;
  VertexDofs<backend::Cpu> dofs;

  explicit Work(const TetMesh& m) : mesh(test::to_work(m)) {
    const backend::Cpu cpu(1);
    build_adjacency(cpu, mesh);
    test::lock_interfaces(cpu, mesh, m);
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
    BoundaryTriangles<backend::Cpu>* const no_surface = nullptr;
    return retriangulate_worst(backend::Cpu(threads), mesh, criterion, flips, dofs, no_surface,
                               {around.data(), static_cast<Size>(around.size())}, {most_tets, vertex_cot, 0.02});
  }
};

/// Four tetrahedra around the edge (0, 1), one of them a sliver whose four vertices are on the surface, as are all.
TetMesh sliver_on_the_surface() {
  TetMesh m;
  m.points = {{-1, 0, 0}, {1, 0, 0}, {0, -1, -0.1}, {0, 1, -0.1}, {0, 1.5, 1.5}, {0, -1.5, 1.5}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 4, 1}, {0, 4, 5, 1}, {0, 5, 2, 1}};
  return test::with_tags(m);
}

/// A regular tetrahedron divided by a vertex close to one of its faces.
TetMesh divided_tet() {
  TetMesh m;
  m.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-0.3, -0.3, -0.3}};
  m.tets = {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}, {0, 1, 2, 4}};
  for (auto& t : m.tets) std::swap(t[2], t[3]);
  return test::with_tags(m);
}

/// Vertex 5 is around the edge (0, 1), but so far beyond its end that the edge cannot be removed.
TetMesh vertex_beyond() {
  TetMesh m;
  m.points = {{-1.1, 0, 0}, {1, 0, 0}, {0, -1.4, -1.4}, {0, 1.4, -1.4}, {2.4, 0, 1.8}, {1.3, 0, 0.4}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 5, 1}, {0, 5, 2, 1}, {5, 0, 2, 4}, {5, 2, 1, 4}, {5, 1, 3, 4}, {5, 3, 0, 4}};
  return test::with_tags(m);
}

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

using Face = std::array<Point3, 3>;

/// The faces on one tetrahedron, or between two of different tags, by the places of their corners.
std::multiset<Face> surface(const TetMesh& m) {
  std::map<std::array<Index, 3>, std::vector<int>> faces;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<Index, 3> face{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != skip) face[at++] = m.tets[t][k];
      }
      std::sort(face.begin(), face.end());
      faces[face].push_back(m.tet_tags[t]);
    }
  }
  std::multiset<Face> result;
  for (const auto& [face, tags] : faces) {
    if (tags.size() == 2 && tags[0] == tags[1]) continue;
    Face at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = m.points[static_cast<std::size_t>(face[k])];
    std::sort(at.begin(), at.end());
    result.insert(at);
  }
  return result;
}

/// Revises a mesh pass by pass, and checks all that must hold after each.
RetriangulationReport check_retriangulations(const TetMesh& before, int passes, double cot, double vertex_cot = 0) {
  Work work(before);
  const auto old_surface = surface(before);
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
    EXPECT_EQ(surface(after), old_surface);
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

TEST(Retriangulate, InsertsAVertexAboveASliverOnTheSurface) {
  const TetMesh before = sliver_on_the_surface();
  ASSERT_TRUE(validate(before).ok());
  Work work(before);
  work.flips.max_ring = 3;                                  // no other operation opens the angle
  const RetriangulationReport r = work.retriangulate(1.7);  // 30 degrees
  EXPECT_EQ(r.inserted, 1);
  EXPECT_EQ(r.removed, 0);
  EXPECT_EQ(work.mesh.tets(), 8);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_adjacency(work.mesh), "");
  EXPECT_TRUE(validate(after).ok());
  EXPECT_EQ(surface(after), surface(before));
  EXPECT_GT(quality(after).dihedral_min, 2 * quality(before).dihedral_min);
  EXPECT_GT(after.points[6][2], 0.3);  // well above the edge it was put on
  EXPECT_EQ(work.mesh.vertex2original.span()[6], kInserted);
  EXPECT_EQ(work.dofs.dof.span()[6], VertexDof::free);
  for (Size v = 0; v < 7; ++v) EXPECT_EQ(work.dofs.active.span()[v], 1);
}

TEST(Retriangulate, RemovesAVertexCloseToAFace) {
  const TetMesh before = divided_tet();
  ASSERT_TRUE(validate(before).ok());
  Work work(before);
  const RetriangulationReport r = work.retriangulate(1.7);
  EXPECT_EQ(r.inserted, 0);
  EXPECT_EQ(r.removed, 1);
  EXPECT_EQ(work.mesh.tets(), 1);
  EXPECT_EQ(work.mesh.free_count, 3);
  EXPECT_EQ(work.mesh.vertex2original.span()[4], kRemoved);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_adjacency(work.mesh), "");
  EXPECT_NEAR(quality(after).dihedral_min, 70.5288, 1e-4);
}

/// The mean energy of a mesh, before and after one pass around all of its tetrahedra that lowers it.
std::array<double, 2> lower_mean(Work& work, Size max_tets, RetriangulationReport& report) {
  const auto mean = [&work] {
    return refresh_energy(backend::Cpu(1), work.mesh, work.criterion, work.flips.energies) /
           static_cast<double>(work.mesh.tets());
  };
  std::vector<Index> all(static_cast<std::size_t>(work.mesh.slots()));
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<Index>(t);
  const double before = mean();
  BoundaryTriangles<backend::Cpu>* const no_surface = nullptr;
  report = retriangulate_worst(backend::Cpu(1), work.mesh, work.criterion, work.flips, work.dofs, no_surface,
                               {all.data(), work.mesh.slots()}, {max_tets, kInfeasible, 1e-3, before});
  return {before, mean()};
}

TEST(Retriangulate, LowersTheMeanEnergy) {
  RetriangulationReport report;
  Work divided(divided_tet());
  // Fewer tetrahedra are allowed where there are more than the limit already.
  const auto [before_removal, after_removal] = lower_mean(divided, 0, report);
  EXPECT_EQ(report.removed, 1);
  EXPECT_NEAR(after_removal, 1, 1e-12);
  EXPECT_GT(before_removal, 1.5);
  // Of a regular mesh nothing is removed, although fewer tetrahedra have a lower sum of energies.
  const TetMesh regular = test::cube(3);
  Work same(regular);
  const auto [before, after] = lower_mean(same, 1 << 20, report);
  EXPECT_EQ(report.inserted + report.removed, 0);
  EXPECT_EQ(before, after);
}

TEST(Retriangulate, InsertsAVertexWhereTheMeanEnergyFalls) {
  TetMesh wheel;
  wheel.points = {{0, 0, -1.5}, {0, 0, 1.5}};
  constexpr int kSpokes = 8;
  for (int k = 0; k < kSpokes; ++k) {
    const double angle = 2 * 3.141592653589793 * k / kSpokes;
    wheel.points.push_back({std::cos(angle), std::sin(angle), 0});
    wheel.tets.push_back({0, 2 + k, 2 + (k + 1) % kSpokes, 1});
  }
  const TetMesh before = test::with_tags(wheel);
  ASSERT_TRUE(validate(before).ok());
  Work work(before);
  RetriangulationReport report;
  const auto [mean_before, mean_after] = lower_mean(work, 1 << 20, report);
  EXPECT_EQ(report.inserted, 1);
  EXPECT_EQ(work.mesh.tets(), 2 * kSpokes);
  EXPECT_LT(mean_after, 0.9 * mean_before);
  EXPECT_TRUE(validate(test::from_work(work.mesh, before)).ok());
}

TEST(Retriangulate, RemovesAnEdgeByMovingAVertexOfItsRing) {
  const TetMesh before = vertex_beyond();
  ASSERT_TRUE(validate(before).ok());
  const auto p = [&before](std::size_t v) { return vec(before.points[v]); };
  ASSERT_FALSE(orient(p(1), p(2), p(5), p(3)).certified());  // that of a 3-2 flip
  Work work(before);
  const RetriangulationReport r = work.retriangulate(1.7, 1 << 20, 1, kInfeasible);
  EXPECT_EQ(r.others, 1);
  EXPECT_EQ(r.inserted + r.removed, 0);
  EXPECT_EQ(work.mesh.tets(), 6);
  EXPECT_EQ(work.mesh.free_count, 1);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_adjacency(work.mesh), "");
  EXPECT_TRUE(validate(after).ok());
  EXPECT_EQ(surface(after), surface(before));
  EXPECT_LT(after.points[5][0], 1);
  for (std::size_t v = 0; v < 5; ++v) EXPECT_EQ(after.points[v], before.points[v]);
  for (const auto& t : after.tets) EXPECT_EQ(std::count(t.begin(), t.end(), 0) + std::count(t.begin(), t.end(), 1), 1);
  EXPECT_GT(quality(after).dihedral_min, 2 * quality(before).dihedral_min);
  EXPECT_EQ(work.mesh.vertex2original.span()[5], 5);
  EXPECT_EQ(work.dofs.active.span()[5], 1);
}

TEST(Retriangulate, RemovesNoEdgeByAVertexThatMustStay) {
  const TetMesh m = vertex_beyond();
  {
    Work work(m);
    work.dofs.dof.span()[5] = VertexDof::fixed;
    EXPECT_EQ(work.retriangulate(1.7, 1 << 20, 1, kInfeasible).others, 0);
  }
  for (const std::array<Index, 2>& edge : {std::array<Index, 2>{0, 1}, std::array<Index, 2>{4, 5}}) {
    Work work(m);
    work.constrain(edge[0], edge[1]);
    EXPECT_EQ(work.retriangulate(1.7, 1 << 20, 1, kInfeasible).others, 0);
  }
  TetMesh two = m;
  two.tet_tags = {1, 2, 2, 2, 2, 2, 2};
  Work work(two);
  work.dofs.dof.span()[5] = VertexDof::free;
  EXPECT_EQ(work.retriangulate(1.7, 1 << 20, 1, kInfeasible).others, 0);
}

TEST(Retriangulate, LeavesAloneWhatIsConstrained) {
  {
    Work work(sliver_on_the_surface());
    work.constrain(0, 1);
    EXPECT_EQ(work.retriangulate().inserted, 0);
  }
  {
    TetMesh m = sliver_on_the_surface();
    m.tet_tags = {1, 2, 2, 2};  // the faces at the edge are an interface
    Work work(m);
    EXPECT_EQ(work.retriangulate().inserted, 0);
  }
  {
    Work work(divided_tet());
    work.dofs.dof.span()[4] = VertexDof::fixed;
    EXPECT_EQ(work.retriangulate(1.7).removed, 0);
  }
}

TEST(Retriangulate, KeepsToTheFloorAndToTheNumberOfTetrahedra) {
  {
    Work work(sliver_on_the_surface());
    const RetriangulationReport r = work.retriangulate(1.7, 7);
    EXPECT_EQ(r.inserted + r.removed, 0);
    EXPECT_EQ(work.mesh.vertices(), 6);
    EXPECT_LE(work.mesh.tets(), 7);
  }
  {
    Work work(sliver_on_the_surface());
    work.flips.max_ring = 3;
    EXPECT_EQ(work.retriangulate(1.7, 7).inserted, 0);
    EXPECT_EQ(work.retriangulate(1.7, 8).inserted, 1);
  }
  Work work(sliver_on_the_surface());
  work.criterion.floor = {1.01, kInfeasible};  // nothing worse than regular
  EXPECT_EQ(work.retriangulate().inserted, 0);
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
    Work work(m);
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
    Work work(m);
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

TEST(MinimizeAngleCost, MovesFlaggedVerticesAloneAndNoAngleBecomesSmaller) {
  TetMesh m = test::cube(5, 0.2);
  Work work(m);
  const backend::Cpu cpu(2);
  Rings<backend::Cpu> rings;
  build_rings(cpu, work.mesh, rings);
  Coloring<backend::Cpu> coloring;
  color_vertices(cpu, rings.view(), work.dofs.dof.span(), coloring);
  std::vector<std::uint8_t> flags(m.points.size(), 0);
  for (std::size_t v = 0; v < flags.size(); v += 2) flags[v] = 1;
  backend::Cpu::Buffer<std::uint8_t> buffer;
  buffer.upload(cpu, flags);
  const Size moved = minimize_angle_cost(cpu, work.mesh, work.criterion, rings.view(), coloring, work.dofs,
                                         Span<const std::uint8_t>(buffer.span()), 0.5)
                         .get()
                         .value;
  const TetMesh after = test::from_work(work.mesh, m);
  EXPECT_TRUE(validate(after).ok());
  EXPECT_GE(quality(after).dihedral_min, quality(m).dihedral_min);
  EXPECT_GT(quality(after).dihedral_1, quality(m).dihedral_1 + 1);
  Size changed = 0;
  for (std::size_t v = 0; v < flags.size(); ++v) {
    if (after.points[v] == m.points[v]) continue;
    ++changed;
    EXPECT_EQ(flags[v], 1);
    EXPECT_EQ(work.dofs.dof.span()[static_cast<Size>(v)], VertexDof::free);
  }
  EXPECT_EQ(changed, moved);
  EXPECT_GT(moved, 10);
}

}  // namespace
}  // namespace tetune
