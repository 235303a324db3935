// SPDX-License-Identifier: Apache-2.0
// The promises of optimize(), checked on many meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/constrained.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sanitized.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(Optimize, NoMeanRatioIsBelowTheSmallestOfTheInput) {
  constexpr std::uint32_t kPlates = test::kSanitized ? 1 : 4;
  for (std::uint32_t seed = 1; seed <= kPlates; ++seed) {
    // Plates, which the shape energy alone would make needles.
    TetMesh before = test::cube(6, 0.2, seed);
    for (Point3& p : before.points) p[2] /= 12;
    for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
      Options options;
      options.effort = effort;
      TetMesh after = before;
      optimize(after, options);
      const double part = effort == Effort::best ? 0.25 : 1;
      EXPECT_GE(quality(after).mean_ratio_min, part * quality(before).mean_ratio_min * (1 - 1e-9));
      EXPECT_LT(quality(after).shape_sum, quality(before).shape_sum);
    }
  }
}

/// Three materials in a cube of n layers of elements: the second one is a layer 1/50 as thick as the others, whose
/// surfaces force their small angles on it.
TetMesh with_thin_layer(int n, double jitter) {
  TetMesh mesh = test::cube(n, jitter);
  const TetMesh lattice = test::cube(n);
  const int below = n / 2;
  const auto level_of = [n](std::size_t v) { return static_cast<int>(v) / ((n + 1) * (n + 1)); };
  constexpr double kThickness = 0.02;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const int level = level_of(v);
    if (level == below || level == below + 1) mesh.points[v] = lattice.points[v];
    if (level > below) mesh.points[v][2] -= (1 - kThickness) / n;
  }
  mesh.tet_tags.clear();
  for (const auto& tet : mesh.tets) {
    int lowest = n;
    for (const Index v : tet) lowest = std::min(lowest, level_of(static_cast<std::size_t>(v)));
    mesh.tet_tags.push_back(lowest < below ? 1 : lowest == below ? 2 : 3);
  }
  return mesh;
}

TEST(Optimize, ElementsThatCannotImproveDoNotSpoilTheOthers) {
  const TetMesh before = with_thin_layer(6, 0.25);
  const Quality input = quality(before);
  TetMesh standard = before;
  optimize(standard);
  const double mean_ratio = quality(standard).mean_ratio;
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
      Options options;
      options.effort = effort;
      options.boundary = boundary;
      TetMesh after = before;
      optimize(after, options);
      const Quality q = quality(after);
      EXPECT_GE(q.dihedral_min, input.dihedral_min * (1 - 1e-9));
      EXPECT_LT(q.dihedral_max, std::max(input.dihedral_max, 165.0) + 1e-9);
      EXPECT_GT(q.mean_ratio, effort == Effort::fast ? input.mean_ratio + 0.02 : mean_ratio - 1e-3);
    }
  }
}

TEST(Optimize, BestOpensTheSmallestAngles) {
  const TetMesh before = test::scrambled(test::cube(8, 0.25), 3);
  TetMesh standard = before;
  optimize(standard);
  Options options;
  options.effort = Effort::best;
  TetMesh best = before;
  const Report report = optimize(best, options);
  EXPECT_GT(report.vertices_inserted, 0);
  EXPECT_GT(report.compound_flips, 0);
  options.keep_vertices = true;
  TetMesh kept = before;
  const Report kept_report = optimize(kept, options);
  EXPECT_EQ(kept_report.vertices_inserted + kept_report.vertices_removed, 0);
  EXPECT_TRUE(kept_report.vertex2original.empty());
  EXPECT_EQ(kept.points.size(), before.points.size());
  EXPECT_GT(quality(best).dihedral_min, quality(standard).dihedral_min + 2);
  EXPECT_GT(quality(kept).dihedral_min, quality(standard).dihedral_min);
  EXPECT_GT(quality(best).mean_ratio, quality(standard).mean_ratio - 0.01);
}

TEST(Optimize, InsertsWithinTheAllowedGrowth) {
  // Stretched elements, which improve by vertices between theirs.
  TetMesh before = test::cube(6, 0.1, 3);
  for (Point3& p : before.points) p[2] *= 4;
  const auto tets = static_cast<double>(before.tets.size());
  std::vector<double> growths;
  for (const double max_growth : {1.0, 1.1, 2.0}) {
    Options options;
    options.effort = Effort::best;
    options.max_growth = max_growth;
    TetMesh after = before;
    optimize(after, options);
    ASSERT_TRUE(validate(after).ok());
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min);
    growths.push_back(static_cast<double>(after.tets.size()) / tets);
    EXPECT_LE(growths.back(), max_growth);
  }
  EXPECT_GT(growths.back(), 1.1);
}

TEST(Optimize, RemovesAtMostATenthOfTheVertices) {
  // Flat elements, which improve where there are fewer of them.
  TetMesh before = test::cube(6);
  for (Point3& p : before.points) p[2] *= 0.02;
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    Options options;
    options.effort = Effort::best;
    options.boundary = boundary;
    TetMesh after = before;
    const Report report = optimize(after, options);
    EXPECT_GT(report.vertices_removed, 0);
    EXPECT_GT(double(after.points.size()) + 1, 0.9 * double(before.points.size()));
  }
}

/// For each vertex half the mean length of its edges on the boundary; 0 for inner ones.
std::vector<double> half_surface_edges(const TetMesh& mesh) {
  std::vector<double> sum(mesh.points.size(), 0);
  std::vector<int> count(mesh.points.size(), 0);
  for (const auto& face : test::skin(mesh)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(face.v[k]);
      for (std::size_t other = 0; other < 3; ++other) {
        if (other == k) continue;
        sum[v] += norm(vec(mesh.points[static_cast<std::size_t>(face.v[other])]) - vec(mesh.points[v]));
        ++count[v];
      }
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = count[v] > 0 ? 0.5 * sum[v] / count[v] : 0;
  return sum;
}

TEST(Optimize, TheSurfaceKeepsItsSizes) {
  TetMesh before = test::cube(8, 0.2);
  for (auto& p : before.points) p[2] *= 0.02;
  const std::vector<double> half = half_surface_edges(before);
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const Relocation relocation : {Relocation::newton, Relocation::gradient}) {
      const double part = boundary == Boundary::slide ? 1.5 : 1;
      for (const Energy energy : {Energy::shape, Energy::harmonic}) {
        TetMesh after = before;
        Options options;
        options.boundary = boundary;
        options.relocation = relocation;
        options.energy = energy;
        if (energy == Energy::shape) options.effort = Effort::fast;
        optimize(after, options);
        double most = 0;
        for (std::size_t v = 0; v < half.size(); ++v) {
          if (half[v] > 0) most = std::max(most, norm(vec(after.points[v]) - vec(before.points[v])) / half[v]);
        }
        if (energy == Energy::shape) {
          EXPECT_LT(most, part * (1 + 1e-9));
          EXPECT_GT(most, 0.9 * part) << "no vertex reached its bound";
        } else if (relocation == Relocation::newton) {
          EXPECT_GT(most, part) << "the harmonic energy has no bound on the displacement";
        }
      }
    }
  }
}

TEST(Optimize, InFixedModeNoSurfaceVertexMoves) {
  const TetMesh before = test::cube(5, 0.2);
  TetMesh after = before;
  Options options;
  options.boundary = Boundary::fixed;
  optimize(after, options);
  std::size_t moved = 0;
  for (std::size_t v = 0; v < before.points.size(); ++v) {
    const Point3& p = before.points[v];
    const bool surface = std::any_of(p.begin(), p.end(), [](double x) { return x == 0 || x == 1; });
    if (surface) {
      EXPECT_EQ(p, after.points[v]);
    } else {
      moved += p != after.points[v] ? 1 : 0;
    }
  }
  EXPECT_EQ(moved, 64U);
}

TEST(Optimize, EachTetDescendsFromOneNearByOfItsRegion) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    const TetMesh before = test::scrambled(test::cube(10, 0.25), 2);
    TetMesh regions = before;
    for (std::size_t t = 0; t < before.tets.size(); ++t)
      regions.tet_tags[t] = test::centroid(before, t)[0] < 0.5 ? 3 : 4;
    TetMesh after = regions;
    Options options;
    options.effort = effort;
    const Report report = optimize(after, options);
    ASSERT_EQ(report.tet2original.size(), after.tets.size());
    double far = 0;
    for (std::size_t t = 0; t < after.tets.size(); ++t) {
      const auto original = static_cast<std::size_t>(report.tet2original[t]);
      ASSERT_LT(original, before.tets.size());
      ASSERT_EQ(after.tet_tags[t], regions.tet_tags[original]);
      const Point3 a = test::centroid(after, t);
      const Point3 b = test::centroid(before, original);
      far += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    EXPECT_LT(far / static_cast<double>(after.tets.size()), 0.1);  // the length of an edge of the lattice
  }
}

TEST(Optimize, IsTheSameForAnyNumberOfThreads) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    const TetMesh before = effort == Effort::standard ? test::varied(4) : test::scrambled(test::cube(10, 0.25), 2);
    Options options;
    options.effort = effort;
    options.threads = 1;
    TetMesh one = before;
    const Report report = optimize(one, options);
    EXPECT_EQ(report.vertices_inserted > 0, effort == Effort::best);
    for (const int threads : {2, 3, 8}) {
      if (test::kSanitized && threads != 3) continue;
      options.threads = threads;
      TetMesh many = before;
      const Report other = optimize(many, options);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.tets, many.tets);
      EXPECT_EQ(one.tet_tags, many.tet_tags);
      EXPECT_EQ(report.tet2original, other.tet2original);
    }
  }
}

TEST(Optimize, ARescaledMeshGivesTheSameMeshRescaled) {
  for (const double scale : {1000.0, 1e-3, 1e-100, 1e100}) {
    TetMesh plain = test::scrambled(test::cube(8, 0.2), 2);
    TetMesh scaled = test::scaled(plain, scale);
    optimize(plain);
    optimize(scaled);
    EXPECT_EQ(plain.tets, scaled.tets);
    double worst = 0;
    for (std::size_t v = 0; v < plain.points.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k)
        worst = std::max(worst, std::fabs(scaled.points[v][k] / scale - plain.points[v][k]));
    }
    EXPECT_LT(worst, 1e-9);
  }
}

TEST(Optimize, WithoutIterationsOnlyFlips) {
  const TetMesh before = test::scrambled(test::cube(6, 0.2), 2);
  TetMesh after = before;
  Options options;
  options.max_iterations = 0;
  const Report report = optimize(after, options);
  EXPECT_EQ(before.points, after.points);
  EXPECT_GT(report.flips23 + report.flips32, 0);
  EXPECT_TRUE(report.sweeps.empty());
  EXPECT_TRUE(report.worst_rounds.empty());
}

TEST(Optimize, ManyThatAreEquallyBadAreWorkedOnOnce) {
  TetMesh plate = test::cube(10);
  for (std::size_t v = 0; v < plate.points.size(); ++v) {
    plate.points[v][2] *= 0.03;
    if (v * 2654435761U % 64 < 32) plate.required_vertices.push_back(static_cast<Index>(v));
  }
  // A needle beside the plate has a smaller mean ratio; else the moves of a lattice would not be allowed.
  const auto first = static_cast<Index>(plate.points.size());
  for (const Point3& p : {Point3{2, 0, 0}, {2.001, 0, 0}, {2, 0.001, 0}, {2, 0, 0.3}}) plate.points.push_back(p);
  plate.tets.push_back({first, first + 1, first + 2, first + 3});
  plate.tet_tags.resize(plate.tets.size(), plate.tet_tags.front());
  plate.point_tags.resize(plate.points.size(), 0);
  TetMesh same = plate;
  const Report report = optimize(plate);
  ASSERT_GE(report.worst_rounds.size(), 2U);
  EXPECT_GT(report.worst_rounds[0].worst, 300 + static_cast<std::int64_t>(plate.tets.size()) / 100);
  EXPECT_EQ(report.worst_rounds[1].round, 1);  // the first on angles
  Options best;
  best.effort = Effort::best;
  best.keep_vertices = true;  // there are no rounds on the mean energy
  EXPECT_EQ(optimize(same, best).worst_rounds.at(1).round, 2);
}

TEST(Optimize, NewtonAndGradientFindTheSameMinimum) {
  Options options;
  options.max_iterations = 0;
  options.max_ring = 3;                // with more flips to choose from, the two soon differ in connectivity
  options.boundary = Boundary::fixed;  // as surface vertices end at their displacement bounds, by different paths
  TetMesh flipped = test::scrambled(test::cube(5, 0.2), 2);
  optimize(flipped, options);
  TetMesh newton = flipped;
  TetMesh gradient = flipped;
  options.max_iterations = 400;
  options.termination = Termination::paper;  // the default one ends a slow descent too early
  const double a = optimize(newton, options).energy_after;
  options.relocation = Relocation::gradient;
  const double b = optimize(gradient, options).energy_after;
  EXPECT_NEAR(a, b, 2e-3 * a);
}

TEST(Optimize, FlipsAloneLeaveNone) {
  Options options;
  options.max_iterations = 0;
  for (const Energy energy : {Energy::shape, Energy::harmonic}) {
    options.energy = energy;
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
      const bool two = seed % 3 == 0;
      TetMesh m =
          test::sheared(test::scrambled(two ? test::two_materials(10, 0.15) : test::cube(10, 0.2, seed), 3, seed),
                        seed % 2 == 0 ? 2.5 : 0);
      const Report first = optimize(m, options);
      EXPECT_GT(first.flips23 + first.flips32 + first.edge_removals, 500);
      const auto tets = m.tets;
      const Report second = optimize(m, options);
      EXPECT_EQ(second.flips23 + second.flips32 + second.edge_removals, 0) << seed;
      EXPECT_EQ(m.tets.size(), tets.size());
    }
  }
}

}  // namespace
}  // namespace tetune
