// SPDX-License-Identifier: Apache-2.0
#include "system/real_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace tetune::plain {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

const char* skip_digits(const char* at, const char* last) { return std::find_if_not(at, last, is_digit); }

/// The end of a decimal number, infinity or NaN that starts at `first`; `first` if there is none.
const char* end_of_real(const char* first, const char* last) {
  const char* const digits = first + (first < last && *first == '-' ? 1 : 0);
  for (const std::string_view word : {"infinity", "inf", "nan"}) {
    const auto same = [](char a, char b) { return (a | 0x20) == b; };
    const bool fits = last - digits >= std::ptrdiff_t(word.size());
    if (fits && std::equal(word.begin(), word.end(), digits, [&](char b, char a) { return same(a, b); })) {
      return digits + word.size();
    }
  }
  const char* at = skip_digits(digits, last);
  bool has_digits = at > digits;
  if (at < last && *at == '.') {
    const char* const end = skip_digits(at + 1, last);
    has_digits = has_digits || end > at + 1;
    at = end;
  }
  if (!has_digits) return first;
  if (at < last && (*at == 'e' || *at == 'E')) {
    const char* const power = at + 1 + (at + 1 < last && (at[1] == '-' || at[1] == '+') ? 1 : 0);
    if (const char* const end = skip_digits(power, last); end > power) at = end;
  }
  return at;
}

using Buffer = std::array<char, 800>;

std::string_view scientific(double value, int digits, Buffer& buffer) {
  return {buffer.data(), std::size_t(std::snprintf(buffer.data(), buffer.size(), "%.*e", digits, value))};
}

/// Raises the last digit of the mantissa by one.
void round_up(std::string_view text, Buffer& buffer) {
  std::size_t at = text.find('e');
  while (at-- > 0) {
    char& c = buffer[at];
    if (!is_digit(c)) continue;
    if (c != '9') {
      ++c;
      return;
    }
    c = '0';
  }
}

/// The number of digits after the point of the shortest scientific notation that reads back to the same bits; the text
/// is in the buffer.
std::string_view shortest(double value, Buffer& buffer) {
  for (int digits = 0;; ++digits) {
    const std::string_view text = scientific(value, digits, buffer);
    if (std::strtod(buffer.data(), nullptr) == value) return text;
    // Below a power of two the doubles are closer to one another than above: the number above may be the only one
    // with this number of digits that reads back.
    int exponent = 0;
    if (std::fabs(std::frexp(value, &exponent)) != 0.5) continue;
    round_up(text, buffer);
    if (std::strtod(buffer.data(), nullptr) == value) return text;
  }
}

std::to_chars_result copy(std::string_view text, char* first, char* last) {
  if (last - first < std::ptrdiff_t(text.size())) return {last, std::errc::value_too_large};
  return {std::copy(text.begin(), text.end(), first), std::errc()};
}

/// A number in scientific notation without a point in fixed notation: its digits, and zeros.
std::string fixed(std::string_view text) {
  const std::size_t e = text.find('e');
  const int exponent = std::atoi(text.data() + e + 1);
  std::string digits;
  std::copy_if(text.begin(), text.begin() + std::ptrdiff_t(e), std::back_inserter(digits), is_digit);
  const std::string sign = text.front() == '-' ? "-" : "";
  const int size = int(digits.size());
  if (exponent < 0) return sign + "0." + std::string(std::size_t(-exponent - 1), '0') + digits;
  if (exponent + 1 >= size) return sign + digits + std::string(std::size_t(exponent + 1 - size), '0');
  return sign + digits.substr(0, std::size_t(exponent + 1)) + "." + digits.substr(std::size_t(exponent + 1));
}

/// The exact digits of a whole number of more digits than a double holds, as the standard library prints them.
std::string fixed(std::string_view text, double value) {
  constexpr double kExact = 9007199254740992;  // 2^53
  if (std::fabs(value) < kExact) return fixed(text);
  Buffer buffer;
  return {buffer.data(), std::size_t(std::snprintf(buffer.data(), buffer.size(), "%.0f", value))};
}

}  // namespace

std::from_chars_result parse_real(const char* first, const char* last, double& value) {
  const char* const end = end_of_real(first, last);
  if (end == first) return {first, std::errc::invalid_argument};
  const std::string text(first, end);
  const double number = std::strtod(text.c_str(), nullptr);
  const bool is_word = !std::any_of(text.begin(), text.end(), is_digit);
  const std::string_view mantissa(text.data(), std::min(text.find_first_of("eE"), text.size()));
  const bool is_lost = number == 0 && mantissa.find_first_of("123456789") != std::string_view::npos;
  if (!is_word && (is_lost || std::isinf(number))) return {end, std::errc::result_out_of_range};
  value = number;
  return {end, std::errc()};
}

std::to_chars_result print_real(char* first, char* last, double value) {
  if (!std::isfinite(value)) return print_real(first, last, value, std::chars_format::scientific);
  Buffer buffer;
  const std::string_view text = shortest(value, buffer);
  const std::string other = fixed(text, value);
  return copy(other.size() <= text.size() ? std::string_view(other) : text, first, last);
}

std::to_chars_result print_real(char* first, char* last, double value, std::chars_format format, int digits) {
  Buffer buffer;
  if (!std::isfinite(value))
    return copy(std::isnan(value) ? std::signbit(value) ? "-nan" : "nan" : value < 0 ? "-inf" : "inf", first, last);
  if (format == std::chars_format::scientific) {
    return copy(digits < 0 ? shortest(value, buffer) : scientific(value, digits, buffer), first, last);
  }
  if (digits < 0) return copy(fixed(shortest(value, buffer), value), first, last);
  return copy({buffer.data(), std::size_t(std::snprintf(buffer.data(), buffer.size(), "%.*f", digits, value))}, first,
              last);
}

}  // namespace tetune::plain
