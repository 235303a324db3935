// SPDX-License-Identifier: Apache-2.0
#include "math/elementary.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

#include "support/bits.hpp"

namespace tetune {
namespace {

constexpr int kSamples = 20000;

/// A sequence in [0, 1) that is the same with every C++ library.
class Uniform {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

/// Within some units in the last place: glibc documents up to four for cbrt().
void expect_near(double actual, double expected) {
  EXPECT_NEAR(actual, expected, 8 * std::numeric_limits<double>::epsilon() * std::fabs(expected));
}

TEST(Elementary, AgreesWithTheCLibrary) {
  Uniform uniform;
  for (int i = 0; i < kSamples; ++i) {
    const double angle = 7 * (2 * uniform() - 1);
    expect_near(elementary::cos(angle), std::cos(angle));
    expect_near(elementary::sin(angle), std::sin(angle));
    const double y = uniform();
    const double x = 2 * uniform() - 1;
    expect_near(elementary::atan2(y, x), std::atan2(y, x));
    const double number = std::ldexp(uniform() - 0.5, int(2000 * uniform()) - 1000);
    expect_near(elementary::cbrt(number), std::cbrt(number));
    expect_near(elementary::repeated_square(x, 2), std::pow(x, 4));
  }
}

TEST(Elementary, KnowsExactValues) {
  EXPECT_EQ(elementary::cos(0), 1);
  EXPECT_EQ(elementary::sin(0), 0);
  EXPECT_EQ(elementary::cos(std::numbers::pi / 2), 0x1.1a62633145c07p-54);
  EXPECT_EQ(elementary::atan2(0, 1), 0);
  EXPECT_EQ(elementary::atan2(1, 0), std::numbers::pi / 2);
  EXPECT_EQ(elementary::atan2(0, -1), std::numbers::pi);
  for (int i = -100; i <= 100; ++i) EXPECT_EQ(elementary::cbrt(double(i) * i * i), i);
  EXPECT_EQ(elementary::cbrt(std::numeric_limits<double>::infinity()), std::numeric_limits<double>::infinity());
  EXPECT_EQ(elementary::repeated_square(3, 3), 6561);
}

/// The checksum was computed with g++ on x86-64.
TEST(Elementary, HasTheSameBitsOnEveryPlatform) {
  Uniform uniform;
  std::uint64_t checksum = 0;
  const auto add = [&checksum](double value) { checksum = checksum * 1099511628211U + test::bits_of(value); };
  for (int i = 0; i < kSamples; ++i) {
    const double angle = 7 * (2 * uniform() - 1);
    add(elementary::cos(angle));
    add(elementary::sin(angle));
    const double y = uniform();
    add(elementary::atan2(y, 2 * uniform() - 1));
    add(elementary::cbrt(1000 * uniform()));
    add(elementary::repeated_square(uniform(), 2));
  }
  EXPECT_EQ(checksum, 1205938339282486903U);
}

}  // namespace
}  // namespace tetune
