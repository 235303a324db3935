// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune::cli {

/// The name that stands for standard input and output.
inline constexpr const char* kPipe = "-";

/// Help text of --tags.
inline constexpr const char* kTagsHelp =
    "Name of cell data of the file (VTK, for example) that number regions, patches and lines: they replace the tags of "
    "the file";

/// A mesh with what is known of its file.
struct Input {
  TetMesh mesh;
  std::vector<std::string> warnings;
  bool binary = false;  ///< MEDIT binary
  double seconds = 0;   ///< the time of reading, without waiting for a pipe
};

/// Reads a file, or MEDIT text or binary from kPipe. Throws FileError.
Input read_input(const std::string& path, int threads);

/// Replaces the tags by the cell data of the name `tags`; if that is empty, adds a warning if some cell data
/// are probably numbers of regions. Throws OptionError.
void choose_tags(Input& input, const std::string& path, const std::string& tags);

/// Writes to a file, or to kPipe. Returns warnings about what the format cannot hold. Throws FileError.
std::vector<std::string> write_output(const std::string& path, bool binary, const TetMesh& mesh, int threads);

/// Copies the files of a mesh byte for byte where both names have the same format. Returns false where they have not,
/// or one is kPipe. Throws FileError.
bool copy_mesh(const std::string& input, const std::string& output);

/// Throws OptionError if a file exists that would be written: a second name may be a mesh that a pattern as *.mesh has
/// matched.
void refuse_existing(const std::string& output);

/// Throws OptionError if a mesh made of `input` would replace one of the files `read_too`, which may be empty names, or
/// a file that one of them or the input includes.
void refuse_replacing(const std::string& output, const std::string& input, const std::vector<std::string>& read_too);

/// The name of a file to read, or to write, in messages.
std::string shown_input(const std::string& path);
std::string shown_output(const std::string& path);

/// One mesh to optimize, and the names of all files to write; an empty name means no file.
struct Job {
  std::string input, output, report, trace, map;
  std::string page;  ///< written by the Python package after the run

  /// The text files.
  std::vector<std::string> texts() const {
    std::vector<std::string> names{report, trace, map, page};
    std::erase(names, "");
    return names;
  }
};

/// Creates the folder that a pattern of outputs names by a / at its end, unless it exists. With --dry-run the
/// destructor removes it again. Throws OptionError.
class OutputFolder {
 public:
  OutputFolder(const std::string& pattern, bool dry_run);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  std::filesystem::path remove_;
};

/// Makes one job per input from a job of patterns: "{}" stands for the input's name without folder and ending, and an
/// output that is a folder, or ends in /, gets the input's name. Throws OptionError if two jobs would write the same
/// file, or if one would write a file that another reads, one of the files `read_too`, or one that such a file
/// includes.
std::vector<Job> make_jobs(const std::vector<std::string>& inputs, const std::vector<std::string>& read_too,
                           const Job& pattern);

}  // namespace tetune::cli
