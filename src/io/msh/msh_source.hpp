// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "backend/span.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "tetune/error.hpp"

namespace tetune {

/// The numbers of an .msh file, in the encoding of the file. Names of sections and some counts are text in either.
class MshSource {
 public:
  MshSource(const std::string& path, std::string_view bytes)
      : path_(path), size_(std::ssize(bytes)), text_(path, bytes) {}

  /// Sets whether numbers are binary from here on.
  void set_binary(bool is_binary) { is_binary_ = is_binary; }
  /// Sets that the file is of the other byte order than this machine.
  void set_swapped() { is_swapped_ = true; }
  bool is_binary() const { return is_binary_; }
  void set_old(bool is_old) { is_old_ = is_old; }
  /// Whether the file is of version 2.2, in which some numbers have 32 bits, and some sections are text in binary
  /// files, too.
  bool is_old() const { return is_old_; }
  /// Sets that counts and numbers of nodes and elements have 32 bits in a binary file, which Gmsh on a machine of 32
  /// bits wrote.
  void set_short_sizes() { has_short_sizes_ = true; }
  TextCursor& text() { return text_; }

  /// An integer of 32 bits.
  int integer(const char* name) {
    const std::int64_t value = is_binary_ ? std::int64_t{take<std::int32_t>()} : text_.integer(name);
    if (value <= std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      fail(std::string(name) + " " + std::to_string(value) + " does not fit 32 bits");
    }
    return static_cast<int>(value);
  }
  /// An integer of 64 bits, the number of a node or element.
  std::int64_t long_integer(const char* name) {
    const std::int64_t value = is_binary_ ? take_size() : text_.integer(name);
    if (value < 0) fail(std::string(name) + " " + std::to_string(value) + " is negative or does not fit 63 bits");
    return value;
  }
  /// A number of a node or element where it has 32 bits in binary files: version 2.2, and data.
  std::int64_t short_integer(const char* name) {
    const std::int64_t value = is_binary_ ? integer(name) : text_.integer(name);
    if (value < 0) fail(std::string(name) + " " + std::to_string(value) + " is negative");
    return value;
  }
  double real(const char* name) { return is_binary_ ? take<double>() : text_.real(name); }

  /// Reads a count of entries, written with 64 bits. Refuses one that the rest of the file cannot hold, with
  /// `text_numbers` numbers or `bytes` bytes per entry, before memory is asked for.
  std::size_t count(const char* name, int text_numbers, int bytes) {
    return checked(long_integer(name), name, text_numbers, bytes);
  }
  /// Reads a count that is text in every file, as count() does; binary entries start on the next line.
  std::size_t text_count(const char* name, int text_numbers, int bytes) {
    const std::int64_t n = text_.integer(name);
    if (is_binary_) text_.line();
    return checked(n, name, text_numbers, bytes);
  }
  std::size_t checked(std::int64_t n, const char* name, int text_numbers, int bytes) {
    const std::int64_t each = is_binary_ ? (has_short_sizes_ ? bytes / 2 : bytes) : 2 * text_numbers;
    if (n >= 0 && n <= text_.remaining() / each + (is_binary_ ? 0 : 1)) return to_size_t(n);
    fail(std::string(name) + " is " + std::to_string(n) + ", more than the rest of the file can hold");
  }

  /// Skips blanks and reads the line that ends a section.
  void expect_end(std::string_view section) {
    const std::string expected = std::string("$End").append(section);
    const std::string_view found = text_.word();
    if (found == expected) return;
    const std::string shown = found.empty() ? "the end of the file" : printable(found.substr(0, 40));
    fail("expected " + expected + ", found \"" + shown + "\"");
  }
  /// Skips the rest of a section, up to the line that ends it.
  void skip_section(std::string_view section) {
    const std::string end = std::string("\n$End").append(section);
    const std::int64_t rest = text_.remaining();
    const char* at = text_.skip(0);
    const auto found = std::string_view(at - 1, to_size_t(rest) + 1).find(end);
    if (found == std::string_view::npos) fail("the section $" + printable(section) + " has no end");
    text_.skip(std::int64_t(found));
  }

  [[noreturn]] void fail(const std::string& text) const {
    if (!is_binary_) text_.fail(text);
    throw FileError(path_ + ", byte " + std::to_string(size_ - text_.remaining()) + ": " + text);
  }

 private:
  std::int64_t take_size() { return has_short_sizes_ ? std::int64_t{take<std::uint32_t>()} : take<std::int64_t>(); }
  template <class T>
  T take() {
    constexpr std::int64_t kBytes = sizeof(T);
    if (text_.remaining() < kBytes) fail("the file ends too early");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), text_.skip(kBytes), sizeof(T));
    if (is_swapped_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  std::string path_;
  std::int64_t size_;
  TextCursor text_;
  bool is_binary_ = false, is_swapped_ = false, is_old_ = false, has_short_sizes_ = false;
};

}  // namespace tetune
