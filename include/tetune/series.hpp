// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tetune/export.hpp"

/// Time series of meshes: VTK's collections (`.pvd`), which list a file for each time.
namespace tetune {

/// One mesh of a series.
struct SeriesStep {
  double time = 0;
  std::string path;
};

/// Reads a `.pvd` file. Paths are relative to the current folder, not to that of the file; times increase. The files
/// themselves are not read. Throws FileError, with the line, for anything that is no such file, an empty list, and a
/// time with several files.
TETUNE_API std::vector<SeriesStep> read_series(const std::string& path);

/// Parses the bytes of a `.pvd` file; `path` stands for it in messages, and the paths in it are relative to its folder.
TETUNE_API std::vector<SeriesStep> parse_series(const std::string& path, std::string_view bytes);

/// Writes a `.pvd` file under a temporary name, then renames it. Paths in its folder are written relative to that.
/// Throws FileError.
TETUNE_API void write_series(const std::string& path, const std::vector<SeriesStep>& steps);

}  // namespace tetune
