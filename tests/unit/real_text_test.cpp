// SPDX-License-Identifier: Apache-2.0
#include "system/real_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "support/bits.hpp"

namespace tetune {
namespace {

std::string printed(double value) {
  char text[800];
  return {text, plain::print_real(text, text + sizeof text, value).ptr};
}

TEST(RealText, ReadsWhatItPrints) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 5000; ++i) {
    const double value = test::double_of(random());
    if (!std::isfinite(value)) continue;
    const std::string text = printed(value);
    double read = 0;
    const auto [end, error] = plain::parse_real(text.data(), text.data() + text.size(), read);
    EXPECT_EQ(error, std::errc()) << text;
    EXPECT_EQ(end, text.data() + text.size()) << text;
    EXPECT_EQ(test::bits_of(read), test::bits_of(value)) << text;
  }
}

TEST(RealText, ReportsABufferThatIsTooSmall) {
  char text[3];
  EXPECT_EQ(plain::print_real(text, text + sizeof text, 0.12).ec, std::errc::value_too_large);
}

// The C library of Windows rounds some numbers wrongly; the standard library of GCC does not use it.
#if defined(__cpp_lib_to_chars) && !defined(_WIN32)
void expect_same_text(double value) {
  char text[800];
  EXPECT_EQ(printed(value), std::string(text, std::to_chars(text, text + sizeof text, value).ptr));
  for (const auto format : {std::chars_format::fixed, std::chars_format::scientific}) {
    char other[800];
    const std::string expected(text, std::to_chars(text, text + sizeof text, value, format).ptr);
    EXPECT_EQ(std::string(other, plain::print_real(other, other + sizeof other, value, format).ptr), expected);
    const std::string rounded(text, std::to_chars(text, text + sizeof text, value, format, 6).ptr);
    EXPECT_EQ(std::string(other, plain::print_real(other, other + sizeof other, value, format, 6).ptr), rounded);
  }
}

TEST(RealText, PrintsAsTheStandardLibrary) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 5000; ++i) {
    const double value = test::double_of(random());
    if (std::isfinite(value)) expect_same_text(value);
    expect_same_text(std::ldexp(static_cast<double>(random() >> 11), int(random() % 120) - 90));
    expect_same_text(static_cast<double>(random() % 100000) / 1000);
  }
  for (int exponent = -1074; exponent < 1024; ++exponent) expect_same_text(std::ldexp(1, exponent));
  for (const double value : {0.0, -0.0, 1.0, -1.0, 100.0, 1e5, 1e22, 123456789012345680000.0}) expect_same_text(value);
}
#endif

#ifdef __cpp_lib_to_chars
TEST(RealText, ReadsAsTheStandardLibrary) {
  for (const std::string text :
       {"",      "-",       "+1",       "1",      "-1.5e3x", ".5",    "5.",
        ".",     "1e",      "1e+",      "1e-5 ",  "inf",     "-inf",  "nan",
        "INF",   "1e400",   "1e-400",   "-1e400", "0e999",   "0x10",  " 1",
        "1.2.3", "1d-3",    "4.9e-324", "00012",  "1e0005",  "0.000", "123456789012345678901234567890",
        "--1",   "infinity"}) {
    double ours = 7;
    double theirs = 7;
    const auto a = plain::parse_real(text.data(), text.data() + text.size(), ours);
    const auto b = std::from_chars(text.data(), text.data() + text.size(), theirs);
    EXPECT_EQ(a.ec, b.ec) << text;
    EXPECT_EQ(a.ptr - text.data(), b.ptr - text.data()) << text;
    EXPECT_EQ(test::bits_of(ours), test::bits_of(theirs)) << text;
  }
}
#endif

}  // namespace
}  // namespace tetune
