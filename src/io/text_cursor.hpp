// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "io/plain_text.hpp"
#include "io/real_field.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {

/// Reads words and numbers from a text in memory; '#' starts a comment that runs to the end of the line.
class TextCursor {
 public:
  TextCursor(std::string path, std::string_view text)
      : path_(std::move(path)), begin_(text.data()), at_(begin_), end_(begin_ + text.size()) {}

  /// Returns the next word, or an empty one at the end.
  std::string_view word() {
    skip_space();
    const char* start = at_;
    while (at_ < end_ && !is_space(*at_) && *at_ != '#') ++at_;
    return {start, std::size_t(at_ - start)};
  }

  std::string_view peek() {
    const char* start = at_;
    const std::string_view w = word();
    at_ = start;
    return w;
  }

  /// Returns the rest of this line and continues after it.
  std::string_view line() {
    const char* start = at_;
    while (at_ < end_ && *at_ != '\n') ++at_;
    std::string_view text(start, std::size_t(at_ - start));
    if (at_ < end_) ++at_;
    if (text.ends_with('\r')) text.remove_suffix(1);
    return text;
  }

  /// Continues after the next n bytes, and returns them; `n` is at most remaining().
  const char* skip(std::int64_t n) {
    const char* start = at_;
    at_ += n;
    return start;
  }

  /// Reads an integer of at most 18 digits; `name` stands for it in messages.
  std::int64_t integer(const char* name) {
    skip_space();
    if (const int count = few_digits(); count > 0 && (at_[count] == ' ' || at_[count] == '\n')) {
      const std::int64_t value = eight_digits(digits_at() << 8 * (8 - count));
      at_ += count;
      return value;
    }
    const char* start = at_;
    bool negative = false;
    if (at_ < end_ && (*at_ == '-' || *at_ == '+')) negative = *at_++ == '-';
    const char* const digits = at_;
    while (at_ < end_ && is_digit(*at_)) ++at_;
    if (at_ == digits || at_ - digits > 18 || !ended()) fail_token(start, "an integer", name);
    std::int64_t value = 0;
    for (const char* digit = digits; digit < at_; ++digit) value = 10 * value + (*digit - '0');
    return negative ? -value : value;
  }

  double real(const char* name) {
    skip_space();
    const char* start = at_;
    double value = 0;
    const auto [stop, error] = parse_real(at_, end_, value);
    at_ = stop;
    if (error != std::errc() || !ended()) return unusual_real(start, name);
    return value;
  }

  /// Skips numbers up to the next word that starts with a letter.
  void skip_numbers() {
    for (;;) {
      skip_space();
      if (at_ >= end_) return;
      if (is_letter(*at_)) {
        const std::string_view w = peek();
        if (w != "nan" && w != "NaN" && w != "inf" && w != "Inf") return;
      }
      word();
    }
  }

  bool at_end() {
    skip_space();
    return at_ >= end_;
  }
  /// Returns true when only blanks or a comment follow on this line.
  bool line_done() {
    while (at_ < end_ && (*at_ == ' ' || *at_ == '\t' || *at_ == '\r')) ++at_;
    return at_ >= end_ || *at_ == '\n' || *at_ == '#';
  }

  /// A range of the lines after this one, to be read by a cursor of its own.
  struct Lines;
  /// Returns the n lines after this one, in ranges of about `part_bytes` bytes; none where the rest of this line is not
  /// blank, or where there are fewer lines.
  std::vector<Lines> next_lines(std::size_t n, std::size_t part_bytes);
  /// Continues at the position of a cursor over a part of the same text.
  void continue_after(const TextCursor& part) { at_ = part.at_; }

  std::int64_t remaining() const { return end_ - at_; }

  /// A text behind the file and the line.
  std::string at_line(const std::string& text) const {
    return path_ + ":" + std::to_string(1 + std::count(begin_, at_, '\n')) + ": " + text;
  }
  [[noreturn]] void fail(const std::string& text) const { throw FileError(at_line(text)); }

  static bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  bool ended() const { return at_ >= end_ || is_space(*at_) || *at_ == '#'; }
  void skip_space() {
    for (;;) {
      while (at_ < end_ && is_space(*at_)) ++at_;
      if (at_ >= end_ || *at_ != '#') return;
      while (at_ < end_ && *at_ != '\n') ++at_;
    }
  }
  /// Returns the next eight bytes, with digits as their values.
  std::uint64_t digits_at() const {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, at_, sizeof bytes);
    return bytes ^ 0x3030303030303030U;
  }
  /// Returns the number of digits that come next if it is 1 to 7, as in most integers of a mesh; otherwise 0.
  int few_digits() const {
    if (std::endian::native != std::endian::little || end_ - at_ < 9) return 0;
    const std::uint64_t digits = digits_at();
    const std::uint64_t others = ((digits + 0x7676767676767676U) | digits) & 0x8080808080808080U;
    return others == 0 ? 0 : std::countr_zero(others) / 8;
  }
  /// Returns the number with these eight digits, the first in the lowest byte: joins pairs, then fours, then all.
  static std::int64_t eight_digits(std::uint64_t digits) {
    digits = digits * 10 + (digits >> 8);
    digits = (digits & 0x00ff00ff00ff00ffU) * 100 + (digits >> 16 & 0x00ff00ff00ff00ffU);
    return std::int64_t((digits & 0xffffU) * 10000 + (digits >> 32 & 0xffffU));
  }
  [[noreturn]] void fail_token(const char* start, const char* expected, const char* name) {
    at_ = start;
    const std::string_view w = word();
    at_ = start;
    fail(std::string("expected ") + expected + " (" + name + "), found " +
         (w.empty() ? "the end of the file" : "\"" + printable(w.substr(0, 40)) + "\""));
  }
  double unusual_real(const char* start, const char* name) {
    at_ = start;
    const std::optional<double> value = parse_real_field(std::string(word()));
    if (!value) fail_token(start, "a number", name);
    return *value;
  }

  std::string path_;
  const char* begin_;
  const char* at_;
  const char* end_;
};

struct TextCursor::Lines {
  std::size_t first, count;
  TextCursor cursor;
};

inline std::vector<TextCursor::Lines> TextCursor::next_lines(std::size_t n, std::size_t part_bytes) {
  const auto next_line = [this](const char* from) {
    const std::size_t line_end = std::string_view(from, std::size_t(end_ - from)).find('\n');
    return line_end == std::string_view::npos ? end_ : from + line_end + 1;
  };
  std::vector<Lines> parts;
  if (!line_done()) return parts;
  const char* from = next_line(at_);
  for (std::size_t first = 0; first < n;) {
    const std::string_view rest(from, std::size_t(end_ - from));
    if (rest.empty()) return {};
    const char* to = next_line(from + std::min(part_bytes, rest.size()) - 1);
    std::size_t count = std::size_t(std::count(from, to, '\n'));
    if (count > n - first) {
      count = n - first;
      to = from;
      for (std::size_t line = 0; line < count; ++line) to = next_line(to);
    }
    if (count == 0) return {};
    parts.push_back({first, count, TextCursor(path_, {from, std::size_t(to - from)})});
    first += count;
    from = to;
  }
  return parts;
}

}  // namespace tetune
