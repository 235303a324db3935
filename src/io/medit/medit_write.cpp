// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>

#include "backend/cpu.hpp"
#include "io/element_blocks.hpp"
#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/medit/medit_codec.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "mesh/sorted.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Writes the sections of a text file.
class TextWriter {
 public:
  TextWriter(FileWriter& file, int threads) : out_(file, threads) {
    out_.text("MeshVersionFormatted 2\n\nDimension 3\n");
  }
  /// Writes a list of n entries; put(entry, i) writes one of them. `subtitle`: a line before the entries.
  template <class Put>
  void list(const MeditSection& section, std::size_t n, int /*reals*/, int /*integers*/, const Put& put,
            const std::string& subtitle = {}) {
    std::string head(1, '\n');
    head.append(section.name).append(1, '\n').append(std::to_string(n)).append(1, '\n').append(subtitle);
    out_.text(head);
    out_.lines(n, put);
  }
  void end() { out_.text("\nEnd\n"); }

 private:
  LineWriter out_;
};

/// Writes the sections of a binary file.
class BinaryWriter {
 public:
  class Entry {
   public:
    Entry(const MeditEncoding& encoding, char* to) : encoding_(encoding), to_(to) {}
    void real(double value) { MeditEncoding::put_real(to_, value); }
    void integer(std::int64_t value) { encoding_.put_integer(to_, value); }

   private:
    const MeditEncoding& encoding_;
    char* to_;
  };

  BinaryWriter(FileWriter& file, const MeditEncoding& encoding, int threads)
      : file_(file), encoding_(encoding), cpu_(threads) {
    write(encoding_.file_head());
  }
  /// Writes a list of n entries; put(entry, i) writes one of them.
  template <class Put>
  void list(const MeditSection& section, std::size_t n, int reals, int integers, const Put& put) {
    const Size size = std::int64_t(n);
    const std::int64_t entry_bytes = encoding_.entry_bytes(reals, integers);
    write(encoding_.section_head(section.code, position_, encoding_.integer_bytes() + size * entry_bytes));
    std::string count(to_size_t(encoding_.integer_bytes()), '\0');
    Entry(encoding_, count.data()).integer(size);
    write(count);
    const auto format = [&](std::string& bytes, Size begin, Size end) {
      bytes.resize(to_size_t((end - begin) * entry_bytes));
      Entry entry(encoding_, bytes.data());
      for (Size i = begin; i < end; ++i) put(entry, to_size_t(i));
    };
    write_in_ranges(cpu_, size, kEntriesPerRange, format, [this](std::string_view bytes) { write(bytes); });
  }
  void end() { write(encoding_.file_end()); }

 private:
  void write(std::string_view bytes) {
    file_.write(bytes);
    position_ += std::ssize(bytes);
  }
  static constexpr Size kEntriesPerRange = 1 << 13;

  FileWriter& file_;
  MeditEncoding encoding_;
  backend::Cpu cpu_;
  std::int64_t position_ = 0;
};

template <class Writer>
void write_elements(Writer& out, const MeditSection& section, const Index* element2vertex,
                    const std::vector<int>& tags) {
  if (tags.empty()) return;
  const std::size_t vertices = to_size_t(section.vertices);
  out.list(section, tags.size(), 0, section.vertices + 1, [&](auto& entry, std::size_t i) {
    for (const Index v : std::span(element2vertex + i * vertices, vertices)) entry.integer(v + 1);
    entry.integer(tags[i]);
  });
}

/// Writes the tetrahedra in the orientation of the input.
template <class Writer>
void write_tets(Writer& out, const TetMesh& mesh) {
  if (mesh.tets.empty()) return;
  out.list(kMeditTetrahedra, mesh.tets.size(), 0, kMeditTetrahedra.vertices + 1, [&](auto& entry, std::size_t t) {
    std::array<Index, 4> tet = mesh.tets[t];
    if (mesh.listed_inside_out) std::swap(tet[2], tet[3]);
    for (const Index v : tet) entry.integer(v + 1);
    entry.integer(mesh.tet_tags[t]);
  });
}

template <class Writer>
void write_ids(Writer& out, const MeditSection& section, const std::vector<Index>& ids) {
  if (ids.empty()) return;
  out.list(section, ids.size(), 0, 1, [&](auto& entry, std::size_t i) { entry.integer(ids[i] + 1); });
}

template <std::size_t N>
const Index* flat(const std::vector<std::array<Index, N>>& elements) {
  return elements.empty() ? nullptr : elements.front().data();
}

/// Elements of one vertex have no section; their vertices are listed as required.
bool is_points(const ElementBlock& block) { return block.kind == kPoints; }

std::vector<Index> list_of(const TetMesh& mesh, const MeditList& list) {
  std::vector<Index> ids = mesh.*list.ids;
  if (list.ids != &TetMesh::required_vertices) return ids;
  for (const ElementBlock& block : mesh.others) {
    if (!is_points(block)) continue;
    ids.insert(ids.end(), block.element2vertex.begin(), block.element2vertex.end());
    sort_unique(ids);
  }
  return ids;
}

const MeditSection& section_of(const ElementBlock& block) {
  for (const MeditSection& section : kMeditOthers) {
    if (section.name == block.kind) return section;
  }
  throw FileError("MEDIT has no section for elements of kind " + block.kind);
}

template <class Writer>
void write_sections(Writer& out, const TetMesh& mesh) {
  out.list(kMeditVertices, mesh.points.size(), 3, 1, [&](auto& entry, std::size_t i) {
    for (const double x : mesh.points[i]) entry.real(x);
    entry.integer(mesh.point_tags[i]);
  });
  write_elements(out, kMeditEdges, flat(mesh.edges), mesh.edge_tags);
  write_elements(out, kMeditTriangles, flat(mesh.triangles), mesh.triangle_tags);
  write_tets(out, mesh);
  std::vector<ElementBlock> joined;
  for (const ElementBlock& block : blocks_by_kind(mesh, joined)) {
    if (is_points(block)) continue;
    write_elements(out, section_of(block), block.element2vertex.data(), block.tags);
    if (block.kind == kMeditOthers[0].name) write_ids(out, kMeditRequiredQuadrilaterals, block.required);
  }
  for (const MeditList& list : kMeditLists) write_ids(out, list.section, list_of(mesh, list));
  out.end();
}

}  // namespace

void warn_of_losses_in_medit(const TetMesh& mesh, const IoContext& context) {
  if (std::any_of(mesh.others.begin(), mesh.others.end(), is_points)) {
    context.warn("elements of one vertex are written as required vertices, without their tags");
  }
  warn_of_data(mesh, context);
  warn_of_names(mesh, context);
  if (mesh.second_order) context.warn(lost_middles(mesh));
}

void write_medit_text(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  warn_of_losses_in_medit(mesh, context);
  TextWriter out(file, context.threads);
  write_sections(out, mesh);
}

void write_medit_solution(FileWriter& file, const std::vector<Measures>& values, int threads) {
  TextWriter out(file, threads);
  std::string fields = std::to_string(kMeasures);
  for (std::size_t k = 0; k < kMeasures; ++k) fields += " 1";  // a scalar
  const auto put = [&values](LineWriter::Entry& entry, std::size_t i) {
    for (const double value : values[i]) entry.real(value);
  };
  out.list({"SolAtTetrahedra", 0, 0}, values.size(), kMeasures, 0, put, fields.append(1, '\n'));
  out.end();
}

void write_medit_binary(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  warn_of_losses_in_medit(mesh, context);
  // An upper bound: the last term covers the heads of the sections.
  std::size_t bytes =
      28 * mesh.points.size() + 20 * mesh.tets.size() + 16 * mesh.triangles.size() + 12 * mesh.edges.size() + 1000;
  for (const ElementBlock& block : mesh.others) {
    bytes += 4 * (2 * block.element2vertex.size() + block.tags.size() + block.required.size());
  }
  for (const MeditList& list : kMeditLists) bytes += 4 * (mesh.*list.ids).size();
  BinaryWriter out(file, MeditEncoding::for_writing(0, std::int64_t(bytes)), context.threads);
  write_sections(out, mesh);
}

}  // namespace tetune
