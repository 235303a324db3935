// SPDX-License-Identifier: GPL-2.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "closed_files.hpp"
#include "gmsh_mesh.hpp"

namespace tetune::plugin {
namespace {

/// Gmsh takes a file that starts with anything else for one of its scripts, and runs it.
void check_start(const std::string& file, const std::string& ending) {
  std::ifstream in(file, std::ios::binary);
  std::string start(12, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  if (ending != ".msh") return;
  for (const char* known : {"$MeshFormat", "$Comments", "$NOD"}) {
    if (start.rfind(known, 0) == 0) return;
  }
  throw FileError("this is not a Gmsh mesh: it does not start with $MeshFormat");
}

/// "msh 2.2 text" and the like; empty when there is no such line.
std::string dialect_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  while (std::getline(in, line) && line.rfind("$MeshFormat", 0) != 0) {
  }
  double version = 0;
  int binary = 0;
  if (!(in >> version >> binary)) return "";
  return std::string(version < 4 ? "msh 2.2" : "msh 4.1") + (binary != 0 ? " binary" : " text");
}

/// These formats have no counts: only their last line tells that nothing is missing.
void check_end(const std::string& file, const std::string& ending, Warnings& warnings) {
  if (ending != ".unv" && ending != ".bdf") return;
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  if (last.find(ending == ".unv" ? "-1" : "ENDDATA") == std::string::npos) {
    warnings.push_back(std::string("it does not end with ") + (ending == ".unv" ? "-1" : "ENDDATA") +
                       "; the file may be cut short");
  }
}

/// Formats that Gmsh has only when it was built with another library.
void check_support(const std::string& ending) {
  for (const auto& [own, feature] : {std::array{".med", "Med"}, std::array{".cgns", "Cgns"}}) {
    if (ending != own) continue;
    std::string options;
    gmsh::option::getString("General.BuildOptions", options);
    if (options.find(feature) != std::string::npos) return;
    throw FileError(std::string("this build of Gmsh has no ") + feature +
                    " (Debian's has not); build tetune with the SDK of gmsh.info, or use .msh");
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

/// Gmsh writes elements of one vertex to other formats in ways that it cannot read itself, if at all.
void leave_out_points(TetMesh& mesh, Warnings& warnings) {
  const auto points = std::find_if(mesh.others.begin(), mesh.others.end(),
                                   [](const ElementBlock& block) { return block.kind == kPoints; });
  if (points == mesh.others.end()) return;
  mesh.others.erase(points);
  std::erase_if(mesh.groups, [](const Group& group) { return group.dimension == 0; });
  warnings.emplace_back("there is no room for elements of one vertex");
}

void refuse_pyramids(const TetMesh& mesh) {
  for (const ElementBlock& block : mesh.others) {
    if (block.kind != "Pyramids") continue;
    throw FileError("Gmsh writes no pyramids to I-deas universal files; choose .msh or .vtu");
  }
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

TetMesh read(const std::string& file, Warnings& warnings) {
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
  check_end(file, ending, warnings);
  if (ending == ".msh") mesh.dialect = dialect_of(file);
  return mesh;
}

void write(const std::string& file, TetMesh mesh, Warnings& warnings) {
  const std::string ending = ending_of(file);
  if (ending != ".msh") leave_out_points(mesh, warnings);
  if (ending == ".unv") refuse_pyramids(mesh);
  start_gmsh();
  check_support(ending);
  guarded([&] {
    const double version = mesh.dialect.rfind("msh 2.2", 0) == 0 ? 2.2 : 4.1;
    const bool all_grouped = to_gmsh(mesh, ending == ".msh" && version > 4, warnings);
    // Gmsh leaves elements out that are in no group when there are groups.
    gmsh::option::setNumber("Mesh.SaveAll", all_grouped ? 0 : 1);
    gmsh::option::setNumber("Mesh.MshFileVersion", version);
    const bool text = mesh.dialect.rfind("msh", 0) == 0 && mesh.dialect.find("text") != std::string::npos;
    gmsh::option::setNumber("Mesh.Binary", ending == ".msh" && !text ? 1 : 0);
    gmsh::option::setNumber("Mesh.BdfFieldFormat", 2);  // 16 characters a number, not 8
    if (ending == ".bdf")
      warnings.push_back("Nastran's fields have 16 characters: coordinates are rounded to about 9 digits");
    gmsh::write(file);
    if (ending == ".msh") {
      append_data(file, mesh, warnings);
    } else {
      warn_of_data(mesh, warnings);
    }
  });
  check_closed_files();
  if (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0) throw FileError("Gmsh wrote nothing");
}

}  // namespace tetune::plugin
