// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <version>

/// std::from_chars and std::to_chars of real numbers, and their replacement for C++ libraries that lack them (libc++
/// before 20).
namespace tetune {

/// The replacement in terms of strtod() and snprintf(), which round correctly in the C libraries of use, in the locale
/// "C". The text of a number is the same as that of the standard library.
namespace plain {
std::from_chars_result parse_real(const char* first, const char* last, double& value);
std::to_chars_result print_real(char* first, char* last, double value);
/// `digits` is the number of digits after the point; if negative, the fewest that read back to the same bits.
std::to_chars_result print_real(char* first, char* last, double value, std::chars_format format, int digits = -1);
}  // namespace plain

#ifdef __cpp_lib_to_chars
inline std::from_chars_result parse_real(const char* first, const char* last, double& value) {
  return std::from_chars(first, last, value);
}
template <class... Format>
std::to_chars_result print_real(char* first, char* last, double value, Format... format) {
  return std::to_chars(first, last, value, format...);
}
#else
using plain::parse_real;
using plain::print_real;
#endif

/// The shortest text that reads back to the same number.
inline std::string number_text(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), print_real(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace tetune
