// SPDX-License-Identifier: Apache-2.0
// Contracts of sliding on curved surfaces, judged by plain means: brute force over the faces, dense
// samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <random>
#include <set>
#include <string>

#include "driver/distributed_interface.hpp"
#include "support/curved.hpp"
#include "support/energy_watch.hpp"
#include "support/sanitized.hpp"
#include "tetune/io.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using test::SkinFace;

constexpr int kShapes = 5;
TetMesh curved(int shape, std::uint32_t seed) {
  switch (shape) {
    case 0:
      return test::ball(7, 0.15, seed);
    case 1:
      return test::waved(test::cube(6, 0.15, seed), seed);
    case 2:
      return test::waved(test::two_materials(6, 0.15), seed);
    case 3:
      return test::with_patches(test::ball(6, 0.15, seed), 0.1);
    default:
      return test::with_patches(test::waved(test::two_materials(6, 0.15), seed), 0.4);
  }
}

struct SlideCase {
  int shape;
  std::uint32_t seed;
  Relocation relocation;
  Energy energy;
  double feature_angle;
};
void PrintTo(const SlideCase& c, std::ostream* out) { *out << "shape " << c.shape << " seed " << c.seed; }

Options options_of(const SlideCase& c) {
  Options options;
  options.boundary = Boundary::slide;
  options.relocation = c.relocation;
  options.energy = c.energy;
  options.feature_angle = c.feature_angle;
  options.boundary_flips = c.seed == 2;
  options.max_iterations = 15;
  return options;
}

double mean_edge(const std::vector<TrianglePoints>& triangles) {
  double sum = 0;
  for (const TrianglePoints& t : triangles) sum += norm(t[1] - t[0]) + norm(t[2] - t[1]) + norm(t[0] - t[2]);
  return sum / (3 * static_cast<double>(triangles.size()));
}

double distance_to(const std::vector<TrianglePoints>& triangles, const std::vector<Vec3>& points) {
  const ClosestTriangle tree(triangles);
  double most = 0;
  for (const Vec3& p : points) most = std::max(most, tree.distance2(p));
  return std::sqrt(most);
}

/// Regions and tag of each face.
std::multiset<std::pair<std::array<int, 2>, int>> kinds_of(const std::vector<SkinFace>& faces) {
  std::multiset<std::pair<std::array<int, 2>, int>> kinds;
  for (const SkinFace& f : faces) kinds.insert({f.regions, f.tag});
  return kinds;
}

class SlideProperties : public testing::TestWithParam<SlideCase> {};

TEST_P(SlideProperties, KeepTheSurfaceItsFeaturesAndTheTags) {
  const SlideCase c = GetParam();
  const TetMesh before = curved(c.shape, c.seed);
  ASSERT_TRUE(validate(before).ok()) << validate(before).message(false);
  TetMesh after = before;
  const Options options = options_of(c);
  const Report report = optimize(after, options, test::energy_watch());
  EXPECT_TRUE(validate(after).ok()) << validate(after).message(false);

  // Fig. 7: no sweep and no pass of flips raises the energy.
  ASSERT_FALSE(report.sweeps.empty());
  double energy = report.energy_before;
  for (const SweepReport& s : report.sweeps) {
    EXPECT_GE(s.decrease, 0);
    EXPECT_LE(s.energy_before, energy * (1 + 1e-12));
    energy = s.energy_before;
  }
  for (const FlipReport& f : report.flip_passes) EXPECT_GE(f.decrease, 0);
  // Work on the worst elements gives some of it back.
  EXPECT_LE(report.energy_after, energy * (report.worst_rounds.empty() ? 1 + 1e-12 : 1.02));
  const Quality q = quality(after);
  if (c.energy == Energy::shape) {
    EXPECT_GE(q.dihedral_min, quality(before).dihedral_min - 1e-9);
  }
  EXPECT_NEAR(report.energy_after, c.energy == Energy::shape ? q.shape_sum : q.eta_sum, 1e-9 * report.energy_after);

  // Each face of the surface is still there, between the same regions; or was flipped within them and its patch.
  const std::vector<SkinFace> faces = test::skin(before);
  if (options.boundary_flips) {
    EXPECT_EQ(kinds_of(faces), kinds_of(test::skin(after)));
  } else {
    EXPECT_EQ(report.boundary_flips, 0);
    EXPECT_EQ(faces, test::skin(after));
    EXPECT_EQ(before.triangles, after.triangles);
  }
  EXPECT_EQ(before.triangle_tags, after.triangle_tags);
  const Comparison change = compare(before, after);
  EXPECT_LT(change.vertices_to_old, 1e-12);
  EXPECT_TRUE(change.vertex_tags_kept && change.tet_tags_kept && change.triangle_tags_kept);

  // Every vertex on its own sheet: the boundary, or the interface between two regions, with its patch tag.
  std::map<std::pair<std::array<int, 2>, int>, std::pair<std::vector<TrianglePoints>, std::vector<Vec3>>> sheets;
  for (const SkinFace& f : faces) {
    auto& [triangles, points] = sheets[{f.regions, f.tag}];
    triangles.push_back(test::corners(before, f));
    for (const Index v : f.v) points.push_back(test::at(after, v));
  }
  for (const auto& [sheet, parts] : sheets) EXPECT_LT(distance_to(parts.first, parts.second), 1e-13);

  // Corners, lines and the rest.
  const test::PlainFeatures features = test::plain_features(before, faces, c.feature_angle);
  std::int64_t fixed = 0;
  std::int64_t curve = 0;
  std::int64_t moved = 0;
  std::vector<Vec3> on_lines;
  for (const auto& [v, degree] : features.degree) {
    const auto i = static_cast<std::size_t>(v);
    if (features.fixed(v)) {
      ++fixed;
      EXPECT_EQ(before.points[i], after.points[i]);
      continue;
    }
    if (features.curve(v)) {
      ++curve;
      on_lines.push_back(vec(after.points[i]));
    }
    moved += before.points[i] != after.points[i] ? 1 : 0;
  }
  EXPECT_EQ(report.fixed_vertices, fixed);
  EXPECT_EQ(report.curve_vertices, curve);
  EXPECT_EQ(report.surface_vertices, static_cast<std::int64_t>(features.degree.size()) - fixed - curve);
  if (!on_lines.empty()) {
    EXPECT_LT(distance_to(test::corners(before, features.edges), on_lines), 1e-13);
  }
  EXPECT_GT(moved, static_cast<std::int64_t>(features.degree.size()) / 3);
}

std::vector<SlideCase> slide_cases() {
  std::vector<SlideCase> all;
  for (int shape = 0; shape < kShapes; ++shape) {
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
      for (const Relocation relocation : {Relocation::newton, Relocation::gradient}) {
        for (const Energy energy : {Energy::shape, Energy::harmonic}) {
          for (const double angle : {45.0, 180.0}) all.push_back({shape, seed, relocation, energy, angle});
        }
      }
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Shapes, SlideProperties, testing::ValuesIn(slide_cases()), [](const auto& test) {
  const SlideCase& c = test.param;
  return "Shape" + std::to_string(c.shape) + "Seed" + std::to_string(c.seed) +
         (c.relocation == Relocation::newton ? "Newton" : "Gradient") +
         (c.energy == Energy::shape ? "Shape" : "Harmonic") + (c.feature_angle < 180 ? "" : "NoFeatures");
});

TEST(Slide, KeepsToTheBoundBothWays) {
  int bounded = 0;
  for (int shape = 0; shape < kShapes; ++shape) {
    for (const double part : {0.2, 0.05, 0.01, 0.002}) {
      for (const double angle : {45.0, 180.0}) {
        if (test::kSanitized && angle == 180) continue;
        const TetMesh before = curved(shape, 3);
        TetMesh after = before;
        Options options = options_of({shape, 3, part == 0.05 ? Relocation::gradient : Relocation::newton,
                                      part == 0.2 ? Energy::harmonic : Energy::shape, angle});
        const std::vector<SkinFace> faces = test::skin(before);
        const auto old_skin = test::corners(before, faces);
        options.max_deviation = part * mean_edge(old_skin);
        options.effort = part == 0.01 ? Effort::best : Effort::standard;
        options.keep_vertices = true;  // the faces below are known by their ids
        const Report report = optimize(after, options);
        EXPECT_TRUE(validate(after).ok());
        EXPECT_LT(report.energy_after, report.energy_before);
        const auto new_skin = test::corners(after, faces);
        const double there = test::sampled_distance(new_skin, ClosestTriangle(old_skin), 6);
        const double back = test::sampled_distance(old_skin, ClosestTriangle(new_skin), 6);
        EXPECT_LE(there, options.max_deviation) << "shape " << shape << " part " << part << " angle " << angle;
        EXPECT_LE(back, options.max_deviation) << "shape " << shape << " part " << part << " angle " << angle;
        bounded += std::max(there, back) > 0.3 * options.max_deviation ? 1 : 0;
        if (angle == 180) continue;
        // Lines, both ways.
        const auto edges = test::plain_features(before, faces, angle).edges;
        if (edges.empty()) continue;
        const auto old_lines = test::corners(before, edges);
        const auto new_lines = test::corners(after, edges);
        EXPECT_LE(test::sampled_distance(new_lines, ClosestTriangle(old_lines), 20), options.max_deviation);
        EXPECT_LE(test::sampled_distance(old_lines, ClosestTriangle(new_lines), 20), options.max_deviation);
      }
    }
  }
  EXPECT_GT(bounded, test::kSanitized ? 10 : 30);
}

/// A box of random sides, bent by waves.
TetMesh bent_box(std::mt19937& random) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto seed = static_cast<std::uint32_t>(random());
  TetMesh m = test::cube(3 + static_cast<int>(random() % 4), between(0.05, 0.2), seed);
  const std::array sides{std::exp(between(-0.7, 0.7)), std::exp(between(-0.7, 0.7)), std::exp(between(-1.2, 0.3))};
  for (Point3& p : m.points) {
    for (std::size_t k = 0; k < 3; ++k) p[k] *= sides[k];
  }
  return test::waved(std::move(m), seed, between(0.02, 0.15) * *std::min_element(sides.begin(), sides.end()));
}

TEST(Slide, KeepsToTheBoundOnBentBoxes) {
  // Seeds up to 600 pass (docs/benchmarks/robustness.md).
  constexpr std::uint32_t kBoxes = test::kSanitized ? 4 : 15;
  double largest = 0;
  for (std::uint32_t seed = 1; seed <= kBoxes; ++seed) {
    std::mt19937 random(seed);
    const TetMesh before = bent_box(random);
    ASSERT_TRUE(validate(before).ok());
    const auto old_skin = test::corners(before, test::skin(before));
    Options options;
    options.boundary = Boundary::slide;
    options.effort = std::array{Effort::fast, Effort::standard, Effort::best}[seed % 3];
    options.feature_angle = seed % 2 == 0 ? 80 : 40;
    options.max_deviation = mean_edge(old_skin) * std::pow(0.02, std::uniform_real_distribution<double>()(random));
    TetMesh after = before;
    optimize(after, options);
    EXPECT_TRUE(validate(after).ok()) << seed;
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min * (1 - 1e-9)) << seed;
    const auto new_skin = test::corners(after, test::skin(after));
    const double distance = std::max(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 12),
                                     test::sampled_distance(old_skin, ClosestTriangle(new_skin), 12));
    EXPECT_LE(distance, options.max_deviation) << seed;
    largest = std::max(largest, distance / options.max_deviation);
  }
  EXPECT_GT(largest, 0.5);
}

TEST(Slide, LowersTheEnergyMoreThanPreservingAndLessWithABound) {
  const TetMesh before = test::waved(test::cube(8, 0.15));
  const auto end = [&before](Boundary boundary, double bound) {
    TetMesh m = before;
    Options options;
    options.boundary = boundary;
    options.max_deviation = bound;
    return optimize(m, options).energy_after;
  };
  const double slide = end(Boundary::slide, 0);
  const double tight = end(Boundary::slide, 1e-3);
  EXPECT_LT(slide, end(Boundary::preserve, 0));
  EXPECT_LT(slide, tight);
  EXPECT_LT(tight, end(Boundary::fixed, 0));
}

TEST(Slide, OnARealMeshKeepsItsFeaturesAndBound) {
  const TetMesh before = read_mesh(TETUNE_DATA "/bracket.meshb");
  const std::vector<SkinFace> faces = test::skin(before);
  const auto old_skin = test::corners(before, faces);
  TetMesh after = before;
  Options options;
  options.boundary = Boundary::slide;
  options.max_deviation = 0.02 * mean_edge(old_skin);
  options.max_iterations = 6;
  options.effort = Effort::best;
  options.keep_vertices = true;
  optimize(after, options);
  EXPECT_TRUE(validate(after).ok());
  EXPECT_EQ(faces, test::skin(after));
  const Comparison change = compare(before, after);
  EXPECT_LT(change.vertices_to_old, 1e-12);
  const auto new_skin = test::corners(after, faces);
  EXPECT_LE(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 4), options.max_deviation);
  EXPECT_LE(test::sampled_distance(old_skin, ClosestTriangle(new_skin), 4), options.max_deviation);
}

TEST(Slide, ABoundHoldsCornersThatAreNoFeatures) {
  for (std::uint32_t seed = 0; seed < (test::kSanitized ? 8 : 40); ++seed) {
    // A bent bar, or a bent sheet as thick as the larger bound or twice that.
    const bool thin = seed % 4 == 3;
    const double thickness = thin ? 1e-3 * (1 + seed / 4 % 2) : 1;
    TetMesh m = test::cube(3 + static_cast<int>(seed % 3), 0.15, seed);
    for (Point3& p : m.points) {
      const double angle = (2 * p[1] - 1) * (0.4 + 0.01 * seed);
      p = {(1 + p[0]) * std::cos(angle), (1 + p[0]) * std::sin(angle), thickness * p[2]};
    }
    const auto old_skin = test::corners(m, test::skin(m));
    Options options;
    options.boundary = Boundary::slide;
    options.effort = seed % 2 == 0 ? Effort::best : Effort::fast;
    options.feature_angle = seed % 3 == 0 ? 120 : 180;
    options.max_deviation = thin ? 1e-3 : 1e-5;
    optimize(m, options);
    const auto new_skin = test::corners(m, test::skin(m));
    EXPECT_LE(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 6), 1.01 * options.max_deviation) << seed;
    EXPECT_LE(test::sampled_distance(old_skin, ClosestTriangle(new_skin), 6), 1.01 * options.max_deviation) << seed;
  }
}

TEST(Slide, ABoundThatVanishesBesideTheMeshIsNotNone) {
  TetMesh m = test::ball(4);
  for (Point3& p : m.points) p = {1e10 * p[0], 1e10 * p[1], 1e10 * p[2]};
  const auto old_skin = test::corners(m, test::skin(m));
  Options options;
  options.boundary = Boundary::slide;
  options.max_deviation = 1e-320;
  optimize(m, options);
  const auto new_skin = test::corners(m, test::skin(m));
  EXPECT_LT(test::sampled_distance(old_skin, ClosestTriangle(new_skin), 4), 1e-4);
}

TEST(Slide, IsTheSameForAnyNumberOfThreads) {
  for (const Relocation relocation : {Relocation::newton, Relocation::gradient}) {
    for (const double part : {0.0, 0.02}) {
      TetMesh one;
      for (const int threads : {1, 2, 3}) {
        if (test::kSanitized && threads == 2) continue;
        TetMesh m = curved(4, 5);
        Options options = options_of({4, 5, relocation, Energy::shape, 45});
        options.threads = threads;
        options.max_deviation = part;
        options.effort = part > 0 ? Effort::best : Effort::standard;
        optimize(m, options);
        if (threads == 1) {
          one = m;
          continue;
        }
        EXPECT_EQ(one.points, m.points);
        EXPECT_EQ(one.tets, m.tets);
        EXPECT_EQ(one.tet_tags, m.tet_tags);
      }
    }
  }
}

TEST(SlideOn, ItsOwnSurfaceGivesTheSameBits) {
  for (int shape = 0; shape < kShapes; ++shape) {
    for (const double bound : {0.0, 0.01}) {
      Options options = options_of({shape, 2, Relocation::newton, Energy::shape, 45});
      options.effort = shape == 1 ? Effort::best : Effort::standard;
      options.max_deviation = bound;
      TetMesh alone = curved(shape, 2);
      TetMesh given = alone;
      SlideSurface surface = find_slide_surface(given, options);
      optimize(alone, options);
      optimize(given, options, {}, surface);
      EXPECT_EQ(alone.points, given.points);
      EXPECT_EQ(alone.tets, given.tets);
    }
  }
}

TEST(SlideOn, TheSurfaceOfTheInputKeepsItHoweverOftenVerticesMove) {
  for (int shape = 0; shape < kShapes; ++shape) {
    for (const double part : {0.0, 0.03}) {
      const TetMesh before = curved(shape, 3);
      const std::vector<SkinFace> faces = test::skin(before);
      const auto old_skin = test::corners(before, faces);
      const auto lines = test::plain_features(before, faces, 45);
      Options options = options_of({shape, 3, Relocation::newton, Energy::shape, 45});
      options.boundary_flips = part == 0;
      options.max_deviation = part * mean_edge(old_skin);
      TetMesh mesh = before;
      SlideSurface surface = find_slide_surface(mesh, options);
      std::vector<Point3> last = mesh.points;
      for (std::uint32_t turn = 0; turn < 4; ++turn) {
        // Others are free each time, so that there is something left to do.
        options.frozen_vertices.assign(mesh.points.size(), 0);
        for (std::size_t v = 0; v < mesh.points.size(); ++v) options.frozen_vertices[v] = (v + turn) % 3 == 0 ? 1 : 0;
        optimize(mesh, options, {}, surface);
        EXPECT_NE(mesh.points, last);
        last = mesh.points;
      }
      EXPECT_TRUE(validate(mesh).ok());
      std::vector<Vec3> on_surface;
      for (const SkinFace& f : test::skin(mesh)) {
        for (const Index v : f.v) on_surface.push_back(test::at(mesh, v));
      }
      EXPECT_LT(distance_to(old_skin, on_surface), 1e-13);
      std::vector<Vec3> on_lines;
      for (const auto& e : lines.edges) {
        for (const Index v : e) on_lines.push_back(test::at(mesh, v));
      }
      if (!on_lines.empty()) {
        EXPECT_LT(distance_to(test::corners(before, lines.edges), on_lines), 1e-13);
      }
      if (part == 0) continue;
      const auto new_skin = test::corners(mesh, faces);
      EXPECT_LE(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 6), options.max_deviation);
      EXPECT_LE(test::sampled_distance(old_skin, ClosestTriangle(new_skin), 6), options.max_deviation);
    }
  }
}

TEST(Slide, ARescaledMeshGivesTheSameMeshRescaled) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const double scale : {1000.0, 1e-3}) {
      TetMesh plain = curved(1, 2);
      TetMesh scaled = plain;
      for (Point3& p : scaled.points) {
        for (double& x : p) x *= scale;
      }
      Options options;
      options.boundary = boundary;
      const Report a = optimize(plain, options);
      const Report b = optimize(scaled, options);
      EXPECT_EQ(plain.tets, scaled.tets);
      // Without a unit: the shape energy itself is the same.
      EXPECT_NEAR(a.energy_before, b.energy_before, 1e-9 * a.energy_before);
      EXPECT_NEAR(a.energy_after, b.energy_after, 1e-9 * a.energy_after);
      ASSERT_EQ(a.sweeps.size(), b.sweeps.size());
      double worst = 0;
      for (std::size_t v = 0; v < plain.points.size(); ++v) {
        for (std::size_t k = 0; k < 3; ++k)
          worst = std::max(worst, std::fabs(scaled.points[v][k] / scale - plain.points[v][k]));
      }
      EXPECT_LT(worst, 1e-9);
    }
  }
}

TEST(Slide, OfASphereWithoutFeaturesHasNoFixedVertex) {
  TetMesh m = test::ball(6);
  Options options;
  options.boundary = Boundary::slide;
  const Report r = optimize(m, options);
  EXPECT_EQ(r.fixed_vertices + r.curve_vertices, 0);
  EXPECT_EQ(r.surface_vertices, 6 * 36 + 2);
}

}  // namespace
}  // namespace tetune
