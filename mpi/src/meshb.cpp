// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <system_error>

#include "files.hpp"
#include "io/medit/medit_codec.hpp"
#include "shared_temporary.hpp"
#include "star_forest.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

/// MEDIT binary files (docs/formats.md, "MEDIT"), of which each rank reads and writes a part of every section.
namespace tetune::mpi {
namespace {

/// A file as MeditTable takes it.
class FileSource {
 public:
  explicit FileSource(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw FileError(path + ": cannot be opened: " + std::strerror(errno));
    std::error_code error;
    size_ = std::int64_t(std::filesystem::file_size(path, error));
    if (error) throw FileError(path + ": cannot be read: " + error.message());
  }
  const std::string& path() const { return path_; }
  std::int64_t size() const { return size_; }
  void read_at(std::int64_t position, char* to, std::int64_t bytes) {
    file_.seekg(position);
    if (!file_.read(to, bytes)) fail_at(position, "the file ends too early");
  }
  [[noreturn]] void fail_at(std::int64_t position, const std::string& text) const {
    throw FileError(path_ + ", byte " + std::to_string(position) + ": " + text);
  }

 private:
  std::string path_;
  std::ifstream file_;
  std::int64_t size_ = 0;
};

class Reader {
 public:
  explicit Reader(const std::string& path) : source_(path), table_(source_) {
    for (const auto& section : table_.sections()) {
      if (table_.find(section.code) != &section) {
        source_.fail_at(section.begin, "section " + std::to_string(section.code) + " occurs twice");
      }
    }
  }

  /// Warns of sections that are not read, and of a missing end.
  void warn_of_the_rest(const IoContext& context) const {
    std::set<int> codes{kMeditDimension, kMeditVertices.code, kMeditEdges.code, kMeditTriangles.code,
                        kMeditTetrahedra.code};
    for (const MeditList& list : kMeditLists) codes.insert(list.section.code);
    for (const auto& section : table_.sections()) {
      if (!codes.contains(section.code)) warn_of_skipped_section(source_.path(), section.code, context);
    }
    table_.warn_of_missing_end(source_.path(), context);
  }

  const MeditEncoding& encoding() const { return table_.encoding(); }
  bool has(const MeditSection& section) const { return table_.find(section.code) != nullptr; }
  std::int64_t dimension() const {
    const auto* section = table_.find(kMeditDimension);
    return section == nullptr ? 0 : table_.dimension(*section);
  }

  /// Returns the number of entries of a list, 0 where the file lacks it.
  std::int64_t count(const MeditSection& section, int reals = 0) const {
    const auto* found = table_.find(section.code);
    return found == nullptr ? 0 : table_.count(*found, section.name, reals, integers_of(section));
  }

  /// Calls entry(i, reals, integers) for the entries [first, last) of a list.
  template <class F>
  void read(const MeditSection& section, int reals, std::int64_t first, std::int64_t last, F entry) {
    if (last <= first) return;
    const int integers = integers_of(section);
    const std::int64_t each = encoding().entry_bytes(reals, integers);
    position_ = table_.entries_begin(*table_.find(section.code)) + first * each;
    constexpr std::int64_t kChunk = 1 << 16;
    std::vector<char> bytes(std::size_t(std::min(kChunk, last - first) * each));
    std::array<double, 3> x{};
    std::array<std::int64_t, 5> n{};
    for (std::int64_t i = first; i < last;) {
      const std::int64_t end = std::min(i + kChunk, last);
      source_.read_at(position_, bytes.data(), (end - i) * each);
      const char* from = bytes.data();
      for (; i < end; ++i, position_ += each) {
        for (int k = 0; k < reals; ++k) item(x, k) = encoding().real(from);
        for (int k = 0; k < integers; ++k) item(n, k) = encoding().integer(from);
        entry(i, x, n);
      }
    }
  }

  int checked_tag(std::int64_t tag) const {
    if (tag != int(tag)) fail("a tag does not fit 32 bits: " + std::to_string(tag));
    return int(tag);
  }
  Id checked_id(std::int64_t id, Id count) const {
    if (id < 1 || id > count) fail("id " + std::to_string(id) + " is not one of 1 to " + std::to_string(count));
    return id - 1;
  }

 private:
  static int integers_of(const MeditSection& section) {
    return section.code == kMeditVertices.code ? 1 : section.vertices + 1;
  }
  [[noreturn]] void fail(const std::string& text) const { source_.fail_at(position_, text); }

  FileSource source_;
  MeditTable<FileSource> table_;
  std::int64_t position_ = 0;  ///< of the entry that is read
};

template <std::size_t N>
std::vector<Element<N>> read_elements(Reader& reader, const MeditSection& section, Id count, Id vertices,
                                      const Blocks& blocks, int rank) {
  std::vector<Element<N>> elements;
  reader.read(section, 0, blocks.begin(rank), std::min(count, blocks.begin(rank + 1)),
              [&](std::int64_t i, const auto&, const auto& n) {
                Element<N> e{i, {}, reader.checked_tag(n[N]), 0};
                for (std::size_t k = 0; k < N; ++k) e.v[k] = reader.checked_id(n[k], vertices);
                elements.push_back(e);
              });
  return elements;
}

/// Sets a flag of the entities in a list of ids. Each rank reads a part of the list and sends each id to the owner rank
/// of its entity.
template <class T>
void add_flags(MPI_Comm comm, std::optional<Reader>& reader, const MeditSection& section, int flag, Id count,
               std::vector<T>& entities) {
  const Blocks blocks(count, size_of(comm));
  std::vector<Id> ids;
  collective_try(comm, [&] {
    const Blocks parts(reader->count(section), size_of(comm));
    const int rank = rank_of(comm);
    reader->read(section, 0, parts.begin(rank), parts.begin(rank + 1),
                 [&](std::int64_t, const auto&, const auto& n) { ids.push_back(reader->checked_id(n[0], count)); });
  });
  std::vector<int> to;
  for (const Id id : ids) to.push_back(blocks.owner(id));
  for (const Id id : Route(comm, to).send(ids)) item(entities, id - blocks.begin(rank_of(comm))).flags |= flag;
}

}  // namespace

bool is_meshb(const std::string& path) { return ending_of(path) == ".meshb"; }

bool is_plain_meshb(const std::string& path) {
  if (!is_meshb(path)) return false;
  try {
    const Reader reader(path);
    const bool has_others = std::any_of(kMeditOthers.begin(), kMeditOthers.end(),
                                        [&reader](const MeditSection& section) { return reader.has(section); });
    const MeditEncoding& encoding = reader.encoding();
    return !has_others && !reader.has(kMeditRequiredQuadrilaterals) && encoding.version >= 2 && !encoding.swapped;
  } catch (const FileError&) {
    return false;  // read_mesh() reports the error
  }
}

Input read_meshb(MPI_Comm comm, const std::string& path) {
  const int rank = rank_of(comm);
  const int ranks = size_of(comm);
  Input input;
  std::optional<Reader> reader;
  Totals& all = input.totals;
  Pieces& pieces = input.pieces;
  collective_try(comm, [&] {
    reader.emplace(path);
    if (reader->dimension() != 3) throw FileError(path + ": the dimension is not 3");
    reader->warn_of_the_rest({0, &input.warnings});
    all = {reader->count(kMeditVertices, 3), reader->count(kMeditTetrahedra), reader->count(kMeditTriangles),
           reader->count(kMeditEdges)};
    const Blocks blocks(all.vertices, ranks);
    reader->read(kMeditVertices, 3, blocks.begin(rank), blocks.begin(rank + 1),
                 [&](std::int64_t i, const auto& x, const auto& n) {
                   pieces.vertices.push_back({i, x, reader->checked_tag(n[0]), 0});
                 });
    pieces.cells = read_elements<4>(*reader, kMeditTetrahedra, all.cells, all.vertices, Blocks(all.cells, ranks), rank);
    pieces.sides = read_elements<3>(*reader, kMeditTriangles, all.sides, all.vertices, Blocks(all.sides, ranks), rank);
    pieces.lines = read_elements<2>(*reader, kMeditEdges, all.lines, all.vertices, Blocks(all.lines, ranks), rank);
  });
  add_flags(comm, reader, kMeditCorners, kCorner, all.vertices, pieces.vertices);
  add_flags(comm, reader, kMeditRequiredVertices, kRequired, all.vertices, pieces.vertices);
  add_flags(comm, reader, kMeditRequiredTetrahedra, kRequired, all.cells, pieces.cells);
  add_flags(comm, reader, kMeditRequiredTriangles, kRequired, all.sides, pieces.sides);
  add_flags(comm, reader, kMeditRidges, kRidge, all.lines, pieces.lines);
  add_flags(comm, reader, kMeditRequiredEdges, kRequired, all.lines, pieces.lines);
  return input;
}

namespace {

/// Writes sections in sequence, of which each rank writes its entries.
class Writer {
 public:
  Writer(MPI_Comm comm, const std::string& path, const MeditEncoding& encoding)
      : comm_(comm), path_(path), encoding_(encoding) {
    if (MPI_File_open(comm, path.c_str(), MPI_MODE_CREATE | MPI_MODE_WRONLY, MPI_INFO_NULL, &file_) != MPI_SUCCESS) {
      throw FileError(path + ": cannot be opened for writing");
    }
    if (MPI_File_set_size(file_, 0) != MPI_SUCCESS) failed_ = 1;
    write_once(encoding_.file_head());
  }

  /// Writes a list; put(to, entity) encodes one of its entries and advances `to`.
  template <class T, class Put>
  void list(int code, const std::vector<T>& entities, int reals, int integers, Put put) {
    const std::int64_t own = std::ssize(entities);
    const std::int64_t count = all_reduce(comm_, own, MPI_SUM);
    if (count == 0) return;
    const std::int64_t each = encoding_.entry_bytes(reals, integers);
    write_once(encoding_.section_head(code, position_, encoding_.integer_bytes() + count * each));
    std::array<char, 8> number;
    char* end = number.data();
    encoding_.put_integer(end, count);
    write_once({number.data(), end});
    std::int64_t offset = position_ + sum_before(comm_, own) * each;
    // The calls that write are collective: all ranks make as many as the one with the most entries.
    constexpr std::int64_t kChunk = 1 << 18;
    std::vector<char> bytes(std::size_t(std::min(kChunk, own) * each));
    const std::int64_t chunks = all_reduce(comm_, (own + kChunk - 1) / kChunk, MPI_MAX);
    for (std::int64_t c = 0; c < chunks; ++c) {
      char* to = bytes.data();
      for (std::int64_t i = c * kChunk; i < std::min(own, (c + 1) * kChunk); ++i) put(to, item(entities, i));
      const std::int64_t length = to - bytes.data();
      write_at(offset, bytes.data(), length);
      offset += length;
    }
    position_ += count * each;
  }

  const MeditEncoding& encoding() const { return encoding_; }

  /// Returns whether all ranks could write. Some versions of Open MPI report no error where the disk is full, so the
  /// size of the file decides, too.
  bool end() {
    write_once(encoding_.file_end());
    if (MPI_File_close(&file_) != MPI_SUCCESS) failed_ = 1;
    std::error_code error;
    if (rank_of(comm_) == 0 && std::filesystem::file_size(path_, error) != std::uintmax_t(position_)) failed_ = 1;
    return all_reduce(comm_, failed_, MPI_MAX) == 0;
  }

 private:
  /// Writes bytes that all ranks have alike: rank 0 does.
  void write_once(const std::string& bytes) {
    write_at(position_, bytes.data(), rank_of(comm_) == 0 ? std::ssize(bytes) : 0);
    position_ += std::ssize(bytes);
  }
  void write_at(std::int64_t offset, const char* bytes, std::int64_t length) {
    if (MPI_File_write_at_all(file_, offset, bytes, int(length), MPI_BYTE, MPI_STATUS_IGNORE) != MPI_SUCCESS) {
      failed_ = 1;
    }
  }

  MPI_Comm comm_;
  std::string path_;
  MPI_File file_ = MPI_FILE_NULL;
  MeditEncoding encoding_;
  std::int64_t position_ = 0;  ///< the end of what all ranks have written
  int failed_ = 0;
};

template <std::size_t N>
void write_elements(Writer& writer, const MeditSection& section, const std::vector<Element<N>>& elements) {
  writer.list(section.code, elements, 0, int(N) + 1, [&writer](char*& to, const Element<N>& e) {
    for (const Id v : e.v) writer.encoding().put_integer(to, v + 1);
    writer.encoding().put_integer(to, e.tag);
  });
}

template <class T>
void write_flagged(Writer& writer, const MeditSection& section, const std::vector<T>& entities, int flag) {
  std::vector<Id> ids;
  for (const T& entity : entities) {
    if ((entity.flags & flag) != 0) ids.push_back(entity.id);
  }
  writer.list(section.code, ids, 0, 1, [&writer](char*& to, Id id) { writer.encoding().put_integer(to, id + 1); });
}

}  // namespace

void write_meshb(MPI_Comm comm, const std::string& path, const Pieces& pieces, const Totals& totals) {
  SharedTemporary temporary(comm, path);
  // An upper bound: the lists of ids may hold every entity.
  const std::int64_t bytes = 36 * totals.vertices + 24 * totals.cells + 20 * totals.sides + 20 * totals.lines;
  Writer writer(comm, temporary.name(), MeditEncoding::for_writing(std::max(totals.vertices, totals.cells), bytes));
  writer.list(kMeditVertices.code, pieces.vertices, 3, 1, [&writer](char*& to, const Vertex& v) {
    for (const double x : v.x) MeditEncoding::put_real(to, x);
    writer.encoding().put_integer(to, v.tag);
  });
  write_elements(writer, kMeditEdges, pieces.lines);
  write_elements(writer, kMeditTriangles, pieces.sides);
  write_elements(writer, kMeditTetrahedra, pieces.cells);
  write_flagged(writer, kMeditCorners, pieces.vertices, kCorner);
  write_flagged(writer, kMeditRequiredVertices, pieces.vertices, kRequired);
  write_flagged(writer, kMeditRidges, pieces.lines, kRidge);
  write_flagged(writer, kMeditRequiredEdges, pieces.lines, kRequired);
  write_flagged(writer, kMeditRequiredTriangles, pieces.sides, kRequired);
  write_flagged(writer, kMeditRequiredTetrahedra, pieces.cells, kRequired);
  if (!writer.end()) throw FileError(path + ": could not be written (disk full?); an old file is untouched");
  temporary.replace();
}

}  // namespace tetune::mpi
