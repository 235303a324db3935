// SPDX-License-Identifier: Apache-2.0
// Trees of boxes, and distances of samples of one surface from another, against all pairs.
#include "quality/sampled_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "math/box_tree.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

class RandomSurfaces {
 public:
  explicit RandomSurfaces(unsigned seed) : random_(seed) {}

  Vec3 point(double size) { return {size * number(), size * number(), size * number()}; }
  /// Triangles of sizes from `smallest` to 1; every fourth one is thin.
  std::vector<TrianglePoints> triangles(int count, double smallest, const Vec3& at) {
    std::vector<TrianglePoints> result;
    for (int i = 0; i < count; ++i) {
      const double size = std::pow(smallest, std::fabs(number()));
      const Vec3 corner = at + point(1);
      const Vec3 edge = point(size);
      const Vec3 other = i % 4 == 0 ? 0.3 * edge + point(1e-4 * size) : point(size);
      result.push_back({corner, corner + edge, corner + other});
    }
    return result;
  }

 private:
  double number() { return uniform_(random_); }

  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

std::vector<SurfaceSample> samples_of(const std::vector<TrianglePoints>& triangles) {
  std::vector<SurfaceSample> result;
  for (const TrianglePoints& t : triangles) {
    result.push_back({t[0], search_radius(t), true});
    result.push_back({(1.0 / 3) * (t[0] + t[1] + t[2]), search_radius(t), false});
  }
  return result;
}

LargestDistances by_all_pairs(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface) {
  LargestDistances result;
  for (const SurfaceSample& s : samples) {
    double d2 = kInfinity;
    for (const TrianglePoints& t : surface) d2 = std::min(d2, distance2(s.point, t));
    result.all = std::max(result.all, std::sqrt(d2));
    if (s.is_vertex) result.vertices = std::max(result.vertices, std::sqrt(d2));
  }
  return result;
}

TEST(SampledDistance, IsTheLargestOfAllPairs) {
  for (const double smallest : {1.0, 1e-3}) {
    for (const double offset : {0.0, 0.3, 50.0}) {  // near, and too far for the search within a radius
      RandomSurfaces random(7);
      const auto triangles = random.triangles(300, smallest, {0, 0, 0});
      const auto surface = random.triangles(200, smallest, {offset, 0, 0});
      const std::vector<SurfaceSample> samples = samples_of(triangles);
      const LargestDistances expected = by_all_pairs(samples, surface);
      for (const int threads : {1, 3}) {
        const LargestDistances found = max_distances(samples, surface, backend::Cpu(threads));
        EXPECT_EQ(found.all, expected.all) << smallest << " " << offset;
        EXPECT_EQ(found.vertices, expected.vertices) << smallest << " " << offset;
      }
    }
  }
}

/// Boxes of thin triangles that share a vertex have most samples, and are divided.
TEST(SampledDistance, OfThinTrianglesAroundAVertex) {
  std::vector<TrianglePoints> triangles, surface;
  constexpr int kCount = 400;
  const auto on_circle = [](int i, double height) {
    const double angle = 2 * M_PI * i / kCount;
    return Vec3{std::cos(angle), std::sin(angle), height * std::sin(5 * angle)};
  };
  for (int i = 0; i < kCount; ++i) {
    triangles.push_back({{{0, 0, 0}, on_circle(i, 0), on_circle(i + 1, 0)}});
    surface.push_back({{{0, 0, 0}, on_circle(i, 1e-3), on_circle(i + 1, 1e-3)}});
  }
  const std::vector<SurfaceSample> samples = samples_of(triangles);
  EXPECT_EQ(max_distances(samples, surface, backend::Cpu(1)).all, by_all_pairs(samples, surface).all);
}

TEST(SampledDistance, OfTrianglesWithoutASize) {
  const std::vector<TrianglePoints> points{{{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}}};
  const std::vector<TrianglePoints> surface{{{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  EXPECT_EQ(max_distances(samples_of(points), surface, backend::Cpu(1)).all, 1);
}

TEST(BoxTree, FindsTheBoxesThatMeetOrAreNear) {
  RandomSurfaces random(11);
  std::vector<Box> boxes;
  for (int i = 0; i < 333; ++i) {
    const Vec3 corner = random.point(1);
    boxes.push_back({corner, corner});
    boxes.back().include(corner + random.point(i % 3 == 0 ? 0.3 : 0.01));
  }
  const BoxTree tree(boxes);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p = random.point(1.5);
    Box query{p, p};
    query.include(p + random.point(0.5));
    std::vector<Index> found, expected;
    tree.for_meeting(query, [&](Index item) { found.push_back(item); });
    std::sort(found.begin(), found.end());
    double closest2 = kInfinity;
    for (Index k = 0; k < std::ssize(boxes); ++k) {
      if (span_of(boxes)[k].meets(query)) expected.push_back(k);
      closest2 = std::min(closest2, span_of(boxes)[k].distance2(p));
    }
    EXPECT_EQ(found, expected);
    double limit = kInfinity;
    int visits = 0;
    tree.for_closer(p, limit, [&](Index item) {
      limit = std::min(limit, span_of(boxes)[item].distance2(p));
      ++visits;
    });
    EXPECT_EQ(limit, closest2);
    EXPECT_LT(visits, 100);
  }
  BoxTree({}).for_meeting({{0, 0, 0}, {1, 1, 1}}, [](Index) { FAIL(); });
}

}  // namespace
}  // namespace tetune
