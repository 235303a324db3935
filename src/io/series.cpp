// SPDX-License-Identifier: Apache-2.0
#include "tetune/series.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "backend/span.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "system/file.hpp"
#include "system/path.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune {
namespace {

constexpr std::array<std::pair<char, std::string_view>, 5> kEntities{
    {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}}};

struct Attribute {
  std::string_view name;
  std::string value;
};

/// An XML tag; a closing one has no attributes.
struct Tag {
  std::string_view name;
  std::vector<Attribute> attributes;
  bool closes = false;    ///< </name>
  bool is_empty = false;  ///< <name/>

  const std::string* find(std::string_view attribute) const {
    for (const Attribute& a : attributes) {
      if (a.name == attribute) return &a.value;
    }
    return nullptr;
  }
};

/// The treatment of text between elements.
enum class TextBetween { fails, is_skipped };

/// Reads the tags of the part of XML that collections use: elements with attributes, comments and a declaration.
class TagReader {
 public:
  TagReader(std::string path, std::string_view text, TextBetween between = TextBetween::fails)
      : path_(std::move(path)), text_(text), between_(between) {}

  [[noreturn]] void fail(const std::string& reason) const {
    const std::string_view before = text_.substr(0, at_);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    throw FileError(path_ + ":" + std::to_string(line) + ": " + reason);
  }

  /// Whether there is another tag; skips comments and declarations before it.
  bool has_next() {
    if (at_ == 0 && text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    for (;;) {
      if (between_ == TextBetween::is_skipped) {
        at_ = std::min(text_.find('<', at_), text_.size());
      } else {
        skip_space();
      }
      if (at_ == text_.size()) return false;
      if (skip("<!--")) {
        skip_to("-->", "a comment does not end");
      } else if (skip("<?")) {
        skip_to("?>", "a declaration does not end");
      } else {
        return true;
      }
    }
  }

  Tag next() {
    if (!has_next()) fail("the file ends early");
    if (!skip("<")) fail("expected an element; a collection has no text between elements");
    Tag tag;
    tag.closes = skip("/");
    tag.name = name();
    skip_space();
    while (!skip(">")) {
      if (!tag.closes && skip("/>")) {
        tag.is_empty = true;
        break;
      }
      if (tag.closes) fail("expected > at the end of </" + std::string(tag.name));
      tag.attributes.push_back(attribute(tag));
      skip_space();
    }
    return tag;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  bool skip(std::string_view expected) {
    if (!text_.substr(at_).starts_with(expected)) return false;
    at_ += expected.size();
    return true;
  }
  void skip_to(std::string_view end, const char* otherwise) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) fail(otherwise);
    at_ = found + end.size();
  }
  std::string_view name() {
    const std::size_t start = at_;
    const auto belongs = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
             c == ':' || c == '.';
    };
    while (at_ < text_.size() && belongs(text_[at_])) ++at_;
    if (at_ == start) fail("expected a name");
    return text_.substr(start, at_ - start);
  }
  Attribute attribute(const Tag& tag) {
    Attribute result{name(), {}};
    if (tag.find(result.name) != nullptr) fail("the attribute " + std::string(result.name) + " is given twice");
    skip_space();
    if (!skip("=")) fail("expected = after " + std::string(result.name));
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'') fail("the value of " + std::string(result.name) + " has no quotes");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) fail("the value of " + std::string(result.name) + " does not end");
    result.value = decoded(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return result;
  }
  std::string decoded(std::string_view text) const {
    std::string result;
    while (!text.empty()) {
      if (text.starts_with("&#")) {
        const std::size_t end = text.find(';');
        if (end == std::string_view::npos) fail("a character reference has no ; at its end");
        result += character(text.substr(2, end - 2));
        text.remove_prefix(end + 1);
        continue;
      }
      const auto* entity = std::find_if(kEntities.begin(), kEntities.end(),
                                        [text](const auto& e) { return text.starts_with(e.second); });
      if (entity == kEntities.end() && (text[0] == '&' || text[0] == '<')) {
        fail("in a value, " + std::string(1, text[0]) + " is written " + (text[0] == '&' ? "&amp;" : "&lt;"));
      }
      result += entity == kEntities.end() ? text[0] : entity->first;
      text.remove_prefix(entity == kEntities.end() ? 1 : entity->second.size());
    }
    return result;
  }

  /// The character of a reference &#N; or &#xN;, in UTF-8.
  std::string character(std::string_view digits) const {
    const int base = digits.starts_with('x') ? 16 : 10;
    if (base == 16) digits.remove_prefix(1);
    std::uint32_t code = 0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, base);
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    if (error != std::errc() || stop != digits.data() + digits.size() || code == 0 || code > 0x10FFFF || is_surrogate) {
      fail("&#" + std::string(digits) + "; stands for no character");
    }
    if (code < 0x80) return {char(code)};
    std::string bytes;
    for (; code >= (bytes.empty() ? 0x40u : 0x40u >> bytes.size()); code >>= 6) {
      bytes.insert(bytes.begin(), char(0x80 | (code & 0x3F)));
    }
    bytes.insert(bytes.begin(), char((0xFF00 >> (bytes.size() + 1) & 0xFF) | code));
    return bytes;
  }

  const std::string path_;
  const std::string_view text_;
  const TextBetween between_;
  std::size_t at_ = 0;
};

std::string encoded(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto* entity = std::find_if(kEntities.begin(), kEntities.end(), [c](const auto& e) { return e.first == c; });
    if (entity == kEntities.end()) {
      result += c;
    } else {
      result += entity->second;
    }
  }
  return result;
}

SeriesStep read_step(const TagReader& reader, const Tag& tag, const std::filesystem::path& folder) {
  const std::string* time = tag.find("timestep");
  const std::string* file = tag.find("file");
  if (time == nullptr) reader.fail("a DataSet has no timestep");
  if (file == nullptr || file->empty()) reader.fail("a DataSet names no file");
  SeriesStep step;
  const char* const end = time->data() + time->size();
  const auto [stop, error] = parse_real(time->data(), end, step.time);
  if (error != std::errc() || stop != end || !std::isfinite(step.time)) {
    reader.fail("the timestep \"" + *time + "\" is not a finite number");
  }
  step.path = (folder / path_of(*file)).string();
  return step;
}

/// The children of the element Collection.
std::vector<SeriesStep> read_collection(TagReader& reader, const std::filesystem::path& folder) {
  std::vector<SeriesStep> steps;
  for (Tag tag = reader.next(); !tag.closes || tag.name != "Collection"; tag = reader.next()) {
    if (tag.name != "DataSet" || tag.closes)
      reader.fail(std::string("<").append(tag.name).append("> in a collection; expected <DataSet> or </Collection>"));
    steps.push_back(read_step(reader, tag, folder));
    if (steps.size() > 1 && !(steps[steps.size() - 2].time < steps.back().time)) {
      reader.fail(steps[steps.size() - 2].time == steps.back().time
                      ? "a time has several files; a series of one mesh has one file per time"
                      : "the times do not increase");
    }
    if (tag.is_empty) continue;
    const Tag end = reader.next();
    if (!end.closes || end.name != "DataSet") reader.fail("expected </DataSet>");
  }
  return steps;
}

}  // namespace

std::vector<std::string> vtk_pieces(const std::string& path) {
  const MappedFile file(path);
  TagReader reader(path, file.bytes(), TextBetween::is_skipped);
  std::vector<std::string> pieces;
  while (reader.has_next()) {
    const Tag tag = reader.next();
    const std::string* source = tag.name == "Piece" ? tag.find("Source") : nullptr;
    if (source != nullptr) pieces.push_back((path_of(path).parent_path() / path_of(*source)).string());
  }
  return pieces;
}

std::vector<SeriesStep> parse_series(const std::string& path, std::string_view bytes) {
  TagReader reader(path, bytes);
  const auto expect = [&reader](const Tag& tag, const std::string& written) {
    if (std::string(tag.closes ? "</" : "<").append(tag.name).append(">") == written) return;
    reader.fail("expected " + written);
  };
  const Tag file = reader.next();
  expect(file, "<VTKFile>");
  const std::string* type = file.find("type");
  if (type == nullptr || *type != "Collection") {
    reader.fail("this file of VTK is not a collection (type=\"Collection\")");
  }
  const Tag collection = reader.next();
  expect(collection, "<Collection>");
  std::vector<SeriesStep> steps;
  if (!file.is_empty && !collection.is_empty) steps = read_collection(reader, path_of(path).parent_path());
  if (steps.empty()) reader.fail("the collection lists no file");
  expect(reader.next(), "</VTKFile>");
  if (reader.has_next()) reader.fail("there is more after </VTKFile>");
  return steps;
}

std::vector<SeriesStep> read_series(const std::string& path) {
  if (!has_times(path)) return parse_series(path, MappedFile(path).bytes());
  std::vector<SeriesStep> steps;
  for (const double time : read_times(path)) steps.push_back({time, path, to_index(std::ssize(steps)) + 1});
  if (steps.empty()) throw FileError(path + ": the file has no times");
  const auto later = [](const SeriesStep& a, const SeriesStep& b) { return !(a.time < b.time); };
  if (std::adjacent_find(steps.begin(), steps.end(), later) != steps.end()) {
    throw FileError(path + ": the times do not increase");
  }
  return steps;
}

TetMesh read_step(const SeriesStep& step, std::vector<std::string>* warnings, int threads) {
  return read_mesh_at(step.path, step.number, {threads, warnings});
}

bool has_times(const std::string& path) {
  const std::string ending = ending_of(path);
  return std::any_of(formats().begin(), formats().end(),
                     [&ending](const Format& f) { return f.has_times && f.has_ending(ending); });
}

void write_series(const std::string& path, const std::vector<SeriesStep>& steps) {
  if (steps.empty()) throw FileError(path + ": the series lists no file");
  // Readers take relative names from the folder of the .pvd file.
  const std::filesystem::path folder = std::filesystem::absolute(path_of(path)).parent_path().lexically_normal();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!std::isfinite(steps[i].time) || (i > 0 && !(steps[i - 1].time < steps[i].time))) {
      throw FileError(path + ": the times of a series must be finite and increase");
    }
  }
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n";
  for (const SeriesStep& step : steps) {
    std::filesystem::path file = path_of(step.path);
    const std::filesystem::path full = std::filesystem::absolute(file).lexically_normal();
    if (file.is_relative() || full.parent_path() == folder) file = full.lexically_relative(folder);
    std::array<char, 32> time{};
    const auto end = print_real(time.data(), time.data() + time.size(), step.time).ptr;
    text += "    <DataSet timestep=\"" + std::string(time.data(), end) + "\" part=\"0\" file=\"" +
            encoded(file.generic_string()) + "\"/>\n";
  }
  write_text(path, text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace tetune
