// SPDX-License-Identifier: Apache-2.0
// Vertices inserted and removed in cavities made by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mesh/id_maps.hpp"
#include "retriangulate_fixture.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using Work = test::RetriangulationWork;
using test::surface_places;

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
  EXPECT_EQ(surface_places(after), surface_places(before));
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
std::array<double, 2> lower_mean(Work& work, Size max_tets, RetriangulationReport& report, bool is_selective = false) {
  const auto mean = [&work] {
    return refresh_energy(backend::Cpu(1), work.mesh, work.criterion, work.flips.energies) /
           static_cast<double>(work.mesh.tets());
  };
  const std::vector<Index> all = identity_map(static_cast<std::size_t>(work.mesh.slots()));
  const double before = mean();
  const EditableMesh<backend::Cpu> editable{work.mesh, work.flips, work.dofs};
  report = retriangulate_worst(backend::Cpu(1), editable, work.criterion, {all.data(), work.mesh.slots()},
                               {max_tets, kInfeasible, 1e-3, before, is_selective});
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

/// An icosahedron divided by a vertex close to one of its faces: twenty tetrahedra are around it.
TetMesh divided_icosahedron() {
  TetMesh m;
  constexpr double phi = std::numbers::phi;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-phi, phi}) {
      m.points.push_back({0, a, b});
      m.points.push_back({a, b, 0});
      m.points.push_back({b, 0, a});
    }
  }
  const auto at = [&m](std::int32_t v) { return vec(m.points[static_cast<std::size_t>(v)]); };
  const auto share_edge = [&](std::int32_t v, std::int32_t w) { return norm(at(v) - at(w)) < 2.1; };
  Vec3 near_face{};
  for (std::int32_t a = 0; a < 12; ++a) {
    for (std::int32_t b = a + 1; b < 12; ++b) {
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!share_edge(a, b) || !share_edge(b, c) || !share_edge(a, c)) continue;
        if (m.tets.empty()) near_face = 0.3 * (at(a) + at(b) + at(c));
        const bool is_outward = dot(at(a), cross(at(b), at(c))) > 0;
        m.tets.push_back(is_outward ? std::array{12, a, b, c} : std::array{12, a, c, b});
      }
    }
  }
  m.points.push_back({near_face.x, near_face.y, near_face.z});
  return test::with_tags(m);
}

TEST(Retriangulate, RemovesVerticesOfFewTetrahedraAloneWhereItIsSelective) {
  const TetMesh icosahedron = divided_icosahedron();
  ASSERT_TRUE(validate(icosahedron).ok());
  ASSERT_EQ(icosahedron.tets.size(), 20U);
  const auto removed = [](const TetMesh& mesh, bool is_selective) {
    Work work(mesh);
    RetriangulationReport report;
    const auto [before, after] = lower_mean(work, 0, report, is_selective);  // no insertion
    if (report.removed > 0) {
      EXPECT_LT(after, before);
    }
    return report.removed;
  };
  EXPECT_EQ(removed(icosahedron, false), 1);
  EXPECT_EQ(removed(icosahedron, true), 0);
  EXPECT_EQ(removed(divided_tet(), true), 1);
}

TEST(Retriangulate, InsertsAVertexWhereTheMeanEnergyFalls) {
  TetMesh wheel;
  wheel.points = {{0, 0, -1.5}, {0, 0, 1.5}};
  constexpr int kSpokes = 8;
  for (int k = 0; k < kSpokes; ++k) {
    const double angle = 2 * std::numbers::pi * k / kSpokes;
    wheel.points.push_back({std::cos(angle), std::sin(angle), 0});
    wheel.tets.push_back({0, 2 + k, 2 + (k + 1) % kSpokes, 1});
  }
  const TetMesh before = test::with_tags(wheel);
  ASSERT_TRUE(validate(before).ok());
  for (const bool is_selective : {false, true}) {
    Work work(before);
    RetriangulationReport report;
    const auto [mean_before, mean_after] = lower_mean(work, 1 << 20, report, is_selective);
    EXPECT_EQ(report.inserted, 1);
    EXPECT_EQ(work.mesh.tets(), 2 * kSpokes);
    EXPECT_LT(mean_after, 0.9 * mean_before);
    EXPECT_TRUE(validate(test::from_work(work.mesh, before)).ok());
  }
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
  EXPECT_EQ(surface_places(after), surface_places(before));
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

}  // namespace
}  // namespace tetune
