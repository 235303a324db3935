// SPDX-License-Identifier: Apache-2.0
// 200 small meshes of the kinds of bench/robustness: every promise on each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <random>
#include <string>

#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sanitized.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

constexpr std::uint32_t kSeeds = test::kSanitized ? 8 : 40;

/// Degrees: of one and the same tetrahedron with its vertices in another order.
constexpr double kRounding = 1e-12;
constexpr double kRoundingOfLargest = 3e-11;  // degrees: its cotangent may grow by a part of 1e-12

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
}

int below(std::mt19937& random, int n) { return static_cast<int>(random() % static_cast<std::uint32_t>(n)); }

std::uint32_t seed(std::mt19937& random) { return static_cast<std::uint32_t>(random()); }

TetMesh jittered(std::mt19937& random, int least) {
  const int n = least + below(random, 4);
  const double jitter = uniform(random, 0, 0.2);
  return test::cube(n, jitter, seed(random));
}

/// Layers, balls or loose tetrahedra of other materials.
void add_materials(TetMesh& m, std::mt19937& random) {
  const int kind = below(random, 4);
  const Point3 middle{uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1)};
  const double radius = uniform(random, 0.2, 0.5);
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    const Point3 c = test::centroid(m, t);
    if (kind == 1) m.tet_tags[t] = 1 + static_cast<int>(3 * c[2]);
    if (kind == 2) m.tet_tags[t] = std::hypot(c[0] - middle[0], c[1] - middle[1], c[2] - middle[2]) < radius ? 2 : 1;
    if (kind == 3) m.tet_tags[t] = random() % 10 == 0 ? 2 : 1;
  }
}

TetMesh lattice(std::mt19937& random) {
  TetMesh m = jittered(random, 4);
  add_materials(m, random);
  const int rounds = below(random, 3);
  return test::scrambled(std::move(m), rounds, seed(random));
}

/// Cells that grow along each axis by up to 20 times, somewhere between 1e-6 and 1e6 in size, off the axes.
TetMesh graded(std::mt19937& random) {
  TetMesh m = jittered(random, 4);
  add_materials(m, random);
  const double size = std::pow(10, uniform(random, -6, 6));
  const Point3 growth{uniform(random, 0.1, 3), uniform(random, 0.1, 3), uniform(random, 0.1, 3)};
  for (Point3& p : m.points) {
    for (std::size_t k = 0; k < 3; ++k) p[k] = size * std::expm1(growth[k] * p[k]) / std::expm1(growth[k]);
    p = {p[0] + 0.3 * p[1], p[1] - 0.2 * p[2], p[2] + 0.1 * p[0]};
  }
  return m;
}

/// Few layers, 10 to 1000 times as wide as thick.
TetMesh plate(std::mt19937& random) {
  TetMesh m = jittered(random, 2);
  if (random() % 2 == 0) add_materials(m, random);
  const double thickness = std::pow(10, -uniform(random, 1, 3));
  for (Point3& p : m.points) p[2] *= thickness;
  return m;
}

TetMesh ball(std::mt19937& random) {
  const int n = 4 + below(random, 4);
  const double jitter = uniform(random, 0, 0.15);
  return test::ball(n, jitter, seed(random));
}

TetMesh waved(std::mt19937& random) {
  TetMesh m = jittered(random, 4);
  add_materials(m, random);
  const double height = uniform(random, 0.01, 0.08);
  return test::waved(std::move(m), seed(random), height);
}

struct Family {
  const char* name;
  TetMesh (*make)(std::mt19937&);
};

void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }

/// Freezes something of the mesh; returns, for each vertex, whether it must not move.
std::vector<std::uint8_t> freeze(TetMesh& m, Options& options, std::mt19937& random) {
  std::vector<std::uint8_t> frozen(m.points.size(), 0);
  switch (random() % 4) {
    case 0:
      for (std::size_t v = 0; v < m.points.size(); ++v) {
        if (random() % 10 == 0) frozen[v] = 1;
      }
      for (std::size_t v = 0; v < frozen.size(); ++v) {
        if (frozen[v] != 0) m.required_vertices.push_back(static_cast<Index>(v));
      }
      break;
    case 1:
      for (const test::SkinFace& f : test::skin(m)) {
        if (random() % 10 != 0) continue;
        m.required_triangles.push_back(static_cast<Index>(m.triangles.size()));
        m.triangles.push_back({f.v[0], f.v[1], f.v[2]});
        m.triangle_tags.push_back(0);
        for (const Index v : f.v) frozen[static_cast<std::size_t>(v)] = 1;
      }
      break;
    case 2:
      options.frozen_regions = {2};
      for (std::size_t t = 0; t < m.tets.size(); ++t) {
        if (m.tet_tags[t] != 2) continue;
        for (const Index v : m.tets[t]) frozen[static_cast<std::size_t>(v)] = 1;
      }
      if (std::count(m.tet_tags.begin(), m.tet_tags.end(), 2) == 0) options.frozen_regions.clear();
      break;
    default:
      break;
  }
  return frozen;
}

class Robustness : public testing::TestWithParam<Family> {};

TEST_P(Robustness, EveryPromiseHolds) {
  for (std::uint32_t s = 1; s <= kSeeds; ++s) {
    SCOPED_TRACE(s);
    std::mt19937 random(s);
    TetMesh before = GetParam().make(random);
    Options options;
    options.boundary = s % 3 == 0 ? Boundary::fixed : s % 3 == 1 ? Boundary::preserve : Boundary::slide;
    const std::vector<std::uint8_t> frozen = freeze(before, options, random);
    ASSERT_TRUE(validate(before).ok());

    TetMesh after = before;
    options.threads = 1;
    optimize(after, options);
    const ValidationReport valid = validate(after);
    ASSERT_TRUE(valid.ok()) << valid.message(false);
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - kRounding);
    EXPECT_LE(quality(after).dihedral_max, std::max(quality(before).dihedral_max, 165.0) + kRoundingOfLargest);
    EXPECT_LE(quality(after).shape_sum, quality(before).shape_sum * (1 + 1e-12));
    ASSERT_EQ(after.points.size(), before.points.size());
    for (std::size_t v = 0; v < frozen.size(); ++v) {
      if (frozen[v] != 0) {
        EXPECT_EQ(after.points[v], before.points[v]) << "vertex " << v;
      }
    }
    EXPECT_EQ(after.triangles, before.triangles);
    EXPECT_EQ(after.required_triangles, before.required_triangles);
    EXPECT_EQ(after.required_vertices, before.required_vertices);
    const Comparison change = compare(before, after);
    EXPECT_TRUE(change.tet_tags_kept && change.vertex_tags_kept && change.triangle_tags_kept);
    const bool slides = options.boundary == Boundary::slide;
    EXPECT_LT(change.vertices_to_old, slides ? 1e-3 : 1e-6);
    if (!slides) {
      EXPECT_LT(std::max(change.new_to_old, change.old_to_new), 1e-6);
    }

    TetMesh again = before;
    options.threads = 3;
    optimize(again, options);
    EXPECT_EQ(again.points, after.points);
    EXPECT_EQ(again.tets, after.tets);
    EXPECT_EQ(again.tet_tags, after.tet_tags);
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Robustness,
                         testing::Values(Family{"lattice", lattice}, Family{"graded", graded}, Family{"plate", plate},
                                         Family{"ball", ball}, Family{"waved", waved}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace tetune
