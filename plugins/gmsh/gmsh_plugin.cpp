// SPDX-License-Identifier: GPL-2.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

#include "closed_files.hpp"
#include "gmsh_mesh.hpp"
#include "io/losses.hpp"

namespace tetune::plugin {
namespace {

/// Throws FileError unless an .msh file starts as one: Gmsh runs any other file as a script.
void check_start(const std::string& file, const std::string& ending) {
  if (ending != ".msh") return;
  std::ifstream in(file, std::ios::binary);
  std::string start(12, '\0');
  in.read(start.data(), std::ssize(start));
  for (const char* known : {"$MeshFormat", "$Comments", "$NOD"}) {
    if (start.rfind(known, 0) == 0) return;
  }
  throw FileError("this is not a Gmsh mesh: it does not start with $MeshFormat");
}

/// Throws FileError for formats that this build of Gmsh lacks.
void check_support(const std::string& ending) {
  for (const auto& [own, feature] : {std::array{".med", "Med"}, std::array{".cgns", "Cgns"}}) {
    if (ending != own) continue;
    std::string options;
    gmsh::option::getString("General.BuildOptions", options);
    if (options.find(feature) != std::string::npos) return;
    throw FileError(std::string("this build of Gmsh has no ") + feature +
                    "; build tetune with the SDK of gmsh.info, or use .msh");
  }
}

void start_gmsh() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::logger::start();
}

/// Throws the first error that Gmsh has logged.
void check_log() {
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log) {
    if (line.rfind("Error", 0) == 0) throw FileError("Gmsh says: " + line.substr(line.find(':') + 2));
  }
}

/// Erases elements of one vertex, which Gmsh writes to other formats than its own in ways that it cannot read.
void erase_points(TetMesh& mesh, Warnings& warnings) {
  const auto points = std::find_if(mesh.others.begin(), mesh.others.end(),
                                   [](const ElementBlock& block) { return block.kind == kPoints; });
  if (points == mesh.others.end()) return;
  mesh.others.erase(points);
  std::erase_if(mesh.groups, [](const Group& group) { return group.dimension == 0; });
  warn_of_point_elements({0, &warnings});
}

template <class Action>
void guarded(const Action& action) {
  try {
    action();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (...) {
    check_log();
    throw;
  }
  check_log();
}

}  // namespace

void check(const std::string& file) {
  start_gmsh();
  check_support(ending_of(file));
}

std::vector<double> times(const std::string&) { return {}; }

TetMesh read(const std::string& file, int, Warnings& warnings) {
  const std::string ending = ending_of(file);
  check_start(file, ending);
  start_gmsh();
  check_support(ending);
  TetMesh mesh;
  guarded([&] {
    gmsh::open(file);
    check_log();
    mesh = from_gmsh(warnings);
  });
  return mesh;
}

void write(const std::string& file, TetMesh mesh, Warnings& warnings) {
  const std::string ending = ending_of(file);
  erase_points(mesh, warnings);
  start_gmsh();
  check_support(ending);
  guarded([&] {
    // Gmsh leaves elements out that are in no group when there are groups.
    gmsh::option::setNumber("Mesh.SaveAll", to_gmsh(mesh, warnings) ? 0 : 1);
    gmsh::option::setNumber("Mesh.Binary", 0);
    gmsh::write(file);
    warn_of_data(mesh, {0, &warnings}, kGeometrical);
  });
  check_closed_files();
  if (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0) throw FileError("Gmsh wrote nothing");
}

}  // namespace tetune::plugin
