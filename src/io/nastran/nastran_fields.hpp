// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// The fields of Nastran's bulk data: numbers, and the lines that hold them.
namespace tetune {

/// The start of a text of a file, for messages.
std::string nastran_shown(std::string_view text);

/// An integer of at most 9 digits that fills the field; nothing for other fields.
std::optional<int> parse_nastran_integer(std::string_view field);

inline constexpr std::size_t kNastranLargeField = 16;

/// Appends a finite number with a decimal point in at most 16 characters: with the digits that read back to the same
/// bits, or as many of them as fit, correctly rounded. Returns whether all of them fit.
bool append_nastran_real(std::string& out, double value);

/// A line of bulk data: the name of a card or the marker of a continuation line, fields and the marker after them. The
/// views are parts of the text.
class NastranLine {
 public:
  /// `text` has no comment and no tabs between fixed fields.
  explicit NastranLine(std::string_view text);
  /// The first field as it is written, without blanks around it.
  std::string_view first() const { return first_; }
  /// The name of the card, in upper case and without the mark of large fields.
  std::string name() const;
  bool is_continuation() const { return first_.empty() || first_[0] == '+' || first_[0] == '*'; }
  bool is_large() const { return is_large_; }
  /// The number of fields between the first and the marker: 8, or 4 large ones.
  std::size_t size() const { return is_large_ ? 4 : 8; }
  /// Field k, from 0; empty where the line ends before it.
  std::string_view field(std::size_t k) const;
  std::string_view marker() const { return field(size()); }
  /// The parts of two markers that must be equal, where both are there: in fixed fields columns 74 to 80 of a line and
  /// 2 to 8 of the one that continues it, between commas all but the first characters.
  std::string_view marker_name() const;
  std::string_view continued_name() const;
  /// Whether there are fields after the marker, or a number in its place.
  bool is_too_long() const;

 private:
  /// A small field as it is written, from a column on that is counted from 0.
  std::string_view columns(std::size_t begin) const;

  std::string_view text_, first_;
  bool is_free_;
  bool is_large_ = false;
};

}  // namespace tetune
