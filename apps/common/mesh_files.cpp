// SPDX-License-Identifier: Apache-2.0
#include "mesh_files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include "system/path.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

constexpr const char* kPlaceholder = "{}";

/// The number of the meshes of a command.
enum class Meshes { one, several };

std::string read_pipe() {
  std::string bytes;
  std::size_t size = 0;
  constexpr std::size_t kMaxPart = std::size_t{1} << 30;
  for (;;) {
    if (bytes.size() - size < (1U << 16)) bytes.resize(std::max<std::size_t>(1U << 20, 2 * bytes.size()));
    const auto got = ::read(STDIN_FILENO, bytes.data() + size, unsigned(std::min(bytes.size() - size, kMaxPart)));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw FileError(std::string("standard input: cannot read: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  bytes.resize(size);
  return bytes;
}

/// The canonical path: equal for all names of one file.
std::string identity(const std::string& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(path_of(path), error);
  const std::filesystem::path same = error ? whole : std::filesystem::weakly_canonical(whole, error);
  return error ? path : same.string();
}

/// Whether the name ends like that of a folder.
bool names_folder(const std::string& name) {
  return name.ends_with('/') || name.ends_with(char(std::filesystem::path::preferred_separator));
}

std::string fill_in(const std::string& option, const std::string& pattern, const std::string& input, Meshes meshes) {
  const std::size_t at = pattern.find(kPlaceholder);
  if (pattern == kPipe && option != "--output") {
    throw OptionError(option + " -: only the mesh can be written to the standard output; give a file name");
  }
  if (pattern.empty() || (at == std::string::npos && meshes == Meshes::one)) return pattern;
  if (at == std::string::npos) {
    throw OptionError(
        fmt::format("{} {}: there are several meshes; use {{}} in the name, which stands for the name of each mesh",
                    option, pattern));
  }
  if (input == kPipe) {
    throw OptionError(fmt::format("{} {}: the standard input has no name to insert; give a name", option, pattern));
  }
  return pattern.substr(0, at) + path_of(input).stem().string() + pattern.substr(at + std::strlen(kPlaceholder));
}

std::string output_of(const std::string& pattern, const std::string& input, Meshes meshes) {
  std::error_code ignored;
  const bool folder = names_folder(pattern) || std::filesystem::is_directory(path_of(pattern), ignored);
  if (folder) {
    if (input == kPipe) {
      throw OptionError(
          fmt::format("--output {}: the standard input has no name to use in a folder; give a name", pattern));
    }
    return (path_of(pattern) / path_of(input).filename()).string();
  }
  if (meshes == Meshes::several && !pattern.empty() && pattern.find(kPlaceholder) == std::string::npos) {
    throw OptionError(
        fmt::format("--output {}: there are several meshes; give a folder (with / at its end), or a name with {{}}, "
                    "which stands for the name of each mesh",
                    pattern));
  }
  return fill_in("--output", pattern, input, meshes);
}

/// The name of cell data that are probably numbers of regions, if the tags are all the same: few integers, each of many
/// tetrahedra. Empty if there are none.
std::string unused_regions(const TetMesh& mesh) {
  constexpr std::size_t kMaxRegions = 50;
  const auto all_same = [](const auto& values) {
    return std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
  };
  if (!all_same(mesh.tet_tags) || !mesh.groups.empty()) return "";
  const auto is_few_integers = [](const auto& values) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    if constexpr (std::is_integral_v<T>) {
      std::set<T> different;
      for (std::size_t i = 0; i < values.size() && different.size() <= kMaxRegions; ++i) different.insert(values[i]);
      return different.size() > 1 && different.size() <= kMaxRegions && 10 * different.size() <= values.size();
    }
    return false;
  };
  for (const DataArray& array : mesh.tet_data) {
    if (array.components == 1 && std::visit(is_few_integers, array.values)) return array.name;
  }
  return "";
}

/// The numbers of Gmsh's entities, as data of meshes whose tags are physical groups.
constexpr const char* kEntities = "gmsh:geometrical";

/// Whether two tetrahedra of one tag, but of different volumes of Gmsh, share a face.
bool joins_volumes(const TetMesh& mesh) {
  const auto data = std::find_if(mesh.tet_data.begin(), mesh.tet_data.end(), [](const DataArray& array) {
    return array.name == kEntities && array.components == 1;
  });
  const auto* const volumes =
      data == mesh.tet_data.end() ? nullptr : std::get_if<std::vector<std::int32_t>>(&data->values);
  if (volumes == nullptr || mesh.groups.empty()) return false;
  const auto both = [&](std::size_t t) { return std::pair(mesh.tet_tags[t], (*volumes)[t]); };
  std::map<int, int> tag2volume;
  bool is_divided = false;
  for (std::size_t t = 0; t < mesh.tets.size() && !is_divided; ++t) {
    if (t > 0 && both(t) == both(t - 1)) continue;
    is_divided = tag2volume.insert(both(t)).first->second != (*volumes)[t];
  }
  if (!is_divided) return false;
  // Only vertices of several volumes can be on a common face.
  std::vector<std::size_t> first_tet(mesh.points.size(), mesh.tets.size());
  std::vector<bool> is_common(mesh.points.size(), false);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) {
      std::size_t& first = first_tet[std::size_t(v)];
      first = std::min(first, t);
      if ((*volumes)[first] != (*volumes)[t]) is_common[std::size_t(v)] = true;
    }
  }
  std::map<std::array<Index, 3>, std::size_t> face2tet;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto& v = mesh.tets[t];
      std::array<Index, 3> face{v[k == 0 ? 1 : 0], v[k <= 1 ? 2 : 1], v[k <= 2 ? 3 : 2]};
      if (!std::all_of(face.begin(), face.end(), [&](Index u) { return is_common[std::size_t(u)]; })) continue;
      std::sort(face.begin(), face.end());
      const std::size_t other = face2tet.try_emplace(face, t).first->second;
      if (mesh.tet_tags[other] == mesh.tet_tags[t] && (*volumes)[other] != (*volumes)[t]) return true;
    }
  }
  return false;
}

/// The files that a mesh is written to: the data of an .xmf file of tetune-mpi are in an .h5 file beside it.
std::vector<std::string> files_written(const std::string& output) {
  std::vector<std::string> files = files_of(output);
  if (ending_of(output) == ".xmf") files.push_back(with_ending(output, ".h5"));
  return files;
}

/// Finds files that would be written twice, or written and read.
class ClashFinder {
 public:
  /// `read_too`: files that are read besides the meshes.
  ClashFinder(const std::vector<std::string>& inputs, const std::vector<std::string>& read_too)
      : inputs_(inputs), read_too_(read_too) {
    for (const std::string& input : inputs) {
      for (const std::string& file : files_of(input)) {
        if (!replaceable_.emplace(identity(file), input).second) {
          throw OptionError(input + ": this mesh is named twice");
        }
      }
    }
  }

  /// Adds the files of the mesh that is made of `input`, which may replace that. Throws OptionError.
  void add_mesh(const std::string& output, const std::string& input) { add(output, input, Content::mesh); }
  /// Adds a text file that is written for `input`. Throws OptionError.
  void add_text(const std::string& output, const std::string& input) { add(output, input, Content::text); }

 private:
  enum class Content { mesh, text };

  void add(const std::string& output, const std::string& input, Content content) {
    if (output.empty() || output == kPipe) return;
    for (const std::string& file : content == Content::mesh ? files_written(output) : std::vector{output}) {
      const std::string same = identity(file);
      const auto [other, first] = written_.emplace(same, input);
      if (!first) {
        throw OptionError(
            fmt::format("{} would be written {}; give another name", file,
                        other->second == input ? "twice" : fmt::format("for {} and for {}", other->second, input)));
      }
      const auto source = replaceable_.find(same);
      const bool is_other = source != replaceable_.end() && (source->second != input || content == Content::text);
      if (is_other || is_read(file, same)) {
        throw OptionError(
            fmt::format("{} would be written for {}, but is read as well; give another name", file, input));
      }
    }
  }

  /// Whether a file is one of `read_too` or a part of another file. Those are searched for parts where the file exists.
  bool is_read(const std::string& file, const std::string& same) {
    std::error_code ignored;
    if (!std::filesystem::exists(path_of(file), ignored)) return false;
    if (!std::exchange(has_kept_, true)) {
      for (const std::string& input : inputs_) keep(input);
      for (const std::string& name : read_too_) keep(name);
    }
    return kept_.contains(same);
  }
  void keep(const std::string& name) {
    if (name.empty() || name == kPipe) return;
    const std::vector<std::string> files = files_read(name);
    const std::size_t own = files_of(name).size();
    for (std::size_t i = 0; i < files.size(); ++i) {
      std::string same = identity(files[i]);
      if (i >= own || !replaceable_.contains(same)) kept_.insert(std::move(same));
    }
  }

  const std::vector<std::string>& inputs_;
  const std::vector<std::string>& read_too_;
  std::map<std::string, std::string> replaceable_;  // file of a mesh to its input
  std::map<std::string, std::string> written_;      // file to the input of its mesh
  std::set<std::string> kept_;
  bool has_kept_ = false;
};

}  // namespace

Input read_input(const std::string& path, int threads) {
  Input input;
  const std::string bytes = path == kPipe ? read_pipe() : "";
  const auto start = std::chrono::steady_clock::now();
  if (path == kPipe) {
    input.mesh = parse_mesh(shown_input(path), bytes, &input.warnings, threads);
    input.binary = bytes.substr(0, 4).find('\0') != std::string::npos;
  } else {
    input.mesh = read_mesh(path, &input.warnings, threads);
    input.binary = ending_of(path) == ".meshb";
  }
  input.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return input;
}

void choose_tags(Input& input, const std::string& path, const std::string& tags) {
  if (!tags.empty()) {
    try {
      use_as_tags(input.mesh, tags);
    } catch (const OptionError& e) {
      throw OptionError(fmt::format("--tags \"{}\": {}: {}", tags, shown_input(path), e.what()));
    }
  } else if (const std::string data = unused_regions(input.mesh); !data.empty()) {
    input.warnings.push_back(
        fmt::format("the cell data \"{0}\" look like numbers of regions, but do not constrain: with --tags \"{0}\" "
                    "the interfaces between these regions are kept",
                    data));
  } else if (joins_volumes(input.mesh)) {
    input.warnings.push_back(
        "volumes in one physical group touch each other: the faces between them are not kept, unless each of the "
        "volumes is in a group of its own too");
  }
}

std::vector<std::string> write_output(const std::string& path, bool binary, const TetMesh& mesh, int threads) {
  std::vector<std::string> warnings;
  if (path == kPipe) {
    write_mesh(STDOUT_FILENO, shown_output(path), binary, mesh, threads, &warnings);
  } else {
    write_mesh(path, mesh, threads, &warnings);
  }
  return warnings;
}

bool copy_mesh(const std::string& input, const std::string& output) {
  if (input == kPipe || output == kPipe || ending_of(input) != ending_of(output)) return false;
  if (files_of(input).size() > 1) return false;
  if (identity(input) == identity(output)) return true;
  // The names of included files are relative to the folder of the input.
  if (files_read(input).size() > 1) return false;
  std::ifstream file(path_of(input), std::ios::binary | std::ios::ate);
  std::string bytes(std::size_t(std::max<std::streamoff>(0, file.tellg())), '\0');
  file.seekg(0);
  // A short read must not become a shorter mesh.
  if (!file.read(bytes.data(), std::streamsize(bytes.size()))) {
    throw FileError(input + ": cannot read: " + std::strerror(errno));
  }
  write_text(output, bytes);
  return true;
}

void refuse_replacing(const std::string& output, const std::string& input, const std::vector<std::string>& read_too) {
  const std::vector<std::string> inputs{input};
  ClashFinder(inputs, read_too).add_mesh(output, input);
}

void refuse_existing(const std::string& output) {
  for (const std::string& file : files_written(output)) {
    std::error_code ignored;
    if (output == kPipe || !std::filesystem::exists(path_of(file), ignored)) continue;
    throw OptionError(
        fmt::format("{}: the second name is that of the mesh to write, and {} exists; to read both, name a folder with "
                    "-o FOLDER/, to replace it, -o {}",
                    output, file == output ? "this file" : file, output));
  }
}

std::string shown_input(const std::string& path) { return path == kPipe ? "standard input" : path; }
std::string shown_output(const std::string& path) { return path == kPipe ? "standard output" : path; }

OutputFolder::OutputFolder(const std::string& pattern, bool dry_run) {
  if (!names_folder(pattern)) return;
  std::error_code error;
  const std::filesystem::path folder = path_of(pattern).parent_path();
  const bool created = std::filesystem::create_directory(folder, error);
  if (!std::filesystem::is_directory(folder)) {
    throw OptionError(fmt::format("--output {}: the folder does not exist and cannot be created{}", pattern,
                                  error ? ": " + error.message() : ""));
  }
  if (created && dry_run) remove_ = folder;
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!remove_.empty()) std::filesystem::remove(remove_, ignored);
}

std::vector<Job> make_jobs(const std::vector<std::string>& inputs, const std::vector<std::string>& read_too,
                           const Job& pattern) {
  const Meshes meshes = inputs.size() > 1 ? Meshes::several : Meshes::one;
  std::vector<Job> jobs;
  if (meshes == Meshes::several && std::find(inputs.begin(), inputs.end(), kPipe) != inputs.end()) {
    throw OptionError("the standard input (-) cannot be one of several meshes");
  }
  ClashFinder clashes(inputs, read_too);
  for (const std::string& input : inputs) {
    const Job job{input,
                  output_of(pattern.output, input, meshes),
                  fill_in("--report", pattern.report, input, meshes),
                  fill_in("--trace", pattern.trace, input, meshes),
                  fill_in("--map", pattern.map, input, meshes),
                  fill_in("--report-html", pattern.page, input, meshes)};
    clashes.add_mesh(job.output, input);
    for (const std::string& text : job.texts()) clashes.add_text(text, input);
    jobs.push_back(job);
  }
  return jobs;
}

}  // namespace tetune::cli
