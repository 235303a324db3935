// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "backend/cpu.hpp"
#include "system/file.hpp"
#include "system/real_text.hpp"

namespace tetune {

/// Formats n entries in ranges, in parallel, and writes the ranges in order. format(bytes, begin, end) sets `bytes`, in
/// which an earlier range may be, to those of the entries [begin, end).
template <class Format, class Write>
void write_in_ranges(const backend::Cpu& cpu, Size n, Size per_range, const Format& format, const Write& write) {
  std::vector<std::string> ranges(to_size_t(4 * cpu.threads()));
  const Span<std::string> range = span_of(ranges);
  for (Size first = 0; first < n; first += range.size() * per_range) {
    const Size count = std::min(range.size(), (n - first + per_range - 1) / per_range);
    cpu.for_parts(count, [&](Size r) {
      const Size begin = first + r * per_range;
      format(range[r], begin, std::min(n, begin + per_range));
    });
    for (Size r = 0; r < count; ++r) write(range[r]);
  }
}

/// Appends a text, or an integer, at the right of `width` columns.
inline void append_right(std::string& line, std::string_view text, std::size_t width) {
  line.append(width - std::min(width, text.size()), ' ').append(text);
}
inline void append_right(std::string& line, std::int64_t number, std::size_t width) {
  std::array<char, 24> digits;
  const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  append_right(line, std::string_view(digits.data(), std::size_t(end - digits.data())), width);
}

/// Writes n records of one or several lines, formatted in parallel; put(text, i) appends record i.
template <class Put>
void write_records(FileWriter& file, const backend::Cpu& cpu, std::size_t n, const Put& put) {
  constexpr Size kRecordsPerRange = 1 << 14;
  const auto format = [&put](std::string& text, Size begin, Size end) {
    text.clear();
    for (Size i = begin; i < end; ++i) put(text, to_size_t(i));
  };
  write_in_ranges(cpu, Size(n), kRecordsPerRange, format, [&file](const std::string& text) { file.write(text); });
}

/// Writes lines of numbers, real ones with the shortest digits that read back to the same bits.
class LineWriter {
 public:
  /// The numbers of one line, each followed by a space.
  class Entry {
   public:
    explicit Entry(std::string& out) : out_(out) {}
    void real(double value) {
      char digits[40];
      append(digits, print_real(digits, digits + sizeof digits, value).ptr);
    }
    template <class T>
    void integer(T value) {
      char digits[40];
      append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }

   private:
    void append(const char* digits, char* end) {
      *end = ' ';
      out_.append(digits, std::size_t(end + 1 - digits));
    }
    std::string& out_;
  };

  LineWriter(FileWriter& file, int threads)
      : LineWriter([&file](std::string_view text) { file.write(text); }, threads) {}
  /// `write` takes the text in order, in parts.
  LineWriter(std::function<void(std::string_view)> write, int threads) : write_(std::move(write)), cpu_(threads) {}
  void text(std::string_view text) { write_(text); }
  /// Writes n lines; put(entry, i) writes one of them.
  template <class Put>
  void lines(std::size_t n, const Put& put) {
    const auto format = [&put](std::string& text, Size begin, Size end) {
      text.clear();
      Entry entry(text);
      for (Size i = begin; i < end; ++i) {
        put(entry, to_size_t(i));
        text.back() = '\n';
      }
    };
    write_in_ranges(cpu_, std::int64_t(n), kLinesPerRange, format, write_);
  }

 private:
  static constexpr Size kLinesPerRange = 1 << 15;
  std::function<void(std::string_view)> write_;
  backend::Cpu cpu_;
};

}  // namespace tetune
