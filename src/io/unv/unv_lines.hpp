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

  /// Starts the next data set and returns its number, or an empty text at the end of the file.
  std::string_view next_set();
  /// Reads the next line of the data set; returns false at its end.
  bool next(std::string_view& line);
  /// Reads a further line of a record. Throws FileError where the data set ends before it.
  std::string_view further();
  /// Reads a further line of a record that is text, and may be blank.
  std::string_view text();
  /// The number of fields of the next line of the file that is not blank, which is not read yet.
  std::size_t size_of_next() const;
  /// Skips the rest of a data set, whose lines may be of any kind.
  void skip_set();

  /// The fields of a line: those between blanks, or columns of these widths where numbers touch.
  const std::vector<std::string_view>& fields(std::string_view line, std::initializer_list<std::size_t> widths);
  /// The integers of a line, as many as it has: between blanks, or in columns of 10 where numbers touch.
  const std::vector<std::int64_t>& integers(std::string_view line);
  /// The integers of the first line of a record. Throws FileError, which names the record, unless there are n.
  const std::vector<std::int64_t>& integers(std::string_view line, std::size_t n, const char* record);
  /// An integer of at most 10 digits. Throws FileError, which names it, for other fields.
  std::int64_t integer(std::string_view field, const char* name) const;
  /// A finite number. Throws FileError, which names it, for other fields.
  double real(std::string_view field, const char* name) const;

  /// The number of the line that was read last.
  std::int64_t line() const { return line_; }
  /// Whether the file ends with the start of a data set, or within one that was skipped.
  bool is_open() const { return is_open_; }
  const std::string& path() const { return path_; }

  /// Throws FileError for the last line; where no line follows it, the error is that the file is cut short.
  [[noreturn]] void fail(const std::string& text) const;
  /// Throws FileError for a line.
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
