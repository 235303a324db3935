// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

/// Time series of meshes: VTK's collections (`.pvd`), which list a file for each time, and Exodus files, which have
/// values for several times.
namespace tetune {

/// One mesh of a series.
struct SeriesStep {
  double time = 0;
  std::string path;
  int number = 0;  ///< of the time in an Exodus file, from 1; 0: the file is of this time alone
};

/// Reads a `.pvd` file, or the times of an Exodus file (`.e .ex2 .exo`). Paths are relative to the current folder, not
/// to that of the file; times increase. The files themselves are not read. Throws FileError for anything that is no
/// such file, an empty list, and a time with several files.
TETUNE_API std::vector<SeriesStep> read_series(const std::string& path);

/// Reads the mesh of a step with its data, as read_mesh() does.
TETUNE_API TetMesh read_step(const SeriesStep& step, std::vector<std::string>* warnings = nullptr, int threads = 0);

/// Whether the ending of a name is that of files with values for several times.
TETUNE_API bool has_times(const std::string& path);

/// Parses the bytes of a `.pvd` file; `path` stands for it in messages, and the paths in it are relative to its folder.
TETUNE_API std::vector<SeriesStep> parse_series(const std::string& path, std::string_view bytes);

/// Writes a `.pvd` file under a temporary name, then renames it. Paths in its folder are written relative to that; all
/// steps have files of their own. Throws FileError, as for no step or times that do not increase.
TETUNE_API void write_series(const std::string& path, const std::vector<SeriesStep>& steps);

}  // namespace tetune
