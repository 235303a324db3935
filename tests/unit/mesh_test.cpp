// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "driver/report/extend_report.hpp"
#include "driver/report/unchanged.hpp"
#include "mesh/listed_faces.hpp"
#include "mesh/sort_mesh.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"

namespace tetune {
namespace {

using test::check_adjacency;
using test::to_work;

Size count_boundary_faces(test::CpuMesh& work) {
  Size count = 0;
  for (Size t = 0; t < work.slots(); ++t) {
    for (int f = 0; f < 4; ++f) count += work.view().tet2tet[t][f] == kNoHalfFace ? 1 : 0;
  }
  return count;
}

TEST(ListedFaces, AreFoundByTheirVerticesInAnyOrder) {
  const ListedFaces<3> faces({{{2, 0, 1}, 5}, {{3, 4, 1}, 1}, {{1, 2, 0}, 0}, {{-1, 4, 2}, 7}}, 6);
  const auto found = [&faces](const std::array<Index, 3>& face) {
    std::vector<Index> ids;
    faces.find(face, [&ids](Index id) { ids.push_back(id); });
    return ids;
  };
  EXPECT_EQ(found({0, 1, 2}), (std::vector<Index>{0, 5}));
  EXPECT_EQ(found({1, 4, 3}), std::vector<Index>{1});
  EXPECT_EQ(found({2, 4, -1}), std::vector<Index>{7});
  EXPECT_TRUE(found({2, 4, 1}).empty());
  EXPECT_TRUE(found({0, 1, 5}).empty());
  std::vector<std::pair<std::size_t, Index>> of_tet;
  faces.find_in_tet({1, 5, 0, 2}, [&of_tet](std::size_t k, Index id) { of_tet.emplace_back(k, id); });
  EXPECT_EQ(of_tet, (std::vector<std::pair<std::size_t, Index>>{{1, 0}, {1, 5}}));
}

TEST(Adjacency, TwoTetsShareOneFace) {
  auto work = to_work(test::two_tets(1));
  const AdjacencyReport report = build_adjacency(backend::Cpu(1), work);
  EXPECT_EQ(count_boundary_faces(work), 6);
  EXPECT_EQ(report.non_manifold_faces, 0);
  EXPECT_EQ(report.misoriented_faces, 0);
  EXPECT_EQ(work.tet2tet.span()[0][0], make_half_face(1, 0));
  EXPECT_EQ(work.tet2tet.span()[1][0], make_half_face(0, 0));
  EXPECT_EQ(work.tet2tet.span()[0][1], kNoHalfFace);
}

TEST(Adjacency, AgreesWithThePlainOracle) {
  for (const int threads : {1, 3}) {
    auto work = to_work(test::cube(6, 0.2));
    const AdjacencyReport report = build_adjacency(backend::Cpu(threads), work);
    EXPECT_TRUE(report.ok());
    EXPECT_EQ(count_boundary_faces(work), 6 * 2 * 36);
    EXPECT_EQ(check_adjacency(work), "");
  }
}

TEST(Adjacency, AnEdgeOfManyTetrahedraIsMatched) {
  // 500 tetrahedra around one edge: rows that are matched by sorting.
  TetMesh m;
  constexpr int n = 500;
  m.points = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < n; ++i)
    m.points.push_back({std::cos(2 * std::numbers::pi * i / n), std::sin(2 * std::numbers::pi * i / n), 0.5});
  for (int i = 0; i < n; ++i) m.tets.push_back({0, static_cast<Index>(2 + i), static_cast<Index>(2 + (i + 1) % n), 1});
  auto work = to_work(test::with_tags(m));
  EXPECT_TRUE(build_adjacency(backend::Cpu(2), work).ok());
  EXPECT_EQ(count_boundary_faces(work), 2 * n);
  EXPECT_EQ(check_adjacency(work), "");
}

TEST(Adjacency, CountsNonManifoldAndMisorientedFaces) {
  TetMesh m = test::two_tets(1);
  m.points.push_back({0, 0, 2});
  m.tets.push_back({5, 2, 4, 3});
  auto non_manifold = to_work(test::with_tags(m));
  EXPECT_EQ(build_adjacency(backend::Cpu(1), non_manifold).non_manifold_faces, 3);
  m.tets = {{0, 2, 4, 3}, {5, 2, 4, 3}};
  auto misoriented = to_work(test::with_tags(m));
  EXPECT_EQ(build_adjacency(backend::Cpu(1), misoriented).misoriented_faces, 1);
}

TEST(SortMesh, IsAPermutation) {
  const TetMesh mesh = test::cube(5, 0.2);
  auto work = to_work(mesh);
  sort_mesh(backend::Cpu(2), work);
  for (Size v = 0; v < work.vertices(); ++v) {
    const Point3& p = mesh.points[static_cast<std::size_t>(work.vertex2original.span()[v])];
    ASSERT_EQ(work.points.span()[v].x, p[0]);
  }
  for (Size t = 0; t < work.slots(); ++t) {
    const auto& original = mesh.tets[static_cast<std::size_t>(work.tet2original.span()[t])];
    for (int k = 0; k < 4; ++k) {
      ASSERT_EQ(work.vertex2original.span()[work.tet2vertex.span()[t][k]], original[static_cast<std::size_t>(k)]);
    }
  }
}

TEST(SortMesh, ARescaledMeshGetsTheSameOrder) {
  TetMesh mesh = test::cube(8, 0.2);
  auto work = to_work(mesh);
  for (auto& p : mesh.points) {
    for (double& x : p) x *= 1000;
  }
  auto scaled = to_work(mesh);
  sort_mesh(backend::Cpu(1), work);
  sort_mesh(backend::Cpu(1), scaled);
  EXPECT_EQ(work.vertex2original.download(), scaled.vertex2original.download());
}

TEST(DiscardResult, ForgetsATransferThatWasGivenUp) {
  const TetMesh mesh = test::cube(2);
  Report report;
  report.transfer_stopped = true;
  report.stop = StopReason::cancelled;
  discard_result(mesh, {}, "the mesh is as before", report);
  EXPECT_FALSE(report.transfer_stopped);
  EXPECT_EQ(report.stop, StopReason::cancelled);
  EXPECT_EQ(report.warnings, std::vector<std::string>{"the mesh is as before"});
}

TEST(ExtendReport, MapsOfListsThatEndEmptyAreEmpty) {
  const auto maps_after = [](std::size_t entries, const std::vector<Index>& further) {
    Report report;
    report.triangle2original = report.edge2original = {1, 3};
    Report next;
    next.triangle2original = next.edge2original = further;
    TetMesh result;
    result.triangles.resize(entries);
    result.edges.resize(entries);
    extend_report(report, std::move(next), result);
    EXPECT_EQ(report.triangle2original, report.edge2original);
    return report.edge2original;
  };
  EXPECT_EQ(maps_after(2, {}), (std::vector<Index>{1, 3}));
  EXPECT_EQ(maps_after(1, {1}), std::vector<Index>{3});
  EXPECT_TRUE(maps_after(0, {}).empty());
}

TEST(CompactSlots, DropsFreeSlots) {
  auto work = to_work(test::cube(2));
  work.tet2vertex.span()[3][0] = kFreeSlot;
  work.tet2vertex.span()[7][0] = kFreeSlot;
  const auto slots = compact_slots(backend::Cpu(1), work).download();
  EXPECT_EQ(work.slots(), 46);
  EXPECT_EQ(slots[3], 4);
  EXPECT_EQ(slots[45], 47);
}

}  // namespace
}  // namespace tetune
