// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
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

/// Writes lines of numbers, real ones with the shortest digits that read back to the same bits. Lines are formatted in
/// ranges, in parallel, and written in order.
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
    const Size size = std::int64_t(n);
    std::vector<std::string> parts(to_size_t(4 * cpu_.threads()));
    const Span<std::string> part = span_of(parts);
    for (Size first = 0; first < size; first += part.size() * kLinesPerPart) {
      cpu_.for_parts(part.size(), [&](Size p) {
        part[p].clear();
        const Size begin = std::min(size, first + p * kLinesPerPart);
        const std::size_t end = to_size_t(std::min(size, begin + kLinesPerPart));
        Entry entry(part[p]);
        for (std::size_t i = to_size_t(begin); i < end; ++i) {
          put(entry, i);
          part[p].back() = '\n';
        }
      });
      for (const std::string& lines : parts) write_(lines);
    }
  }

 private:
  static constexpr Size kLinesPerPart = 1 << 15;
  std::function<void(std::string_view)> write_;
  backend::Cpu cpu_;
};

}  // namespace tetune
