// SPDX-License-Identifier: Apache-2.0
// TetGen's .node, .ele, .face and .edge files (TetGen manual, Sect. 5.2).
#include <filesystem>
#include <memory>

#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune {
namespace {

/// The files of a mesh: they are complete before the first replaces an old one.
class TetgenWriter {
 public:
  TetgenWriter(const std::string& path, int threads) : path_(path), threads_(threads) {}

  void write_points(const TetMesh& mesh) {
    LineWriter out = start(".node");
    const bool tagged = has_tag(mesh.point_tags);
    out.text(std::to_string(mesh.points.size()) + (tagged ? " 3 0 1\n" : " 3 0 0\n"));
    out.lines(mesh.points.size(), [&](auto& entry, std::size_t i) {
      entry.integer(i + 1);
      for (const double x : mesh.points[i]) entry.real(x);
      if (tagged) entry.integer(mesh.point_tags[i]);
    });
  }
  void write_tets(const TetMesh& mesh) {
    const auto vertices_of = [&mesh](std::size_t t) {
      std::array<Index, 4> tet = mesh.tets[t];
      if (mesh.listed_inside_out) std::swap(tet[2], tet[3]);
      return tet;
    };
    write_elements(".ele", " 4", mesh.tet_tags, vertices_of);
  }
  template <std::size_t N>
  void write_faces_or_edges(const char* ending, const std::vector<std::array<Index, N>>& elements,
                            const std::vector<int>& tags) {
    write_elements(ending, "", tags, [&elements](std::size_t i) { return elements[i]; });
  }
  /// Whether there is a file of the set with this ending, which must not stay beside the others.
  bool exists(const char* ending) const {
    std::error_code ignored;
    return std::filesystem::exists(path_of(with_ending(path_, ending)), ignored);
  }
  void commit() {
    for (const auto& file : files_) file->commit();
  }

 private:
  /// Writes elements, one per tag; `head`: what follows their number in the first line, before the flag of tags.
  template <class VerticesOf>
  void write_elements(const char* ending, const char* head, const std::vector<int>& tags,
                      const VerticesOf& vertices_of) {
    LineWriter out = start(ending);
    const bool tagged = has_tag(tags);
    out.text(std::to_string(tags.size()) + head + (tagged ? " 1\n" : " 0\n"));
    out.lines(tags.size(), [&](auto& entry, std::size_t i) {
      entry.integer(i + 1);
      for (const Index v : vertices_of(i)) entry.integer(v + 1);
      if (tagged) entry.integer(tags[i]);
    });
  }
  LineWriter start(const char* ending) {
    const std::string name = with_ending(path_, ending);
    check_place(name);
    files_.push_back(std::make_unique<FileWriter>(name));
    return {*files_.back(), threads_};
  }
  std::string path_;
  int threads_;
  std::vector<std::unique_ptr<FileWriter>> files_;
};

}  // namespace

void write_tetgen(const std::string& path, const TetMesh& mesh, const IoContext& context) {
  for (const ElementBlock& block : mesh.others) {
    if (block.kind != kPoints)
      throw FileError("TetGen's files cannot hold " + block.kind + "; choose .vtu, .msh or .mesh");
    warn_of_point_elements(context);
  }
  warn_of_lists(mesh, context);
  warn_of_data(mesh, context);
  warn_of_names(mesh, context);
  if (mesh.second_order) context.warn(lost_middles(mesh));
  TetgenWriter files(path, context.threads);
  files.write_points(mesh);
  files.write_tets(mesh);
  files.write_faces_or_edges(".face", mesh.triangles, mesh.triangle_tags);
  if (!mesh.edges.empty() || files.exists(".edge")) {
    files.write_faces_or_edges(".edge", mesh.edges, mesh.edge_tags);
  }
  files.commit();
}

}  // namespace tetune
