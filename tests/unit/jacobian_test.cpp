// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "curved/curved_edges.hpp"
#include "curved/held_bound.hpp"
#include "curved/relaxation_energy.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

/// The straight element of four vertices.
TenNodes straight(const std::array<Vec3, 4>& vertices) {
  TenNodes nodes{};
  for (std::size_t k = 0; k < 4; ++k) nodes[k] = vertices[k];
  for (std::size_t e = 0; e < 6; ++e) {
    nodes[4 + e] = 0.5 * (vertices[kCurvedTetEdges[e][0]] + vertices[kCurvedTetEdges[e][1]]);
  }
  return nodes;
}

const std::array<Vec3, 4> kUnitTet{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// The determinant by the derivatives of the shape functions: the definition.
double plain_determinant(const TenNodes& nodes, const std::array<double, 4>& at) {
  std::array<Vec3, 4> derivatives{};  // by each barycentric coordinate
  for (std::size_t k = 0; k < 4; ++k) derivatives[k] = (4 * at[k] - 1) * nodes[k];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [i, j] = kCurvedTetEdges[e];
    derivatives[i] = derivatives[i] + 4 * at[j] * nodes[4 + e];
    derivatives[j] = derivatives[j] + 4 * at[i] * nodes[4 + e];
  }
  const Vec3& d = derivatives[0];
  return dot(cross(derivatives[1] - d, derivatives[2] - d), derivatives[3] - d);
}

/// The smallest determinant at the points of a lattice with n steps per edge.
double sampled_minimum(const TenNodes& nodes, int n) {
  double least = kInfinity;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      for (int k = 0; i + j + k <= n; ++k) {
        const double h = 1.0 / n;
        least = std::min(least, plain_determinant(nodes, {(n - i - j - k) * h, i * h, j * h, k * h}));
      }
    }
  }
  return least;
}

TEST(Jacobian, StraightElementHasConstantDeterminant) {
  const ScaledJacobian j = jacobian_of(straight(kUnitTet));
  for (const double c : j.polynomial.coefficients) EXPECT_EQ(c, 1);
  const CurvedTet t = measure_nodes(straight(kUnitTet));
  EXPECT_EQ(t.validity, CurvedValidity::valid);
  EXPECT_NEAR(t.min_lower, 1, 1e-12);
  EXPECT_NEAR(t.max_upper, 1, 1e-12);
  EXPECT_EQ(t.corner_ratio, 1);
  EXPECT_EQ(t.middle_offset, 0);
}

TEST(Jacobian, AFlatElementHasInfiniteScaledJacobians) {
  const CurvedTet t = measure_nodes(straight({Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_NE(t.validity, CurvedValidity::valid);
  EXPECT_EQ(t.min_lower, -kInfinity);
  EXPECT_EQ(t.scaled_jacobian(), -kInfinity);
  EXPECT_EQ(t.max_upper, kInfinity);
}

TEST(Jacobian, DeterminantOfAMovedMiddleIsKnown) {
  // x = u + 4 s u (1 - u - v - w) along the first edge: dx/du = 1 + 4 s (1 - 2 u - v - w), the determinant.
  for (const double s : {0.1, 0.2, 0.24, 0.26, -0.3}) {
    TenNodes nodes = straight(kUnitTet);
    nodes[4].x += s;
    const CurvedTet t = measure_nodes(nodes);
    const double minimum = 1 - 4 * std::fabs(s);
    EXPECT_EQ(t.validity, minimum > 0 ? CurvedValidity::valid : CurvedValidity::inverted) << s;
    EXPECT_LE(t.min_lower, minimum);
    EXPECT_GE(t.min_lower, minimum - 2e-3);
    EXPECT_GE(t.min_upper, minimum);
    EXPECT_LE(t.max_lower, 1 + 4 * std::fabs(s));
    EXPECT_GE(t.max_upper, 1 + 4 * std::fabs(s));
    EXPECT_NEAR(t.middle_offset, std::fabs(s), 1e-15);
    if (minimum > 0) {
      EXPECT_NEAR(t.corner_ratio, (2 - minimum) / minimum, 1e-9);
    } else {
      EXPECT_EQ(t.corner_ratio, kInfinity);
    }
  }
  TenNodes flat = straight(kUnitTet);
  flat[4].x += 0.25;
  EXPECT_EQ(measure_nodes(flat).validity, CurvedValidity::undecided);
}

TEST(Jacobian, BezierFormIsTheDeterminant) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    TenNodes nodes = straight(kUnitTet);
    for (Vec3& x : nodes) x = x + 0.3 * Vec3{uniform(random), uniform(random), uniform(random)};
    const JacobianPolynomial p = jacobian_of(nodes).polynomial;
    const std::array<double, 4> at{0.1, 0.2, 0.3, 0.4};
    // The polynomial is in units of a power of two.
    const double ratio = evaluate(p, {1, 0, 0, 0}) / plain_determinant(nodes, {1, 0, 0, 0});
    EXPECT_NEAR(evaluate(p, at), ratio * plain_determinant(nodes, at), 1e-11 * std::fabs(ratio));
    const auto parts = subdivide(p);
    EXPECT_NEAR(evaluate(parts[1], at), evaluate(p, {0.05, 0.6, 0.15, 0.2}), 1e-11 * std::fabs(ratio));
    // Part 5: its corners are the middles of 01, 02, 12, 13.
    EXPECT_NEAR(evaluate(parts[5], at), evaluate(p, {0.15, 0.4, 0.25, 0.2}), 1e-11 * std::fabs(ratio));
  }
}

/// Counts elements that are said to be valid and are not, and undecided ones, by dense sampling.
TEST(Jacobian, ProofAgreesWithSampling) {
  const char* const more = std::getenv("TETUNE_CURVED_ELEMENTS");
  const int elements = more != nullptr ? std::atoi(more) : 2000;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int false_valid = 0;
  int false_inverted = 0;
  int undecided = 0;
  int valid = 0;
  for (int i = 0; i < elements; ++i) {
    const auto shift = [&](double by) { return by * Vec3{uniform(random), uniform(random), uniform(random)}; };
    std::array<Vec3, 4> vertices = kUnitTet;
    for (Vec3& x : vertices) x = x + shift(0.3);
    TenNodes nodes = straight(vertices);
    const double size = 0.3 * std::fabs(uniform(random));
    for (std::size_t e = 4; e < 10; ++e) nodes[e] = nodes[e] + shift(size);
    const CurvedTet t = measure_nodes(nodes);
    const double least = sampled_minimum(nodes, 12);
    valid += t.validity == CurvedValidity::valid ? 1 : 0;
    undecided += t.validity == CurvedValidity::undecided ? 1 : 0;
    if (t.validity == CurvedValidity::valid && least <= 0) ++false_valid;
    const double size3 = std::fabs(jacobian_of(straight(vertices)).straight);
    if (t.validity == CurvedValidity::inverted && t.min_upper > -1e-3 * size3 && least > 0.05 * size3) ++false_inverted;
  }
  EXPECT_EQ(false_valid, 0);
  EXPECT_EQ(false_inverted, 0);
  EXPECT_LE(undecided, elements / 1000);
  EXPECT_GT(valid, elements / 4);
  EXPECT_LT(valid, elements - elements / 20);
  std::printf("%d elements: %d valid, %d undecided\n", elements, valid, undecided);
}

TEST(Jacobian, ProofIsIndependentOfScaleAndPlace) {
  TenNodes nodes = straight(kUnitTet);
  nodes[4].x += 0.2499;
  for (const double scale : {1.0, 1e-60, 1e60}) {
    TenNodes scaled = nodes;
    for (Vec3& x : scaled) x = scale * x;
    EXPECT_EQ(measure_nodes(scaled).validity, CurvedValidity::valid) << scale;
  }
  for (Vec3& x : nodes) x = x + Vec3{1e6, -1e6, 1e6};
  EXPECT_NE(measure_nodes(nodes).validity, CurvedValidity::inverted);
}

TEST(Jacobian, GradientOfTheRelaxationEnergyIsItsDerivative) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  PatchElement element;
  for (std::size_t n = 0; n < 10; ++n) element.nodes[n] = n;
  element.inverse_ideal = inverse_of_edges({Vec3{0, 0, 0}, {1, 0.2, 0}, {0.1, 1, 0}, {0, 0.3, 1.1}});
  const TenNodes nodes = straight(kUnitTet);
  const std::vector<std::size_t> unknowns{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  RelaxationEnergy energy({element}, {nodes.begin(), nodes.end()}, unknowns);
  std::vector<double> x = energy.start();
  for (double& c : x) c += shift(random);
  std::vector<double> gradient(x.size());
  std::vector<double> ignored(x.size());
  for (const int power : {1, 4, 16}) {
    for (const double epsilon : {0.0, 0.3}) {
      energy.power = power;
      energy.epsilon = epsilon;
      energy(x, gradient);
      for (std::size_t i = 0; i < x.size(); ++i) {
        constexpr double kStep = 1e-6;
        std::vector<double> y = x;
        y[i] = x[i] + kStep;
        const double high = energy(y, ignored);
        y[i] = x[i] - kStep;
        const double slope = (high - energy(y, ignored)) / (2 * kStep);
        EXPECT_NEAR(gradient[i], slope, 1e-5 * (1 + std::fabs(slope)));
      }
    }
  }
}

TEST(Jacobian, HeldNodesBoundTheScaledJacobian) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.15, 0.15);
  const auto displace = [&](Vec3& x) { x = x + Vec3{shift(random), shift(random), shift(random)}; };
  const std::array<Index, 4> tet{0, 1, 2, 3};
  HeldNodes held{{1, 1, 1, 1}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}}};
  for (int i = 0; i < 200; ++i) {
    TenNodes nodes = straight(kUnitTet);
    for (std::size_t k = 4; k < 10; ++k) displace(nodes[k]);
    const double bound = bound_by_held(tet, nodes, held);
    // The two faces at edge 01 are held, and with them what the determinant is there.
    for (const double s : {0.0, 0.25, 1.0}) EXPECT_LE(bound, plain_determinant(nodes, {1 - s, s, 0, 0}) + 1e-12);
    displace(nodes[9]);
    EXPECT_NEAR(bound_by_held(tet, nodes, held), bound, 1e-12);
    EXPECT_LE(measure_nodes(nodes).scaled_jacobian(), bound + 1e-12);
  }
  held.edges.erase(held.edges.begin());
  EXPECT_EQ(bound_by_held(tet, straight(kUnitTet), held), kInfinity);
}

}  // namespace
}  // namespace tetune
