// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstring>
#include <set>

#include "io/medit_sections.hpp"
#include "io/registry.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Lines are made in parts of this many, in parallel, and written in order.
constexpr std::size_t kPart = 1 << 15;

class TextLine {
 public:
  explicit TextLine(std::string& out) : out_(out) {}
  template <class T>
  void number(T value) {
    char digits[40];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    out_.append(digits, static_cast<std::size_t>(result.ptr - digits));
  }
  void space() { out_ += ' '; }
  void end() { out_ += '\n'; }

 private:
  std::string& out_;
};

template <class Line>
void write_lines(FileWriter& file, std::size_t n, int threads, const Line& line) {
  const par::Cpu cpu(threads);
  const auto wave = static_cast<std::size_t>(cpu.threads()) * 4;
  std::vector<std::string> parts(wave);
  for (std::size_t first = 0; first < n; first += wave * kPart) {
    cpu.for_parts(static_cast<par::Size>(wave), [&](par::Size p) {
      std::string& out = parts[static_cast<std::size_t>(p)];
      out.clear();
      const std::size_t begin = std::min(n, first + static_cast<std::size_t>(p) * kPart);
      const std::size_t end = std::min(n, begin + kPart);
      TextLine text(out);
      for (std::size_t i = begin; i < end; ++i) line(text, i);
    });
    for (const std::string& part : parts) file.write(part);
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

/// Tetrahedra as the caller listed them.
std::vector<std::array<Index, 4>> as_listed(const TetMesh& mesh) {
  std::vector<std::array<Index, 4>> tets = mesh.tets;
  if (mesh.listed_inside_out) {
    for (auto& tet : tets) std::swap(tet[2], tet[3]);
  }
  return tets;
}

/// Gathers a binary section and writes it, with the position of the next one in its head.
class BinaryWriter {
 public:
  BinaryWriter(FileWriter& file, bool wide) : file_(file), wide_(wide) {
    put<std::int32_t>(1);
    put<std::int32_t>(wide ? 3 : 2);
    flush();
  }
  template <class T>
  void put(T value) {
    std::memcpy(room(sizeof(T)), &value, sizeof(T));
  }
  /// Room for so many bytes, to be filled at once.
  char* room(std::size_t bytes) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + bytes);
    return bytes_.data() + at;
  }
  void section(int code, std::size_t body_bytes) {
    put<std::int32_t>(code);
    const std::size_t head = sizeof(std::int32_t) + (wide_ ? 8 : 4);
    const std::size_t next = position_ + head + body_bytes;
    if (wide_) {
      put(static_cast<std::int64_t>(next));
    } else {
      put(static_cast<std::int32_t>(next));
    }
    bytes_.reserve(head + body_bytes);
  }
  void flush() {
    file_.write(bytes_.data(), bytes_.size());
    position_ += bytes_.size();
    bytes_.clear();
  }
  void end() {
    put<std::int32_t>(kMeditEnd);
    if (wide_) {
      put<std::int64_t>(0);
    } else {
      put<std::int32_t>(0);
    }
    flush();
  }

 private:
  FileWriter& file_;
  bool wide_;
  std::size_t position_ = 0;
  std::vector<char> bytes_;
};

void write_binary_elements(BinaryWriter& out, const MeditSection& section, const Index* element2vertex,
                           const std::vector<int>& tags) {
  if (tags.empty()) return;
  const auto each = static_cast<std::size_t>(section.vertices);
  out.section(section.code, 4 + tags.size() * (each + 1) * 4);
  out.put(static_cast<std::int32_t>(tags.size()));
  char* to = out.room(tags.size() * (each + 1) * 4);
  const auto put = [&to](std::int32_t value) {
    std::memcpy(to, &value, sizeof value);
    to += sizeof value;
  };
  for (std::size_t i = 0; i < tags.size(); ++i) {
    for (std::size_t k = 0; k < each; ++k) put(element2vertex[i * each + k] + 1);
    put(tags[i]);
  }
  out.flush();
}

void write_binary_list(BinaryWriter& out, const MeditSection& section, const std::vector<Index>& ids) {
  if (ids.empty()) return;
  out.section(section.code, 4 + ids.size() * 4);
  out.put(static_cast<std::int32_t>(ids.size()));
  for (const Index id : ids) out.put<std::int32_t>(id + 1);
  out.flush();
}

template <std::size_t N>
const Index* flat(const std::vector<std::array<Index, N>>& elements) {
  return elements.empty() ? nullptr : elements.front().data();
}

/// Elements of one vertex have no section; what they constrain has.
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

std::vector<std::string> not_kept_by_medit(const TetMesh& mesh) {
  std::vector<std::string> lost;
  std::set<std::string> names;
  for (const auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) {
    add_names(*data, names);
  }
  for (const ElementBlock& block : mesh.others) {
    add_names(block.data, names);
    if (is_points(block)) lost.push_back("elements of one vertex are written as required vertices, without their tags");
  }
  for (const std::string& name : names) lost.push_back("MEDIT has no room for the data \"" + name + "\"");
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), [](const Group& g) { return !g.name.empty(); })) {
    lost.push_back("MEDIT has no room for the names of groups");
  }
  if (mesh.second_order) lost.push_back("written as linear elements, without the nodes in the middles of edges");
  return lost;
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
    const auto each = static_cast<std::size_t>(section_of(block).vertices);
    write_header(file, block.kind, block.tags.size());
    write_lines(file, block.tags.size(), threads, [&](TextLine& line, std::size_t i) {
      for (std::size_t k = 0; k < each; ++k) {
        line.number(block.element2vertex[i * each + k] + 1);
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
  // Positions in version 2 are 32 bits wide: version 3 where the file may not fit.
  std::size_t bytes = 28 * mesh.points.size() + 20 * mesh.tets.size();
  bytes += 16 * mesh.triangles.size() + 12 * mesh.edges.size();
  for (const ElementBlock& block : mesh.others) {
    bytes += 4 * (block.element2vertex.size() + block.tags.size() + block.required.size());
  }
  for (const MeditList& list : kMeditLists) bytes += 4 * (mesh.*list.ids).size();
  BinaryWriter out(file, bytes > 2'000'000'000U);
  out.section(kMeditDimension, 4);
  out.put<std::int32_t>(3);
  out.flush();
  out.section(kMeditVertices.code, 4 + mesh.points.size() * 28);
  out.put(static_cast<std::int32_t>(mesh.points.size()));
  char* to = out.room(mesh.points.size() * 28);
  for (std::size_t i = 0; i < mesh.points.size(); ++i, to += 28) {
    const std::int32_t tag = mesh.point_tags[i];
    std::memcpy(to, mesh.points[i].data(), 24);
    std::memcpy(to + 24, &tag, sizeof tag);
  }
  out.flush();
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
