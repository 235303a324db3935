// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "io/plugin/plugin_call.hpp"
#include "io/plugin/plugin_protocol.hpp"
#include "system/child_process.hpp"
#include "system/path.hpp"
#include "system/write_all.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune {
namespace {

namespace fs = std::filesystem;

/// What add_plugin_folder() has added.
struct AddedFolders {
  std::mutex mutex;
  std::vector<fs::path> folders;
};

AddedFolders& added_folders() {
  static AddedFolders added;  // constructed where first used, which may be before main()
  return added;
}

/// The folders that are searched for programs, in this order. The working folder and folders that the environment names
/// are never among them.
std::vector<fs::path> plugin_folders() {
  const fs::path own = own_folder();
  std::vector<fs::path> folders{own / "../libexec/tetune", own / "libexec/tetune"};
  AddedFolders& added = added_folders();
  {
    const std::lock_guard lock(added.mutex);
    folders.insert(folders.end(), added.folders.begin(), added.folders.end());
  }
  folders.emplace_back(TETUNE_PLUGIN_FOLDER);
  std::erase_if(folders, [](const fs::path& folder) { return !folder.is_absolute(); });
  return folders;
}

/// Returns the path of the program, or an empty one.
std::string find_program(const Plugin& plugin) {
  for (const fs::path& folder : plugin_folders()) {
    std::error_code ignored;
    const fs::path program = folder / plugin.program;
    if (fs::is_regular_file(program, ignored)) return program.string();
  }
  return {};
}

/// Throws FileError where a program ended without an answer.
void check_status(const ExitStatus& status, const Plugin& plugin, const char* verb, const std::string& path,
                  bool has_input) {
  const std::string library = plugin.library;
  if (status.code == kPluginNotLoaded) {
    throw FileError(path + ": tetune's plugin for " + library + " cannot start: a shared library is missing; install " +
                    library);
  }
  if (status.code == kPluginNoInterpreter) {
    throw FileError(path + ": tetune's plugin for " + library +
                    " cannot start: there is no Python interpreter to run it; install tetune again with the Python in "
                    "use");
  }
  if (status.code == 0 && status.signal.empty()) return;
  throw FileError(path + ": " + library + " failed to " + verb + " it (" +
                  (status.signal.empty() ? "exit code " + std::to_string(status.code) : status.signal) + ")" +
                  (has_input ? "" : "; the file is damaged, or of a kind that " + library + " does not read"));
}

/// Replaces what is in the channel.
void write_input(const MemoryFile& channel, const Plugin& plugin, const std::string& path,
                 const std::function<void(PluginWriter&)>& write) {
  channel.clear();
  PluginWriter writer([&](const void* data, std::size_t bytes) {
    if (write_all(channel.descriptor(), data, bytes)) return;
    throw FileError(path + ": no memory for handing the mesh to " + plugin.library + ": " + std::strerror(errno));
  });
  writer(kStreamVersion);
  write(writer);
}

/// Throws FileError where the answer has an error or is none.
void read_answer(const MemoryFile& channel, const Plugin& plugin, const std::string& path, const IoContext& context,
                 const std::function<void(MeshReader&)>& read) {
  const MappedFile mapped(channel.descriptor(), path);
  MeshReader answer(mapped.bytes());
  std::uint64_t version = 0;
  if (mapped.bytes().size() >= sizeof version) answer(version);
  if (version != kAnswerVersion) {
    throw FileError(path + ": tetune's plugin for " + plugin.library +
                    " gave no answer, or is of another build; install tetune again");
  }
  std::string error;
  std::vector<std::string> warnings;
  try {
    answer(error, warnings);
    if (error.empty() && read) read(answer);
  } catch (const FileError& e) {
    throw FileError(path + ": the answer of tetune's plugin for " + plugin.library + ": " + e.what() +
                    "; install tetune again");
  }
  if (!error.empty()) throw FileError(path + ": " + error);
  for (const std::string& warning : warnings) context.warn(path + ": " + warning);
}

/// A run of a plugin's program on a file.
struct PluginRun {
  const char* verb;
  std::string path;                               ///< of the file in messages
  std::string file = {};                          ///< the one that the program opens; empty: `path`
  int time = 0;                                   ///< the number of one of the file's times; 0: none is named
  std::function<void(PluginWriter&)> write = {};  ///< encodes the input; may be empty
  std::function<void(MeshReader&)> read = {};     ///< decodes the rest of the answer; may be empty
};

/// Returns when the program has answered. Throws FileError, with what to install where the plugin or its library is
/// missing.
void run_plugin(const Plugin& plugin, const PluginRun& run, const IoContext& context) {
  require_plugin(plugin, run.path);
  const MemoryFile channel;
  if (run.write) write_input(channel, plugin, run.path, run.write);
  std::vector<std::string> words{run.verb, run.file.empty() ? run.path : run.file};
  if (run.time > 0) words.push_back(std::to_string(run.time));
  check_status(run_program(find_program(plugin), words, channel, kPluginDescriptor), plugin, run.verb, run.path,
               run.write || !run.read);
  read_answer(channel, plugin, run.path, context, run.read);
}

}  // namespace

void PluginSession::call(const char* verb, const IoContext& context, const std::function<void(PluginWriter&)>& write,
                         const std::function<void(MeshReader&)>& read) {
  const std::lock_guard lock(mutex_);
  if (!process_) {
    require_plugin(plugin_, file_);
    channel_ = std::make_unique<MemoryFile>();
    process_ = std::make_unique<ChildProcess>(find_program(plugin_), std::vector<std::string>{"serve", file_},
                                              *channel_, kPluginDescriptor);
  }
  write_input(*channel_, plugin_, file_, [&](PluginWriter& out) {
    out(std::string(verb));
    if (write) write(out);
  });
  if (const auto status = process_->request()) check_status(*status, plugin_, verb, file_, bool(write));
  read_answer(*channel_, plugin_, file_, context, read);
}

bool has_plugin(const Plugin& plugin) { return !find_program(plugin).empty(); }

bool is_script(const Plugin& plugin) {
  std::ifstream file(find_program(plugin), std::ios::binary);
  return file.get() == '#' && file.get() == '!';
}

void require_plugin(const Plugin& plugin, const std::string& path) {
  if (!has_child_processes()) {
    throw FileError(path + ": files with the extension \"" + path_of(path).extension().string() +
                    "\" need tetune's plugin for " + plugin.library + ", which exists on Linux only" +
                    (plugin.reads_meshes ? "; convert the mesh to .mesh, .meshb, .msh or .inp first, for example with "
                                           "meshio or Gmsh"
                                         : ""));
  }
  if (has_plugin(plugin)) return;
  std::string searched;
  for (const fs::path& folder : plugin_folders()) {
    const std::string name = folder.lexically_normal().string();
    searched += (searched.empty() ? "" : ", ") + name;
  }
  throw FileError(path + ": files with the extension \"" + path_of(path).extension().string() +
                  "\" need tetune's plugin for " + plugin.library + ": there is no " + plugin.program + " in " +
                  searched + "; install " + plugin.library +
                  " with its headers and build tetune again, or, in a program, name the folder that has it "
                  "(add_plugin_folder())");
}

void add_plugin_folder(const std::string& folder) {
  const fs::path path = path_of(folder);
  if (!path.is_absolute()) throw OptionError("add_plugin_folder(): \"" + folder + "\" is not an absolute path");
  AddedFolders& added = added_folders();
  const std::lock_guard lock(added.mutex);
  if (std::find(added.folders.begin(), added.folders.end(), path) == added.folders.end()) {
    added.folders.push_back(path);
  }
}

TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const IoContext& context, int time) {
  { const MappedFile readable(path); }  // an error of opening has the same message for all formats
  TetMesh mesh;
  const auto read = [&](MeshReader& answer) { answer(mesh); };
  run_plugin(plugin, {.verb = "read", .path = path, .time = time, .read = read}, context);
  return mesh;
}

std::vector<double> read_times_by_plugin(const Plugin& plugin, const std::string& path) {
  { const MappedFile readable(path); }
  std::vector<double> times;
  const auto read = [&](MeshReader& answer) { answer(times); };
  run_plugin(plugin, {.verb = "times", .path = path, .read = read}, {});
  return times;
}

void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const IoContext& context) {
  const auto write = [&](PluginWriter& out) { out(mesh); };
  run_plugin(plugin, {.verb = "write", .path = path, .file = temporary, .write = write}, context);
}

void require_format(const Plugin& plugin, const std::string& path) {
  run_plugin(plugin, {.verb = "check", .path = path}, {});
}

}  // namespace tetune
