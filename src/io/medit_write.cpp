// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <set>
#include <span>

#include "backend/cpu.hpp"
#include "io/medit_codec.hpp"
#include "io/registry.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Lines are formatted in ranges of this many, in parallel, and written in order.
constexpr Size kLinesPerPart = 1 << 15;

class TextLine {
 public:
  explicit TextLine(std::string& out) : out_(out) {}
  template <class T>
  void number(T value) {
    char digits[40];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    out_.append(std::string_view(digits, result.ptr));
  }
  void space() { out_ += ' '; }
  void end() { out_ += '\n'; }

 private:
  std::string& out_;
};

/// Calls line(text, i) for each of n lines.
template <class Line>
void write_lines(FileWriter& file, std::size_t n, int threads, const Line& line) {
  const backend::Cpu cpu(threads);
  const Size size = to_index(n);
  std::vector<std::string> parts(std::size_t{4} * cpu.threads());
  const Span<std::string> part = span_of(parts);
  for (Size first = 0; first < size; first += part.size() * kLinesPerPart) {
    cpu.for_parts(part.size(), [&](Size p) {
      part[p].clear();
      const Size begin = std::min(size, first + p * kLinesPerPart);
      const std::size_t end = to_size_t(std::min(size, begin + kLinesPerPart));
      TextLine text(part[p]);
      for (std::size_t i = to_size_t(begin); i < end; ++i) line(text, i);
    });
    for (const std::string& text : parts) file.write(text);
  }
}

void write_header(FileWriter& file, std::string_view name, std::size_t n) {
  std::string header(1, '\n');
  header.append(name).append(1, '\n').append(std::to_string(n)).append(1, '\n');
  file.write(header);
}

template <std::size_t N>
void write_text_elements(FileWriter& file, const MeditSection& section,
                         const std::vector<std::array<Index, N>>& elements, const std::vector<int>& tags, int threads) {
  if (elements.empty()) return;
  write_header(file, section.name, elements.size());
  write_lines(file, elements.size(), threads, [&](TextLine& line, std::size_t i) {
    for (const Index v : elements[i]) {
      line.number(v + 1);
      line.space();
    }
    line.number(tags[i]);
    line.end();
  });
}

void write_text_list(FileWriter& file, std::string_view name, const std::vector<Index>& ids, int threads) {
  if (ids.empty()) return;
  write_header(file, name, ids.size());
  write_lines(file, ids.size(), threads, [&](TextLine& line, std::size_t i) {
    line.number(ids[i] + 1);
    line.end();
  });
}

/// The tetrahedra in the orientation in which the caller listed them.
std::vector<std::array<Index, 4>> as_listed(const TetMesh& mesh) {
  std::vector<std::array<Index, 4>> tets = mesh.tets;
  if (mesh.listed_inside_out) {
    for (auto& tet : tets) std::swap(tet[2], tet[3]);
  }
  return tets;
}

/// Writes the sections of a binary file.
class BinaryWriter {
 public:
  BinaryWriter(FileWriter& file, const MeditEncoding& encoding) : file_(file), encoding_(encoding) {
    write(encoding_.file_head());
  }
  /// Writes a list of n entries; put(to, i) encodes one of them and advances `to`.
  template <class Put>
  void list(int code, std::size_t n, int reals, int integers, Put put) {
    const std::int64_t body = encoding_.integer_bytes() + std::int64_t(n) * encoding_.entry_bytes(reals, integers);
    write(encoding_.section_head(code, position_, body));
    bytes_.resize(to_size_t(body));
    char* to = bytes_.data();
    encoding_.put_integer(to, std::int64_t(n));
    for (std::size_t i = 0; i < n; ++i) put(to, i);
    write({bytes_.data(), bytes_.size()});
  }
  void end() { write(encoding_.file_end()); }
  const MeditEncoding& encoding() const { return encoding_; }

 private:
  void write(std::string_view bytes) {
    file_.write(bytes);
    position_ += std::ssize(bytes);
  }
  FileWriter& file_;
  MeditEncoding encoding_;
  std::int64_t position_ = 0;
  std::vector<char> bytes_;
};

void write_binary_elements(BinaryWriter& out, const MeditSection& section, const Index* element2vertex,
                           const std::vector<int>& tags) {
  if (tags.empty()) return;
  out.list(section.code, tags.size(), 0, section.vertices + 1,
           [&, v = element2vertex](char*& to, std::size_t i) mutable {
             for (const Index* const end = v + section.vertices; v != end; ++v) out.encoding().put_integer(to, *v + 1);
             out.encoding().put_integer(to, tags[i]);
           });
}

void write_binary_list(BinaryWriter& out, const MeditSection& section, const std::vector<Index>& ids) {
  if (ids.empty()) return;
  out.list(section.code, ids.size(), 0, 1,
           [&](char*& to, std::size_t i) { out.encoding().put_integer(to, ids[i] + 1); });
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
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
  return ids;
}

const MeditSection& section_of(const ElementBlock& block) {
  for (const MeditSection& section : kMeditOthers) {
    if (section.name != block.kind) continue;
    if (block.vertices_per_element == section.vertices) return section;
    throw FileError(block.kind + " have " + std::to_string(section.vertices) + " vertices each, and not " +
                    std::to_string(block.vertices_per_element));
  }
  throw FileError("MEDIT has no section for elements of kind " + block.kind);
}

void add_names(const std::vector<DataArray>& data, std::set<std::string>& names) {
  for (const DataArray& array : data) names.insert(array.name);
}

}  // namespace

std::vector<std::string> lost_in_medit(const TetMesh& mesh) {
  std::vector<std::string> losses;
  std::set<std::string> names;
  for (const auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) {
    add_names(*data, names);
  }
  for (const ElementBlock& block : mesh.others) {
    add_names(block.data, names);
    if (is_points(block))
      losses.push_back("elements of one vertex are written as required vertices, without their tags");
  }
  for (const std::string& name : names) losses.push_back("MEDIT has no room for the data \"" + name + "\"");
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), [](const Group& g) { return !g.name.empty(); })) {
    losses.push_back("MEDIT has no room for the names of groups");
  }
  if (mesh.second_order) losses.push_back("written as linear elements, without the nodes in the middles of edges");
  return losses;
}

void write_medit_text(FileWriter& file, const TetMesh& mesh, int threads) {
  file.write("MeshVersionFormatted 2\n\nDimension 3\n");
  write_header(file, kMeditVertices.name, mesh.points.size());
  write_lines(file, mesh.points.size(), threads, [&](TextLine& line, std::size_t i) {
    for (const double x : mesh.points[i]) {
      line.number(x);
      line.space();
    }
    line.number(mesh.point_tags[i]);
    line.end();
  });
  write_text_elements(file, kMeditEdges, mesh.edges, mesh.edge_tags, threads);
  write_text_elements(file, kMeditTriangles, mesh.triangles, mesh.triangle_tags, threads);
  write_text_elements(file, kMeditTetrahedra, mesh.listed_inside_out ? as_listed(mesh) : mesh.tets, mesh.tet_tags,
                      threads);
  for (const ElementBlock& block : mesh.others) {
    if (is_points(block)) continue;
    const std::size_t each = to_size_t(section_of(block).vertices);
    write_header(file, block.kind, block.tags.size());
    write_lines(file, block.tags.size(), threads, [&](TextLine& line, std::size_t i) {
      for (const Index v : std::span(block.element2vertex).subspan(i * each, each)) {
        line.number(v + 1);
        line.space();
      }
      line.number(block.tags[i]);
      line.end();
    });
    if (block.kind == kMeditOthers[0].name) {
      write_text_list(file, kMeditRequiredQuadrilaterals.name, block.required, threads);
    }
  }
  for (const MeditList& list : kMeditLists) write_text_list(file, list.section.name, list_of(mesh, list), threads);
  file.write("\nEnd\n");
}

void write_medit_solution(FileWriter& file, const std::vector<Measures>& values, int threads) {
  file.write("MeshVersionFormatted 2\n\nDimension 3\n");
  write_header(file, "SolAtTetrahedra", values.size());
  std::string fields = std::to_string(kMeasures);
  for (std::size_t k = 0; k < kMeasures; ++k) fields += " 1";  // a scalar
  file.write(fields + "\n");
  write_lines(file, values.size(), threads, [&](TextLine& line, std::size_t i) {
    for (std::size_t k = 0; k < kMeasures; ++k) {
      if (k > 0) line.space();
      line.number(values[i][k]);
    }
    line.end();
  });
  file.write("\nEnd\n");
}

void write_medit_binary(FileWriter& file, const TetMesh& mesh, int) {
  // An upper bound: the last term covers the heads of the sections.
  std::size_t bytes =
      28 * mesh.points.size() + 20 * mesh.tets.size() + 16 * mesh.triangles.size() + 12 * mesh.edges.size() + 1000;
  for (const ElementBlock& block : mesh.others) {
    bytes += 4 * (2 * block.element2vertex.size() + block.tags.size() + block.required.size());
  }
  for (const MeditList& list : kMeditLists) bytes += 4 * (mesh.*list.ids).size();
  BinaryWriter out(file, MeditEncoding::for_writing(0, std::int64_t(bytes)));
  out.list(kMeditVertices.code, mesh.points.size(), 3, 1, [&](char*& to, std::size_t i) {
    for (const double x : mesh.points[i]) MeditEncoding::put_real(to, x);
    out.encoding().put_integer(to, mesh.point_tags[i]);
  });
  write_binary_elements(out, kMeditEdges, flat(mesh.edges), mesh.edge_tags);
  write_binary_elements(out, kMeditTriangles, flat(mesh.triangles), mesh.triangle_tags);
  if (mesh.listed_inside_out) {
    write_binary_elements(out, kMeditTetrahedra, flat(as_listed(mesh)), mesh.tet_tags);
  } else {
    write_binary_elements(out, kMeditTetrahedra, flat(mesh.tets), mesh.tet_tags);
  }
  for (const ElementBlock& block : mesh.others) {
    if (is_points(block)) continue;
    write_binary_elements(out, section_of(block), block.element2vertex.data(), block.tags);
    if (block.kind == kMeditOthers[0].name) write_binary_list(out, kMeditRequiredQuadrilaterals, block.required);
  }
  for (const MeditList& list : kMeditLists) write_binary_list(out, list.section, list_of(mesh, list));
  out.end();
}

}  // namespace tetune
