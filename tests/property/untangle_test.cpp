// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

constexpr int kCubeCells = 8;

using test::is_inner;

TetMesh tangled(double noise, std::uint32_t seed) { return test::tangled(kCubeCells, noise, seed); }

std::int64_t inverted(const TetMesh& m) {
  std::int64_t count = 0;
  for (const Finding& f : validate(m).findings) count += f.count;
  return count;
}

Options untangling(Boundary boundary = Boundary::preserve) {
  Options options;
  options.untangle = true;
  options.boundary = boundary;
  return options;
}

TEST(Untangle, MakesEveryVolumePositiveAndKeepsTheSurface) {
  std::int64_t all = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const TetMesh before = tangled(0.5 + 0.05 * seed, seed);
    const std::int64_t bad = inverted(before);
    ASSERT_GT(bad, 0);
    all += bad;
    TetMesh after = before;
    EXPECT_THROW(optimize(after), MeshError);
    EXPECT_EQ(after.points, before.points);
    const auto boundary = seed % 3 == 0 ? Boundary::fixed : seed % 3 == 1 ? Boundary::preserve : Boundary::slide;
    const Report report = optimize(after, untangling(boundary));
    EXPECT_EQ(report.tets_untangled, bad);
    const ValidationReport valid = validate(after);
    EXPECT_TRUE(valid.ok()) << valid.message(false);
    EXPECT_GT(quality(after).dihedral_min, 5);
    // The surface and the interface are as in the lattice before the noise.
    const Comparison change = compare(test::two_materials(kCubeCells), after);
    EXPECT_LT(change.new_to_old, 1e-12);
    EXPECT_LT(change.old_to_new, 1e-12);
    EXPECT_LT(change.region_volume_change, 1e-12);
  }
  EXPECT_GT(all, 1000);
}

TEST(Untangle, MakesRoomAroundATangleWhereFlipsAreNotAllowed) {
  int done = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    TetMesh m = tangled(1.5 + 0.1 * seed, seed);
    const auto tets = m.tets;
    Options options = untangling(Boundary::fixed);
    options.flips = false;
    options.max_iterations = 0;
    try {
      optimize(m, options);
    } catch (const UntangleError&) {
      continue;
    }
    EXPECT_TRUE(validate(m).ok());
    ++done;
  }
  EXPECT_EQ(done, 20);
}

TEST(Untangle, LeavesWhatIsFrozen) {
  TetMesh before = tangled(0.6, 5);
  for (std::size_t v = 0; v < before.points.size(); v += 10) {
    if (!is_inner(before.points[v])) before.required_vertices.push_back(static_cast<Index>(v));
  }
  TetMesh after = before;
  optimize(after, untangling(Boundary::slide));
  EXPECT_TRUE(validate(after).ok());
  for (const Index v : before.required_vertices) {
    EXPECT_EQ(after.points[static_cast<std::size_t>(v)], before.points[static_cast<std::size_t>(v)]);
  }
}

TEST(Untangle, IsTheSameForAnyNumberOfThreads) {
  const TetMesh before = tangled(0.9, 7);
  Options options = untangling();
  options.threads = 1;
  TetMesh one = before;
  optimize(one, options);
  for (const int threads : {2, 3}) {
    options.threads = threads;
    TetMesh many = before;
    optimize(many, options);
    EXPECT_EQ(one.points, many.points);
    EXPECT_EQ(one.tets, many.tets);
  }
}

TEST(Untangle, TakesFlatTetrahedraApart) {
  TetMesh m = test::cube(4);
  m.points[62] = {0.5, 0.5, 0.25};  // the middle one, put on the vertex below it
  ASSERT_EQ(m.points[37], m.points[62]);
  optimize(m, untangling());
  EXPECT_TRUE(validate(m).ok());
  EXPECT_GT(quality(m).dihedral_min, 20);
}

TEST(Untangle, SaysWhatIsLeftAndChangesNothing) {
  TetMesh m = test::two_tets(0.5);
  std::swap(m.points[0], m.points[1]);  // both inverted, and nothing may move
  const TetMesh before = m;
  try {
    optimize(m, untangling(Boundary::fixed));
    FAIL();
  } catch (const UntangleError& e) {
    EXPECT_EQ(e.tangled, 2);
    EXPECT_EQ(e.left, (std::vector<Index>{0, 1}));
    EXPECT_NE(e.message(true).find("counted from 1: 1, 2)"), std::string::npos) << e.message(true);
  }
  EXPECT_EQ(m.points, before.points);
  EXPECT_EQ(m.tets, before.tets);
}

/// The error for a mesh that cannot be untangled.
UntangleError failure(TetMesh m, Boundary boundary) {
  Options options = untangling(boundary);
  options.threads = 1;
  try {
    optimize(m, options);
  } catch (const UntangleError& e) {
    return e;
  }
  throw std::logic_error("it did not fail");
}

TEST(Untangle, SaysWhereTheSurfaceCrossesItself) {
  TetMesh m = test::cube(4);
  const auto top = std::find(m.points.begin(), m.points.end(), Point3{0.5, 0.5, 1});
  ASSERT_NE(top, m.points.end());
  *top = {0.52, 0.47, -0.3};  // through the opposite side
  const UntangleError e = failure(m, Boundary::fixed);
  EXPECT_EQ(e.reason, UntangleError::Reason::surface_at_fault);
  EXPECT_NE(e.message(true).find("crosses itself"), std::string::npos);
  for (const Index t : e.left) {
    const auto& tet = m.tets[static_cast<std::size_t>(t)];
    const auto is_at = [&](Index v, double z) { return m.points[static_cast<std::size_t>(v)][2] == z; };
    EXPECT_TRUE(std::any_of(tet.begin(), tet.end(), [&](Index v) { return is_at(v, -0.3) || is_at(v, 0); }));
  }
  EXPECT_FALSE(e.left.empty());
}

TEST(Untangle, SaysWhereTheSurfaceIsFolded) {
  TetMesh m = test::cube(4);
  const auto top = std::find(m.points.begin(), m.points.end(), Point3{0.5, 0.5, 1});
  ASSERT_NE(top, m.points.end());
  *top = {0.9, 0.5, 1};  // beyond its neighbor at 0.75
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve}) {
    const UntangleError e = failure(m, boundary);
    EXPECT_EQ(e.reason, UntangleError::Reason::surface_at_fault);
    EXPECT_NE(e.message(true).find("is folded onto itself at"), std::string::npos) << e.message(true);
    EXPECT_FALSE(e.left.empty());
  }
}

TEST(Untangle, SaysWhyItEnded) {
  const auto reason = [](const Options& options, const Context& context) {
    TetMesh m = test::two_tets(0.5);
    std::swap(m.points[0], m.points[1]);
    m.required_vertices = {0, 1, 2, 3, 4};
    try {
      optimize(m, options, context);
    } catch (const UntangleError& e) {
      return std::pair(e.reason, e.message(true).find("no room") != std::string::npos);
    }
    throw std::logic_error("it did not fail");
  };
  using Reason = UntangleError::Reason;
  EXPECT_EQ(reason(untangling(), {}), std::pair(Reason::no_room, true));
  EXPECT_EQ(reason(untangling(Boundary::slide), {}), std::pair(Reason::no_room_though_sliding, true));
  int asked = 0;
  Context context;
  context.stop = [&asked] { return ++asked == 1; };
  EXPECT_EQ(reason(untangling(), context), std::pair(Reason::stopped, false));
  context.stop = {};
  context.progress = [](const Progress&) { return false; };
  EXPECT_EQ(reason(untangling(), context), std::pair(Reason::stopped, false));
}

TEST(Untangle, DoesNothingToAValidMesh) {
  TetMesh plain = test::cube(5, 0.2);
  TetMesh asked = plain;
  optimize(plain);
  EXPECT_EQ(optimize(asked, untangling()).tets_untangled, 0);
  EXPECT_EQ(plain.points, asked.points);
  EXPECT_EQ(plain.tets, asked.tets);
}

TEST(Coordinates, FarFromTheOriginAreAsGood) {
  TetMesh near = test::scrambled(test::cube(6, 0.2), 2);
  // To multiples of 2^-20, so that the shifted mesh has the same shape to the last bit.
  for (Point3& p : near.points) {
    for (double& x : p) x = std::round(x * (1 << 20)) / (1 << 20);
  }
  TetMesh far = near;
  for (Point3& p : far.points) {
    for (double& x : p) x += 1 << 30;
  }
  ASSERT_TRUE(validate(near).ok());
  optimize(near);
  optimize(far);
  EXPECT_TRUE(validate(far).ok());
  const Quality a = quality(near);
  const Quality b = quality(far);
  EXPECT_NEAR(a.dihedral_min, b.dihedral_min, 1);
  EXPECT_NEAR(a.mean_ratio, b.mean_ratio, 1e-3);
}

}  // namespace
}  // namespace tetune
