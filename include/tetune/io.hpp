// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Reads a mesh. The ending of the name says which format it is:
/// - `.mesh`: MEDIT text (versions 1 to 4)
/// - `.meshb`: MEDIT binary (versions 1 to 4, either byte order)
/// - `.ele .node .face`: TetGen; the other files of the same stem are read too
/// - `.vtu .pvtu .vtk`: VTK: unstructured grids, XML (one file, or parts) and legacy
/// - `.e .ex2 .exo`: Exodus
/// - `.msh`: Gmsh (versions 2.2 and 4.1, text or binary, either byte order)
/// - `.inp`: decks of Abaqus and CalculiX (tetrahedra of 4 or 10 nodes); all around the mesh is kept in TetMesh::deck
/// - `.su2`: SU2
/// - `.vol`, `.vol.gz`: Netgen
/// - `.bdf .nas`: Nastran's bulk data
/// - `.unv`: universal files of I-deas
/// - `.med .cgns`: MED, CGNS
///
/// Files of VTK and Exodus, the last two, and other versions of `.msh` are read by separate programs of the
/// installation that use VTK and Gmsh (docs/formats.md).
/// Skipped sections and the like are reported in `warnings`, if given. Tetrahedra that are listed inside out are
/// reversed: if all are, without a warning (`listed_inside_out` is set); see orient_uniformly(). Throws FileError,
/// whose message names file, place and remedy. `threads` 0 means all.
TETUNE_API TetMesh read_mesh(const std::string& path, std::vector<std::string>* warnings = nullptr, int threads = 0);

/// Parses the bytes of a MEDIT file, text or binary, in memory. `name` stands for the file in messages. Otherwise as
/// read_mesh().
TETUNE_API TetMesh parse_mesh(const std::string& name, std::string_view bytes,
                              std::vector<std::string>* warnings = nullptr, int threads = 0);

/// Writes a mesh in the format that the ending of the name says: those of read_mesh() except .pvtu; for
/// .ele, .node and .face all of TetGen's files. The file is written under a temporary name and renamed
/// once complete, so that a failure or an interruption leaves an old file unchanged. MEDIT text has the shortest digits
/// that read back to the same bits. Data and names that the format cannot hold are reported in `warnings`, if given.
/// Throws FileError. `threads` 0 means all.
TETUNE_API void write_mesh(const std::string& path, const TetMesh& mesh, int threads = 0,
                           std::vector<std::string>* warnings = nullptr);

/// Writes a mesh in MEDIT text or binary to an open file descriptor, for pipes. `name` stands for the file in messages.
/// Otherwise as above.
TETUNE_API void write_mesh(int descriptor, const std::string& name, bool binary, const TetMesh& mesh, int threads = 0,
                           std::vector<std::string>* warnings = nullptr);

/// Writes text to a file under a temporary name, then renames it, as write_mesh() does. Throws FileError.
TETUNE_API void write_text(const std::string& path, std::string_view text);

/// Throws FileError unless a file can be created at `path`: to fail before the work rather than after it. A file that
/// exists stays.
TETUNE_API void check_place(const std::string& path);

/// check_place(), and throws FileError if write_mesh() does not know the ending of `path`.
TETUNE_API void check_writable(const std::string& path);

/// Throws FileError where the format of `path` has no nodes in the middles of edges: write_mesh() drops them there.
TETUNE_API void check_second_order(const std::string& path);

/// The names of the files that write_mesh() writes for a name: several for TetGen, in which any of them names the mesh.
TETUNE_API std::vector<std::string> files_of(const std::string& path);

/// The names of the files that read_mesh(), or read_series() with read_step(), reads for a name: also those that a deck
/// includes, pieces of a .pvtu file and meshes of a series. A file that cannot be read names no others.
TETUNE_API std::vector<std::string> files_read(const std::string& path);

/// The endings that read_mesh() and write_mesh() know: ".mesh .meshb ...".
TETUNE_API std::string readable_endings();
TETUNE_API std::string writable_endings();

/// Adds a folder to those in which the programs that use VTK, Gmsh and OpenCASCADE are searched for:
/// `../libexec/tetune` and `libexec/tetune` beside the library (a static one: beside the running program), these
/// folders, and the one that CMAKE_INSTALL_PREFIX named when the library was built. Programs in it run with the rights
/// of this process. Throws OptionError unless the path is absolute.
TETUNE_API void add_plugin_folder(const std::string& folder);

#ifdef TETUNE_INSTALLED_PLUGINS
/// A static library cannot find its installation; find_package(tetune) defines the folder.
inline const bool kHasInstalledPlugins = (add_plugin_folder(TETUNE_INSTALLED_PLUGINS), true);
#endif

}  // namespace tetune
