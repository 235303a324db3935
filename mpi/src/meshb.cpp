// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <system_error>

#include "files.hpp"
#include "tetune/error.hpp"

/// MEDIT binary files, each rank its part of every section (docs/formats.md, "MEDIT").
namespace tetune::mpi {
namespace {

/// Codes of the sections.
enum Code : int {
  kDimension = 3,
  kVertices = 4,
  kEdges = 5,
  kTriangles = 6,
  kTetrahedra = 8,
  kRequiredTets = 12,
  kCorners = 13,
  kRidges = 14,
  kRequiredVertices = 15,
  kRequiredEdges = 16,
  kRequiredTriangles = 17,
  kEnd = 54
};
/// Elements of other kinds, and what is required of them: not read in parallel.
constexpr int kOthers[] = {7, 9, 10, 18, 49};

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw FileError(path + ": cannot be opened: " + std::strerror(errno));
    size_ = static_cast<std::int64_t>(std::filesystem::file_size(path));
    if (take<std::int32_t>() != 1) throw FileError(path + ": not a MEDIT binary file of this machine's byte order");
    version_ = take<std::int32_t>();
    if (version_ < 2 || version_ > 4) fail("version " + std::to_string(version_) + " is not one of 2 to 4");
    while (at_ < size_) {
      const int code = take<std::int32_t>();
      if (code == kEnd) break;
      const std::int64_t next = version_ == 2 ? take<std::int32_t>() : take<std::int64_t>();
      if (next != 0 && (next < at_ || next > size_)) fail("the position of the next section is outside the file");
      if (!sections_.emplace(code, std::pair(at_, next == 0 ? size_ : next)).second) {
        fail("section " + std::to_string(code) + " is there twice");
      }
      if (next == 0) break;
      at_ = next;
    }
  }

  bool has(int code) const { return sections_.count(code) > 0; }

  /// The dimension is 32 bits wide, or as any other number in some files of version 4.
  std::int64_t dimension() {
    if (!has(kDimension)) return 0;
    const auto [begin, end] = sections_.at(kDimension);
    at_ = begin;
    return end - begin == 8 ? take<std::int64_t>() : take<std::int32_t>();
  }

  /// Entries of a section, or 0.
  std::int64_t count(int code, int reals, int integers) {
    if (!has(code)) return 0;
    const auto [begin, end] = sections_.at(code);
    at_ = begin;
    const std::int64_t n = integer();
    const std::int64_t each = 8 * reals + width() * integers;
    if (n < 0 || n > (end - at_) / each || (end != size_ && n * each != end - at_)) {
      fail("section " + std::to_string(code) + " claims " + std::to_string(n) + " entries, which do not fit it");
    }
    return n;
  }

  /// Calls entry(i, reals, integers) for the entries [first, last).
  template <class F>
  void read(int code, int reals, int integers, std::int64_t first, std::int64_t last, F entry) {
    if (last <= first) return;
    const std::int64_t each = 8 * reals + width() * integers;
    at_ = sections_.at(code).first + width() + first * each;
    constexpr std::int64_t kChunk = 1 << 16;
    std::vector<char> bytes;
    std::vector<double> x(static_cast<std::size_t>(reals));
    std::vector<std::int64_t> n(static_cast<std::size_t>(integers));
    for (std::int64_t i = first; i < last;) {
      const std::int64_t count = std::min(kChunk, last - i);
      bytes.resize(static_cast<std::size_t>(count * each));
      get(bytes.data(), bytes.size());
      const char* p = bytes.data();
      const auto next = [&p]<class T>(T) {
        T value;
        std::memcpy(&value, p, sizeof value);
        p += sizeof value;
        return value;
      };
      for (std::int64_t k = 0; k < count; ++k, ++i) {
        for (double& r : x) r = next(0.0);
        for (std::int64_t& v : n) v = version_ == 4 ? next(std::int64_t{0}) : next(std::int32_t{0});
        entry(i, x, n);
      }
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(path_ + ", byte " + std::to_string(at_) + ": " + what);
  }

 private:
  std::int64_t width() const { return version_ == 4 ? 8 : 4; }
  std::int64_t integer() { return version_ == 4 ? take<std::int64_t>() : take<std::int32_t>(); }
  template <class T>
  T take() {
    T value;
    get(&value, sizeof value);
    return value;
  }
  void get(void* to, std::size_t bytes) {
    file_.seekg(at_);
    if (!file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) fail("the file ends too early");
    at_ += static_cast<std::int64_t>(bytes);
  }

  std::string path_;
  std::ifstream file_;
  std::int64_t size_ = 0, at_ = 0;
  int version_ = 0;
  std::map<int, std::pair<std::int64_t, std::int64_t>> sections_;
};

int checked_tag(const Reader& reader, std::int64_t tag) {
  if (tag != static_cast<int>(tag)) reader.fail("a tag does not fit 32 bits: " + std::to_string(tag));
  return static_cast<int>(tag);
}

Id checked_id(const Reader& reader, std::int64_t id, Id count) {
  if (id < 1 || id > count) {
    reader.fail("number " + std::to_string(id) + " is not one of 1 to " + std::to_string(count));
  }
  return id - 1;
}

template <std::size_t N>
std::vector<Element<N>> read_elements(Reader& reader, int code, Id count, Id vertices, const Blocks& blocks, int rank) {
  std::vector<Element<N>> elements;
  reader.read(code, 0, N + 1, blocks.begin(rank), std::min(count, blocks.begin(rank + 1)),
              [&](std::int64_t i, const auto&, const auto& n) {
                Element<N> e{i, {}, checked_tag(reader, n[N]), 0};
                for (std::size_t k = 0; k < N; ++k) e.v[k] = checked_id(reader, n[k], vertices);
                elements.push_back(e);
              });
  return elements;
}

/// A list of ids, of which each rank reads a part and sends each to the home of its entity.
struct Listed {
  int code;
  int flag;
};
template <class T>
void add_flags(MPI_Comm comm, std::optional<Reader>& reader, Listed list, Id count, std::vector<T>& items) {
  const int ranks = size_of(comm);
  const Blocks blocks(count, ranks);
  std::vector<Id> ids;
  together(comm, [&] {
    const Id entries = reader->count(list.code, 0, 1);
    const Blocks parts(entries, ranks);
    const int rank = rank_of(comm);
    reader->read(list.code, 0, 1, parts.begin(rank), parts.begin(rank + 1),
                 [&](std::int64_t, const auto&, const auto& n) { ids.push_back(checked_id(*reader, n[0], count)); });
  });
  std::vector<int> to;
  for (const Id id : ids) to.push_back(blocks.home(id));
  for (const Id id : Route(comm, to).send(ids)) {
    items[static_cast<std::size_t>(id - blocks.begin(rank_of(comm)))].flags |= list.flag;
  }
}

}  // namespace

bool is_plain_meshb(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".meshb") return false;
  try {
    const Reader reader(path);
    return std::none_of(std::begin(kOthers), std::end(kOthers), [&reader](int code) { return reader.has(code); });
  } catch (const FileError&) {
    return false;  // tetune's own reader says what is wrong
  }
}

Input read_meshb(MPI_Comm comm, const std::string& path) {
  const int rank = rank_of(comm);
  const int ranks = size_of(comm);
  Input input;
  std::optional<Reader> reader;
  together(comm, [&] {
    reader.emplace(path);
    if (reader->dimension() != 3) throw FileError(path + ": the dimension is not 3");
    Totals& all = input.totals;
    all = {reader->count(kVertices, 3, 1), reader->count(kTetrahedra, 0, 5), reader->count(kTriangles, 0, 4),
           reader->count(kEdges, 0, 3)};
    const Blocks blocks(all.vertices, ranks);
    reader->read(kVertices, 3, 1, blocks.begin(rank), blocks.begin(rank + 1),
                 [&](std::int64_t i, const auto& x, const auto& n) {
                   input.pieces.vertices.push_back({i, {x[0], x[1], x[2]}, checked_tag(*reader, n[0]), 0});
                 });
    input.pieces.cells =
        read_elements<4>(*reader, kTetrahedra, all.cells, all.vertices, Blocks(all.cells, ranks), rank);
    input.pieces.sides = read_elements<3>(*reader, kTriangles, all.sides, all.vertices, Blocks(all.sides, ranks), rank);
    input.pieces.lines = read_elements<2>(*reader, kEdges, all.lines, all.vertices, Blocks(all.lines, ranks), rank);
  });
  add_flags(comm, reader, {kCorners, kCorner}, input.totals.vertices, input.pieces.vertices);
  add_flags(comm, reader, {kRequiredVertices, kRequired}, input.totals.vertices, input.pieces.vertices);
  add_flags(comm, reader, {kRequiredTets, kRequired}, input.totals.cells, input.pieces.cells);
  add_flags(comm, reader, {kRequiredTriangles, kRequired}, input.totals.sides, input.pieces.sides);
  add_flags(comm, reader, {kRidges, kRidge}, input.totals.lines, input.pieces.lines);
  add_flags(comm, reader, {kRequiredEdges, kRequired}, input.totals.lines, input.pieces.lines);
  return input;
}

namespace {

/// Writes sections one after the other, each rank its entries.
class Writer {
 public:
  Writer(MPI_Comm comm, const std::string& path, std::int64_t largest, std::int64_t bytes)
      : comm_(comm),
        version_(largest > 0x7fffffff    ? 4
                 : bytes > 2'000'000'000 ? 3
                                         : 2) {
    if (MPI_File_open(comm, path.c_str(), MPI_MODE_CREATE | MPI_MODE_WRONLY, MPI_INFO_NULL, &file_) != MPI_SUCCESS) {
      throw FileError(path + ": cannot be opened for writing");
    }
    number(1);
    put(version_, 4);
    flush();
    section(kDimension, 4);
    put(3, 4);
    flush();
  }

  template <class T, class F>
  void entries(int code, const std::vector<T>& items, std::int64_t reals, std::int64_t integers, F entry) {
    const auto mine = static_cast<std::int64_t>(items.size());
    const std::int64_t count = all_reduce(comm_, mine, MPI_SUM);
    if (count == 0) return;
    const std::int64_t each = 8 * reals + width() * integers;
    section(code, width() + count * each);
    number(count);
    flush();
    offset_ = at_ + sum_before(comm_, mine) * each;
    // All ranks write as often as the one that has most.
    constexpr std::int64_t kChunk = 1 << 18;
    const std::int64_t chunks = all_reduce(comm_, (mine + kChunk - 1) / kChunk, MPI_MAX);
    for (std::int64_t c = 0; c < chunks; ++c) {
      for (std::int64_t i = c * kChunk; i < std::min(mine, (c + 1) * kChunk); ++i) {
        entry(items[static_cast<std::size_t>(i)]);
      }
      write_all();
    }
    at_ += count * each;
  }

  void real(double x) {
    const char* p = reinterpret_cast<const char*>(&x);
    bytes_.insert(bytes_.end(), p, p + sizeof x);
  }
  void number(std::int64_t n) { put(n, width_of_number()); }

  bool end() {
    put(kEnd, 4);
    put(0, version_ == 2 ? 4 : 8);
    flush();
    if (MPI_File_close(&file_) != MPI_SUCCESS) failed_ = 1;
    return all_reduce(comm_, failed_, MPI_MAX) == 0;
  }

 private:
  std::int64_t width() const { return version_ == 4 ? 8 : 4; }
  int width_of_number() const { return at_ == 0 ? 4 : static_cast<int>(width()); }
  void put(std::int64_t n, int bytes) {
    const auto narrow = static_cast<std::int32_t>(n);
    const char* p = bytes == 8 ? reinterpret_cast<const char*>(&n) : reinterpret_cast<const char*>(&narrow);
    bytes_.insert(bytes_.end(), p, p + bytes);
  }
  void section(int code, std::int64_t length) {
    const int position = version_ == 2 ? 4 : 8;
    put(code, 4);
    put(at_ + 4 + position + length, position);
    flush();
  }
  /// What all ranks have alike, rank 0 writes.
  void flush() {
    const auto length = static_cast<std::int64_t>(bytes_.size());
    if (rank_of(comm_) != 0) bytes_.clear();
    offset_ = at_;
    write_all();
    at_ += length;
  }
  void write_all() {
    if (MPI_File_write_at_all(file_, offset_, bytes_.data(), static_cast<int>(bytes_.size()), MPI_BYTE,
                              MPI_STATUS_IGNORE) != MPI_SUCCESS) {
      failed_ = 1;
    }
    offset_ += static_cast<std::int64_t>(bytes_.size());
    bytes_.clear();
  }

  MPI_Comm comm_;
  MPI_File file_ = MPI_FILE_NULL;
  int version_;
  std::int64_t at_ = 0;      ///< end of what has been laid out, the same on all ranks
  std::int64_t offset_ = 0;  ///< where this rank writes next
  int failed_ = 0;
  std::vector<char> bytes_;
};

template <std::size_t N>
void write_elements(Writer& writer, int code, const std::vector<Element<N>>& elements) {
  writer.entries(code, elements, 0, N + 1, [&writer](const Element<N>& e) {
    for (const Id v : e.v) writer.number(v + 1);
    writer.number(e.tag);
  });
}

template <class T>
void write_flagged(Writer& writer, int code, const std::vector<T>& items, int flag) {
  std::vector<Id> ids;
  for (const T& item : items) {
    if ((item.flags & flag) != 0) ids.push_back(item.id);
  }
  writer.entries(code, ids, 0, 1, [&writer](Id id) { writer.number(id + 1); });
}

}  // namespace

void write_meshb(MPI_Comm comm, const std::string& path, const Pieces& pieces, const Totals& totals) {
  const std::string temporary = path + ".tetune-mpi.tmp";
  // Upper bounds: lists may hold everything.
  const std::int64_t bytes = 36 * totals.vertices + 24 * totals.cells + 20 * totals.sides + 20 * totals.lines;
  Writer writer(comm, temporary, std::max(totals.vertices, totals.cells), bytes);
  writer.entries(kVertices, pieces.vertices, 3, 1, [&writer](const Vertex& v) {
    for (const double x : v.x) writer.real(x);
    writer.number(v.tag);
  });
  write_elements(writer, kEdges, pieces.lines);
  write_elements(writer, kTriangles, pieces.sides);
  write_elements(writer, kTetrahedra, pieces.cells);
  write_flagged(writer, kCorners, pieces.vertices, kCorner);
  write_flagged(writer, kRequiredVertices, pieces.vertices, kRequired);
  write_flagged(writer, kRidges, pieces.lines, kRidge);
  write_flagged(writer, kRequiredEdges, pieces.lines, kRequired);
  write_flagged(writer, kRequiredTriangles, pieces.sides, kRequired);
  write_flagged(writer, kRequiredTets, pieces.cells, kRequired);
  const bool written = writer.end();
  together(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::error_code error;
    if (written) std::filesystem::rename(temporary, path, error);
    if (written && !error) return;
    std::filesystem::remove(temporary, error);
    throw FileError(path + ": could not be written (disk full?); an old file is untouched");
  });
}

}  // namespace tetune::mpi
