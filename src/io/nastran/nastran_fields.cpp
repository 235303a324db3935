// SPDX-License-Identifier: Apache-2.0
#include "io/nastran/nastran_fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>

#include "io/plain_text.hpp"
#include "system/real_text.hpp"

namespace tetune {
namespace {

constexpr std::size_t kSmallField = 8, kMarkerColumn = 72;

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

/// The digits of a number without the point, and the power of ten of the first: 0.012 has "12" and -2.
struct Decimal {
  std::string digits;
  int power = 0;
};

/// The fewest digits that read back to the same bits, or a number of them, without zeros at the end.
Decimal decimal_of(double magnitude, int count) {
  std::array<char, 48> buffer;
  char* const begin = buffer.data();
  char* const limit = begin + buffer.size();
  const char* const end = count == 0
                              ? print_real(begin, limit, magnitude, std::chars_format::scientific).ptr
                              : print_real(begin, limit, magnitude, std::chars_format::scientific, count - 1).ptr;
  Decimal decimal;
  const std::string_view text(begin, std::size_t(end - begin));
  const std::size_t exponent = text.find('e');
  std::copy_if(text.begin(), text.begin() + std::ptrdiff_t(exponent), std::back_inserter(decimal.digits),
               is_decimal_digit);
  std::from_chars(begin + exponent + (text[exponent + 1] == '+' ? 2 : 1), end, decimal.power);
  while (decimal.digits.size() > 1 && decimal.digits.back() == '0') decimal.digits.pop_back();
  return decimal;
}

std::string in_fixed_notation(const Decimal& decimal) {
  const std::string& digits = decimal.digits;
  if (decimal.power < 0) return "0." + std::string(std::size_t(-decimal.power - 1), '0') + digits;
  const std::size_t before = std::size_t(decimal.power) + 1;
  if (before >= digits.size()) return digits + std::string(before - digits.size(), '0') + ".";
  return digits.substr(0, before) + "." + digits.substr(before);
}

/// The first notation in which the number has at most `size` characters; empty if there is none.
std::string shortest_notation(const Decimal& decimal, std::size_t size) {
  // Longer numbers in fixed notation do not fit.
  if (decimal.power < int(size) && decimal.power > -int(size)) {
    std::string text = in_fixed_notation(decimal);
    if (text.size() > size && text[0] == '0') text.erase(0, 1);
    if (text.size() <= size) return text;
  }
  const std::string mantissa = decimal.digits.substr(0, 1) + "." + decimal.digits.substr(1);
  const std::string power = (decimal.power < 0 ? "" : "+") + std::to_string(decimal.power);
  for (const char* const mark : {"E", ""}) {
    std::string text = mantissa + mark + power;
    if (text.size() <= size) return text;
  }
  return {};
}

/// A marker without its first character, and without blanks around the rest.
std::string_view without_first(std::string_view marker) { return marker.empty() ? marker : trimmed(marker.substr(1)); }

}  // namespace

std::string nastran_shown(std::string_view text) {
  constexpr std::size_t kMaxShown = 24;
  return printable(text.substr(0, kMaxShown));
}

std::optional<int> parse_nastran_integer(std::string_view field) {
  const std::string_view digits = field.substr(field.starts_with('+') || field.starts_with('-') ? 1 : 0);
  constexpr std::size_t kMaxDigits = 9;
  if (digits.empty() || digits.size() > kMaxDigits || !std::all_of(digits.begin(), digits.end(), is_decimal_digit)) {
    return {};
  }
  int value = 0;
  for (const char digit : digits) value = 10 * value + (digit - '0');
  return field[0] == '-' ? -value : value;
}

bool append_nastran_real(std::string& out, double value) {
  const bool is_negative = std::signbit(value);
  const std::size_t size = kNastranLargeField - (is_negative ? 1 : 0);
  Decimal decimal = decimal_of(std::fabs(value), 0);
  if (is_negative) out += '-';
  std::string text = shortest_notation(decimal, size);
  const bool is_exact = !text.empty();
  for (int digits = int(decimal.digits.size()) - 1; text.empty(); --digits) {
    decimal = decimal_of(std::fabs(value), digits);
    text = shortest_notation(decimal, size);
  }
  out += text;
  return is_exact;
}

NastranLine::NastranLine(std::string_view text) : text_(text), is_free_(text.find(',') != std::string_view::npos) {
  first_ = trimmed(text.substr(0, is_free_ ? text.find(',') : kSmallField));
  is_large_ = first_.starts_with('*') || (first_.ends_with('*') && !first_.starts_with('+'));
}

std::string NastranLine::name() const {
  std::string_view name = first_;
  if (is_large_ && name.ends_with('*')) name.remove_suffix(1);
  // meshio 5 writes the names of second-order elements with this mark.
  if (name.ends_with('_')) name.remove_suffix(1);
  return in_upper_case(trimmed(name));
}

std::string_view NastranLine::field(std::size_t k) const {
  if (!is_free_) {
    const std::size_t width = is_large_ ? kNastranLargeField : kSmallField;
    const std::size_t begin = kSmallField + k * width;
    if (begin >= text_.size()) return {};
    return trimmed(text_.substr(begin, begin >= kMarkerColumn ? kSmallField : width));
  }
  std::string_view rest = text_;
  for (std::size_t i = 0; i <= k; ++i) {
    const std::size_t comma = rest.find(',');
    if (comma == std::string_view::npos) return {};
    rest.remove_prefix(comma + 1);
  }
  return trimmed(rest.substr(0, rest.find(',')));
}

std::string_view NastranLine::marker_name() const {
  return without_first(is_free_ ? marker() : columns(kMarkerColumn));
}

std::string_view NastranLine::continued_name() const { return without_first(is_free_ ? first_ : columns(0)); }

std::string_view NastranLine::columns(std::size_t begin) const {
  return begin < text_.size() ? text_.substr(begin, kSmallField) : std::string_view();
}

bool NastranLine::is_too_long() const {
  if (!is_free_) return false;
  if (!marker().empty() && is_decimal_digit(marker()[0])) return true;
  std::string_view rest = text_;
  for (std::size_t i = 0; i < size() + 2; ++i) {
    const std::size_t comma = rest.find(',');
    if (comma == std::string_view::npos) return false;
    rest.remove_prefix(comma + 1);
  }
  return rest.find_first_not_of(" \t\r,") != std::string_view::npos;
}

}  // namespace tetune
