// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "system/file.hpp"
#include "system/real_text.hpp"

namespace tetune {

/// Writes numbers in text, with the shortest digits that read back to the same bits, or binary.
class MshSink {
 public:
  MshSink(FileWriter& file, bool is_binary) : file_(file), is_binary_(is_binary) {}
  ~MshSink() = default;
  MshSink(const MshSink&) = delete;
  MshSink& operator=(const MshSink&) = delete;

  bool is_binary() const { return is_binary_; }
  /// Makes numbers text where a section is text in every file.
  void set_binary(bool is_binary) { is_binary_ = is_binary; }
  void text(std::string_view words) {
    buffer_.append(words);
    if (buffer_.size() > kFlushBytes) flush();
  }
  void integer(int value) { put(value); }
  void long_integer(std::int64_t value) { put(value); }
  void count(std::size_t value) { put(std::int64_t(value)); }
  void real(double value) { put(value); }
  /// Ends a line of text.
  void end_line() {
    if (is_binary_) return;
    if (buffer_.ends_with(' ')) buffer_.pop_back();
    text("\n");
  }
  void begin(const char* section) { text(std::string("$") + section + "\n"); }
  void end(const char* section) { text(std::string(is_binary_ ? "\n" : "") + "$End" + section + "\n"); }
  void flush() {
    file_.write(buffer_);
    buffer_.clear();
  }

 private:
  static constexpr std::size_t kFlushBytes = 1 << 20;
  template <class T>
  void put(T value) {
    std::array<char, 40> digits;
    char* to = digits.data();
    if (is_binary_) {
      std::memcpy(to, &value, sizeof value);
      to += sizeof value;
    } else {
      char* const end = to + digits.size() - 1;
      if constexpr (std::is_floating_point_v<T>) {
        to = print_real(to, end, value).ptr;
      } else {
        to = std::to_chars(to, end, value).ptr;
      }
      *to++ = ' ';
    }
    text({digits.data(), std::size_t(to - digits.data())});
  }
  FileWriter& file_;
  bool is_binary_;
  std::string buffer_;
};

/// A name as it stands between quotation marks in one line.
inline std::string msh_quoted(std::string name) {
  std::replace(name.begin(), name.end(), '"', '\'');
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return '"' + name + '"';
}

}  // namespace tetune
