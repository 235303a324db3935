// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "tetune/error.hpp"

namespace tetune {

/// Reads words and numbers from a text in memory; '#' starts a comment that runs to the end of the line.
class TextCursor {
 public:
  TextCursor(std::string path, std::string_view text)
      : path_(std::move(path)), begin_(text.data()), at_(begin_), end_(begin_ + text.size()) {}

  /// The next word, or an empty one at the end.
  std::string_view word() {
    skip_space();
    const char* start = at_;
    while (at_ < end_ && !is_space(*at_) && *at_ != '#') ++at_;
    return {start, static_cast<std::size_t>(at_ - start)};
  }

  std::string_view peek() {
    const char* start = at_;
    const std::string_view w = word();
    at_ = start;
    return w;
  }

  std::int64_t integer(const char* what) {
    skip_space();
    if (const int count = few_digits(); count > 0 && (at_[count] == ' ' || at_[count] == '\n')) {
      const std::uint64_t value = eight_digits(digits_at() << 8 * (8 - count));
      at_ += count;
      return static_cast<std::int64_t>(value);
    }
    const char* start = at_;
    bool negative = false;
    if (at_ < end_ && (*at_ == '-' || *at_ == '+')) negative = *at_++ == '-';
    std::uint64_t value = 0;
    const char* digits = at_;
    while (at_ < end_ && static_cast<unsigned char>(*at_ - '0') < 10) {
      value = 10 * value + static_cast<std::uint64_t>(*at_++ - '0');
    }
    if (at_ == digits || at_ - digits > 18 || !ended()) fail_token(start, "an integer", what);
    const auto result = static_cast<std::int64_t>(value);
    return negative ? -result : result;
  }

  double real(const char* what) {
    skip_space();
    const char* start = at_;
    double value = 0;
    const auto [stop, error] = std::from_chars(at_, end_, value);
    at_ = stop;
    if (error != std::errc() || !ended()) return unusual_real(start, what);
    return value;
  }

  /// Passes over numbers up to the next word that starts with a letter.
  void skip_numbers() {
    for (;;) {
      skip_space();
      if (at_ >= end_) return;
      const char c = *at_;
      const bool letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
      if (letter) {
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
  /// True when only blanks or a comment follow on this line.
  bool line_done() {
    while (at_ < end_ && (*at_ == ' ' || *at_ == '\t' || *at_ == '\r')) ++at_;
    return at_ >= end_ || *at_ == '\n' || *at_ == '#';
  }

  /// Some of the lines that follow this one, to be read by a cursor of their own.
  struct Lines;
  /// The n lines that follow this one, in parts of about as many bytes; none where something follows on this one, or
  /// there are fewer.
  std::vector<Lines> next_lines(std::size_t n, std::size_t bytes_each);
  /// Goes on where a cursor over some of its text is.
  void go_on_after(const TextCursor& part) { at_ = part.at_; }

  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(begin_, at_, '\n');
    throw FileError(path_ + ":" + std::to_string(line) + ": " + what);
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  bool ended() const { return at_ >= end_ || is_space(*at_) || *at_ == '#'; }
  void skip_space() {
    for (;;) {
      while (at_ < end_ && is_space(*at_)) ++at_;
      if (at_ >= end_ || *at_ != '#') return;
      while (at_ < end_ && *at_ != '\n') ++at_;
    }
  }
  /// The next eight bytes, digits as their values.
  std::uint64_t digits_at() const {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, at_, sizeof bytes);
    return bytes ^ 0x3030303030303030U;
  }
  /// How many digits come next, where they are less than eight; 0: look at them one by one. Most numbers of a mesh are
  /// such.
  int few_digits() const {
    if (std::endian::native != std::endian::little || end_ - at_ < 9) return 0;
    const std::uint64_t digits = digits_at();
    const std::uint64_t others = ((digits + 0x7676767676767676U) | digits) & 0x8080808080808080U;
    return others == 0 ? 0 : std::countr_zero(others) / 8;
  }
  /// The number that eight values from 0 to 9 write, the first in the lowest byte: pairs, then fours, then all.
  static std::uint64_t eight_digits(std::uint64_t digits) {
    digits = digits * 10 + (digits >> 8);
    digits = (digits & 0x00ff00ff00ff00ffU) * 100 + (digits >> 16 & 0x00ff00ff00ff00ffU);
    return (digits & 0xffffU) * 10000 + (digits >> 32 & 0xffffU);
  }
  [[noreturn]] void fail_token(const char* start, const char* wanted, const char* what) {
    at_ = start;
    const std::string_view w = word();
    at_ = start;
    fail(std::string("expected ") + wanted + " (" + what + "), found " +
         (w.empty() ? "the end of the file" : "\"" + std::string(w.substr(0, 40)) + "\""));
  }
  /// What from_chars leaves: a plus sign, 1.0D-3 as Fortran programs write, and what no double holds.
  double unusual_real(const char* start, const char* what) {
    at_ = start;
    std::string token(word());
    for (char& c : token) {
      if (c == 'D' || c == 'd') c = 'e';
    }
    const char* from = token.data();
    const char* to = from + token.size();
    if (token.size() > 1 && token[0] == '+' && token[1] != '-') ++from;
    double value = 0;
    auto [stop, error] = std::from_chars(from, to, value);
    if (error == std::errc::result_out_of_range) {
      // Too small reads as zero, too large as infinity, which validation reports.
      long double wide = 0;
      const auto again = std::from_chars(from, to, wide);
      if (again.ec != std::errc()) fail_token(start, "a number of the range of double", what);
      value = static_cast<double>(wide);
    } else if (error != std::errc()) {
      fail_token(start, "a number", what);
    }
    if (stop != to) fail_token(start, "a number", what);
    return value;
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

inline std::vector<TextCursor::Lines> TextCursor::next_lines(std::size_t n, std::size_t bytes_each) {
  const auto past_line = [this](const char* from) {
    const void* found = from < end_ ? std::memchr(from, '\n', static_cast<std::size_t>(end_ - from)) : nullptr;
    return found != nullptr ? static_cast<const char*>(found) + 1 : end_;
  };
  std::vector<Lines> parts;
  if (!line_done()) return parts;
  const char* from = past_line(at_);
  for (std::size_t first = 0; first < n;) {
    if (from == end_) return {};
    const char* to = past_line(from + std::min(bytes_each, static_cast<std::size_t>(end_ - from)) - 1);
    auto count = static_cast<std::size_t>(std::count(from, to, '\n'));
    if (count > n - first) {
      count = n - first;
      to = from;
      for (std::size_t line = 0; line < count; ++line) to = past_line(to);
    }
    if (count == 0) return {};
    parts.push_back({first, count, TextCursor(path_, {from, static_cast<std::size_t>(to - from)})});
    first += count;
    from = to;
  }
  return parts;
}

}  // namespace tetune
