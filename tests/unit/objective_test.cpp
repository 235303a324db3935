// SPDX-License-Identifier: Apache-2.0
// Objectives compared with their definitions in 113-bit arithmetic.
#include <gtest/gtest.h>

#include <random>

#include "energy/ring.hpp"
#include "energy/simd_ring.hpp"
#include "support/quad.hpp"
#include "support/random.hpp"

namespace tetune {
namespace {

using test::random_vec;

using Real = test::Quad;

Real root(Real x) {
  // Newton's method refines the square root of a double to 113 bits; the scale keeps the double in range.
  Real scale = 1;
  while (x > 1e200) {
    x /= Real(1e100) * 1e100;
    scale *= Real(1e100);
  }
  Real r = std::sqrt(static_cast<double>(x));
  for (int i = 0; i < 3; ++i) r = (r + x / r) / 2;
  return scale * r;
}

/// The energies by areas and volume: eta, and powers of (eta / eta_r)^(3/2), where eta_r^3 = 2187 volume.
Real plain_energy(const Objective& objective, const test::QuadTet& p) {
  const Real eta = plain_eta(p);
  if (!objective.shape) return eta;
  Real shape = root(eta * eta * eta / (2187 * plain_volume(p)));
  for (int i = 0; i < objective.log2_power; ++i) shape *= shape;
  for (int i = objective.log2_power; i < 0; ++i) shape = root(shape);
  return shape;
}

const Objective kObjectives[] = {kHarmonicObjective, kShapeObjective, shape_objective(1), shape_objective(2)};

/// The ring that is one tetrahedron (x, p[0], p[1], p[2]).
struct OneFace {
  std::vector<Point> points;
  LinkFace face{{0, 1, 2}};
  explicit OneFace(const Vec3 p[3]) : points{point(p[0]), point(p[1]), point(p[2])} {}
  template <class Ring>
  Ring ring(const Objective& objective) const {
    return {objective, {points.data(), 3}, &face, 1};
  }
};

/// The faces of an octahedron of random radii around the origin.
struct Octahedron {
  std::vector<Point> points;
  std::vector<LinkFace> faces;
  explicit Octahedron(std::mt19937& random) {
    for (int k = 0; k < 6; ++k) {
      Vec3 p = 0.25 * random_vec(random);
      (k / 2 == 0 ? p.x : k / 2 == 1 ? p.y : p.z) += k % 2 == 0 ? 1 : -1;
      points.push_back(point(p));
    }
    for (Index x = 0; x < 2; ++x) {
      for (Index y = 2; y < 4; ++y) {
        for (Index z = 4; z < 6; ++z) {
          LinkFace f{{x, y, z}};
          const Vec3 a = vec(points[static_cast<std::size_t>(x)]);
          const Vec3 b = vec(points[static_cast<std::size_t>(y)]);
          // The tetrahedron with the origin is positive.
          if (dot(cross(a, b), vec(points[static_cast<std::size_t>(z)])) < 0) std::swap(f.v[1], f.v[2]);
          faces.push_back(f);
        }
      }
    }
  }
  template <class Ring>
  Ring ring(const Objective& objective) const {
    return {objective, {points.data(), 6}, faces.data(), 8};
  }
};

TEST(ShapeEnergy, OfARegularTetrahedronOfAnySizeIsOne) {
  const double s = 1 / std::sqrt(2.0);
  for (const double edge : {1e-40, 1e-3, 1.0, 7.0, 1e5, 1e40}) {
    const Vec3 p[4] = {{0.5 * edge, 0, -0.5 * s * edge},
                       {-0.5 * edge, 0, -0.5 * s * edge},
                       {0, -0.5 * edge, 0.5 * s * edge},
                       {0, 0.5 * edge, 0.5 * s * edge}};
    const TetEnergy e = tet_energy(kShapeObjective, p[0], p[1], p[2], p[3]);
    EXPECT_TRUE(e.certified);
    EXPECT_NEAR(e.energy, 1, 1e-14) << edge;
  }
}

TEST(ShapeEnergy, OfAnyOtherTetrahedronIsLargerAndDoesNotDependOnTheUnit) {
  std::mt19937 random(3);
  int positive = 0;
  for (int i = 0; i < 1000; ++i) {
    Vec3 p[4];
    for (Vec3& v : p) v = random_vec(random);
    const TetEnergy e = tet_energy(kShapeObjective, p[0], p[1], p[2], p[3]);
    if (!e.certified) continue;
    ++positive;
    EXPECT_GT(e.energy, 1);
    for (const double scale : {1e-30, 1000.0, 1e30}) {
      const TetEnergy scaled = tet_energy(kShapeObjective, scale * p[0], scale * p[1], scale * p[2], scale * p[3]);
      EXPECT_NEAR(scaled.energy, e.energy, 1e-10 * e.energy);
    }
  }
  EXPECT_GT(positive, 300);
}

TEST(Objective, AgreesWithItsDefinitionOnTetrahedraAndSlivers) {
  std::mt19937 random(5);
  std::vector<Objective> objectives(std::begin(kObjectives), std::end(kObjectives));
  objectives.insert(objectives.end(), {shape_objective(-1), shape_objective(-3)});
  for (const Objective& objective : objectives) {
    for (const double flatness : {1.0, 1e-3, 1e-7, 1e-11}) {
      int positive = 0;
      for (int i = 0; i < 300; ++i) {
        Vec3 p[4];
        for (Vec3& v : p) {
          v = random_vec(random);
          v.z *= flatness;
        }
        const Orient o = orient(p[0], p[1], p[2], p[3]);
        const TetEnergy e = tet_energy(objective, p[0], p[1], p[2], p[3]);
        if (!e.certified) continue;
        ++positive;
        const auto expected = static_cast<double>(plain_energy(objective, test::quad_tet(p)));
        EXPECT_NEAR(e.energy, expected, (1e-13 + 4 * o.bound / o.det) * expected);
      }
      EXPECT_GT(positive, 100);
    }
  }
}

/// Compares derivatives with finite differences in 113-bit arithmetic, with steps small relative to the height.
template <class Ring>
void expect_derivatives(const Objective& objective, double flatness, std::uint32_t seed) {
  std::mt19937 random(seed);
  int positive = 0;
  for (int i = 0; i < 100; ++i) {
    Vec3 p[4];
    for (Vec3& v : p) {
      v = random_vec(random);
      v.z *= flatness;
    }
    const Orient o = orient(p[0], p[1], p[2], p[3]);
    if (!o.certified() || o.det < 0) continue;
    ++positive;
    const RingModel m = OneFace(p + 1).template ring<Ring>(objective).model(p[0]);
    const Vec3 n = cross(p[2] - p[1], p[3] - p[1]);
    const Real h = Real(1e-8) * o.det / norm(n);
    const test::QuadTet at = test::quad_tet(p);
    const auto energy = [&](int a, int da, int b, int db) {
      test::QuadTet moved = at;
      moved[0].x[static_cast<std::size_t>(a)] += da * h;
      moved[0].x[static_cast<std::size_t>(b)] += db * h;
      return plain_energy(objective, moved);
    };
    const double g[3] = {m.gradient.x, m.gradient.y, m.gradient.z};
    const double hessian[3][3] = {{m.hessian.xx, m.hessian.xy, m.hessian.xz},
                                  {m.hessian.xy, m.hessian.yy, m.hessian.yz},
                                  {m.hessian.xz, m.hessian.yz, m.hessian.zz}};
    const double tolerance = 1e-11 + 40 * o.bound / o.det;
    const double trace = m.hessian.xx + m.hessian.yy + m.hessian.zz;
    for (int a = 0; a < 3; ++a) {
      const Real slope = (energy(a, 1, a, 0) - energy(a, -1, a, 0)) / (2 * h);
      EXPECT_NEAR(g[a], static_cast<double>(slope), tolerance * norm(m.gradient));
      for (int b = 0; b < 3; ++b) {
        const Real curvature =
            (energy(a, 1, b, 1) - energy(a, 1, b, -1) - energy(a, -1, b, 1) + energy(a, -1, b, -1)) / (4 * h * h);
        EXPECT_NEAR(hessian[a][b], static_cast<double>(curvature), tolerance * trace);
      }
    }
  }
  EXPECT_GT(positive, 25);
}

TEST(Objective, GradientAndHessianAreThoseOfTheDefinition) {
  for (const Objective& objective : kObjectives) {
    for (const double flatness : {1.0, 1e-2, 1e-4, 1e-8}) {
      expect_derivatives<PlainRing<>>(objective, flatness, 7);
      expect_derivatives<SimdRing>(objective, flatness, 8);
    }
  }
}

TEST(Objective, ARootHasTheDerivativesOfItsTangent) {
  std::mt19937 random(17);
  int positive = 0;
  for (const int log2_power : {-1, -3}) {
    const double root = std::exp2(log2_power);
    for (int i = 0; i < 200; ++i) {
      Vec3 p[4];
      for (Vec3& v : p) v = random_vec(random);
      if (!tet_energy(kShapeObjective, p[0], p[1], p[2], p[3]).certified) continue;
      ++positive;
      const OneFace face(p + 1);
      const RingModel energy = face.ring<PlainRing<>>(kShapeObjective).model(p[0]);
      const RingModel model = face.ring<PlainRing<>>(shape_objective(log2_power)).model(p[0]);
      EXPECT_NEAR(model.value, std::pow(energy.value, root), 1e-12 * model.value);
      const double slope = root * model.value / energy.value;
      EXPECT_LT(norm(model.gradient - slope * energy.gradient), 1e-11 * norm(model.gradient));
      const double trace = model.hessian.xx + model.hessian.yy + model.hessian.zz;
      for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        EXPECT_LT(norm(model.hessian * axis - slope * (energy.hessian * axis)), 1e-11 * trace);
      }
    }
  }
  EXPECT_GT(positive, 100);
}

TEST(Objective, BothRingsAgree) {
  std::mt19937 random(11);
  for (const Objective& objective : kObjectives) {
    for (int i = 0; i < 100; ++i) {
      const Octahedron ring(random);
      auto plain = ring.ring<PlainRing<>>(objective);
      auto simd = ring.ring<SimdRing>(objective);
      const Vec3 x = 0.2 * random_vec(random);
      const Vec3 p = random_vec(random);
      const RingModel a = plain.model(x);
      const RingModel b = simd.model(x);
      EXPECT_NEAR(a.value, b.value, 1e-13 * a.value);
      EXPECT_NEAR(plain.value(x).value, simd.value(x).value, 1e-13 * a.value);
      EXPECT_NEAR(a.value, plain.value(x).value, 1e-13 * a.value);
      EXPECT_LT(norm(a.gradient - b.gradient), 1e-12 * (a.value + norm(a.gradient)));
      for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        EXPECT_LT(norm(a.hessian * axis - b.hessian * axis), 1e-12 * (a.hessian.xx + a.hessian.yy + a.hessian.zz));
      }
      const double t = 0.5 * simd.step_bound(x, p);
      EXPECT_NEAR(plain.ray(x, p)(t), simd.ray(x, p)(t), 1e-12 * a.value);
      EXPECT_NEAR(simd.ray(x, p)(t), simd.value(x + t * p).value, 1e-11 * simd.value(x + t * p).value);
    }
  }
}

TEST(Objective, IsConvexOnTheKernel) {
  std::mt19937 random(13);
  for (const Objective& objective : kObjectives) {
    int tried = 0;
    for (int i = 0; i < 5000; ++i) {
      const Octahedron octahedron(random);
      auto ring = octahedron.ring<PlainRing<>>(objective);
      // Some segments end close to the boundary of the kernel, where the energy is steep.
      const Vec3 a = 1.0 * random_vec(random);
      const Vec3 b = 0.6 * random_vec(random);
      if (!ring.value(a).certified || !ring.value(b).certified) continue;
      ++tried;
      for (const double t : {0.01, 0.3, 0.5, 0.9}) {
        const double on_chord = (1 - t) * ring.value(a).value + t * ring.value(b).value;
        EXPECT_LE(ring.value((1 - t) * a + t * b).value, on_chord * (1 + 1e-13));
      }
      const Sym3 h = ring.model(a).hessian;
      for (int direction = 0; direction < 5; ++direction) {
        const Vec3 p = random_vec(random);
        EXPECT_GT(dot(p, h * p), -1e-14 * (h.xx + h.yy + h.zz) * dot(p, p));
      }
    }
    EXPECT_GT(tried, 300);
  }
}

}  // namespace
}  // namespace tetune
