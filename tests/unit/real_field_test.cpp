// SPDX-License-Identifier: Apache-2.0
#include "io/real_field.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "math/constants.hpp"
#include "support/bits.hpp"

namespace tetune {
namespace {

void expect_value(const std::string& text, double expected) {
  const std::optional<double> value = parse_real_field(text);
  ASSERT_TRUE(value) << text;
  EXPECT_EQ(test::bits_of(*value), test::bits_of(expected)) << text;  // with its sign
}

TEST(RealField, NotationsOfOtherPrograms) {
  expect_value("+1.5", 1.5);
  expect_value("1.0D-3", 1e-3);
  expect_value("-2.5d+2", -250);
  expect_value(".5e1", 5);
}

TEST(RealField, BeyondTheRangeOfDouble) {
  const std::string zeros(400, '0');
  for (const std::string& text : {std::string("1e400"), std::string("0.001E+999999999999999999999999"), "1" + zeros,
                                  "12" + zeros + ".5e-20", std::string("1e") + std::string(400, '9')}) {
    expect_value(text, kInfinity);
    expect_value("-" + text, -kInfinity);
  }
  for (const std::string& text : {std::string("1e-400"), std::string("123456.7d-999999999999999999999999"),
                                  "0." + zeros + "1", "." + zeros + "1e20"}) {
    expect_value(text, 0.0);
    expect_value("-" + text, -0.0);
  }
  expect_value("0e999", 0.0);
  expect_value("1" + zeros + "e-300", 1e100);
  expect_value("0." + zeros + "1e+300", 1e-101);
}

TEST(RealField, NoNumber) {
  for (const char* text : {"", "+", "-", "+-1", "--1", "1x", "1e", "1e400x", "1,5", "0x10", "e5", "."}) {
    EXPECT_FALSE(parse_real_field(text)) << text;
  }
}

}  // namespace
}  // namespace tetune
