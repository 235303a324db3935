// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune::cli {

/// The name that stands for standard input and output.
inline constexpr const char* kPipe = "-";

/// Of the option --tags.
inline constexpr const char* kTagsHelp =
    "Cell data of the file (VTK, for example) that number its regions, patches and lines: they are the tags then, in "
    "the place of those that the file has";

/// A mesh as it was read.
struct Input {
  TetMesh mesh;
  std::vector<std::string> warnings;
  bool binary = false;  ///< MEDIT binary
  double seconds = 0;   ///< that reading took, without waiting for a pipe
};

/// Of a file, or of kPipe: MEDIT, text or binary. Throws FileError.
Input read_input(const std::string& path, int threads);

/// Takes cell data for the tags; `tags` empty: leaves these, and warns where they may not be what is meant. Throws
/// OptionError.
void choose_tags(Input& input, const std::string& path, const std::string& tags);

/// To a file, or to kPipe. Returns warnings: what the format has no room for. Throws FileError.
std::vector<std::string> write_output(const std::string& path, bool binary, const TetMesh& mesh, int threads);

/// Messages name it so.
std::string shown_name(const std::string& path, bool output);

/// One mesh to optimise, and the names of all files that come of it; empty: none.
struct Job {
  std::string input, output, report, trace, map;
};

/// Where the pattern of an output ends in /: makes that folder unless it is there, and takes it away again if it was
/// made for a look alone. Throws OptionError.
class MadeFolder {
 public:
  MadeFolder(const std::string& pattern, bool for_a_look);
  ~MadeFolder();
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;

 private:
  std::filesystem::path remove_;
};

/// Fills in the patterns of `pattern` for each input: "{}" is the input's name without folder and ending; an output
/// that ends in / or is a folder gets the input's name. Throws OptionError where two jobs would write the same file, or
/// one writes what another reads.
std::vector<Job> make_jobs(const std::vector<std::string>& inputs, const Job& pattern);

}  // namespace tetune::cli
