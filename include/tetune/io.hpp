// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Reads a mesh. The format follows from the name:
/// - `.mesh`: MEDIT text (versions 1 to 4)
/// - `.meshb`: MEDIT binary (versions 1 to 4, either byte order)
/// - `.ele .node .face`: TetGen; the siblings of the same stem are read along
/// - `.vtu .pvtu .vtk`: VTK: unstructured grids, XML (whole or in parts) and legacy
/// - `.e .ex2 .exo`: Exodus
/// - `.msh`: Gmsh (versions 1 to 4.1, text or binary)
/// - `.unv .bdf .med .cgns`: I-deas universal, Nastran, MED, CGNS
///
/// The last four through programs of the installation on top of VTK and Gmsh (docs/formats.md).
/// Things worth telling the user (skipped sections and the like) are appended to `warnings` when given.
/// Tetrahedra that are listed inside out are turned: all of them silently (`listed_inside_out` is set), some with a
/// warning; see orient_uniformly().
/// Throws FileError with file, place and remedy. `threads` 0 means all.
TetMesh read_mesh(const std::string& path, std::vector<std::string>* warnings = nullptr, int threads = 0);

/// The same from memory: the bytes of a MEDIT file, text or binary, whichever it is. `name` is what messages call it.
TetMesh parse_mesh(const std::string& name, std::string_view bytes, std::vector<std::string>* warnings = nullptr,
                   int threads = 0);

/// Writes a mesh in the format that the name says, those above but .ele .node .face .pvtu, and .inp (Abaqus): to a
/// temporary file beside it, renamed once complete, so that a failure leaves an old file untouched. MEDIT text carries
/// the shortest digits that read back to the same bits. What the format has no room for (data, names) is told in
/// `warnings` when given. Throws FileError. `threads` 0 means all.
void write_mesh(const std::string& path, const TetMesh& mesh, int threads = 0,
                std::vector<std::string>* warnings = nullptr);

/// The same to an open file descriptor, for pipes: in MEDIT text, or binary. `name` is what messages call it.
void write_mesh(int descriptor, const std::string& name, bool binary, const TetMesh& mesh, int threads = 0,
                std::vector<std::string>* warnings = nullptr);

/// Writes any text to a file as write_mesh() does: under a temporary name, then renamed. Throws FileError.
void write_text(const std::string& path, std::string_view text);

/// Deletes the temporary files of all writes in progress, for a signal handler before _exit(): old files are then
/// untouched and nothing else is left. A write that begins after it never returns. Returns whether one of them had its
/// final name by then.
bool remove_temporary_files() noexcept;

/// Throws FileError when `path` has an ending that write_mesh does not know or lies in a folder that is not
/// there or not writable: to fail before the work rather than after it.
void check_writable(const std::string& path);

/// Endings that read_mesh() and write_mesh() know: ".mesh .meshb ...".
std::string readable_endings();
std::string writable_endings();

}  // namespace tetune
