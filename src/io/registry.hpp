// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "io/io_context.hpp"
#include "system/file.hpp"
#include "tetune/mesh.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {

/// A program in the installation's own folder that reads and writes files through a library. It is a process of its
/// own: the library is loaded where it is used, its crash on a damaged file is an error message, and its license and
/// symbols do not affect tetune.
struct Plugin {
  /// File name of the program.
  const char* program;
  /// Name of the library.
  const char* library;
  bool reads_meshes = true;
};

inline constexpr Plugin kVtkPlugin{"tetune-vtk", "VTK"};
inline constexpr Plugin kGmshPlugin{"tetune-gmsh", "Gmsh"};
inline constexpr Plugin kOcctPlugin{"tetune-occt", "OpenCASCADE", false};

/// One file format, which functions of the library or a plugin read and write.
struct Format {
  const char* name;
  std::vector<std::string> endings;
  TetMesh (*read)(const std::string& path, const IoContext& context) = nullptr;
  /// Replaces the file as a whole or not at all. The texts of warnings name no file.
  void (*write)(const std::string& path, const TetMesh& mesh, const IoContext& context) = nullptr;
  /// The plugin of a format without functions.
  const Plugin* plugin = nullptr;
  bool plugin_writes = true;
  /// Whether some builds of the plugin's library lack the format.
  bool is_optional = false;
  /// Whether a mesh is written to a set of files, with these endings.
  bool is_set = false;
  /// Whether a file may have values for several times, of one mesh.
  bool has_times = false;
  /// What else than a mesh's elements, tags and data a file can hold.
  struct Holds {
    bool periodic_links = false, node_numbers = false, deck = false, length_unit = false;
    bool mid_side_nodes = true;
  };
  Holds holds{};
  /// The files that a file names and that are read with it; null: none.
  std::vector<std::string> (*parts)(const std::string& path) = nullptr;
  bool has_ending(const std::string& ending) const {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  }
  bool reads() const { return read != nullptr || plugin != nullptr; }
  bool writes() const { return write != nullptr || (plugin != nullptr && plugin_writes); }
};

/// Returns an empty text if a list may have this number of entries, at most `max` (kMaxTets or kMaxEntries), else the
/// reason against it. Readers refuse a count by it before memory is asked for.
std::string excess_of(std::int64_t entries, Index max);

/// The formats of this build. To add one: docs/adding-a-format.md.
const std::vector<Format>& formats();

/// The times whose values a file has; requires that its format has them. Throws as read_mesh().
std::vector<double> read_times(const std::string& path);
/// read_mesh() with the values of a time, by its number from 1; 0: of the first.
TetMesh read_mesh_at(const std::string& path, int time, const IoContext& context);

/// Reads text or binary, by the first bytes.
TetMesh read_medit(const std::string& path, const IoContext& context);
/// Reads from bytes in memory; `name` stands for them in messages.
TetMesh parse_medit(const std::string& name, std::string_view bytes, const IoContext& context);
void write_medit_text(FileWriter& file, const TetMesh& mesh, const IoContext& context);
void write_medit_binary(FileWriter& file, const TetMesh& mesh, const IoContext& context);
/// Writes a MEDIT solution in text, with one scalar field on tetrahedra per measure.
void write_medit_solution(FileWriter& file, const std::vector<Measures>& values, int threads);
TetMesh read_tetgen(const std::string& path, const IoContext& context);
/// Reads versions 2.2 and 4.1 of Gmsh's format; others with Gmsh's plugin where it is installed.
TetMesh read_msh(const std::string& path, const IoContext& context);
/// Writes the set of files to which `path` belongs.
void write_tetgen(const std::string& path, const TetMesh& mesh, const IoContext& context);
/// Writes the version and encoding of TetMesh::dialect, or 4.1 binary.
void write_msh(FileWriter& file, const TetMesh& mesh, const IoContext& context);

/// Reads a deck of Abaqus or CalculiX, with the files that it includes.
TetMesh read_inp(const std::string& path, const IoContext& context);
/// The files that a deck includes, and those that they include. Throws FileError.
std::vector<std::string> included_inp_files(const std::string& path);
/// Reads from bytes in memory; `path` stands for them in messages, and included files are relative to it.
TetMesh parse_inp(const std::string& path, std::string bytes, const IoContext& context);
/// Writes the deck that the mesh was read from with this mesh in it, or else a deck of the mesh alone. Throws FileError
/// where a part of the deck cannot follow the mesh.
void write_inp(FileWriter& file, const TetMesh& mesh, const IoContext& context);
/// The warning of other formats on the deck of a mesh, which they cannot hold.
std::string lost_deck(const TetMesh& mesh);

/// Reads Nastran's bulk data, with the files that they include.
TetMesh read_nastran(const std::string& path, const IoContext& context);
/// The files that Nastran's bulk data include, and those that they include. Throws FileError.
std::vector<std::string> included_nastran_files(const std::string& path);
/// Writes bulk data with the numbers of nodes of TetMesh::deck_nodes.
void write_nastran(FileWriter& file, const TetMesh& mesh, const IoContext& context);

/// Reads a universal file of I-deas.
TetMesh read_unv(const std::string& path, const IoContext& context);
/// Writes a universal file with the numbers of nodes of TetMesh::deck_nodes.
void write_unv(FileWriter& file, const TetMesh& mesh, const IoContext& context);

TetMesh read_su2(const std::string& path, const IoContext& context);
void write_su2(FileWriter& file, const TetMesh& mesh, const IoContext& context);

/// Reads a mesh of Netgen, compressed if the name ends in .gz.
TetMesh read_netgen(const std::string& path, const IoContext& context);
void write_netgen(FileWriter& file, const TetMesh& mesh, const IoContext& context);
void write_netgen_compressed(FileWriter& file, const TetMesh& mesh, const IoContext& context);

/// The pieces that a .pvtu file names. Throws FileError.
std::vector<std::string> vtk_pieces(const std::string& path);

/// Whether this installation has the plugin.
bool has_plugin(const Plugin& plugin);

/// `time`: the number of one of the file's times; 0: none is named. Throws FileError, with what to install, where the
/// plugin or its library is missing.
TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const IoContext& context, int time = 0);
/// The times whose values the file has.
std::vector<double> read_times_by_plugin(const Plugin& plugin, const std::string& path);

/// Writes `temporary`, a file in the folder of `path` with the same extension; messages name `path`.
void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const IoContext& context);

/// Throws FileError unless this installation has the plugin.
void require_plugin(const Plugin& plugin, const std::string& path);

/// Whether the plugin is a script, which needs packages that an installation may lack.
bool is_script(const Plugin& plugin);

/// Throws FileError unless the plugin's library has the format of the name, which some builds of it lack.
void require_format(const Plugin& plugin, const std::string& path);

}  // namespace tetune
