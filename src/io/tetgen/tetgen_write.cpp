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
  TetgenWriter(const std::string& path, int threads) : path_(path_of(path)), threads_(threads) {}

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
  /// Writes elements; `head`: what follows their number in the first line, before the flag of tags.
  template <std::size_t N>
  void write_elements(const char* ending, const char* head, const std::vector<std::array<Index, N>>& elements,
                      const std::vector<int>& tags, bool inside_out = false) {
    LineWriter out = start(ending);
    const bool tagged = has_tag(tags);
    out.text(std::to_string(elements.size()) + head + (tagged ? " 1\n" : " 0\n"));
    out.lines(elements.size(), [&](auto& entry, std::size_t i) {
      entry.integer(i + 1);
      auto vertices = elements[i];
      if (inside_out) std::swap(vertices[N - 2], vertices[N - 1]);
      for (const Index v : vertices) entry.integer(v + 1);
      if (tagged) entry.integer(tags[i]);
    });
  }
  /// Whether there is a file of the set with this ending, which must not stay beside the others.
  bool exists(const char* ending) const {
    std::error_code ignored;
    return std::filesystem::exists(std::filesystem::path(path_).replace_extension(ending), ignored);
  }
  void commit() {
    for (const auto& file : files_) file->commit();
  }

 private:
  LineWriter start(const char* ending) {
    const std::string name = std::filesystem::path(path_).replace_extension(ending).string();
    check_place(name);
    files_.push_back(std::make_unique<FileWriter>(name));
    return {*files_.back(), threads_};
  }
  std::filesystem::path path_;
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
  files.write_elements(".ele", " 4", mesh.tets, mesh.tet_tags, mesh.listed_inside_out);
  files.write_elements(".face", "", mesh.triangles, mesh.triangle_tags);
  if (!mesh.edges.empty() || files.exists(".edge")) {
    files.write_elements(".edge", "", mesh.edges, mesh.edge_tags);
  }
  files.commit();
}

}  // namespace tetune
