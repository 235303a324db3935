// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "backend/pack.hpp"
#include "math/angle.hpp"
#include "math/hilbert.hpp"
#include "math/orient.hpp"
#include "support/bits.hpp"
#include "support/random.hpp"

namespace tetune {
namespace {

TEST(Hilbert, NeighborsOnTheCurveAreNeighborsInSpace) {
  constexpr std::uint32_t kCells = 8;
  constexpr std::uint32_t kStep = static_cast<std::uint32_t>(kHilbertCells) / kCells;
  std::map<std::uint64_t, std::array<int, 3>> along;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        along[hilbert_index(static_cast<std::uint32_t>(x) * kStep, static_cast<std::uint32_t>(y) * kStep,
                            static_cast<std::uint32_t>(z) * kStep) >>
              (kHilbertBits - 9)] = {x, y, z};
      }
    }
  }
  ASSERT_EQ(along.size(), 512U);
  const std::array<int, 3>* last = nullptr;
  for (const auto& [index, cell] : along) {
    if (last != nullptr) {
      EXPECT_EQ(std::abs(cell[0] - (*last)[0]) + std::abs(cell[1] - (*last)[1]) + std::abs(cell[2] - (*last)[2]), 1);
    }
    last = &cell;
  }
}

TEST(Orient, FilterNeverContradictsExactArithmetic) {
  std::mt19937 random(5);
  int uncertain = 0;
  for (int i = 0; i < 20000; ++i) {
    // Points within a few units in the last place of one plane.
    Point3 p[4];
    for (auto& q : p) {
      const double u = test::uniform(random);
      const double v = test::uniform(random);
      q = {u, v, 0.3 * u + 0.7 * v + 1e-16 * (static_cast<double>(random() % 9) - 4)};
    }
    const Orient o = orient(vec(p[0]), vec(p[1]), vec(p[2]), vec(p[3]));
    const int exact = orient_sign(p[0], p[1], p[2], p[3]);
    if (o.certified()) {
      EXPECT_EQ(exact, 1);
    } else if (o.det < -o.bound) {
      EXPECT_EQ(exact, -1);
    } else {
      ++uncertain;
    }
  }
  EXPECT_GT(uncertain, 1000);
}

TEST(Orient, ExactSignAgreesWithIntegers) {
  std::mt19937 random(7);
  int zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    long long c[4][3];
    Point3 p[4];
    for (int k = 0; k < 4; ++k) {
      for (int a = 0; a < 3; ++a) {
        c[k][a] = static_cast<long long>(random() % 5) - 2 + (1LL << 50);
        p[k][static_cast<std::size_t>(a)] = static_cast<double>(c[k][a]);
      }
    }
    long long d[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int a = 0; a < 3; ++a) d[k][a] = c[k + 1][a] - c[0][a];
    }
    const long long det = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                          d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                          d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[3]), det > 0 ? 1 : det < 0 ? -1 : 0);
    zeros += det == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 100);
}

TEST(Orient, ExactSignDoesNotUnderflow) {
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e-150, 0, 0}, {0, 1e-150, 0}, {0, 0, 1e-150}), 1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e-150, 0, 0}, {0, 0, 1e-150}, {0, 1e-150, 0}), -1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {1e150, 0, 0}, {0, 1e150, 0}, {1e150, 1e150, 0}), 0);
}

TEST(Orient, ExactSignHoldsForAnyMagnitudes) {
  std::mt19937_64 random(13);
  const auto any = [&random] {
    for (;;) {
      const double x = test::double_of(random());
      if (std::isfinite(x)) return random() % 4 == 0 ? std::ldexp(x, -1000) : x;
    }
  };
  int solid = 0;
  for (int i = 0; i < 20000; ++i) {
    Point3 p[4];
    for (Point3& q : p) q = {any(), any(), any()};
    const int sign = orient_sign(p[0], p[1], p[2], p[3]);
    EXPECT_EQ(orient_sign(p[0], p[1], p[3], p[2]), -sign);
    EXPECT_EQ(orient_sign(p[1], p[2], p[3], p[0]), -sign);
    solid += sign != 0 ? 1 : 0;
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[1]), 0);
    EXPECT_EQ(orient_sign(p[0], p[0], p[2], p[1]), 0);
    for (Point3& q : p) q[2] = q[0];
    EXPECT_EQ(orient_sign(p[0], p[1], p[2], p[3]), 0);
  }
  EXPECT_GT(solid, 19000);
  const double min = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(orient_sign({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {3, 3, min}), 1);
  EXPECT_EQ(orient_sign({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {3, 3, -min}), -1);
  EXPECT_EQ(orient_sign({0, 0, 0}, {min, 0, 0}, {0, min, 0}, {0, 0, min}), 1);
  const double max = std::numeric_limits<double>::max();
  EXPECT_EQ(orient_sign({-max, -max, -max}, {max, -max, -max}, {-max, max, -max}, {-max, -max, max}), 1);
}

TEST(UpperAtan2, IsTheAngle) {
  for (int i = 0; i <= 20000; ++i) {
    const double angle = std::numbers::pi * i / 20000;
    for (const double length : {1e-150, 1.0, 1e150}) {
      ASSERT_NEAR(upper_atan2(length * std::sin(angle), length * std::cos(angle)), angle, 4e-15);
    }
  }
  for (const double small : {1e-300, 1e-20, 1e-10}) EXPECT_NEAR(upper_atan2(small, 1.0), small, 1e-14 * small);
  EXPECT_EQ(upper_atan2(0.0, 0.0), 0);
  EXPECT_EQ(upper_atan2(0.0, 1.0), 0);
  EXPECT_NEAR(upper_atan2(0.0, -1.0), std::numbers::pi, 1e-15);
}

TEST(UpperAtan2, OfAPackIsThatOfEachLane) {
  const backend::Pack4 y{0, 1, 0.25, 1e-9};
  const backend::Pack4 x{-2, 0, -3, 1};
  const backend::Pack4 angles = upper_atan2(y, x);
  for (int l = 0; l < kLanesOf<backend::Pack4>; ++l) EXPECT_EQ(angles[l], upper_atan2(lane(y, l), lane(x, l)));
}

}  // namespace
}  // namespace tetune
