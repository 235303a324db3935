// SPDX-License-Identifier: Apache-2.0
// MEDIT meshes, text and binary, versions 1 to 4 (libMeshb's format).
#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

#include "backend/cpu.hpp"
#include "io/medit/medit_codec.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Calls read_part(i), which returns whether it has read what it expected, for each i below `parts` on all threads.
/// Returns false where one did not, or found an error: reading in sequence finds the first one, if there is one.
template <class ReadPart>
bool read_parts_on_all_threads(int threads, Size parts, const ReadPart& read_part) {
  std::atomic<bool> as_expected = true;
  backend::Cpu(threads).for_parts(parts, [&](Size part) {
    try {
      if (read_part(part)) return;
    } catch (const FileError&) {
    }
    as_expected = false;
  });
  return as_expected;
}

/// The numbers of a text file.
class TextSource {
 public:
  TextSource(TextCursor& cursor, int threads) : cursor_(cursor), threads_(threads) {}
  double real() { return cursor_.real("coordinate"); }
  std::int64_t integer(const char* name) { return cursor_.integer(name); }
  /// Refuses a count that the rest of the file cannot hold, before memory is asked for.
  std::size_t count(const MeditSection& section, int reals, int integers) {
    const std::int64_t n = cursor_.integer("number of entries");
    const std::int64_t min_bytes = 2 * (reals + integers);
    if (n < 0) fail("section " + std::string(section.name) + " claims " + std::to_string(n) + " entries");
    if (n > cursor_.remaining() / min_bytes + 1) {
      fail("section " + std::string(section.name) + " claims " + std::to_string(n) +
           " entries, more than the rest of the file can hold");
    }
    return to_size_t(n);
  }
  /// Calls read(source, i) for each of the next n entries.
  template <class Read>
  void entries(std::size_t n, const Read& read) {
    if (n >= kMinParallel && read_lines(n, read)) return;
    for (std::size_t i = 0; i < n; ++i) read(*this, i);
  }
  [[noreturn]] void fail(const std::string& text) const { cursor_.fail(text); }

 private:
  static constexpr std::size_t kMinParallel = 4096;
  static constexpr std::size_t kBytesPerPart = 1 << 16;

  /// Most programs write one entry per line, so that ranges of lines can be read on all threads. Returns false where
  /// some range does not hold one entry per line: reading in sequence finds the error, if there is one.
  template <class Read>
  bool read_lines(std::size_t n, const Read& read) {
    std::vector<TextCursor::Lines> parts = cursor_.next_lines(n, kBytesPerPart);
    if (parts.empty()) return false;
    const bool as_expected = read_parts_on_all_threads(threads_, std::ssize(parts), [&](Size part) {
      TextCursor::Lines& lines = span_of(parts)[part];
      TextSource source(lines.cursor, 1);
      for (std::size_t i = lines.first; i < lines.first + lines.count; ++i) read(source, i);
      return lines.cursor.at_end();
    });
    if (as_expected) cursor_.continue_after(parts.back().cursor);
    return as_expected;
  }

  TextCursor& cursor_;
  int threads_;
};

/// The bytes of a binary file in memory, as MeditTable takes them, and the numbers of one of its sections in sequence.
class BinarySource {
 public:
  BinarySource(std::string path, std::string_view bytes, int threads)
      : path_(std::move(path)), bytes_(bytes), threads_(threads) {}

  std::int64_t size() const { return std::ssize(bytes_); }
  void read_at(std::int64_t position, char* to, std::int64_t n) const { std::copy_n(bytes_.begin() + position, n, to); }
  [[noreturn]] void fail_at(std::int64_t position, const std::string& text) const {
    throw FileError(path_ + ", byte " + std::to_string(position) + ": " + text);
  }
  [[noreturn]] void fail(const std::string& text) const { fail_at(next_ - bytes_.data(), text); }

  using Table = MeditTable<const BinarySource>;
  void enter(const Table& table, const Table::Section& section) {
    table_ = &table;
    section_ = &section;
    encoding_ = table.encoding();
    next_ = bytes_.data() + section.begin;
  }
  std::size_t count(const MeditSection& section, int reals, int integers) {
    const std::int64_t n = table_->count(*section_, section.name, reals, integers);
    next_ = bytes_.data() + table_->entries_begin(*section_);
    entry_bytes_ = encoding_.entry_bytes(reals, integers);
    return to_size_t(n);
  }
  double real() { return encoding_.real(next_); }
  std::int64_t integer(const char*) { return encoding_.integer(next_); }
  template <class Read>
  void entries(std::size_t n, const Read& read) {
    if (n > kEntriesPerPart && read_parts(n, read)) return;
    for (std::size_t i = 0; i < n; ++i) read(*this, i);
  }

 private:
  static constexpr std::size_t kEntriesPerPart = 1 << 13;

  /// Reads the entries on all threads. Returns false where one of them is wrong: reading in sequence finds the first.
  template <class Read>
  bool read_parts(std::size_t n, const Read& read) {
    const auto parts = Size((n + kEntriesPerPart - 1) / kEntriesPerPart);
    const bool as_expected = read_parts_on_all_threads(threads_, parts, [&](Size part) {
      const std::size_t first = to_size_t(part) * kEntriesPerPart;
      BinarySource source = *this;
      source.next_ += std::int64_t(first) * entry_bytes_;
      for (std::size_t i = first; i < std::min(n, first + kEntriesPerPart); ++i) read(source, i);
      return true;
    });
    if (as_expected) next_ += std::int64_t(n) * entry_bytes_;
    return as_expected;
  }

  std::string path_;
  std::string_view bytes_;
  int threads_;
  const char* next_ = bytes_.data();
  std::int64_t entry_bytes_ = 0;
  MeditEncoding encoding_;
  const Table* table_ = nullptr;
  const Table::Section* section_ = nullptr;
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

  /// Reads a section by name, or by code where that is not 0; returns false when tetune does not keep such sections.
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
  std::size_t count(const MeditSection& section, int reals, int integers) {
    const std::size_t n = source_.count(section, reals, integers);
    const std::string excess =
        excess_of(std::int64_t(n), section.code == kMeditTetrahedra.code ? kMaxTets : kMaxEntries);
    if (!excess.empty()) source_.fail("section " + std::string(section.name) + " has " + excess);
    return n;
  }
  static Index id(Source& source, std::string_view section) {
    const std::int64_t value = source.integer("id");
    if (value < 1 || value > std::numeric_limits<Index>::max()) {
      source.fail("id " + std::to_string(value) + " in section " + std::string(section) +
                  "; ids count from 1 and are below 2^31");
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

  /// Refuses a second section of a kind, which would replace the first silently.
  template <class T>
  void expect_first(std::string_view section, const std::vector<T>& entries) {
    if (!entries.empty()) source_.fail("section " + std::string(section) + " occurs twice");
  }

  bool read_vertices() {
    expect_first(kMeditVertices.name, mesh_.points);
    const std::size_t n = count(kMeditVertices, 3, 1);
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
    const std::size_t n = count(section, 0, section.vertices + 1);
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
    const std::size_t n = count(section, 0, section.vertices + 1);
    ElementBlock block{std::string(section.name), section.vertices, {}, {}, {}};
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
    const std::size_t n = count(section, 0, 1);
    ids.resize(n);
    source_.entries(n, [&](Source& source, std::size_t i) { ids[i] = id(source, section.name); });
    return true;
  }

  Source& source_;
  TetMesh& mesh_;
  std::vector<Index> required_quads_;
};

TetMesh parse_text(const std::string& path, std::string_view bytes, const IoContext& context) {
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
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
      if (!TextCursor::is_letter(word[0])) {
        cursor.fail("expected a section name, found \"" + printable(word.substr(0, 40)) +
                    "\"; the section before it is longer than it says");
      }
      context.warn(path + ": section " + printable(word.substr(0, 60)) + " is not kept by tetune; skipped");
      cursor.skip_numbers();
    }
  }
  if (word.empty()) context.warn(path + kMeditNoEnd);
  reader.finish();
  return mesh;
}

TetMesh parse_binary(const std::string& path, std::string_view bytes, const IoContext& context) {
  BinarySource source(path, bytes, context.threads);
  const MeditTable table(std::as_const(source));
  TetMesh mesh;
  MeditReader reader(source, mesh);
  for (const auto& section : table.sections()) {
    source.enter(table, section);
    if (section.code == kMeditDimension) {
      reader.set_dimension(table.dimension(section));
    } else if (!reader.read({}, section.code)) {
      warn_of_skipped_section(path, section.code, context);
    }
  }
  table.warn_of_missing_end(path, context);
  reader.finish();
  return mesh;
}

/// The first word of a text has no zero byte; the first number of a binary file, 1, has three in either byte order.
bool is_binary(std::string_view bytes) { return bytes.substr(0, 4).find('\0') != std::string_view::npos; }

bool is_utf16(std::string_view bytes) { return bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"); }

}  // namespace

TetMesh parse_medit(const std::string& name, std::string_view bytes, const IoContext& context) {
  if (is_utf16(bytes)) throw FileError(name + ": this is text in UTF-16; save it as plain text (UTF-8)");
  return is_binary(bytes) ? parse_binary(name, bytes, context) : parse_text(name, bytes, context);
}

TetMesh read_medit(const std::string& path, const IoContext& context) {
  return parse_medit(path, MappedFile(path).bytes(), context);
}

}  // namespace tetune
