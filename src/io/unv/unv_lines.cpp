// SPDX-License-Identifier: Apache-2.0
#include "io/unv/unv_lines.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "io/plain_text.hpp"
#include "io/real_field.hpp"
#include "io/unv/unv_format.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

bool is_mark(std::string_view line) { return trimmed(line) == "-1"; }

std::string quoted(std::string_view text) {
  constexpr std::size_t kMaxShown = 40;
  return "\"" + printable(trimmed(text).substr(0, kMaxShown)) + "\"";
}

void split_at_blanks(std::string_view line, std::vector<std::string_view>& fields) {
  constexpr std::string_view kSeparators = " \t\r";
  fields.clear();
  for (std::size_t at = line.find_first_not_of(kSeparators); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kSeparators, end);
  }
}

/// Reads one line off the text.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

}  // namespace

bool UnvLines::read(std::string_view& line) {
  if (rest_.empty()) return false;
  line = take_line(rest_);
  ++line_;
  return true;
}

bool UnvLines::read_filled(std::string_view& line) {
  while (read(line)) {
    if (!trimmed(line).empty()) return true;
  }
  return false;
}

std::string_view UnvLines::next_set() {
  std::string_view line;
  if (!read_filled(line)) return {};
  if (!is_mark(line)) {
    fail("this line should be -1, the start of a data set of an I-deas universal file, and is " + quoted(line));
  }
  do {
    if (read_filled(line)) continue;
    is_open_ = true;
    return {};
  } while (is_mark(line));
  const std::string_view number = trimmed(line);
  set_ = printable(number.substr(0, number.find_first_of(" \t")));
  return set_;
}

bool UnvLines::next(std::string_view& line) {
  if (!read_filled(line)) fail_end();
  if (!is_mark(line)) return true;
  set_.clear();
  return false;
}

std::string_view UnvLines::further() {
  std::string_view line;
  if (!read_filled(line)) fail_end();
  if (!is_mark(line)) return line;
  fail_at(line_, "the data set " + set_ +
                     " ends here within a record: a line is missing, or has fewer numbers than the record says");
}

std::string_view UnvLines::text() {
  std::string_view line;
  if (!read(line)) fail_end();
  return line;
}

std::size_t UnvLines::size_of_next() const {
  std::string_view rest = rest_;
  std::vector<std::string_view> fields;
  while (fields.empty() && !rest.empty()) split_at_blanks(take_line(rest), fields);
  return fields.size();
}

/// A line of -1 may be data: that at the end of the data set is the last of the file, or another data set starts after
/// it.
void UnvLines::skip_set() {
  std::string_view line;
  while (read(line)) {
    if (!is_mark(line)) continue;
    const std::size_t following = rest_.find_first_not_of(" \t\r\n");
    if (following != std::string_view::npos) {
      std::string_view rest = rest_.substr(following);
      if (!is_mark(take_line(rest))) continue;
    }
    set_.clear();
    return;
  }
  is_open_ = true;
}

const std::vector<std::string_view>& UnvLines::fields(std::string_view line,
                                                      std::initializer_list<std::size_t> widths) {
  split_at_blanks(line, fields_);
  if (fields_.size() == widths.size()) return fields_;
  fields_.clear();
  for (const std::size_t width : widths) {
    const std::size_t end = std::min(width, line.size());
    fields_.push_back(trimmed(line.substr(0, end)));
    line.remove_prefix(end);
  }
  return fields_;
}

const std::vector<std::int64_t>& UnvLines::integers(std::string_view line) {
  split_at_blanks(line, fields_);
  const bool numbers_touch = std::any_of(fields_.begin(), fields_.end(),
                                         [](std::string_view field) { return field.size() > kUnvIntegerWidth; });
  if (numbers_touch) {
    fields_.clear();
    for (; !line.empty(); line.remove_prefix(std::min(kUnvIntegerWidth, line.size()))) {
      const std::string_view field = trimmed(line.substr(0, kUnvIntegerWidth));
      if (!field.empty()) fields_.push_back(field);
    }
  }
  integers_.clear();
  for (const std::string_view field : fields_) integers_.push_back(integer(field, "an integer"));
  return integers_;
}

const std::vector<std::int64_t>& UnvLines::integers(std::string_view line, std::size_t n, const char* record) {
  integers(line);
  if (integers_.size() == n) return integers_;
  fail("the first line of " + std::string(record) + " should have " + std::to_string(n) + " integers, and has " +
       std::to_string(integers_.size()));
}

std::int64_t UnvLines::integer(std::string_view field, const char* name) const {
  std::int64_t value = 0;
  const char* const end = field.data() + field.size();
  const bool has_plus = field.starts_with('+');
  const auto [stop, error] = std::from_chars(field.data() + (has_plus ? 1 : 0), end, value);
  constexpr std::int64_t kMax = 9'999'999'999;  // 10 digits
  if (error == std::errc() && stop == end && value <= kMax && value >= -kMax) return value;
  fail("this should be " + std::string(name) + " of at most 10 digits, and is " + quoted(field));
}

double UnvLines::real(std::string_view field, const char* name) const {
  const std::optional<double> value = parse_fortran_real(field);
  if (value && std::isfinite(*value)) return *value;
  fail("this should be " + std::string(name) + ", and is " + quoted(field));
}

void UnvLines::fail(const std::string& text) const {
  if (!set_.empty() && trimmed(rest_).empty()) fail_end();
  fail_at(line_, text);
}

void UnvLines::fail_end() const {
  fail_at(line_, "it ends within the data set " + set_ +
                     ", before the -1 after its lines; the file is cut short: write or copy it again");
}

void UnvLines::fail_at(std::int64_t line, const std::string& text) const {
  throw FileError(path_ + ":" + std::to_string(line) + ": " + text);
}

}  // namespace tetune
