// SPDX-License-Identifier: Apache-2.0
// The bound on the deviation of a surface that slides, judged by dense samples both ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "slide_fixture.hpp"
#include "support/sanitized.hpp"
#include "tetune/io.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using test::curved;
using test::kShapes;
using test::mean_edge;
using test::options_of;
using test::SkinFace;

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
        options.keep_vertices = true;  // the edges below are known by their ids
        const Report report = optimize(after, options);
        EXPECT_TRUE(validate(after).ok());
        EXPECT_LT(report.energy_after, report.energy_before);
        const auto new_skin = test::corners(after, test::skin(after));
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

TEST(Slide, EditsOfTheSurfaceKeepToTheBoundBothWays) {
  std::int64_t edited = 0;
  double largest = 0;
  for (int shape = 0; shape < kShapes; ++shape) {
    const TetMesh before = curved(shape, 4);
    const auto old_skin = test::corners(before, test::skin(before));
    for (const double part : {0.4, 0.04}) {
      if (test::kSanitized && part == 0.4) continue;
      Options options;
      options.boundary = Boundary::slide;
      options.effort = Effort::best;
      options.restarts = 1;
      options.max_deviation = part * mean_edge(old_skin);
      options.threads = 1;
      TetMesh after = before;
      const Report report = optimize(after, options);
      EXPECT_TRUE(validate(after).ok());
      const auto new_skin = test::corners(after, test::skin(after));
      const double distance = std::max(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 8),
                                       test::sampled_distance(old_skin, ClosestTriangle(new_skin), 8));
      EXPECT_LE(distance, options.max_deviation) << "shape " << shape << " part " << part;
      largest = std::max(largest, distance / options.max_deviation);
      edited += (report.boundary_flips > 0 ? 1 : 0) + (new_skin.size() != old_skin.size() ? 1 : 0);

      if (test::kSanitized || part != 0.4) continue;
      options.threads = 3;
      TetMesh by_three = before;
      optimize(by_three, options);
      EXPECT_EQ(by_three.points, after.points);
      EXPECT_EQ(by_three.tets, after.tets);
    }
  }
  EXPECT_GT(edited, kShapes);
  EXPECT_GT(largest, 0.3);
}

TEST(Slide, EditsWithinABoundAreTheSameForAnyNumberOfThreads) {
  // With more vertices of a color on the surface than one thread takes at a time.
  const TetMesh before = test::waved(test::cube(test::kSanitized ? 6 : 18, 0.2, 3), 3);
  Options options;
  options.boundary = Boundary::slide;
  options.effort = Effort::best;
  options.max_deviation = 5e-3;
  options.restarts = 0;
  options.threads = 1;
  TetMesh one = before;
  EXPECT_GT(optimize(one, options).boundary_flips, test::kSanitized ? 0 : 100);
  options.threads = 3;
  TetMesh three = before;
  optimize(three, options);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.tets, three.tets);
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
  EXPECT_GT(largest, test::kSanitized ? 0.3 : 0.5);  // of fewer boxes
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
  EXPECT_GT(optimize(after, options).boundary_flips, 0);  // in its flat patches
  EXPECT_TRUE(validate(after).ok());
  const Comparison change = compare(before, after);
  EXPECT_LT(change.vertices_to_old, 1e-12);
  const auto new_skin = test::corners(after, test::skin(after));
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

}  // namespace
}  // namespace tetune
