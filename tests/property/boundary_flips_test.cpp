// SPDX-License-Identifier: Apache-2.0
// Flips in the boundary: within its patches, where options allow them, the same for any number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

#include "mesh/tet.hpp"
#include "support/constrained.hpp"
#include "support/meshes.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// A cube whose sides are patches 1 to 6, all listed; every third triangle seen from inside.
TetMesh patched(const TetMesh& bare) {
  TetMesh m = test::with_listed_sides(bare);
  for (std::size_t i = 2; i < m.triangles.size(); i += 3) std::swap(m.triangles[i][0], m.triangles[i][1]);
  return m;
}

/// Area vector of a triangle, doubled.
Vec3 area2(const TetMesh& m, const std::array<Index, 3>& t) {
  return cross(test::at(m, t[1]) - test::at(m, t[0]), test::at(m, t[2]) - test::at(m, t[0]));
}

TEST(BoundaryFlips, StayWithinTheirPatches) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide, Boundary::fixed}) {
    const TetMesh before = patched(test::scrambled(test::cube(8, 0.25), 3, 2));
    ASSERT_EQ(before.triangles.size(), 12U * 64);
    TetMesh after = before;
    Options options;
    options.boundary = boundary;
    const Report report = optimize(after, options);
    EXPECT_TRUE(validate(after).ok());
    test::expect_present(after);
    EXPECT_EQ(before.triangle_tags, after.triangle_tags);
    ASSERT_EQ(after.triangles.size(), before.triangles.size());
    EXPECT_EQ(patched(after).triangles.size() - after.triangles.size(), before.triangles.size());
    std::set<std::array<Index, 3>> different;
    std::size_t changed = 0;
    std::array<double, 7> area{};
    for (std::size_t i = 0; i < after.triangles.size(); ++i) {
      different.insert(ascending(after.triangles[i]));
      changed += after.triangles[i] != before.triangles[i] ? 1 : 0;
      const Vec3 now = area2(after, after.triangles[i]);
      EXPECT_GT(dot(now, area2(before, before.triangles[i])), 0) << i;  // the same side, and still turned as it was
      area[static_cast<std::size_t>(after.triangle_tags[i])] += 0.5 * norm(now);
    }
    EXPECT_EQ(different.size(), after.triangles.size());
    for (std::size_t side = 1; side <= 6; ++side) EXPECT_NEAR(area[side], 1, 1e-12);
    if (boundary == Boundary::fixed) {
      EXPECT_EQ(report.boundary_flips, 0);
      EXPECT_EQ(changed, 0U);
    } else {
      EXPECT_GT(report.boundary_flips, 20);
      EXPECT_GT(changed, 20U);
      std::int64_t flips = 0;
      for (const FlipReport& f : report.flip_passes) flips += f.boundary_flips;
      EXPECT_LE(flips, report.boundary_flips);
      EXPECT_GT(flips, 0);
    }
  }
}

TEST(BoundaryFlips, AreNotDoneWhereOptionsExcludeThem) {
  const TetMesh before = patched(test::scrambled(test::cube(6, 0.25), 3, 2));
  const auto triangles_after = [&before](const Options& options) {
    TetMesh after = before;
    EXPECT_EQ(optimize(after, options).boundary_flips, 0);
    return after.triangles;
  };
  Options options;
  options.boundary_flips = false;
  EXPECT_EQ(triangles_after(options), before.triangles);
  options = {};
  options.max_ring = 3;
  EXPECT_EQ(triangles_after(options), before.triangles);
}

TEST(BoundaryFlips, WithABoundOnTheDeviationAreDoneInFlatPatchesAlone) {
  // The upper side is curved.
  constexpr int kUpper = 6;
  TetMesh before = patched(test::cube(6, 0.2));
  for (Point3& p : before.points) p[2] *= 1 + 0.1 * p[0] * (1 - p[0]);
  TetMesh after = before;
  Options options;
  options.boundary = Boundary::slide;
  options.max_deviation = 0.01;
  EXPECT_GT(optimize(after, options).boundary_flips, 20);
  ASSERT_EQ(after.triangles.size(), before.triangles.size());
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    if (after.triangle_tags[i] == kUpper) {
      EXPECT_EQ(after.triangles[i], before.triangles[i]) << i;
    }
  }
  const Comparison change = compare(before, after);
  EXPECT_LE(std::max(change.new_to_old, change.old_to_new) * change.mean_edge, options.max_deviation);
}

TEST(BoundaryFlips, AreTheSameForAnyNumberOfThreads) {
  const TetMesh before = patched(test::scrambled(test::cube(10, 0.25), 3, 2));
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    Options options;
    options.boundary = boundary;
    options.threads = 1;
    TetMesh one = before;
    EXPECT_GT(optimize(one, options).boundary_flips, 20);
    for (const int threads : {2, 3}) {
      options.threads = threads;
      TetMesh many = before;
      optimize(many, options);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.tets, many.tets);
      EXPECT_EQ(one.triangles, many.triangles);
    }
  }
}

}  // namespace
}  // namespace tetune
