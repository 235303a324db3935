// SPDX-License-Identifier: Apache-2.0
// Parts that stay to the last bit, and the volumes of regions.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "support/curved.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(Interfaces, KeepTheVolumeOfEachRegionWhenPreserved) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const TetMesh before = test::sheared(test::scrambled(test::two_materials(6, 0.2), 2, seed), 0.4);
    TetMesh after = before;
    optimize(after);
    EXPECT_NE(before.points, after.points);
    EXPECT_LT(compare(before, after).region_volume_change, 1e-10);
  }
}

TEST(Frozen, VerticesStayToTheLastBit) {
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    const TetMesh before = seed % 3 == 0 ? test::scrambled(test::two_materials(4, 0.15), 2, seed)
                                         : test::waved(test::cube(4, 0.15, seed), seed);
    TetMesh after = before;
    Options options;
    options.boundary = seed % 2 == 0 ? Boundary::slide : Boundary::preserve;
    options.frozen_vertices.assign(before.points.size(), 0);
    for (std::size_t i = 0; i < before.points.size() / 10; ++i) {
      options.frozen_vertices[random() % before.points.size()] = 1;
    }
    optimize(after, options);
    int moved = 0;
    for (std::size_t v = 0; v < before.points.size(); ++v) {
      if (options.frozen_vertices[v] != 0) {
        ASSERT_EQ(before.points[v], after.points[v]) << seed;
      } else {
        moved += before.points[v] != after.points[v] ? 1 : 0;
      }
    }
    EXPECT_GT(moved, 20);
    EXPECT_TRUE(validate(after).ok());
  }
}

std::set<std::array<Index, 4>> tets_of(const TetMesh& m, int tag) {
  std::set<std::array<Index, 4>> set;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    if (m.tet_tags[t] == tag) set.insert(ascending(m.tets[t]));
  }
  return set;
}

TEST(Frozen, RegionsAndPatchesStayToTheLastBit) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
      const TetMesh before = test::with_patches(test::waved(test::two_materials(6, 0.15), seed), 0.4);
      Options options;
      options.boundary = boundary;
      options.frozen_regions = {1};
      TetMesh after = before;
      optimize(after, options);
      EXPECT_EQ(tets_of(before, 1), tets_of(after, 1));
      EXPECT_NE(tets_of(before, 2), tets_of(after, 2));
      for (const auto& t : tets_of(before, 1)) {
        for (const Index v : t)
          ASSERT_EQ(before.points[static_cast<std::size_t>(v)], after.points[static_cast<std::size_t>(v)]);
      }
      options.frozen_regions.clear();
      options.frozen_patches = {9};
      after = before;
      optimize(after, options);
      const std::vector<test::SkinFace> skin = test::skin(after);
      int moved = 0;
      std::set<Index> frozen;
      for (const test::SkinFace& f : test::skin(before)) {
        if (f.tag != 9) continue;
        frozen.insert(f.v.begin(), f.v.end());
        EXPECT_EQ(std::count(skin.begin(), skin.end(), f), 1);
      }
      EXPECT_GT(frozen.size(), 20U);
      for (std::size_t v = 0; v < before.points.size(); ++v) {
        const bool same = before.points[v] == after.points[v];
        if (frozen.count(static_cast<Index>(v)) == 1) {
          EXPECT_TRUE(same);
        } else {
          moved += same ? 0 : 1;
        }
      }
      EXPECT_GT(moved, 100);
    }
  }
}

}  // namespace
}  // namespace tetune
