// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/arc.hpp"
#include "core/gather.hpp"
#include "core/hilbert.hpp"
#include "core/orient.hpp"
#include "meshes.hpp"
#include "work.hpp"

namespace tetune {
namespace {

using test::check_links;
using test::to_work;

TEST(Hilbert, NeighboursOnTheCurveAreNeighboursInSpace) {
  constexpr std::uint32_t kCells = 8;
  constexpr std::uint32_t kStep = static_cast<std::uint32_t>(kHilbertCells) / kCells;
  std::map<std::uint64_t, std::array<int, 3>> along;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        along[hilbert_index(static_cast<std::uint32_t>(x) * kStep, static_cast<std::uint32_t>(y) * kStep,
                            static_cast<std::uint32_t>(z) * kStep) >>
              (kHilbertBits - 9)] = {x, y, z};
      }
    }
  }
  ASSERT_EQ(along.size(), 512U);
  const std::array<int, 3>* last = nullptr;
  for (const auto& [index, cell] : along) {
    if (last != nullptr) {
      EXPECT_EQ(std::abs(cell[0] - (*last)[0]) + std::abs(cell[1] - (*last)[1]) + std::abs(cell[2] - (*last)[2]), 1);
    }
    last = &cell;
  }
}

TEST(Orient, FilterNeverContradictsExactArithmetic) {
  std::mt19937 random(5);
  int doubtful = 0;
  for (int i = 0; i < 20000; ++i) {
    // Points close to one plane, a few last bits apart.
    Point3 p[4];
    for (auto& q : p) {
      const double u = static_cast<double>(random()) / 4294967296.0;
      const double v = static_cast<double>(random()) / 4294967296.0;
      q = {u, v, 0.3 * u + 0.7 * v + 1e-16 * (static_cast<double>(random() % 9) - 4)};
    }
    const Orient o = orient(vec(p[0]), vec(p[1]), vec(p[2]), vec(p[3]));
    const int exact = orient_sign(p[0], p[1], p[2], p[3]);
    if (o.certified()) {
      EXPECT_EQ(exact, 1);
    } else if (o.det < -o.bound) {
      EXPECT_EQ(exact, -1);
    } else {
      ++doubtful;
    }
  }
  EXPECT_GT(doubtful, 1000);
}

TEST(Orient, ExactSignAgreesWithIntegers) {
  std::mt19937 random(7);
  int zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    long long c[4][3];
    Point3 p[4];
    for (int k = 0; k < 4; ++k) {
      for (int a = 0; a < 3; ++a) {
        c[k][a] = static_cast<long long>(random() % 5) - 2 + (1LL << 50);
        p[k][static_cast<std::size_t>(a)] = static_cast<double>(c[k][a]);
      }
    }
    long long d[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int a = 0; a < 3; ++a) d[k][a] = c[k + 1][a] - c[0][a];
    }
    const long long det = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                          d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                          d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[3]), det > 0 ? 1 : det < 0 ? -1 : 0);
    zeros += det == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 100);
}

TEST(Orient, ExactSignDoesNotUnderflow) {
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e-150, 0, 0}, {0, 1e-150, 0}, {0, 0, 1e-150}), 1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e-150, 0, 0}, {0, 0, 1e-150}, {0, 1e-150, 0}), -1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e150, 0, 0}, {0, 1e150, 0}, {1e150, 1e150, 0}), 0);
}

TEST(Orient, ExactSignHoldsForAnyMagnitudes) {
  std::mt19937_64 random(13);
  const auto any = [&random] {
    for (;;) {
      const double x = std::bit_cast<double>(random());
      if (std::isfinite(x)) return random() % 4 == 0 ? std::ldexp(x, -1000) : x;
    }
  };
  int solid = 0;
  for (int i = 0; i < 20000; ++i) {
    Point3 p[4];
    for (Point3& q : p) q = {any(), any(), any()};
    const int sign = orient_sign(p[0], p[1], p[2], p[3]);
    EXPECT_EQ(orient_sign(p[0], p[1], p[3], p[2]), -sign);
    EXPECT_EQ(orient_sign(p[1], p[2], p[3], p[0]), -sign);
    solid += sign != 0 ? 1 : 0;
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[1]), 0);
    EXPECT_EQ(orient_sign(p[0], p[0], p[2], p[1]), 0);
    for (Point3& q : p) q[2] = q[0];
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[3]), 0);
  }
  EXPECT_GT(solid, 19000);
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(orient_sign({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {3, 3, least}), 1);
  EXPECT_EQ(orient_sign({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {3, 3, -least}), -1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {least, 0, 0}, {0, least, 0}, {0, 0, least}), 1);
  const double most = std::numeric_limits<double>::max();
  EXPECT_EQ(orient_sign({-most, -most, -most}, {most, -most, -most}, {-most, most, -most}, {-most, -most, most}), 1);
}

TEST(Adjacency, TwoTetsShareOneFace) {
  auto work = to_work(test::two_tets(1));
  const AdjacencyReport report = build_adjacency(par::Cpu(1), work);
  EXPECT_EQ(report.boundary_faces, 6);
  EXPECT_EQ(report.crowded_faces, 0);
  EXPECT_EQ(report.same_side_faces, 0);
  EXPECT_EQ(work.tet2tet.span()[0][0], make_link(1, 0));
  EXPECT_EQ(work.tet2tet.span()[1][0], make_link(0, 0));
  EXPECT_EQ(work.tet2tet.span()[0][1], kNoLink);
}

TEST(Adjacency, AgreesWithThePlainOracle) {
  for (const int threads : {1, 3}) {
    auto work = to_work(test::cube(6, 0.2));
    const AdjacencyReport report = build_adjacency(par::Cpu(threads), work);
    EXPECT_EQ(report.boundary_faces, 6 * 2 * 36);
    EXPECT_EQ(report.crowded_faces + report.same_side_faces, 0);
    EXPECT_EQ(check_links(work), "");
  }
}

TEST(Adjacency, ALargeFanIsMatchedToo) {
  // 500 tetrahedra around one edge: rows far beyond the size kept in registers.
  TetMesh m;
  constexpr int n = 500;
  m.points = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < n; ++i) m.points.push_back({std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n), 0.5});
  for (int i = 0; i < n; ++i) m.tets.push_back({0, static_cast<Index>(2 + i), static_cast<Index>(2 + (i + 1) % n), 1});
  auto work = to_work(test::with_tags(m));
  EXPECT_EQ(build_adjacency(par::Cpu(2), work).boundary_faces, 2 * n);
  EXPECT_EQ(check_links(work), "");
}

TEST(Adjacency, FindsFacesThatAreThereTwice) {
  for (const TetMesh& m : {test::one_tet(), test::two_tets(1), test::cube(9, 0.2)}) {
    auto work = to_work(m);
    build_adjacency(par::Cpu(2), work);
    EXPECT_EQ(count_doubled_faces(par::Cpu(2), work), 0);
  }
  // A tetrahedron over a face of an inner one, not linked with it.
  TetMesh m = test::cube(4);
  m.points.push_back({2, 3, 5});
  const auto inner = m.tets[m.tets.size() / 2];
  m.tets.push_back({inner[0], inner[1], inner[2], static_cast<Index>(m.points.size() - 1)});
  m.tet_tags.push_back(0);
  m.point_tags.resize(m.points.size());
  auto work = to_work(m);
  build_adjacency(par::Cpu(1), work);
  EXPECT_EQ(count_doubled_faces(par::Cpu(1), work), 2) << "sides of the face beyond the first";
}

TEST(Adjacency, CountsCrowdedAndOneSidedFaces) {
  TetMesh m = test::two_tets(1);
  m.points.push_back({0, 0, 2});
  m.tets.push_back({5, 2, 4, 3});
  auto crowded = to_work(test::with_tags(m));
  EXPECT_EQ(build_adjacency(par::Cpu(1), crowded).crowded_faces, 3);
  m.tets = {{0, 2, 4, 3}, {5, 2, 4, 3}};
  auto one_sided = to_work(test::with_tags(m));
  EXPECT_EQ(build_adjacency(par::Cpu(1), one_sided).same_side_faces, 1);
}

TEST(SortMesh, PermutesWithoutLoss) {
  const TetMesh mesh = test::cube(5, 0.2);
  auto work = to_work(mesh);
  sort_mesh(par::Cpu(2), work);
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
  sort_mesh(par::Cpu(1), work);
  sort_mesh(par::Cpu(1), scaled);
  EXPECT_EQ(work.vertex2original.download(), scaled.vertex2original.download());
}

TEST(CompactSlots, DropsFreeSlots) {
  auto work = to_work(test::cube(2));
  work.tet2vertex.span()[3][0] = kFreeSlot;
  work.tet2vertex.span()[7][0] = kFreeSlot;
  const auto slots = compact_slots(par::Cpu(1), work).download();
  EXPECT_EQ(work.slots(), 46);
  EXPECT_EQ(slots[3], 4);
  EXPECT_EQ(slots[45], 47);
}

TEST(Arc, IsTheAngle) {
  for (int i = 0; i <= 20000; ++i) {
    const double angle = std::numbers::pi * i / 20000;
    for (const double length : {1e-150, 1.0, 1e150}) {
      ASSERT_NEAR(arc(length * std::sin(angle), length * std::cos(angle)), angle, 4e-15);
    }
  }
  for (const double small : {1e-300, 1e-20, 1e-10}) EXPECT_NEAR(arc(small, 1.0), small, 1e-14 * small);
  EXPECT_EQ(arc(0.0, 0.0), 0);
  EXPECT_EQ(arc(0.0, 1.0), 0);
  EXPECT_NEAR(arc(0.0, -1.0), std::numbers::pi, 1e-15);
}

TEST(Arc, OfPacksIsThatOfEachLane) {
  const par::Pack y{0, 1, 0.25, 1e-9};
  const par::Pack x{-2, 0, -3, 1};
  const par::Pack angles = arc(y, x);
  for (int l = 0; l < kLanesOf<par::Pack>; ++l) EXPECT_EQ(angles[l], arc(lane(y, l), lane(x, l)));
}

}  // namespace
}  // namespace tetune
