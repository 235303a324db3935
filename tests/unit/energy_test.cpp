// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "energy/ring.hpp"
#include "energy/simd_ring.hpp"
#include "support/quad.hpp"
#include "support/random.hpp"

namespace tetune {
namespace {

using test::random_vec;

/// A ring whose faces are those of a regular icosahedron with displaced vertices, without the first `drop` ones.
struct Ring20 {
  std::vector<Point> points;
  std::vector<LinkFace> faces;
  explicit Ring20(std::uint32_t seed, int drop = 0) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::mt19937 random(seed);
    const double c[12][3] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (const auto& p : c) {
      const Vec3 d = 0.15 * random_vec(random);
      points.push_back({p[0] + d.x, p[1] + d.y, p[2] + d.z, 0});
    }
    const int f[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                          {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                          {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int i = drop; i < 20; ++i) {
      LinkFace face{{f[i][0], f[i][1], f[i][2]}};
      const Vec3 a = vec(points[static_cast<std::size_t>(face.v[0])]);
      const Vec3 b = vec(points[static_cast<std::size_t>(face.v[1])]);
      const Vec3 e = vec(points[static_cast<std::size_t>(face.v[2])]);
      if (dot(cross(a, b), e) < 0) std::swap(face.v[1], face.v[2]);
      faces.push_back(face);
    }
  }
  Span<const Point> span() const { return {points.data(), static_cast<Size>(points.size())}; }
  PlainRing<> plain() const { return {kHarmonicObjective, span(), faces.data(), static_cast<Size>(faces.size())}; }
  SimdRing simd() const { return {kHarmonicObjective, span(), faces.data(), static_cast<Size>(faces.size())}; }
};

TEST(HarmonicIndex, OfTheRegularTetrahedronWithUnitEdge) {
  // Four areas sqrt(3)/4, volume 1/(6 sqrt 2): eta = (4 * 3/16) * 6 sqrt 2.
  const double s = 1 / std::sqrt(2.0);
  const Vec3 p[4] = {{0.5, 0, -0.5 * s}, {-0.5, 0, -0.5 * s}, {0, 0.5, 0.5 * s}, {0, -0.5, 0.5 * s}};
  const TetEnergy e = tet_energy(kHarmonicObjective, p[0], p[1], p[2], p[3]);
  const TetEnergy turned = tet_energy(kHarmonicObjective, p[0], p[1], p[3], p[2]);
  EXPECT_NE(e.certified, turned.certified);
  EXPECT_NEAR(e.certified ? e.energy : turned.energy, 4.5 * std::sqrt(2.0), 1e-14);
}

TEST(HarmonicIndex, OfAPackHasTheBitsOfEachLane) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const Objective& objective : {kHarmonicObjective, kShapeObjective, shape_objective(2)}) {
    for (int i = 0; i < 200; ++i) {
      std::vector<Point> points;
      for (int k = 0; k < 16; ++k)
        points.push_back(point({coordinate(random), coordinate(random), coordinate(random)}));
      // Every fourth one is flat: the sign of the volume is uncertain.
      for (std::size_t k = 0; k < 4 && i % 4 == 0; ++k) points[k].z = 0.25 * points[k].x;
      const Span<const Point> all(points.data(), 16);
      const auto corner = [&](Index k) { return gather<backend::Pack4>(all, {k, k + 4, k + 8, k + 12}); };
      const TetEnergyT<backend::Pack4> pack = tet_energy(objective, corner(0), corner(1), corner(2), corner(3));
      for (int l = 0; l < 4; ++l) {
        const auto at = [&](int k) { return vec(points[static_cast<std::size_t>(4 * l + k)]); };
        const TetEnergy one = tet_energy(objective, at(0), at(1), at(2), at(3));
        EXPECT_EQ(pack.energy[l], one.energy);
        EXPECT_EQ(pack.certified[l] != 0, one.certified);
        EXPECT_EQ(pack.shape[l], one.shape);
        EXPECT_EQ(pack.q[l], one.q);
        EXPECT_EQ(pack.w[l], one.w);
      }
    }
  }
}

TEST(HarmonicIndex, AgreesWithItsDefinition) {
  std::mt19937 random(11);
  int positive = 0;
  for (int i = 0; i < 2000; ++i) {
    Vec3 p[4];
    for (Vec3& v : p) v = random_vec(random);
    const TetEnergy e = tet_energy(kHarmonicObjective, p[0], p[1], p[2], p[3]);
    if (!e.certified) continue;
    ++positive;
    const double expected = static_cast<double>(plain_eta(test::quad_tet(p)));
    EXPECT_NEAR(e.energy, expected, 1e-10 * expected);
  }
  EXPECT_GT(positive, 800);
}

TEST(HarmonicIndex, OfSliversStaysWithinTheErrorOfTheVolume) {
  std::mt19937 random(13);
  for (const double flatness : {1e-6, 1e-9, 1e-12}) {
    for (int i = 0; i < 500; ++i) {
      // A square with its diagonals `flatness` apart: volume about flatness times edge cubed.
      Vec3 p[4] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, flatness}, {0, -1, flatness}};
      for (Vec3& v : p) v = v + 0.1 * Vec3{random_vec(random).x, random_vec(random).y, 0};
      const Orient o = orient(p[0], p[1], p[2], p[3]);
      if (o.det < 0) std::swap(p[2], p[3]);
      const TetEnergy e = tet_energy(kHarmonicObjective, p[0], p[1], p[2], p[3]);
      const double expected = static_cast<double>(plain_eta(test::quad_tet(p)));
      EXPECT_TRUE(e.certified);
      EXPECT_NEAR(e.energy, expected, (4 * o.bound / std::fabs(o.det) + 1e-13) * expected);
    }
  }
}

TEST(HarmonicIndex, IsFiniteForAnUncertainVolume) {
  const TetEnergy e = tet_energy(kHarmonicObjective, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1e-17});
  EXPECT_FALSE(tet_energy(kHarmonicObjective, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0}).certified);
  EXPECT_TRUE(std::isfinite(e.energy));
  EXPECT_GT(e.energy, 1e10);
}

template <class R>
void expect_model_matches_differences(R ring, const Vec3& x) {
  const RingModel m = ring.model(x);
  const double h = 1e-5;
  const Vec3 axes[3] = {{h, 0, 0}, {0, h, 0}, {0, 0, h}};
  const double g[3] = {m.gradient.x, m.gradient.y, m.gradient.z};
  const double hess[3][3] = {{m.hessian.xx, m.hessian.xy, m.hessian.xz},
                             {m.hessian.xy, m.hessian.yy, m.hessian.yz},
                             {m.hessian.xz, m.hessian.yz, m.hessian.zz}};
  const double scale = std::fabs(m.hessian.xx) + std::fabs(m.hessian.yy) + std::fabs(m.hessian.zz);
  EXPECT_NEAR(m.value, ring.value(x).value, 1e-12 * m.value);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(g[i], (ring.value(x + axes[i]).value - ring.value(x - axes[i]).value) / (2 * h), 1e-7 * scale);
    for (int j = 0; j < 3; ++j) {
      const RingModel up = ring.model(x + axes[j]);
      const RingModel down = ring.model(x - axes[j]);
      const double gi_up = i == 0 ? up.gradient.x : i == 1 ? up.gradient.y : up.gradient.z;
      const double gi_down = i == 0 ? down.gradient.x : i == 1 ? down.gradient.y : down.gradient.z;
      EXPECT_NEAR(hess[i][j], (gi_up - gi_down) / (2 * h), 1e-7 * scale);
    }
  }
}

TEST(Ring, GradientAndHessianMatchFiniteDifferences) {
  std::mt19937 random(17);
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const Ring20 ring(seed);
    const Vec3 x = 0.5 * random_vec(random);
    expect_model_matches_differences(ring.plain(), x);
    expect_model_matches_differences(ring.simd(), x);
  }
}

void expect_same_bits(const RingModel& a, const RingModel& b) {
  EXPECT_EQ(a.value, b.value);
  EXPECT_EQ((std::array{a.gradient.x, a.gradient.y, a.gradient.z}),
            (std::array{b.gradient.x, b.gradient.y, b.gradient.z}));
  EXPECT_EQ(a.length2, b.length2);
  const Sym3& h = a.hessian;
  const Sym3& k = b.hessian;
  EXPECT_EQ((std::array{h.xx, h.yy, h.zz, h.xy, h.xz, h.yz}), (std::array{k.xx, k.yy, k.zz, k.xy, k.xz, k.yz}));
}

TEST(Ring, SimdAndPlainGiveTheSameBitsForEveryRemainder) {
  for (int drop = 0; drop < 19; ++drop) {
    const Ring20 ring(3, drop);
    PlainRing<> plain = ring.plain();
    SimdRing simd = ring.simd();
    const Vec3 x{0.1, -0.2, 0.15};
    const Vec3 p{0.3, 0.1, -0.2};
    const RingModel a = plain.model(x);
    const RingModel b = simd.model(x);
    expect_same_bits(a, b);
    EXPECT_EQ(plain.step_bound(x, p), simd.step_bound(x, p));
    for (const Vec3& at : {x, x + p}) {
      EXPECT_EQ(plain.value(at).certified, simd.value(at).certified);
      EXPECT_EQ(plain.value(at).value, simd.value(at).value);
    }
    EXPECT_EQ(plain.ray(x, p)(0.4), simd.ray(x, p)(0.4));
  }
}

TEST(Ring, RayIsTheValueAlongIt) {
  const Ring20 ring(4);
  SimdRing simd = ring.simd();
  const Vec3 x{0.05, 0.1, 0};
  const Vec3 p{0.2, -0.1, 0.3};
  simd.model(x);
  const double bound = simd.step_bound(x, p);
  const auto ray = simd.ray(x, p);
  for (const double share : {0.0, 0.3, 0.6, 0.9}) {
    const double t = share * bound;
    const double expected = simd.value(x + t * p).value;
    EXPECT_NEAR(ray(t), expected, 1e-10 * expected);
  }
}

TEST(Ring, StepBoundIsTheFirstInversion) {
  std::mt19937 random(19);
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const Ring20 ring(seed);
    SimdRing simd = ring.simd();
    const Vec3 x = 0.3 * random_vec(random);
    const Vec3 p = random_vec(random);
    simd.model(x);
    const double t = simd.step_bound(x, p);
    EXPECT_TRUE(simd.value(x + (1 - 1e-9) * t * p).certified);
    EXPECT_FALSE(simd.value(x + (1 + 1e-9) * t * p).certified);
  }
}

TEST(Ring, IsConvex) {
  std::mt19937 random(23);
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const Ring20 ring(seed);
    SimdRing simd = ring.simd();
    const Vec3 a = 0.6 * random_vec(random);
    const Vec3 b = 0.6 * random_vec(random);
    if (!simd.value(a).certified || !simd.value(b).certified) continue;
    const double middle = simd.value(0.5 * (a + b)).value;
    EXPECT_LE(middle, 0.5 * (simd.value(a).value + simd.value(b).value) * (1 + 1e-14));
  }
}

TEST(Ring, UncertainVolumesGiveAFiniteModel) {
  Ring20 ring(5);
  // x is in the plane of one face up to rounding.
  const LinkFace f = ring.faces[7];
  const Vec3 x = (1.0 / 3) * (vec(ring.points[static_cast<std::size_t>(f.v[0])]) +
                              vec(ring.points[static_cast<std::size_t>(f.v[1])]) +
                              vec(ring.points[static_cast<std::size_t>(f.v[2])]));
  SimdRing simd = ring.simd();
  PlainRing<> plain = ring.plain();
  const RingModel a = simd.model(x);
  const RingModel b = plain.model(x);
  EXPECT_TRUE(std::isfinite(a.value));
  EXPECT_TRUE(std::isfinite(a.hessian.xx));
  EXPECT_FALSE(simd.value(x).certified);
  expect_same_bits(a, b);
}

}  // namespace
}  // namespace tetune
