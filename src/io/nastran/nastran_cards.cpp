// SPDX-License-Identifier: Apache-2.0
// The lines of Nastran's bulk data: comments, continuation, included files.
#include "io/nastran/nastran_cards.hpp"

#include <algorithm>
#include <filesystem>

#include "backend/span.hpp"
#include "io/nastran/nastran_fields.hpp"
#include "io/plain_text.hpp"
#include "system/file.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr std::size_t kMaxIncludeDepth = 20, kMaxIncludedFiles = 1000;
/// No card that is read has more fields.
constexpr std::size_t kMaxCardFields = 64;

/// The first word of a line, in upper case.
std::string first_word(std::string_view line) {
  const std::string_view text = trimmed(line);
  return in_upper_case(text.substr(0, text.find_first_of(" \t,='\"")));
}

/// A line with blanks up to the next column that is a multiple of 8 in the place of each tab.
std::string without_tabs(std::string_view line) {
  std::string text;
  for (const char c : line) {
    if (c != '\t') {
      text += c;
    } else {
      text.append(8 - text.size() % 8, ' ');
    }
  }
  return text;
}

}  // namespace

void NastranCards::read() { read_file(path_); }

std::string NastranCards::text_of(NastranPlace place) const {
  return span_of(files_)[place.file] + ":" + std::to_string(place.line);
}

void NastranCards::fail(NastranPlace place, const std::string& text) const {
  throw FileError(text_of(place) + ": " + text);
}

void NastranCards::read_file(const std::string& path) {
  const MappedFile file(path);
  if (file.bytes().find('\0') != std::string_view::npos) {
    throw FileError(path + ":1: this is a binary file; Nastran's bulk data are text");
  }
  Source source{file.bytes(), {std::int32_t(files_.size()), 0}};
  if (source.rest.starts_with(kByteOrderMark)) source.rest.remove_prefix(kByteOrderMark.size());
  files_.push_back(path);
  stack_.push_back(path);
  here_ = {source.place.file, 1};
  if (stack_.size() == 1) skip_control(source);
  std::string_view line;
  while (!has_end_ && next_line(source, line)) {
    here_ = source.place;
    if (!trimmed(line).empty()) read_line(source, line);
  }
  flush();
  stack_.pop_back();
}

bool NastranCards::next_line(Source& source, std::string_view& line) {
  if (source.rest.empty()) return false;
  const std::size_t end = source.rest.find('\n');
  line = source.rest.substr(0, end);
  source.rest.remove_prefix(end == std::string_view::npos ? source.rest.size() : end + 1);
  ++source.place.line;
  line = line.substr(0, line.find('$'));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

/// Continues at the statement BEGIN BULK if there is one: statements before it may be like cards.
void NastranCards::skip_control(Source& source) {
  Source ahead = source;
  std::string_view line;
  for (Source before = ahead; next_line(ahead, line); before = ahead) {
    const std::string word = first_word(line);
    if (word == "ENDDATA") break;
    if (word == "BEGIN") {
      source = before;
      return;
    }
    has_control_ = has_control_ || !trimmed(line).empty();
  }
  has_control_ = false;
}

void NastranCards::read_line(Source& source, std::string_view line) {
  if (first_word(line) == "INCLUDE") return include(source, line);
  const bool is_free = line.find(',') != std::string_view::npos;
  const bool has_tabs = !is_free && line.find('\t') != std::string_view::npos;
  std::string expanded = has_tabs ? without_tabs(line) : std::string();
  const bool continues = NastranLine(has_tabs ? expanded : line).is_continuation();
  if (!continues) flush();
  if (has_tabs) line = expanded_.emplace_back(std::move(expanded));
  if (continues) return continue_card(line);
  start_card(line);
}

void NastranCards::start_card(std::string_view line) {
  const NastranLine parsed(line);
  const std::string word = first_word(line);
  if (word == "ENDDATA") {
    has_end_ = true;
    return;
  }
  if (word == "BEGIN") return begin_bulk();
  if (parsed.first().starts_with('=')) {
    fail(here_, "a line that repeats the card before it (" + nastran_shown(parsed.first()) +
                    ") is not read; write its cards out");
  }
  card_.name = parsed.name();
  card_.place = here_;
  const std::size_t blank = card_.name.find(' ');
  if (blank != std::string::npos) {
    if (is_read_(card_.name.substr(0, blank))) {
      fail(here_, "the fields of this line are neither 8 columns wide nor separated by commas");
    }
    card_.name.resize(blank);
  }
  if (!is_read_(card_.name)) {
    state_ = State::in_ignored;
    const std::string shown = nastran_shown(card_.name);
    if (names_.insert(shown).second) ignored_.push_back(shown);
    return;
  }
  state_ = State::in_card;
  has_cards_ = true;
  add_fields(line);
}

void NastranCards::begin_bulk() {
  if (has_cards_ || has_begin_) {
    fail(here_, "a second BEGIN: the parts of a model with superelements are not read; write it as one model");
  }
  has_begin_ = true;
  // The cards before, as from an included file, were other statements.
  has_control_ = has_control_ || !ignored_.empty();
  ignored_.clear();
  names_.clear();
  state_ = State::outside;
}

void NastranCards::continue_card(std::string_view line) {
  if (state_ == State::in_ignored) return;
  if (state_ == State::outside) fail(here_, "this line continues a card, and there is none before it");
  const std::string_view before = card_.marker_name;
  const std::string_view after = NastranLine(line).continued_name();
  if (!before.empty() && !after.empty() && in_upper_case(before) != in_upper_case(after)) {
    fail(here_, "this line continues a card that ends with +" + nastran_shown(after) +
                    ", and the one before it ends with +" + nastran_shown(before) + "; put it below its card");
  }
  add_fields(line);
}

void NastranCards::add_fields(std::string_view line) {
  const NastranLine parsed(line);
  if (parsed.is_too_long()) {
    fail(here_, "this line has more than " + std::to_string(parsed.size()) +
                    " fields after the first; continue it in a line that starts with a comma");
  }
  if (!parsed.is_large() && card_.fields.size() % 8 != 0) {
    fail(here_, "a line of large fields has no second half before this line; start it with *");
  }
  card_.marker = parsed.marker();
  card_.marker_name = parsed.marker_name();
  if (card_.fields.size() >= kMaxCardFields) return;
  for (std::size_t k = 0; k < parsed.size(); ++k) card_.fields.push_back(parsed.field(k));
}

void NastranCards::flush() {
  if (state_ == State::in_card) take_(card_);
  state_ = State::outside;
  card_.fields.clear();
  card_.marker = card_.marker_name = {};
  expanded_.clear();
}

void NastranCards::include(Source& source, std::string_view line) {
  flush();
  const NastranPlace where = here_;
  constexpr std::size_t kWord = std::string_view("INCLUDE").size();
  // The name may go on in further lines up to the quotation mark.
  std::string_view rest = trimmed(line).substr(kWord);
  std::string name(trimmed(rest));
  const char quote = name.empty() ? '\0' : name[0];
  if (quote == '\'' || quote == '"') {
    name.erase(0, 1);
    while (name.find(quote) == std::string::npos) {
      if (!next_line(source, rest)) fail(where, "the name of the included file has no quotation mark at its end");
      name += trimmed(rest);
    }
    name.resize(name.find(quote));
  }
  name = trimmed(name);
  if (name.empty()) fail(where, "INCLUDE has no name of a file");
  if (stack_.size() >= kMaxIncludeDepth || files_.size() >= kMaxIncludedFiles) {
    fail(where, "there are too many included files");
  }
  const std::string path = included_path(name, stack_.back());
  if (!is_file(path)) fail(where, "the included file " + path + " does not exist");
  if (std::find(stack_.begin(), stack_.end(), path) != stack_.end()) fail(where, path + " includes itself");
  read_file(path);
  here_ = where;
}

/// The file of that name in the folder of the file that includes it, or else of the first file.
std::string NastranCards::included_path(const std::string& name, const std::string& file) const {
  std::string with_slashes = name;
  std::replace(with_slashes.begin(), with_slashes.end(), '\\', '/');
  const auto in_folder_of = [](const std::string& of, const std::string& relative) {
    return (path_of(of).parent_path() / path_of(relative)).lexically_normal().string();
  };
  for (const std::string& written : {name, with_slashes}) {
    for (const std::string& of : {file, path_}) {
      const std::string path = in_folder_of(of, written);
      if (is_file(path)) return path;
    }
  }
  return in_folder_of(file, name);
}

}  // namespace tetune
