// SPDX-License-Identifier: Apache-2.0
// MEDIT meshes, text and binary, versions 1 to 4 (libMeshb's format).
#include <atomic>
#include <cstring>
#include <limits>
#include <type_traits>

#include "io/medit_sections.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Numbers of a text file.
class TextSource {
 public:
  TextSource(TextCursor& cursor, int threads) : cursor_(cursor), threads_(threads) {}
  double real() { return cursor_.real("coordinate"); }
  std::int64_t integer(const char* what) { return cursor_.integer(what); }
  /// A length that cannot be true, given what is left of the file, is refused before memory is asked for.
  std::size_t count(std::string_view section, int numbers_each) {
    const std::int64_t n = cursor_.integer("number of entries");
    const std::size_t smallest = 2 * static_cast<std::size_t>(numbers_each);
    if (n < 0) fail("section " + std::string(section) + " claims " + std::to_string(n) + " entries");
    if (static_cast<std::uint64_t>(n) > cursor_.remaining() / smallest + 1) {
      fail("section " + std::string(section) + " claims " + std::to_string(n) +
           " entries, more than the rest of the file can hold");
    }
    return static_cast<std::size_t>(n);
  }
  /// Calls read(source, i) for the n entries that come next.
  template <class Read>
  void entries(std::size_t n, const Read& read) {
    if (n >= kMany && read_lines(n, read)) return;
    for (std::size_t i = 0; i < n; ++i) read(*this, i);
  }
  [[noreturn]] void fail(const std::string& what) const { cursor_.fail(what); }

 private:
  static constexpr std::size_t kMany = 4096;
  static constexpr std::size_t kBytesEach = 1 << 16;

  /// Most programs write an entry a line, so that parts of the lines can be read on all threads. False where some part
  /// does not hold as many entries as lines: reading one after another can say why.
  template <class Read>
  bool read_lines(std::size_t n, const Read& read) {
    std::vector<TextCursor::Lines> parts = cursor_.next_lines(n, kBytesEach);
    if (parts.empty()) return false;
    std::atomic<bool> as_expected = true;
    par::Cpu(threads_).for_parts(static_cast<par::Size>(parts.size()), [&](par::Size p) {
      TextCursor::Lines& lines = parts[static_cast<std::size_t>(p)];
      try {
        TextSource source(lines.cursor, 1);
        for (std::size_t i = lines.first; i < lines.first + lines.count; ++i) read(source, i);
        if (lines.cursor.at_end()) return;
      } catch (const FileError&) {
      }
      as_expected = false;
    });
    if (as_expected) cursor_.go_on_after(parts.back().cursor);
    return as_expected;
  }

  TextCursor& cursor_;
  int threads_;
};

/// Numbers of a binary file.
class BinarySource {
 public:
  BinarySource(std::string path, std::string_view bytes) : path_(std::move(path)), bytes_(bytes) {}

  void open() {
    const auto code = take<std::int32_t>();
    if (code == 16777216) {
      swap_ = true;
    } else if (code != 1) {
      fail("this is not a MEDIT mesh, neither in text nor binary");
    }
    version_ = take<std::int32_t>();
    if (version_ < 1 || version_ > 4) fail("version " + std::to_string(version_) + " is not one of 1 to 4");
  }
  bool at_end() const { return at_ + sizeof(std::int32_t) > bytes_.size(); }
  std::int32_t keyword() { return take<std::int32_t>(); }
  /// Where the next section starts; 0 in the last one.
  std::size_t next_position() {
    const std::int64_t position = version_ >= 3 ? take<std::int64_t>() : take<std::int32_t>();
    const auto from = static_cast<std::int64_t>(at_);
    if (position != 0 && (position < from || position > static_cast<std::int64_t>(bytes_.size()))) {
      fail("a section points to a place outside the file");
    }
    section_end_ = position != 0 ? static_cast<std::size_t>(position) : bytes_.size();
    return static_cast<std::size_t>(position);
  }
  /// Leaves a section for the next one, which must start where this one's entries end.
  void go_to(std::size_t position, bool skipped) {
    if (!skipped && position != at_) {
      fail("the entries of a section end here, but the section ends at byte " + std::to_string(position));
    }
    at_ = position;
  }
  /// 32 bits wide in every version (libMeshb); some writers of version 4 widen it like any other number.
  std::int64_t dimension(std::size_t next) {
    return version_ == 4 && next == at_ + sizeof(std::int64_t) ? take<std::int64_t>() : take<std::int32_t>();
  }

  double real() { return version_ == 1 ? static_cast<double>(take<float>()) : take<double>(); }
  std::int64_t integer(const char*) { return version_ == 4 ? take<std::int64_t>() : take<std::int32_t>(); }
  std::size_t count(std::string_view section, int numbers_each) {
    const std::int64_t n = integer("");
    const std::size_t smallest = (version_ == 4 ? 8 : 4) * static_cast<std::size_t>(numbers_each);
    if (n < 0 || at_ > section_end_ || static_cast<std::uint64_t>(n) > (section_end_ - at_) / smallest) {
      fail("section " + std::string(section) + " claims " + std::to_string(n) + " entries, more than it can hold");
    }
    return static_cast<std::size_t>(n);
  }
  template <class Read>
  void entries(std::size_t n, const Read& read) {
    for (std::size_t i = 0; i < n; ++i) read(*this, i);
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(path_ + ", byte " + std::to_string(at_) + ": " + what);
  }

 private:
  template <class T>
  T take() {
    if (at_ + sizeof(T) > bytes_.size()) fail("the file ends too early");
    unsigned char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at_, sizeof(T));
    if (swap_) std::reverse(raw, raw + sizeof(T));
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  std::string path_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::size_t section_end_ = 0;
  int version_ = 2;
  bool swap_ = false;
};

template <class Source>
class MeditReader {
 public:
  MeditReader(Source& source, TetMesh& mesh) : source_(source), mesh_(mesh) {}

  void set_dimension(std::int64_t dimension) {
    if (dimension != 3) {
      source_.fail("the mesh has dimension " + std::to_string(dimension) +
                   "; tetune takes tetrahedral meshes, dimension 3");
    }
  }

  /// Reads a section by name or code; returns false when it is not one that tetune keeps.
  bool read(std::string_view name, int code) {
    const auto is = [&](const MeditSection& s) { return code != 0 ? s.code == code : s.name == name; };
    if (is(kMeditVertices)) return read_vertices();
    if (is(kMeditEdges)) return read_elements(kMeditEdges, mesh_.edges, mesh_.edge_tags);
    if (is(kMeditTriangles)) return read_elements(kMeditTriangles, mesh_.triangles, mesh_.triangle_tags);
    if (is(kMeditTetrahedra)) return read_elements(kMeditTetrahedra, mesh_.tets, mesh_.tet_tags);
    for (const MeditSection& section : kMeditOthers) {
      if (is(section)) return read_others(section);
    }
    for (const MeditList& list : kMeditLists) {
      if (is(list.section)) return read_list(list.section, mesh_.*list.ids);
    }
    if (is(kMeditRequiredQuadrilaterals)) return read_list(kMeditRequiredQuadrilaterals, required_quads_);
    return false;
  }

  void finish() {
    if (required_quads_.empty()) return;
    for (ElementBlock& block : mesh_.others) {
      if (block.kind != kMeditOthers[0].name) continue;
      block.required = std::move(required_quads_);
      return;
    }
    source_.fail("RequiredQuadrilaterals are listed, but no Quadrilaterals");
  }

 private:
  std::size_t count(const MeditSection& section, int numbers_each) {
    const std::size_t n = source_.count(section.name, numbers_each);
    const std::string excess = too_many(static_cast<std::int64_t>(n), section.code == kMeditTetrahedra.code);
    if (!excess.empty()) source_.fail("section " + std::string(section.name) + " has " + excess);
    return n;
  }
  static Index id(Source& source, std::string_view section) {
    const std::int64_t value = source.integer("id");
    if (value < 1 || value > std::numeric_limits<Index>::max()) {
      source.fail("id " + std::to_string(value) + " in section " + std::string(section) + "; ids count from 1");
    }
    return static_cast<Index>(value - 1);
  }
  static int tag(Source& source) {
    const std::int64_t value = source.integer("reference");
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      source.fail("reference " + std::to_string(value) + " does not fit 32 bits");
    }
    return static_cast<int>(value);
  }

  /// A second section of a kind would silently replace the first.
  template <class T>
  void expect_first(std::string_view section, const std::vector<T>& entries) {
    if (!entries.empty()) source_.fail("section " + std::string(section) + " is there twice");
  }

  bool read_vertices() {
    expect_first(kMeditVertices.name, mesh_.points);
    const std::size_t n = count(kMeditVertices, 4);
    mesh_.points.resize(n);
    mesh_.point_tags.resize(n);
    source_.entries(n, [this](Source& source, std::size_t i) {
      for (double& x : mesh_.points[i]) x = source.real();
      mesh_.point_tags[i] = tag(source);
    });
    return true;
  }

  template <std::size_t N>
  bool read_elements(const MeditSection& section, std::vector<std::array<Index, N>>& elements, std::vector<int>& tags) {
    expect_first(section.name, elements);
    const std::size_t n = count(section, section.vertices + 1);
    elements.resize(n);
    tags.resize(n);
    source_.entries(n, [&](Source& source, std::size_t i) {
      for (Index& v : elements[i]) v = id(source, section.name);
      tags[i] = tag(source);
    });
    return true;
  }

  bool read_others(const MeditSection& section) {
    for (const ElementBlock& block : mesh_.others) {
      if (block.kind == section.name) expect_first(section.name, block.tags);
    }
    const std::size_t n = count(section, section.vertices + 1);
    ElementBlock block;
    block.kind = section.name;
    block.vertices_per_element = section.vertices;
    block.element2vertex.reserve(n * static_cast<std::size_t>(section.vertices));
    block.tags.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (int k = 0; k < section.vertices; ++k) block.element2vertex.push_back(id(source_, section.name));
      block.tags.push_back(tag(source_));
    }
    if (n > 0) mesh_.others.push_back(std::move(block));
    return true;
  }

  bool read_list(const MeditSection& section, std::vector<Index>& ids) {
    expect_first(section.name, ids);
    const std::size_t n = count(section, 1);
    ids.resize(n);
    source_.entries(n, [&](Source& source, std::size_t i) { ids[i] = id(source, section.name); });
    return true;
  }

  Source& source_;
  TetMesh& mesh_;
  std::vector<Index> required_quads_;
};

constexpr const char* kNoEnd = ": the section End is missing; the file may be cut short";

TetMesh parse_text(const std::string& path, std::string_view bytes, const ReadContext& context) {
  constexpr std::string_view kMarkOfUtf8 = "\xEF\xBB\xBF";
  if (bytes.starts_with(kMarkOfUtf8)) bytes.remove_prefix(kMarkOfUtf8.size());
  TextCursor cursor(path, bytes);
  TextSource source(cursor, context.threads);
  TetMesh mesh;
  MeditReader reader(source, mesh);
  std::string_view word = cursor.word();
  if (bytes.empty()) cursor.fail("the file is empty");
  if (word != "MeshVersionFormatted") {
    cursor.fail("this is not a MEDIT mesh: it does not start with MeshVersionFormatted");
  }
  const std::int64_t version = cursor.integer("version");
  if (version < 1 || version > 4) cursor.fail("version " + std::to_string(version) + " is not one of 1 to 4");
  for (word = cursor.word(); !word.empty() && word != "End"; word = cursor.word()) {
    if (word == "Dimension") {
      reader.set_dimension(cursor.integer("dimension"));
    } else if (!reader.read(word, 0)) {
      const char c = word[0];
      if (!((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))) {
        cursor.fail("expected a section name, found \"" + std::string(word.substr(0, 40)) +
                    "\"; the section before it is longer than it says");
      }
      context.warn(path + ": section " + std::string(word.substr(0, 60)) + " is not one that tetune keeps; skipped");
      cursor.skip_numbers();
    }
  }
  if (word.empty()) context.warn(path + kNoEnd);
  reader.finish();
  return mesh;
}

TetMesh parse_binary(const std::string& path, std::string_view bytes, const ReadContext& context) {
  BinarySource source(path, bytes);
  TetMesh mesh;
  MeditReader reader(source, mesh);
  source.open();
  bool ended = false;
  while (!ended && !source.at_end()) {
    const std::int32_t code = source.keyword();
    ended = code == kMeditEnd;
    if (ended) break;
    const std::size_t next = source.next_position();
    bool skipped = false;
    if (code == kMeditDimension) {
      reader.set_dimension(source.dimension(next));
    } else if (!reader.read({}, code)) {
      context.warn(path + ": section with code " + std::to_string(code) + " is not one that tetune keeps; skipped");
      skipped = true;
    }
    ended = next == 0;
    if (!ended) source.go_to(next, skipped);
  }
  if (!ended) context.warn(path + kNoEnd);
  reader.finish();
  return mesh;
}

/// A text has no such byte in its first word; the first number of a binary file, 1, has three in either byte order.
bool is_binary(std::string_view bytes) { return bytes.substr(0, 4).find('\0') != std::string_view::npos; }

bool is_utf16(std::string_view bytes) { return bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"); }

}  // namespace

TetMesh parse_medit(const std::string& name, std::string_view bytes, const ReadContext& context) {
  if (is_utf16(bytes)) throw FileError(name + ": this is text in UTF-16; save it as plain text (UTF-8)");
  return is_binary(bytes) ? parse_binary(name, bytes, context) : parse_text(name, bytes, context);
}

TetMesh read_medit(const std::string& path, const ReadContext& context) {
  return parse_medit(path, MappedFile(path).bytes(), context);
}

}  // namespace tetune
