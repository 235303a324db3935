// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Reads a mesh. The format follows from the name:
///   .mesh              MEDIT text (versions 1 to 4)
///   .meshb             MEDIT binary (versions 1 to 4, either byte order)
///   .ele .node .face   TetGen; the siblings of the same stem are read along
/// Things worth telling the user (skipped sections and the like) are appended to `warnings` when given.
/// When every tetrahedron is listed inside out, all are turned and `listed_inside_out` is set.
/// Throws FileError with file, place and remedy. `threads` 0 means all.
TetMesh read_mesh(const std::string& path, std::vector<std::string>* warnings = nullptr, int threads = 0);

/// Writes a mesh as .mesh or .meshb by the name: to a temporary file beside it, renamed once complete, so
/// that a failure leaves an old file untouched. Text carries the shortest digits that read back to the same bits.
/// Throws FileError. `threads` 0 means all.
void write_mesh(const std::string& path, const TetMesh& mesh, int threads = 0);

/// Throws FileError when `path` has an ending that write_mesh does not know or lies in a folder that is not
/// there or not writable: to fail before the work rather than after it.
void check_writable(const std::string& path);

}  // namespace tetune
