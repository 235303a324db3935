// SPDX-License-Identifier: Apache-2.0
// The bound on the distance between the surface of the mesh and the input surface.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "boundary/closest_triangle.hpp"
#include "surface.hpp"
#include "surface/deviation.hpp"

namespace tetune {
namespace {

using test::bumpy;
using test::descent;
using test::flat;
using test::height_field;
using test::height_field_with_line;
using test::random_vec;
using test::TinySurface;
using test::uniform;

/// A mesh surface of the reference's own triangles whose vertices have slid.
struct SlidSurface {
  const TinySurface& s;
  std::vector<Point> points;
  std::vector<Site> sites;
  explicit SlidSurface(const TinySurface& surface) : s(surface), points(surface.points) {
    for (std::size_t v = 0; v < points.size(); ++v) sites.push_back({SiteKind::vertex, static_cast<Index>(v)});
  }
  bool allows(Index v, const Landing& landing, double limit) const {
    return DeviationBound(s.view(), {points.data(), static_cast<Size>(points.size())},
                          {sites.data(), static_cast<Size>(sites.size())}, v, limit)
        .allows(landing.at, landing.site);
  }
  /// Calls f(vertex, where it may go) for each of `tries` random walks that leave the surface upright.
  template <class F>
  void for_walks(int tries, double far, std::mt19937& random, const F& f) {
    for (int i = 0; i < tries; ++i) {
      const auto v = static_cast<Index>(random() % s.points.size());
      if (s.kind[static_cast<std::size_t>(v)] == Mobility::fixed) continue;
      const Landing landing = wander(v, far, random);
      SlidSurface moved = *this;
      moved.put(v, landing);
      if (moved.upright()) f(v, landing);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  /// A random walk of a few hops from where the vertex is.
  Landing wander(Index v, double far, std::mt19937& random) const {
    const auto i = static_cast<std::size_t>(v);
    Landing at{vec(points[i]), sites[i], 0, false};
    for (int hop = 0; hop < 4; ++hop) {
      const Primitive p = steepest(s.view(), s.kind[i], at.site, random_vec(random));
      if (p.on.kind == SiteKind::none) continue;
      at = advance(s.view(), s.kind[i], p, at.site, at.at, (1 / norm(descent(p))) * p.down, far * uniform(random));
    }
    return at;
  }
  void put(Index v, const Landing& landing) {
    points[static_cast<std::size_t>(v)] = point(landing.at);
    sites[static_cast<std::size_t>(v)] = landing.site;
  }
  TrianglePoints triangle(std::size_t t, const std::vector<Point>& at) const {
    TrianglePoints p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = vec(at[static_cast<std::size_t>(s.triangles[t].v[k])]);
    return p;
  }
  /// Stays a graph over the plane, as a mesh of positive volumes below it would.
  bool upright() const {
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const TrianglePoints p = triangle(t, points);
      if (!(cross(p[1] - p[0], p[2] - p[0]).z > 1e-4)) return false;
    }
    return true;
  }
  /// Plain oracle: both surfaces sampled densely.
  double distance() const {
    std::vector<TrianglePoints> now;
    std::vector<TrianglePoints> before;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      now.push_back(triangle(t, points));
      before.push_back(triangle(t, s.points));
    }
    return std::max(farthest(now, ClosestTriangle(before)), farthest(before, ClosestTriangle(now)));
  }

 private:
  static double farthest(const std::vector<TrianglePoints>& from, const ClosestTriangle& to) {
    constexpr int kSamples = 8;
    double most = 0;
    for (const TrianglePoints& t : from) {
      for (int a = 0; a <= kSamples; ++a) {
        for (int b = 0; a + b <= kSamples; ++b) {
          const Vec3 p = t[0] + (static_cast<double>(a) / kSamples) * (t[1] - t[0]) +
                         (static_cast<double>(b) / kSamples) * (t[2] - t[0]);
          most = std::max(most, to.distance2(p));
        }
      }
    }
    return std::sqrt(most);
  }
};

TEST(SmallSet, FindsWhatSharesASlot) {
  SmallSet<100> set;
  // 256 slots: all ids but the first few share theirs.
  const auto id = [](int i) { return static_cast<Index>(256 * (i / 4) + i % 4); };
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT(set.find(id(i)), 0);
    EXPECT_EQ(set.add(id(i)), i);
  }
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(set.find(id(i)), i);
    EXPECT_EQ(set[i], id(i));
  }
  EXPECT_LT(set.find(id(100)), 0);
  EXPECT_LT(set.find(5), 0);
  EXPECT_EQ(set.add(5), SmallSet<100>::kAbsent);
  EXPECT_EQ(set.size(), 100);
}

/// Whether the look at all triangles of a vertex at once decides, and how.
enum class Decision { close, far, open };
Decision cover_of(const SlidSurface& mesh, Index v, const Landing& landing, double limit) {
  const ReferenceView ref = mesh.s.view();
  StarCover star(ref, {mesh.points.data(), static_cast<Size>(mesh.points.size())},
                 {mesh.sites.data(), static_cast<Size>(mesh.sites.size())}, limit);
  if (!star.take(v, landing.at)) return Decision::open;
  const auto unknown = [](std::uint32_t, const Vec3&, const double*) { return Wedge::close; };
  StarCover::Mask in_doubt = 0;
  if (!star.is_close(landing.site, unknown, in_doubt)) return Decision::far;
  return in_doubt == 0 ? Decision::close : Decision::open;
}

TEST(StarCover, KeepsToTheBoundByItself) {
  std::mt19937 random(11);
  for (const double limit : {0.02, 0.005}) {
    const TinySurface s = height_field(9, bumpy);
    SlidSurface mesh(s);
    int count[3] = {0, 0, 0};
    mesh.for_walks(3000, 0.1, random, [&](Index v, const Landing& landing) {
      const Decision decision = cover_of(mesh, v, landing, limit);
      ++count[static_cast<int>(decision)];
      if (decision != Decision::close) return;
      mesh.put(v, landing);
      if (count[0] % 10 == 0) {
        ASSERT_LE(mesh.distance(), limit);
      }
    });
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(count[0], 50) << limit;
    EXPECT_GT(count[1], 50) << limit;
  }
}

TEST(DeviationBound, LetsVerticesOfAPlaneGoAnywhere) {
  std::mt19937 random(7);
  const TinySurface s = height_field(6, flat);
  SlidSurface mesh(s);
  int moves = 0;
  mesh.for_walks(2000, 0.05, random, [&](Index v, const Landing& landing) {
    ASSERT_TRUE(mesh.allows(v, landing, 1e-9));
    mesh.put(v, landing);
    ++moves;
  });
  EXPECT_GT(moves, 500);
}

TEST(DeviationBound, HoldsBothWaysOnACurvedSurface) {
  std::mt19937 random(8);
  for (const double limit : {0.1, 0.02, 0.005, 0.001}) {
    const TinySurface s = height_field(7, bumpy);
    SlidSurface mesh(s);
    int allowed = 0;
    int refused = 0;
    mesh.for_walks(3000, 0.1, random, [&](Index v, const Landing& landing) {
      const bool fine = mesh.allows(v, landing, limit);
      (fine ? allowed : refused) += 1;
      if (!fine) return;
      mesh.put(v, landing);
      if (allowed % 10 == 0) {
        ASSERT_LE(mesh.distance(), limit) << limit;
      }
    });
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed, limit > 0.001 ? 200 : 20) << limit;
    EXPECT_GT(refused, limit < 0.1 ? 50 : -1) << limit;
  }
}

TEST(DeviationBound, HoldsAlongAFeatureLine) {
  std::mt19937 random(9);
  // The line x = 1/2 over a fold of varying height: of a bent polyline every chord leaves something out.
  const auto roof = [](double x, double y) { return 0.4 * std::fabs(x - 0.5) + 0.06 * std::sin(9 * y); };
  const TinySurface s = height_field_with_line(8, roof);
  for (const double limit : {0.05, 0.01, 0.003}) {
    SlidSurface mesh(s);
    int allowed[2] = {0, 0};
    int refused = 0;
    mesh.for_walks(6000, 0.1, random, [&](Index v, const Landing& landing) {
      if (!mesh.allows(v, landing, limit)) {
        ++refused;
        return;
      }
      mesh.put(v, landing);
      ++allowed[s.kind[static_cast<std::size_t>(v)] == Mobility::curve ? 1 : 0];
    });
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed[0], 50) << limit;
    EXPECT_GT(allowed[1], 10) << limit;
    EXPECT_GT(refused, 10) << limit;
    // The line itself, both ways.
    const auto segments = [](const std::vector<Point>& p) {
      std::vector<TrianglePoints> all;
      for (std::size_t j = 0; j < 8; ++j) {
        const Vec3 end = vec(p[(j + 1) * 9 + 4]);
        all.push_back({vec(p[j * 9 + 4]), end, end});
      }
      return all;
    };
    double off = 0;
    const auto look = [&](const std::vector<Point>& from, const std::vector<Point>& to) {
      const ClosestTriangle line(segments(to));
      for (const TrianglePoints& p : segments(from)) {
        for (int k = 0; k <= 20; ++k) off = std::max(off, line.distance2(p[0] + (k / 20.0) * (p[1] - p[0])));
      }
    };
    look(s.points, mesh.points);
    look(mesh.points, s.points);
    EXPECT_LE(std::sqrt(off), limit);
  }
}

TEST(DeviationBound, CountsWhatItCannotDecideAsTooFar) {
  // A star triangle without area has no heights.
  const TinySurface s = height_field(3, flat);
  const SlidSurface mesh(s);
  const Landing onto_neighbour{vec(s.points[6]), {SiteKind::vertex, 6}, 0, true};
  EXPECT_FALSE(mesh.allows(5, onto_neighbour, 100));
  EXPECT_TRUE(mesh.allows(5, onto_neighbour, 0));  // no bound
  // One large triangle over more small ones than there is room for.
  const TinySurface fine = height_field(24, flat);
  SlidSurface spread(fine);
  const auto go = [&](Index v, Index to) {
    spread.put(v, {vec(fine.points[static_cast<std::size_t>(to)]), {SiteKind::vertex, to}, 0, true});
  };
  const auto id = [](int i, int j) { return static_cast<Index>(j * 25 + i); };
  go(id(12, 12), id(2, 2));
  go(id(13, 12), id(22, 2));
  EXPECT_FALSE(spread.allows(
      id(13, 13), {vec(fine.points[static_cast<std::size_t>(id(12, 22))]), {SiteKind::vertex, id(12, 22)}, 0, true},
      100));
}

}  // namespace
}  // namespace tetune
