// SPDX-License-Identifier: Apache-2.0
// The promises of optimize(), checked on many meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "mesh/tet.hpp"
#include "support/allocation_watch.hpp"
#include "support/constrained.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Tetrahedra about one edge, a fan from the lowest corner of the box on: the vertices of the edge have all of them.
TetMesh fan(int count) {
  TetMesh m;
  m.points = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i <= count; ++i) {
    const double angle = std::numbers::pi / 2 * i / count;
    m.points.push_back({std::cos(angle), std::sin(angle), 0.5});
    if (i > 0) m.tets.push_back({0, 1, i + 1, i + 2});
  }
  return test::with_tags(std::move(m));
}

TEST(Optimize, VerticesOfManyTetrahedraTakeNoSquaredTime) {
  // With quadratic time this would take a minute; it takes a second or two, and longer under sanitizers.
  constexpr std::chrono::seconds kEnough(test::kSanitized ? 300 : 30);
  for (const auto& [boundary, bound] :
       {std::pair(Boundary::preserve, 0.0), {Boundary::slide, 0.0}, {Boundary::slide, 0.01}}) {
    TetMesh m = fan(60'000);
    ASSERT_TRUE(validate(m).ok());
    Options options;
    options.boundary = boundary;
    options.max_deviation = bound;
    options.max_iterations = 2;
    options.threads = 1;
    const auto start = std::chrono::steady_clock::now();
    optimize(m, options);
    EXPECT_LT(std::chrono::steady_clock::now() - start, kEnough);
    EXPECT_TRUE(validate(m).ok());
  }
}

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
          EXPECT_GT(most, 0.9 * part) << "no vertex wanted to go far";
        } else if (relocation == Relocation::newton) {
          EXPECT_GT(most, part) << "the harmonic energy has no leash";
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
    TetMesh scaled = plain;
    for (Point3& p : scaled.points) {
      for (double& x : p) x *= scale;
    }
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

TEST(Optimize, StopsWhenAskedAndLeavesAValidMesh) {
  TetMesh m = test::cube(6, 0.2);
  Context context;
  int calls = 0;
  context.progress = [&calls](const Progress&) { return ++calls < 4; };
  const Report report = optimize(m, {}, context);
  EXPECT_EQ(report.stop, StopReason::cancelled);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_LT(report.energy_after, report.energy_before);
  EXPECT_NEAR(report.energy_after, quality(m).shape_sum, 1e-9 * report.energy_after);
}

TEST(Optimize, IsValidHoweverEarlyItMustEnd) {
  // Flips after the last sweep must not leave stale rings to the work on the worst elements.
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh before = test::scrambled(test::cube(6, 0.3), 3, seed);
    for (int sweeps = 1; sweeps <= 5; ++sweeps) {
      TetMesh after = before;
      Options options;
      options.max_iterations = sweeps;
      const Report report = optimize(after, options);
      EXPECT_TRUE(validate(after).ok()) << validate(after).message(false);
      EXPECT_NEAR(quality(after).volume, quality(before).volume, 1e-12);
      EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - 1e-9);
      EXPECT_LE(static_cast<int>(report.sweeps.size()), sweeps);
    }
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

TEST(Optimize, HandlesTheSmallestMeshes) {
  TetMesh one = test::one_tet();
  EXPECT_EQ(optimize(one).fixed_vertices, 4);
  TetMesh two = test::two_tets(0.3);
  EXPECT_EQ(optimize(two).flips23, 1);
  TetMesh none;
  EXPECT_EQ(optimize(none).tets_after, 0);
  TetMesh points;
  for (int i = 0; i < 100; ++i) points.points.push_back({0.1 * i, std::sin(i), std::cos(3 * i)});
  points.point_tags.assign(points.points.size(), 0);
  const std::vector<Point3> before = points.points;
  EXPECT_EQ(optimize(points).tets_after, 0);
  EXPECT_EQ(points.points, before);
  TetMesh loose = test::one_tet();
  loose.points.push_back({9, 9, 9});
  loose.point_tags.push_back(0);
  optimize(loose);
  EXPECT_EQ(loose.points.back(), (Point3{9, 9, 9}));
}

TEST(Optimize, LeavesTheMeshAsItWasWhereverMemoryRunsOut) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "memory never runs out here";
  TetMesh before = test::scrambled(test::cube(2, 0.2), 2);
  before.required_tets = {7};
  for (const auto& t : before.tets) {
    before.triangles.push_back({t[0], t[1], t[2]});
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = k + 1; l < 4; ++l) before.edges.push_back({t[k], t[l]});
    }
  }
  before.triangle_tags.resize(before.triangles.size());
  before.edge_tags.resize(before.edges.size());
  before.point_data = {{"heat", 2, std::vector<double>(2 * before.points.size())}};
  before.tet_data = {{"flag", 1, std::vector<std::int8_t>(before.tets.size())}};
  Options options;
  options.threads = 1;
  options.max_iterations = 1;
  options.effort = Effort::best;
  options.restarts = 1;
  TetMesh after = before;
  bool done = false;
  for (std::size_t granted = 0; !done; granted += test::kSanitized ? 37 : 8) {
    ASSERT_LT(granted, 10000U);
    try {
      const test::AllocationWatch watch(granted);
      optimize(after, options);
      done = true;
    } catch (const std::bad_alloc&) {
      ASSERT_TRUE(after.points == before.points && after.tets == before.tets && after.tet_tags == before.tet_tags &&
                  after.required_tets == before.required_tets && after.triangles == before.triangles &&
                  after.edges == before.edges)
          << granted;
    }
  }
  EXPECT_NE(after.points, before.points);
  EXPECT_NE(after.tets, before.tets);
  EXPECT_LT(after.triangles.size(), before.triangles.size());
  EXPECT_LT(after.edges.size(), before.edges.size());
}

TEST(Optimize, AMeshThatOverlapsItselfKeepsItsFacesOrIsRefused) {
  // A 2-3 flip of the third and the last makes the face of the first a second time.
  TetMesh before;
  before.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {2, 1, 5}};
  before.tets = {{0, 1, 2, 5}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}};
  before = test::with_tags(std::move(before));
  orient_uniformly(before);
  ASSERT_TRUE(validate(before).ok()) << validate(before).message(false);
  TetMesh m = before;
  try {
    optimize(m);
    ADD_FAILURE() << "not refused";
  } catch (const OverlapError& e) {
    EXPECT_FALSE(e.tets.empty());
    EXPECT_NE(e.message(true).find("flips=false"), std::string::npos) << e.message(true);
  }
  EXPECT_EQ(m.tets, before.tets);
  EXPECT_EQ(m.points, before.points);
  Options options;
  options.flips = false;
  options.keep_vertices = true;
  for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
    options.effort = effort;
    m = before;
    optimize(m, options);
    EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
  }
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

TEST(Optimize, MakesNoVolumeThatIsTooSmallToComputeWith) {
  // Found by fuzzing: beside the one far vertex all others are so close together that a flip at vertices 1 and 5 makes
  // a volume in which products underflow.
  TetMesh before;
  before.points = {{0, 0, 0},
                   {1, 0, 0},
                   {131072, 1.4843376004141983e48, 0},
                   {1, 2.93873e-39, 0},
                   {0, 0, 1},
                   {1, 0, 3.7092e-68},
                   {0, 2.32831e-10, 1},
                   {1, 0.6875, 1.015625},
                   {0.4, 0.55, 0.5998779296875}};
  before.tets = {{0, 1, 3, 8}, {0, 3, 2, 8}, {4, 7, 5, 8}, {4, 6, 7, 8}, {0, 5, 1, 8}, {0, 4, 5, 8},
                 {2, 3, 7, 8}, {2, 7, 6, 8}, {0, 2, 6, 8}, {0, 6, 4, 8}, {1, 5, 7, 8}, {1, 7, 3, 8}};
  // The same, where the order of its vertices decides whether they do.
  TetMesh ordered;
  ordered.points = {{0, 0, 0}, {5, 0, 0}, {0, 1e79 / 3, 0}, {1, 1, 0},       {0.1, 0, 2},
                    {1, 0, 1}, {0, 1, 1}, {2, 1, 1},        {0.4, 0.55, 0.6}};
  ordered.tets = {{0, 1, 3, 8}, {0, 3, 2, 8}, {4, 7, 5, 8}, {4, 6, 7, 8}, {0, 5, 1, 8}, {0, 5, 4, 8},
                  {2, 3, 7, 8}, {2, 7, 6, 8}, {0, 2, 8, 6}, {0, 6, 4, 8}, {1, 5, 7, 8}, {1, 7, 3, 8}};
  ordered = test::with_tags(std::move(ordered));
  orient_uniformly(ordered);
  for (const TetMesh& mesh : {before, ordered}) {
    TetMesh tagged = test::with_tags(mesh);
    ASSERT_TRUE(validate(tagged).ok()) << validate(tagged).message(false);
    for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
      Options options;
      options.effort = effort;
      TetMesh m = tagged;
      optimize(m, options);
      EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
      EXPECT_NE(m.tets, tagged.tets);
    }
  }
}

TEST(Optimize, RefusesOptionsOutOfRange) {
  TetMesh m = test::one_tet();
  Options options;
  options.max_iterations = -1;
  EXPECT_THROW(optimize(m, options), OptionError);
  options = {};
  options.threads = -2;
  EXPECT_THROW(optimize(m, options), OptionError);
  for (const int ring : {2, 8}) {
    options = {};
    options.max_ring = ring;
    EXPECT_THROW(optimize(m, options), OptionError);
  }
}

}  // namespace
}  // namespace tetune
