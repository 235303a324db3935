// SPDX-License-Identifier: Apache-2.0
// The bound on the distance between the surface of the mesh and the input surface.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "boundary/sliding/deviation_bound.hpp"
#include "boundary/sliding/trace.hpp"
#include "math/closest_triangle.hpp"
#include "support/curved.hpp"
#include "support/surface.hpp"

namespace tetune {
namespace {

using test::bumpy;
using test::descent;
using test::flat;
using test::height_field;
using test::height_field_with_line;
using test::random_vec;
using test::sampled_distance;
using test::TinySurface;
using test::uniform;
using Pack = backend::Cpu::Pack;

/// A mesh surface with the triangles of the reference, whose vertices have moved.
struct SlidSurface {
  const TinySurface& s;
  std::vector<Point> points;
  std::vector<SurfacePoint> surface_points;
  explicit SlidSurface(const TinySurface& surface) : s(surface), points(surface.points) {
    for (std::size_t v = 0; v < points.size(); ++v)
      surface_points.push_back({SurfacePointKind::vertex, static_cast<Index>(v)});
  }
  bool allows(Index v, const TraceResult& end, double limit) const {
    return VertexDeviation<Pack>({s.view(), span_of(points), span_of(surface_points), v, limit})
        .allows(vec(points[static_cast<std::size_t>(v)]), end.position, end.surface_point);
  }
  /// Calls f(vertex, end of the walk) for each of `tries` random walks that leave the surface upright.
  template <class F>
  void for_walks(int tries, double far, std::mt19937& random, const F& f) {
    for (int i = 0; i < tries; ++i) {
      const auto v = static_cast<Index>(random() % s.points.size());
      if (s.dof[static_cast<std::size_t>(v)] == VertexDof::fixed) continue;
      const TraceResult end = wander(v, far, random);
      SlidSurface moved = *this;
      moved.put(v, end);
      if (moved.upright()) f(v, end);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  /// A random walk of a few steps from the position of the vertex.
  TraceResult wander(Index v, double far, std::mt19937& random) const {
    const auto i = static_cast<std::size_t>(v);
    TraceResult at{vec(points[i]), surface_points[i], 0, false};
    for (int step = 0; step < 4; ++step) {
      const SurfaceElement p = steepest(s.view(), s.dof[i], at.surface_point, random_vec(random));
      if (p.on.kind == SurfacePointKind::none) continue;
      at = advance(s.view(), {at.position, at.surface_point, s.dof[i]}, p, (1 / norm(descent(p))) * p.descent,
                   far * uniform(random));
    }
    return at;
  }
  void put(Index v, const TraceResult& end) {
    span_of(points)[v] = point(end.position);
    span_of(surface_points)[v] = end.surface_point;
  }
  TrianglePoints triangle(std::size_t t, const std::vector<Point>& at) const {
    TrianglePoints p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = vec(at[static_cast<std::size_t>(s.triangles[t].v[k])]);
    return p;
  }
  /// Whether the surface is a graph over the plane, as that of a mesh of positive volumes below it is.
  bool upright() const {
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const TrianglePoints p = triangle(t, points);
      if (!(cross(p[1] - p[0], p[2] - p[0]).z > 1e-4)) return false;
    }
    return true;
  }
  /// Plain oracle: the largest distance between dense samples of both surfaces.
  double distance() const {
    std::vector<TrianglePoints> now;
    std::vector<TrianglePoints> before;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      now.push_back(triangle(t, points));
      before.push_back(triangle(t, s.points));
    }
    constexpr int kSamples = 8;
    return std::max(sampled_distance(now, ClosestTriangle(before), kSamples),
                    sampled_distance(before, ClosestTriangle(now), kSamples));
  }
};

TEST(SmallSet, FindsIdsOfTheSameHash) {
  SmallSet<100> set;
  // Ids that are equal modulo 256 share a slot.
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

/// The decision of the fast test alone.
enum class Decision { within, beyond, undecided };
Decision fan_decision(const SlidSurface& mesh, Index v, const TraceResult& end, double limit) {
  const ReferenceView ref = mesh.s.view();
  const DeviationInput input{ref, span_of(mesh.points), span_of(mesh.surface_points), v, limit};
  const TriangleDeviation wedges(input);
  SurfaceFan<Pack> fan;
  if (!fan.build(ref, span_of(mesh.points), v, end.position)) return Decision::undecided;
  fan.find_prisms();
  FanMask undecided = 0;
  FanDeviation<Pack> test(fan, input, wedges);
  if (!test.is_within(end.surface_point, undecided)) return Decision::beyond;
  return undecided == 0 ? Decision::within : Decision::undecided;
}

TEST(FanDeviation, KeepsTheBoundAlone) {
  std::mt19937 random(11);
  for (const double limit : {0.02, 0.005}) {
    const TinySurface s = height_field(9, bumpy);
    SlidSurface mesh(s);
    int count[3] = {0, 0, 0};
    mesh.for_walks(3000, 0.1, random, [&](Index v, const TraceResult& end) {
      const Decision decision = fan_decision(mesh, v, end, limit);
      ++count[static_cast<int>(decision)];
      if (decision != Decision::within) return;
      mesh.put(v, end);
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

/// Whether the test along the axis of the fan decides alone that the bound holds.
bool axis_test_allows(const SlidSurface& mesh, Index v, const TraceResult& end, double limit) {
  const ReferenceView ref = mesh.s.view();
  const DeviationInput input{ref, span_of(mesh.points), span_of(mesh.surface_points), v, limit};
  SurfaceFan<Pack> fan;
  return fan.build(ref, span_of(mesh.points), v, end.position) &&
         AxisDeviation<Pack>(fan, input).is_within(end.surface_point);
}
/// Whether the general test, along the normals of the triangles, allows each of them.
bool triangle_test_allows(const SlidSurface& mesh, Index v, const TraceResult& end, double limit) {
  const ReferenceView ref = mesh.s.view();
  const TriangleDeviation test({ref, span_of(mesh.points), span_of(mesh.surface_points), v, limit});
  for (Size c = ref.vertex2corner.begin(v); c < ref.vertex2corner.end(v); ++c) {
    if (!test.is_within(ref.vertex2corner.items[c], end.position, end.surface_point)) return false;
  }
  return true;
}

TEST(AxisDeviation, ImpliesTheTestAlongTheNormals) {
  std::mt19937 random(13);
  for (const double limit : {0.05, 0.02, 0.005}) {
    const TinySurface s = height_field(9, [](double x, double y) { return 0.4 * bumpy(x, y); });
    SlidSurface mesh(s);
    int allowed = 0;
    int others = 0;
    mesh.for_walks(4000, 0.1, random, [&](Index v, const TraceResult& end) {
      // Moves that the general test alone allows take part, so that triangles of both kinds are neighbors.
      const bool general = triangle_test_allows(mesh, v, end, limit);
      if (axis_test_allows(mesh, v, end, limit)) {
        ASSERT_TRUE(general) << limit;
        ++allowed;
      } else if (general) {
        ++others;
      } else {
        return;
      }
      mesh.put(v, end);
      if (allowed % 10 == 0) {
        ASSERT_LE(mesh.distance(), limit);
      }
    });
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed, 50) << limit;
    EXPECT_GT(others, 50) << limit;
  }
}

TEST(AxisDeviation, LeavesFansAtFeaturesUndecided) {
  std::mt19937 random(14);
  const TinySurface s = height_field_with_line(8, flat);
  const SlidSurface mesh(s);
  const ReferenceView ref = s.view();
  int decided = 0;
  for (Index v = 0; v < std::ssize(s.points); ++v) {
    if (ref.dof[v] != VertexDof::surface) continue;
    bool at_feature = false;
    for (Size c = ref.vertex2corner.begin(v); c < ref.vertex2corner.end(v); ++c) {
      at_feature = at_feature || ref.across[ref.vertex2corner.items[c]] == kFeatureEdge;
    }
    const TraceResult here{vec(s.points[static_cast<std::size_t>(v)]), {SurfacePointKind::vertex, v}, 0, true};
    const bool allowed = axis_test_allows(mesh, v, here, 0.01);
    EXPECT_FALSE(at_feature && allowed) << v;
    decided += allowed ? 1 : 0;
  }
  EXPECT_GT(decided, 0);
}

TEST(VertexDeviation, DoesNotRestrictMotionInAPlane) {
  std::mt19937 random(7);
  const TinySurface s = height_field(6, flat);
  SlidSurface mesh(s);
  int moves = 0;
  mesh.for_walks(2000, 0.05, random, [&](Index v, const TraceResult& end) {
    ASSERT_TRUE(mesh.allows(v, end, 1e-9));
    mesh.put(v, end);
    ++moves;
  });
  EXPECT_GT(moves, 500);
}

TEST(VertexDeviation, BoundsBothDistancesOfACurvedSurface) {
  std::mt19937 random(8);
  for (const double limit : {0.1, 0.02, 0.005, 0.001}) {
    const TinySurface s = height_field(7, bumpy);
    SlidSurface mesh(s);
    int allowed = 0;
    int refused = 0;
    mesh.for_walks(3000, 0.1, random, [&](Index v, const TraceResult& end) {
      const bool is_allowed = mesh.allows(v, end, limit);
      (is_allowed ? allowed : refused) += 1;
      if (!is_allowed) return;
      mesh.put(v, end);
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

TEST(VertexDeviation, BoundsTheDistanceOfAFeatureLine) {
  std::mt19937 random(9);
  // The line x = 1/2 over a fold of varying height: chords of a bent polyline deviate from it.
  const auto roof = [](double x, double y) { return 0.4 * std::fabs(x - 0.5) + 0.06 * std::sin(9 * y); };
  const TinySurface s = height_field_with_line(8, roof);
  for (const double limit : {0.05, 0.01, 0.003}) {
    SlidSurface mesh(s);
    int allowed[2] = {0, 0};
    int refused = 0;
    mesh.for_walks(6000, 0.1, random, [&](Index v, const TraceResult& end) {
      if (!mesh.allows(v, end, limit)) {
        ++refused;
        return;
      }
      mesh.put(v, end);
      ++allowed[s.dof[static_cast<std::size_t>(v)] == VertexDof::curve ? 1 : 0];
    });
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed[0], 50) << limit;
    EXPECT_GT(allowed[1], 10) << limit;
    EXPECT_GT(refused, 10) << limit;
    // Both distances of the line itself.
    const auto segments = [](const std::vector<Point>& p) {
      std::vector<TrianglePoints> all;
      for (std::size_t j = 0; j < 8; ++j) {
        const Vec3 end = vec(p[(j + 1) * 9 + 4]);
        all.push_back({vec(p[j * 9 + 4]), end, end});
      }
      return all;
    };
    double off = 0;
    const auto measure = [&](const std::vector<Point>& from, const std::vector<Point>& to) {
      const ClosestTriangle line(segments(to));
      for (const TrianglePoints& p : segments(from)) {
        for (int k = 0; k <= 20; ++k) off = std::max(off, line.distance2(p[0] + (k / 20.0) * (p[1] - p[0])));
      }
    };
    measure(s.points, mesh.points);
    measure(mesh.points, s.points);
    EXPECT_LE(std::sqrt(off), limit);
  }
}

TEST(VertexDeviation, RejectsWhatItCannotDecide) {
  // Over a degenerate triangle heights are not defined.
  const TinySurface s = height_field(3, flat);
  const SlidSurface mesh(s);
  const TraceResult onto_neighbor{vec(s.points[6]), {SurfacePointKind::vertex, 6}, 0, true};
  EXPECT_FALSE(mesh.allows(5, onto_neighbor, 100));
  // One large triangle over more small ones than fit into the memory of a thread.
  const TinySurface fine = height_field(24, flat);
  SlidSurface stretched(fine);
  const auto move = [&](Index v, Index to) {
    stretched.put(v, {vec(fine.points[static_cast<std::size_t>(to)]), {SurfacePointKind::vertex, to}, 0, true});
  };
  const auto id = [](int i, int j) { return static_cast<Index>(j * 25 + i); };
  move(id(12, 12), id(2, 2));
  move(id(13, 12), id(22, 2));
  EXPECT_FALSE(stretched.allows(
      id(13, 13),
      {vec(fine.points[static_cast<std::size_t>(id(12, 22))]), {SurfacePointKind::vertex, id(12, 22)}, 0, true}, 100));
}

TEST(DeviationBound, AllowsAnyMoveWhereItIsZero) {
  const TinySurface s = height_field(3, flat);
  const SlidSurface mesh(s);
  const ReferenceView ref = s.view();
  DeviationBound<Pack> bound({ref, span_of(mesh.points), span_of(mesh.surface_points), 5, 0}, vec(mesh.points[5]));
  EXPECT_TRUE(bound.allows(vec(s.points[6]), {SurfacePointKind::vertex, 6}));
}

TEST(DeviationBound, AddsUpDriftAndTestedDeviation) {
  std::mt19937 random(12);
  const TinySurface s = height_field(9, bumpy);
  const ReferenceView ref = s.view();
  for (const double limit : {0.05, 0.01}) {
    for (const double share : {0.0, kDriftShare}) {
      const double drift = share * limit;
      SlidSurface mesh(s);
      SlidSurface checked(s);
      const CheckedSurfaceView view{span_of(checked.points), span_of(checked.surface_points), {}, {}};
      int moves = 0;
      int tests = 0;
      mesh.for_walks(4000, 0.03, random, [&](Index v, const TraceResult& end) {
        DeviationBound<Pack> bound({ref, view.points, view.surface_points, v, limit}, vec(view.points[v]), false,
                                   share);
        if (!bound.allows(end.position, end.surface_point)) return;
        const Point before = view.points[v];
        bound.store(view, v);
        mesh.put(v, end);
        ++moves;
        const bool is_new = norm(vec(view.points[v]) - vec(before)) > 0;
        if (is_new) {
          EXPECT_EQ(norm(vec(view.points[v]) - end.position), 0);
          EXPECT_EQ(view.surface_points[v].item, end.surface_point.item);
          ++tests;
        }
        ASSERT_LE(norm(vec(view.points[v]) - end.position), drift);
      });
      EXPECT_LE(checked.distance(), limit - drift);
      EXPECT_LE(mesh.distance(), limit);
      EXPECT_GT(mesh.distance(), 0.2 * limit);
      EXPECT_GT(moves, 500) << limit;
      if (drift == 0) {
        EXPECT_EQ(tests, moves);
      }
      if (drift > 0.01) {
        EXPECT_LT(tests, 3 * moves / 4);
      }
    }
  }
}

TEST(DeviationBound, IsNoneForALimitOf0) {
  const TinySurface s = height_field(3, flat);
  const ReferenceView ref = s.view();
  DeviationBound<Pack> none({ref, {}, {}, 5, 0}, {});
  EXPECT_TRUE(none.allows({9, 9, 9}, {SurfacePointKind::vertex, 6}));
  none.store({}, 5);
}

}  // namespace
}  // namespace tetune
