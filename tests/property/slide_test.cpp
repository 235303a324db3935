// SPDX-License-Identifier: Apache-2.0
// Contracts of sliding on curved surfaces, judged by plain means: brute force over the faces.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "slide_fixture.hpp"
#include "support/energy_watch.hpp"
#include "support/sanitized.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using test::curved;
using test::distance_to;
using test::kShapes;
using test::options_of;
using test::SkinFace;
using test::SlideCase;

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

TEST(Slide, ARescaledMeshGivesTheSameMeshRescaled) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const double scale : {1000.0, 1e-3}) {
      TetMesh plain = curved(1, 2);
      TetMesh scaled = test::scaled(plain, scale);
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
