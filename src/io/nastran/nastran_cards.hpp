// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace tetune {

/// A line of one of the files that were read.
struct NastranPlace {
  std::int32_t file = 0;
  std::uint32_t line = 0;
};

/// A card of bulk data with the fields after its name, those of all its lines. The views are valid while it is taken.
struct NastranCard {
  std::string name;
  NastranPlace place;
  std::vector<std::string_view> fields;
  /// The last field of the last line: where it has a name after the sign, another line was to follow.
  std::string_view marker;
  std::string_view marker_name;  ///< NastranLine::marker_name()
  /// Field k, from 0; empty where the card ends before it.
  std::string_view field(std::size_t k) const { return k < fields.size() ? fields[k] : std::string_view(); }
};

/// The cards of a file of bulk data, and of the files that it includes.
class NastranCards {
 public:
  using IsRead = std::function<bool(const std::string& name)>;
  using Take = std::function<void(const NastranCard& card)>;
  /// take(card) is called for the cards whose names `is_read` accepts.
  NastranCards(std::string path, IsRead is_read, Take take)
      : path_(std::move(path)), is_read_(std::move(is_read)), take_(std::move(take)) {}

  /// Reads all files. Throws FileError.
  void read();

  [[noreturn]] void fail(NastranPlace place, const std::string& text) const;
  /// The file and line of a place, for messages.
  std::string text_of(NastranPlace place) const;

  /// The names of the cards that are not read, in their order.
  const std::vector<std::string>& ignored() const { return ignored_; }
  /// Whether there are statements before the bulk data.
  bool has_control() const { return has_control_; }
  bool has_end() const { return has_end_; }
  /// The files that were read, in this order.
  const std::vector<std::string>& files() const { return files_; }
  /// The last line that was read.
  NastranPlace end() const { return here_; }

 private:
  /// The lines of one file that follow.
  struct Source {
    std::string_view rest;
    NastranPlace place;
  };
  enum class State { outside, in_ignored, in_card };

  void read_file(const std::string& path);
  /// Continues after the next line, and returns it without a comment at its end; false at the end of the file.
  static bool next_line(Source& source, std::string_view& line);
  void skip_control(Source& source);
  void read_line(Source& source, std::string_view line);
  void start_card(std::string_view line);
  void begin_bulk();
  void continue_card(std::string_view line);
  void add_fields(std::string_view line);
  void include(Source& source, std::string_view line);
  std::string included_path(const std::string& name, const std::string& file) const;
  /// Ends the card before, and hands it to take().
  void flush();

  std::string path_;
  IsRead is_read_;
  Take take_;
  std::vector<std::string> files_, stack_;
  State state_ = State::outside;
  NastranCard card_;
  std::deque<std::string> expanded_;  ///< lines of the card whose tabs were replaced
  NastranPlace here_;
  std::set<std::string> names_;
  std::vector<std::string> ignored_;
  bool has_control_ = false, has_end_ = false, has_begin_ = false, has_cards_ = false;
};

}  // namespace tetune
