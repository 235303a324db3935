// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "backend/span.hpp"
#include "io/inp/inp_format.hpp"
#include "io/plain_text.hpp"
#include "io/real_field.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {

/// The place of a text, for messages.
struct InpPlace {
  std::string file;
  std::int64_t line = 0;
  [[noreturn]] void fail(const std::string& text) const {
    throw FileError(file + ":" + std::to_string(line) + ": " + text);
  }
};

/// Reads the lines and numbers of one file of a deck.
class InpCursor {
 public:
  InpCursor(std::string file, std::string_view text)
      : file_(std::move(file)), at_(text.data()), end_(at_ + text.size()) {}

  enum class Line { blank, comment, keyword, data };

  const char* at() const { return at_; }
  bool at_end() const { return at_ >= end_; }
  std::int64_t line() const { return line_; }
  InpPlace place() const { return {file_, line_}; }
  [[noreturn]] void fail(const std::string& text) const { place().fail(text); }
  /// Throws FileError for an earlier line of the same file.
  [[noreturn]] void fail_at(std::int64_t line, const std::string& text) const { InpPlace{file_, line}.fail(text); }

  Line line_kind() const {
    const char* p = at_;
    while (p < end_ && is_blank(*p)) ++p;
    if (p == end_ || *p == '\n') return Line::blank;
    if (*p != '*') return Line::data;
    return p + 1 < end_ && p[1] == '*' ? Line::comment : Line::keyword;
  }

  /// Continues after this line, and returns it without its end.
  std::string_view take_line() {
    const char* const start = at_;
    const void* const found = std::memchr(at_, '\n', to_size_t(end_ - at_));
    const char* const stop = found == nullptr ? end_ : static_cast<const char*>(found);
    at_ = stop;
    pass_line_end();
    std::string_view line(start, to_size_t(stop - start));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  /// Continues after comments between lines that belong together.
  void skip_comments() {
    while (!at_end() && line_kind() == Line::comment) take_line();
  }
  /// Continues after kByteOrderMark; returns whether there is one.
  bool take_byte_order_mark() {
    const bool has_mark = std::string_view(at_, to_size_t(end_ - at_)).starts_with(kByteOrderMark);
    if (has_mark) at_ += kByteOrderMark.size();
    return has_mark;
  }

  /// Takes a keyword line and the lines that continue it: those after a comma that have parameters. Some decks have a
  /// comma there before data.
  InpKeyword take_keyword() {
    std::string_view line = take_line();
    std::string text(line.substr(line.find('*')));
    while (line.find_last_not_of(" \t") != std::string_view::npos && line[line.find_last_not_of(" \t")] == ',') {
      const char* const here = at_;
      const std::int64_t line_here = line_;
      skip_comments();
      const bool has_data = !at_end() && line_kind() == Line::data;
      line = has_data ? take_line() : std::string_view();
      const std::string first = inp_name(line.substr(0, line.find(',')));
      const bool has_parameter =
          line.find('=') != std::string_view::npos || first == "GENERATE" || first == "INTERNAL" || first == "UNSORTED";
      if (!has_data || !has_parameter) {
        at_ = here;
        line_ = line_here;
        break;
      }
      text += line;
    }
    return parse_inp_keyword(text);
  }

  // Numbers of a line, with commas between them.

  void skip_blanks() {
    while (at_ < end_ && is_blank(*at_)) ++at_;
  }
  bool line_done() {
    skip_blanks();
    return at_ >= end_ || *at_ == '\n';
  }
  /// Skips a comma; returns false where the line ends.
  bool take_comma() {
    if (line_done()) return false;
    if (*at_ != ',') fail("expected a comma, found \"" + shown() + "\"");
    ++at_;
    return true;
  }
  void end_line() {
    if (!line_done()) fail("expected the end of the line, found \"" + shown() + "\"");
    pass_line_end();
  }
  /// A positive integer of at most 18 digits; `name` stands for it in messages.
  std::int64_t label(const char* name) { return integer(name, 1); }
  /// A label(), or 0, which stands for none.
  std::int64_t label_or_zero(const char* name) { return integer(name, 0); }
  /// A number; an empty field is 0.
  double real() {
    skip_blanks();
    if (at_ >= end_ || *at_ == ',' || *at_ == '\n') return 0;
    double value = 0;
    const auto [stop, error] = parse_real(at_, end_, value);
    if (error != std::errc() || !(stop == end_ || *stop == ',' || *stop == '\n' || is_blank(*stop)))
      return other_real();
    at_ = stop;
    return value;
  }

 private:
  std::int64_t integer(const char* name, std::int64_t min) {
    skip_blanks();
    const char* const start = at_;
    std::int64_t value = 0;
    while (at_ < end_ && *at_ >= '0' && *at_ <= '9' && at_ - start < 18) value = 10 * value + (*at_++ - '0');
    const bool is_ended = at_ >= end_ || *at_ == ',' || *at_ == '\n' || is_blank(*at_);
    if (at_ != start && is_ended && value >= min) return value;
    at_ = start;
    fail(std::string("expected the ") + name + ", found \"" + shown() + "\"");
  }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  /// Continues with the next line, where this one is not the last.
  void pass_line_end() {
    if (at_ == end_) return;
    ++at_;
    ++line_;
  }

  /// The next field, for messages.
  std::string shown() const {
    const char* const stop = std::find_if(at_, end_, [](char c) { return c == ',' || c == '\n'; });
    const std::string text = printable({at_, std::min(stop, at_ + std::min<std::ptrdiff_t>(40, end_ - at_))});
    return text.empty() ? "the end of the line" : text;
  }
  double other_real() {
    const char* const stop = std::find_if(at_, end_, [](char c) { return c == ',' || c == '\n' || is_blank(c); });
    const std::optional<double> value = parse_real_field(std::string(at_, stop));
    if (!value) fail("expected a coordinate, found \"" + shown() + "\"");
    at_ = stop;
    return *value;
  }

  std::string file_;
  const char* at_;
  const char* end_;
  std::int64_t line_ = 1;
};

}  // namespace tetune
