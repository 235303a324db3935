// SPDX-License-Identifier: Apache-2.0
// Trees of boxes, and distances of samples of one surface from another, against all pairs.
#include "quality/sampled_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
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
    const double angle = 2 * std::numbers::pi * i / kCount;
    return Vec3{std::cos(angle), std::sin(angle), height * std::sin(5 * angle)};
  };
  for (int i = 0; i < kCount; ++i) {
    triangles.push_back({{{0, 0, 0}, on_circle(i, 0), on_circle(i + 1, 0)}});
    surface.push_back({{{0, 0, 0}, on_circle(i, 1e-3), on_circle(i + 1, 1e-3)}});
  }
  const std::vector<SurfaceSample> samples = samples_of(triangles);
  EXPECT_EQ(max_distances(samples, surface, backend::Cpu(1)).all, by_all_pairs(samples, surface).all);
}

/// A surface over a grid, whose vertices are numbered along its rows.
struct GridSurface {
  static constexpr Index kSide = 24;
  std::vector<TrianglePoints> triangles;
  std::vector<std::array<Index, 3>> ids;

  template <class Height>
  GridSurface(double shift, const Height& height) {
    const auto point = [&](Index v) {
      const double x = v % kSide + shift, y = v / kSide - 0.4 * shift;
      return Vec3{x, y, height(x, y)};
    };
    for (Index row = 0; row + 1 < kSide; ++row) {
      for (Index column = 0; column + 1 < kSide; ++column) {
        const Index v = row * kSide + column;
        for (const std::array<Index, 3>& t :
             {std::array<Index, 3>{v, v + 1, v + kSide + 1}, {v, v + kSide + 1, v + kSide}}) {
          ids.push_back(t);
          triangles.push_back({point(t[0]), point(t[1]), point(t[2])});
        }
      }
    }
  }
  /// Vertices and centroids, with a start.
  std::vector<SurfaceSample> samples(const std::function<Index(Index)>& start) const {
    std::vector<SurfaceSample> result = samples_of(triangles);
    for (std::size_t i = 0; i < result.size(); ++i) result[i].start = start(ids[i / 2][0]);
    return result;
  }
};

/// Bounds by descent do not change the result, wherever it starts: near, on the other sheet of a thin plate, anywhere,
/// at a vertex without triangles, or nowhere.
TEST(SampledDistance, DoesNotDependOnWhereTheDescentStarts) {
  const auto wave = [](double x, double y) { return 0.3 * std::sin(0.9 * x) * std::cos(0.7 * y); };
  const GridSurface from(0.3, [&](double x, double y) { return wave(x, y) + 0.02 * std::sin(5 * x * y); });
  GridSurface to(0, wave);
  const GridSurface other_sheet(0, [&](double x, double y) { return wave(x, y) - 0.05; });
  constexpr Index kVertices = GridSurface::kSide * GridSurface::kSide;
  for (std::size_t i = 0; i < other_sheet.triangles.size(); ++i) {
    to.triangles.push_back(other_sheet.triangles[i]);
    to.ids.push_back(other_sheet.ids[i]);
    for (Index& v : to.ids.back()) v += kVertices;
  }
  std::mt19937 random(5);
  const std::vector<std::function<Index(Index)>> starts{
      [](Index v) { return v; }, [](Index v) { return v + kVertices; },
      [&](Index) { return static_cast<Index>(random() % (2 * kVertices + 1)); },
      [](Index v) { return v % 3 == 0 ? -1 : v; }, [](Index) { return -1; }};
  const LargestDistances expected = by_all_pairs(from.samples(starts[0]), to.triangles);
  for (const auto& start : starts) {
    const std::vector<SurfaceSample> samples = from.samples(start);
    for (const int threads : {1, 3}) {
      const backend::Cpu cpu(threads);
      const SurfaceDescent descent(to.triangles, to.ids, 2 * kVertices + 1, cpu);
      const LargestDistances found = max_distances(samples, to.triangles, cpu, &descent);
      EXPECT_EQ(found.all, expected.all);
      EXPECT_EQ(found.vertices, expected.vertices);
    }
  }
}

TEST(SurfaceDescent, FindsAnUpperBoundThatIsTheDistanceNearTheStart) {
  const auto wave = [](double x, double y) { return 0.1 * std::sin(0.5 * x) * std::cos(0.4 * y); };
  const GridSurface from(0.3, wave), to(0, wave);
  const backend::Cpu cpu(1);
  const SurfaceDescent descent(to.triangles, to.ids, GridSurface::kSide * GridSurface::kSide, cpu);
  int exact = 0, count = 0;
  for (const SurfaceSample& s : from.samples([](Index v) { return v; })) {
    double d2 = kInfinity;
    for (const TrianglePoints& t : to.triangles) d2 = std::min(d2, distance2(s.point, t));
    const double bound = descent.distance2(s.point, s.start, 0);
    EXPECT_GE(bound, d2);
    EXPECT_LE(descent.distance2(s.point, s.start, 0.01), std::max(bound, 0.01));
    exact += bound == d2 ? 1 : 0;
    ++count;
  }
  EXPECT_GT(exact, 0.99 * count);
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
