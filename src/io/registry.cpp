// SPDX-License-Identifier: Apache-2.0
#include "io/registry.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "tetune/error.hpp"
#include "tetune/io.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

const Format& format_of(const std::string& path, bool to_write) {
  const std::string ending = std::filesystem::path(path).extension().string();
  for (const Format& format : formats()) {
    if (std::find(format.endings.begin(), format.endings.end(), ending) == format.endings.end()) continue;
    if (to_write ? format.write != nullptr : format.read != nullptr) return format;
  }
  std::string known;
  for (const Format& format : formats()) {
    if (to_write ? format.write == nullptr : format.read == nullptr) continue;
    for (const std::string& e : format.endings) known += (known.empty() ? "" : " ") + e;
  }
  throw FileError(path + ": tetune does not " + (to_write ? "write" : "read") + " files of ending \"" + ending +
                  "\"; known endings: " + known);
}

/// Writers index tags by element, so their lengths must agree.
void check_lengths(const std::string& path, const TetMesh& mesh) {
  const auto check = [&path](const std::string& what, std::size_t tags, std::size_t elements) {
    if (tags == elements) return;
    throw FileError(path + ": the mesh has " + std::to_string(tags) + " tags for " + std::to_string(elements) + " " +
                    what);
  };
  check("vertices", mesh.point_tags.size(), mesh.points.size());
  check("tetrahedra", mesh.tet_tags.size(), mesh.tets.size());
  check("triangles", mesh.triangle_tags.size(), mesh.triangles.size());
  check("edges", mesh.edge_tags.size(), mesh.edges.size());
  for (const ElementBlock& block : mesh.others) {
    const auto each = static_cast<std::size_t>(std::max(1, block.vertices_per_element));
    check(block.kind, block.tags.size() * each, block.element2vertex.size());
    const auto same_kind = [&block](const ElementBlock& b) { return b.kind == block.kind; };
    if (std::count_if(mesh.others.begin(), mesh.others.end(), same_kind) > 1) {
      throw FileError(path + ": the mesh has two blocks of " + block.kind + "; a file has room for one");
    }
  }
}

}  // namespace

const std::vector<Format>& formats() {
  static const std::vector<Format> list = {
      {"MEDIT text", {".mesh"}, read_medit_text, write_medit_text},
      {"MEDIT binary", {".meshb"}, read_medit_binary, write_medit_binary},
      {"TetGen", {".ele", ".node", ".face"}, read_tetgen, nullptr},
  };
  return list;
}

TetMesh read_mesh(const std::string& path, std::vector<std::string>* warnings, int threads) {
  const ReadContext context{threads, warnings};
  TetMesh mesh = format_of(path, false).read(path, context);
  orient_uniformly(mesh, threads);
  return mesh;
}

namespace {

void check_place(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  std::error_code ignored;
  if (!std::filesystem::is_directory(name, ignored)) throw FileError(path + ": the folder " + name + " does not exist");
  if (std::filesystem::is_directory(path, ignored)) throw FileError(path + ": is a folder; give a file name");
  if (::access(name.c_str(), W_OK) != 0) throw FileError(path + ": no permission to write in " + name);
}

}  // namespace

void check_writable(const std::string& path) {
  format_of(path, true);
  check_place(path);
}

void write_mesh(const std::string& path, const TetMesh& mesh, int threads) {
  const Format& format = format_of(path, true);
  check_writable(path);
  check_lengths(path, mesh);
  FileWriter file(path);
  format.write(file, mesh, threads);
  file.commit();
}

void write_measures(const std::string& path, const TetMesh& mesh, int threads) {
  if (std::filesystem::path(path).extension() != ".sol") {
    throw FileError(path + ": measures are written as a MEDIT solution; give a name that ends in .sol");
  }
  check_place(path);
  const std::vector<Measures> measures = measure_each(mesh, threads);
  FileWriter file(path);
  write_medit_solution(file, measures, threads);
  file.commit();
}

}  // namespace tetune
