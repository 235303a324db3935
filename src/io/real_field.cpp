// SPDX-License-Identifier: Apache-2.0
#include "io/real_field.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>

#include "math/constants.hpp"
#include "system/real_text.hpp"

namespace tetune {
namespace {

bool is_ascii_digit(char c) { return c >= '0' && c <= '9'; }

/// The value of the digits, infinity if there are too many.
double digits_value(std::string_view digits) {
  double value = 0;
  for (const char digit : digits) value = 10 * value + (digit - '0');
  return value;
}

/// The nearest of zero and infinity, with the sign of a number beyond the range of double.
double saturated(std::string_view text) {
  const std::string_view mantissa = text.substr(0, text.find_first_of("eE"));
  const double leading = double(mantissa.find_first_of("123456789"));
  double power = double(std::min(mantissa.find('.'), mantissa.size())) - leading;
  if (mantissa.size() < text.size()) {
    const std::string_view exponent = text.substr(mantissa.size() + 1);
    const double size = digits_value(exponent.substr(exponent.find_first_not_of("+-")));
    power += exponent.starts_with('-') ? -size : size;
  }
  return std::copysign(power > 0 ? kInfinity : 0, text.starts_with('-') ? -1.0 : 1.0);
}

}  // namespace

std::optional<double> parse_real_field(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == 'D' || c == 'd'; }, 'e');
  if (text.starts_with('+') && !text.starts_with("+-")) text.erase(0, 1);
  const char* const end = text.data() + text.size();
  double value = 0;
  const auto [stop, error] = parse_real(text.data(), end, value);
  if (stop != end) return {};
  if (error == std::errc::result_out_of_range) return saturated(text);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

std::optional<double> parse_fortran_real(std::string_view field) {
  const bool has_sign = field.starts_with('+') || field.starts_with('-');
  const std::string_view magnitude = field.substr(has_sign ? 1 : 0);
  if (magnitude.empty() || (magnitude[0] != '.' && !is_ascii_digit(magnitude[0]))) return {};
  if (field[0] == '+') field = magnitude;
  const char* const end = field.data() + field.size();
  double value = 0;
  const auto [stop, error] = parse_real(field.data(), end, value);
  if (stop == end && error == std::errc()) return value;
  if (error == std::errc::invalid_argument) return {};
  // The exponent of Fortran, or one without a letter.
  std::string text(field.data(), stop);
  const bool has_exponent = text.find_first_of("eE") != std::string::npos;
  if (stop != end) {
    if (has_exponent || std::string_view("dD+-").find(*stop) == std::string_view::npos) return {};
    text += "e";
    text.append(*stop == '+' || *stop == '-' ? stop : stop + 1, end);
  }
  return parse_real_field(text);
}

}  // namespace tetune
