// SPDX-License-Identifier: Apache-2.0
#include "io/registry.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "io/mesh_stream.hpp"
#include "io/plugin_protocol.hpp"
#include "system/child_process.hpp"
#include "system/path.hpp"
#include "system/write_all.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

namespace fs = std::filesystem;

/// Returns the path of the program, or an empty one. The working folder and folders that the environment names are
/// never searched.
std::string find_program(const Plugin& plugin) {
  const fs::path own = own_folder();
  for (const fs::path& folder : {own / "../libexec/tetune", own / "libexec/tetune", fs::path(TETUNE_PLUGIN_FOLDER)}) {
    std::error_code ignored;
    const fs::path program = folder / plugin.program;
    if (folder.is_absolute() && fs::is_regular_file(program, ignored)) return program.string();
  }
  return {};
}

/// A call of a plugin that concerns the file `path`.
class Call {
 public:
  Call(const Plugin& plugin, const std::string& path) : path_(path), library_(plugin.library) {
    require_plugin(plugin, path);
    program_ = find_program(plugin);
  }

  void send(const TetMesh& mesh) {
    MeshWriter writer([this](const void* data, std::size_t bytes) {
      if (write_all(channel_.descriptor(), data, bytes)) return;
      throw FileError(path_ + ": no memory for handing the mesh to " + library_ + ": " + std::strerror(errno));
    });
    writer(kStreamVersion, mesh);
  }

  /// Runs the program on `file` and reads its answer; the rest of the answer is a mesh when `mesh` is given.
  void run(const char* verb, const std::string& file, const IoContext& context, TetMesh* mesh = nullptr) {
    const ExitStatus status = run_program(program_, {verb, file}, channel_, kPluginDescriptor);
    if (status.code == kPluginNotLoaded) {
      throw FileError(path_ + ": tetune's plugin for " + library_ +
                      " cannot start: a shared library is missing; install " + library_);
    }
    if (status.code != 0 || !status.signal.empty()) {
      throw FileError(
          path_ + ": " + library_ + " failed to " + verb + " it (" +
          (status.signal.empty() ? "exit code " + std::to_string(status.code) : status.signal) + ")" +
          (mesh != nullptr ? "; the file is damaged, or of a kind that " + library_ + " does not read" : ""));
    }
    const MappedFile mapped(channel_.descriptor(), path_);
    MeshReader answer(mapped.bytes());
    std::uint64_t version = 0;
    if (mapped.bytes().size() >= sizeof version) answer(version);
    if (version != kAnswerVersion) {
      throw FileError(path_ + ": tetune's plugin for " + library_ +
                      " gave no answer, or is of another build; install tetune again");
    }
    std::string error;
    std::vector<std::string> warnings;
    answer(error, warnings);
    if (!error.empty()) throw FileError(path_ + ": " + error);
    for (const std::string& warning : warnings) context.warn(path_ + ": " + warning);
    if (mesh != nullptr) answer(*mesh);
  }

 private:
  const std::string& path_;
  std::string library_, program_;
  MemoryFile channel_;
};

}  // namespace

bool has_plugin(const Plugin& plugin) { return !find_program(plugin).empty(); }

bool is_script(const Plugin& plugin) {
  std::ifstream file(find_program(plugin), std::ios::binary);
  return file.get() == '#' && file.get() == '!';
}

void require_plugin(const Plugin& plugin, const std::string& path) {
  if (!has_child_processes()) {
    throw FileError(path + ": files with the extension \"" + path_of(path).extension().string() +
                    "\" need tetune's plugin for " + plugin.library +
                    ", which exists on Linux only; convert the mesh to .mesh, .meshb, .msh or .inp first, for example "
                    "with meshio or Gmsh");
  }
  if (has_plugin(plugin)) return;
  throw FileError(path + ": files with the extension \"" + path_of(path).extension().string() +
                  "\" need tetune's plugin for " + plugin.library + ", which is not installed; install " +
                  plugin.library + " with its headers and build tetune again");
}

TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const IoContext& context) {
  { const MappedFile readable(path); }  // an error of opening has the same message for all formats
  TetMesh mesh;
  Call(plugin, path).run("read", path, context, &mesh);
  return mesh;
}

void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const IoContext& context) {
  Call call(plugin, path);
  call.send(mesh);
  call.run("write", temporary, context);
}

void require_format(const Plugin& plugin, const std::string& path) { Call(plugin, path).run("check", path, {}); }

}  // namespace tetune
