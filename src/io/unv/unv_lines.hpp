// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace tetune {

/// The lines of a universal file. A data set starts with a line of -1 and one with its number, and ends with a line of
/// -1. Blank lines between records are skipped.
class UnvLines {
 public:
  UnvLines(std::string path, std::string_view text) : path_(std::move(path)), rest_(text) {}

  /// Starts the next data set, and returns its number; an empty text at the end of the file.
  std::string_view next_set();
  /// The next line of the data set; false at its end.
  bool next(std::string_view& line);
  /// A further line of a record.
  std::string_view further();
  /// A further line of text, which may be blank.
  std::string_view text();
  /// The number of integers in the next line of the file, without reading it.
  std::size_t size_of_next() const;
  /// Skips the rest of a data set, whose lines may be of any kind.
  void skip_set();

  /// The fields of a line: those between blanks, or columns of these widths where numbers touch.
  const std::vector<std::string_view>& fields(std::string_view line, std::initializer_list<std::size_t> widths);
  /// The integers of a line, as many as it has: between blanks, or in columns of 10 where numbers touch.
  const std::vector<std::int64_t>& integers(std::string_view line);
  /// The same for a line of n integers.
  const std::vector<std::int64_t>& integers(std::string_view line, std::size_t n, const char* record);
  std::int64_t integer(std::string_view field, const char* name) const;
  /// Throws FileError unless it is a finite number.
  double real(std::string_view field, const char* name) const;

  /// The number of the line that was read last.
  std::int64_t line() const { return line_; }
  /// Whether the file ends with the start of a data set, or within one that was skipped.
  bool is_open() const { return is_open_; }
  const std::string& path() const { return path_; }

  /// An error in the last line; where no line follows it, the file is cut short.
  [[noreturn]] void fail(const std::string& text) const;
  [[noreturn]] void fail_at(std::int64_t line, const std::string& text) const;

 private:
  bool read(std::string_view& line);
  bool read_filled(std::string_view& line);
  [[noreturn]] void fail_end() const;

  std::string path_;
  std::string_view rest_;
  std::int64_t line_ = 0;
  std::string set_;  ///< the number of the data set; empty outside of one
  bool is_open_ = false;
  std::vector<std::string_view> fields_;
  std::vector<std::int64_t> integers_;
};

}  // namespace tetune
