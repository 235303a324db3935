// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "io/io_context.hpp"
#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

/// The MEDIT format: its sections, and the layout of binary files (libMeshb's, versions 1 to 4). Shared by the readers
/// and writers of whole meshes and those of tetune-mpi, in which each rank has a part of every section.
///
/// A binary file is: the number 1, which shows the byte order, and the version, each of 32 bits; then sections, each of
/// a code of 32 bits, the position of the next section, and its body. The body of a list is the number of entries, then
/// the entries. Ids count from 1.
namespace tetune {

/// A section of a MEDIT file that tetune keeps: its name in text, its code in binary.
struct MeditSection {
  std::string_view name;
  int code;
  int vertices;  ///< per element; 0: a list of ids
};

inline constexpr int kMeditDimension = 3;
inline constexpr int kMeditEnd = 54;
inline constexpr MeditSection kMeditVertices{"Vertices", 4, 1};

/// Elements that TetMesh has arrays for.
inline constexpr MeditSection kMeditEdges{"Edges", 5, 2};
inline constexpr MeditSection kMeditTriangles{"Triangles", 6, 3};
inline constexpr MeditSection kMeditTetrahedra{"Tetrahedra", 8, 4};

/// Elements that are kept as ElementBlock.
inline constexpr std::array<MeditSection, 4> kMeditOthers{{
    {"Quadrilaterals", 7, 4},
    {"Pyramids", 49, 5},
    {"Prisms", 9, 6},
    {"Hexahedra", 10, 8},
}};

/// Lists of ids.
inline constexpr MeditSection kMeditCorners{"Corners", 13, 0};
inline constexpr MeditSection kMeditRequiredVertices{"RequiredVertices", 15, 0};
inline constexpr MeditSection kMeditRidges{"Ridges", 14, 0};
inline constexpr MeditSection kMeditRequiredEdges{"RequiredEdges", 16, 0};
inline constexpr MeditSection kMeditRequiredTriangles{"RequiredTriangles", 17, 0};
inline constexpr MeditSection kMeditRequiredTetrahedra{"RequiredTetrahedra", 12, 0};
inline constexpr MeditSection kMeditRequiredQuadrilaterals{"RequiredQuadrilaterals", 18, 0};

/// A list of ids and the member of TetMesh that holds it, in the order in which they are written.
struct MeditList {
  MeditSection section;
  std::vector<Index> TetMesh::*ids;
};
inline constexpr std::array<MeditList, 6> kMeditLists{{
    {kMeditCorners, &TetMesh::corners},
    {kMeditRequiredVertices, &TetMesh::required_vertices},
    {kMeditRidges, &TetMesh::ridges},
    {kMeditRequiredEdges, &TetMesh::required_edges},
    {kMeditRequiredTriangles, &TetMesh::required_triangles},
    {kMeditRequiredTetrahedra, &TetMesh::required_tets},
}};

/// Warns of the contents that a MEDIT file cannot hold.
TETUNE_API void warn_of_losses_in_medit(const TetMesh& mesh, const IoContext& context);

/// The widths and the byte order of the numbers of a binary file.
struct MeditEncoding {
  int version = 2;
  bool swapped = false;  ///< the file is of the other byte order than this machine

  int real_bytes() const { return version == 1 ? 4 : 8; }
  /// The width of ids, references and numbers of entries.
  int integer_bytes() const { return version == 4 ? 8 : 4; }
  int position_bytes() const { return version >= 3 ? 8 : 4; }
  std::int64_t entry_bytes(int reals, int integers) const {
    return std::int64_t{real_bytes()} * reals + std::int64_t{integer_bytes()} * integers;
  }

  /// Decodes a number and advances `from` past it.
  double real(const char*& from) const { return version == 1 ? double{take<float>(from)} : take<double>(from); }
  std::int64_t integer(const char*& from) const { return signed_number(from, integer_bytes()); }
  std::int64_t signed_number(const char*& from, int bytes) const {
    return bytes == 8 ? take<std::int64_t>(from) : std::int64_t{take<std::int32_t>(from)};
  }

  /// Encodes a number in this machine's byte order and advances `to` past it.
  static void put_real(char*& to, double value) { put(to, value); }
  void put_integer(char*& to, std::int64_t value) const { put_signed(to, value, integer_bytes()); }
  static void put_signed(char*& to, std::int64_t value, int bytes) {
    if (bytes == 8) {
      put(to, value);
    } else {
      put(to, static_cast<std::int32_t>(value));
    }
  }

  /// The encoding that holds ids up to `largest_id` in a file of at most `bytes` bytes: positions are 32 bits wide in
  /// version 2, ids in versions 2 and 3.
  static MeditEncoding for_writing(std::int64_t largest_id, std::int64_t bytes) {
    return {largest_id > 0x7fffffff ? 4 : bytes > 2'000'000'000 ? 3 : 2};
  }
  /// The code of a section and the position of the next one, for a section at `position` with a body of `body_bytes`.
  std::string section_head(int code, std::int64_t position, std::int64_t body_bytes) const {
    return words({{code, 4}, {position + 4 + position_bytes() + body_bytes, position_bytes()}});
  }
  /// The first bytes of a file, with the section of the dimension.
  std::string file_head() const {
    return words({{1, 4}, {version, 4}}) + section_head(kMeditDimension, 8, 4) + words({{3, 4}});
  }
  /// The section that ends a file.
  std::string file_end() const { return words({{kMeditEnd, 4}, {0, position_bytes()}}); }

 private:
  template <class T>
  T take(const char*& from) const {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), from, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    from += sizeof(T);
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  template <class T>
  static void put(char*& to, T value) {
    std::memcpy(to, &value, sizeof value);
    to += sizeof value;
  }
  struct Word {
    std::int64_t value;
    int bytes;
  };
  static std::string words(std::initializer_list<Word> list) {
    std::array<char, 16> buffer;
    char* to = buffer.data();
    for (const Word& w : list) put_signed(to, w.value, w.bytes);
    return {buffer.data(), to};
  }
};

inline constexpr const char* kMeditNoEnd = ": the section End is missing; the file may be cut short";

/// The warning of a section of a binary file that readers skip.
inline void warn_of_skipped_section(const std::string& path, int code, const IoContext& context) {
  context.warn(path + ": section with code " + std::to_string(code) + " is not kept by tetune; skipped");
}

/// The sections of a binary file, in the order of the file. `Source` has these members:
///   std::int64_t size() const                                         bytes of the file
///   void read_at(std::int64_t position, char* to, std::int64_t n)      n bytes that are in the file
///   [[noreturn]] void fail_at(std::int64_t position, const std::string& text)
template <class Source>
class MeditTable {
 public:
  struct Section {
    int code;
    std::int64_t begin, end;  ///< positions of the body
    bool is_last;             ///< nothing follows, and `end` is that of the file
  };

  explicit MeditTable(Source& source) : source_(source) {
    const std::int64_t mark = number_at(0, 4);
    encoding_.swapped = mark == 16777216;
    if (mark != 1 && !encoding_.swapped) source.fail_at(4, "this is not a MEDIT mesh, neither in text nor binary");
    const std::int64_t version = number_at(4, 4);
    if (version < 1 || version > 4) {
      source.fail_at(8, "version " + std::to_string(version) + " is not one of 1 to 4");
    }
    encoding_.version = static_cast<int>(version);
    for (std::int64_t at = 8; !is_complete_ && at + 4 <= source.size();) {
      const auto code = static_cast<int>(number_at(at, 4));
      is_complete_ = code == kMeditEnd;
      if (is_complete_) break;
      const std::int64_t next = number_at(at + 4, encoding_.position_bytes());
      const std::int64_t begin = at + 4 + encoding_.position_bytes();
      if (next != 0 && (next < begin || next > source.size())) {
        source.fail_at(begin, std::string("a section points to a place outside the file") +
                                  (next > source.size() ? ", which may be cut off" : ""));
      }
      is_complete_ = next == 0;
      sections_.push_back({code, begin, next == 0 ? source.size() : next, next == 0});
      at = next;
    }
  }

  const MeditEncoding& encoding() const { return encoding_; }
  const std::vector<Section>& sections() const { return sections_; }
  const Section* find(int code) const {
    const auto at =
        std::find_if(sections_.begin(), sections_.end(), [code](const Section& s) { return s.code == code; });
    return at == sections_.end() ? nullptr : &*at;
  }
  /// Warns where the section End is missing.
  void warn_of_missing_end(const std::string& path, const IoContext& context) const {
    if (!is_complete_) context.warn(path + kMeditNoEnd);
  }

  /// The dimension is 32 bits wide in every version (libMeshb); some writers of version 4 make it 64 bits wide.
  std::int64_t dimension(const Section& section) const {
    return number_at(section.begin, encoding_.version == 4 && section.end - section.begin == 8 ? 8 : 4);
  }
  /// Returns the number of entries of a list; they start at entries_begin(). Fails where they do not fill the section.
  std::int64_t count(const Section& section, std::string_view name, int reals, int integers) const {
    const std::int64_t n = number_at(section.begin, encoding_.integer_bytes());
    const std::int64_t each = encoding_.entry_bytes(reals, integers);
    if (n < 0 || n > (section.end - entries_begin(section)) / each) {
      source_.fail_at(entries_begin(section), "section " + std::string(name) + " claims " + std::to_string(n) +
                                                  " entries, more than it can hold");
    }
    if (const std::int64_t end = entries_begin(section) + n * each; end != section.end && !section.is_last) {
      source_.fail_at(end,
                      "the entries of a section end here, but the section ends at byte " + std::to_string(section.end));
    }
    return n;
  }
  std::int64_t entries_begin(const Section& section) const { return section.begin + encoding_.integer_bytes(); }

 private:
  std::int64_t number_at(std::int64_t position, int bytes) const {
    if (position + bytes > source_.size()) source_.fail_at(position, "the file ends too early");
    std::array<char, 8> raw;
    source_.read_at(position, raw.data(), bytes);
    const char* from = raw.data();
    return encoding_.signed_number(from, bytes);
  }

  Source& source_;
  MeditEncoding encoding_;
  std::vector<Section> sections_;
  bool is_complete_ = false;
};

}  // namespace tetune
