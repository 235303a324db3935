// SPDX-License-Identifier: Apache-2.0
#include "io/plugin.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>

#include "io/mesh_stream.hpp"
#include "io/plugin_protocol.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

namespace fs = std::filesystem;

/// Folder of the program or shared library that this code is in.
fs::path own_folder() {
  Dl_info info{};
  link_map* map = nullptr;
  std::string object = "/proc/self/exe";
  if (::dladdr1(reinterpret_cast<const void*>(&own_folder), &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) !=
          0 &&
      map != nullptr && map->l_name != nullptr && map->l_name[0] == '/') {
    object = map->l_name;
  }
  std::error_code ignored;
  const fs::path folder = fs::canonical(object, ignored).parent_path();
  // A library for some processors is two folders below that for all.
  const fs::path above = folder.parent_path();
  return above.filename() == "glibc-hwcaps" ? above.parent_path() : folder;
}

/// Where the program is, or an empty path. Never the working folder, never a folder that the environment names.
fs::path find_program(const Plugin& plugin) {
  const fs::path own = own_folder();
  for (const fs::path& folder : {own / "../libexec/tetune", own / "libexec/tetune", fs::path(TETUNE_PLUGIN_FOLDER)}) {
    std::error_code ignored;
    fs::path program = folder / plugin.program;
    if (folder.is_absolute() && fs::is_regular_file(program, ignored)) return program;
  }
  return {};
}

/// Memory that is handed to the program and back, as a file without a name.
class Channel {
 public:
  Channel() : descriptor_(::memfd_create("tetune", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw FileError(std::string("cannot create a channel to a plugin: ") + std::strerror(errno));
  }
  ~Channel() { ::close(descriptor_); }
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Runs it to its end; returns its status as waitpid() tells it.
int run(const fs::path& program, const Channel& channel, const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
  }
  ::posix_spawn_file_actions_adddup2(&files, channel.descriptor(), kPluginDescriptor);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw FileError(program.string() + ": cannot be started: " + std::strerror(error));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

/// Calls the program and reads its answer; the mesh follows in what is left of the answer when `mesh` is given.
void call(const Plugin& plugin, const char* verb, const std::string& path, const std::string& file,
          const Channel& channel, const ReadContext& context, TetMesh* mesh) {
  require_plugin(plugin, path);
  const fs::path program = find_program(plugin);
  const int status = run(program, channel, {program.string(), verb, file});
  const std::string library = plugin.library;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kPluginNotLoaded) {
    throw FileError(path + ": tetune's plugin for " + library + " cannot start: a library of " + library +
                    " is missing; install the package " + plugin.run_package);
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string how =
        WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : "exit code " + std::to_string(WEXITSTATUS(status));
    throw FileError(path + ": " + library + " failed to " + verb + " it (" + how + ")" +
                    (mesh != nullptr ? "; the file is damaged, or of a kind that " + library + " cannot take" : ""));
  }
  struct stat info {};
  ::fstat(channel.descriptor(), &info);
  const auto size = static_cast<std::size_t>(info.st_size);
  void* memory = size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, channel.descriptor(), 0) : MAP_FAILED;
  if (memory == MAP_FAILED) throw FileError(path + ": tetune's plugin for " + library + " gave no answer");
  const std::unique_ptr<void, std::function<void(void*)>> mapped(memory, [size](void* m) { ::munmap(m, size); });
  MeshReader answer({static_cast<const char*>(memory), size});
  std::uint64_t version = 0;
  answer(version);
  if (version != kAnswerVersion) {
    throw FileError(path + ": tetune's plugin for " + library +
                    " gave no answer, or is of another build; install tetune anew");
  }
  std::string error;
  std::vector<std::string> warnings;
  answer(error);
  answer(warnings);
  if (!error.empty()) throw FileError(path + ": " + error);
  for (const std::string& warning : warnings) context.warn(path + ": " + warning);
  if (mesh != nullptr) answer(*mesh);
}

}  // namespace

bool has_plugin(const Plugin& plugin) { return !find_program(plugin).empty(); }

void require_plugin(const Plugin& plugin, const std::string& path) {
  if (has_plugin(plugin)) return;
  throw FileError(path + ": files of ending \"" + fs::path(path).extension().string() + "\" need tetune's plugin for " +
                  plugin.library + ", which is not installed; install the package " + plugin.build_package +
                  " and build tetune again");
}

TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const ReadContext& context) {
  { const MappedFile readable(path); }  // the errors of opening are the same for all formats
  const Channel channel;
  TetMesh mesh;
  call(plugin, "read", path, path, channel, context, &mesh);
  return mesh;
}

void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const ReadContext& context) {
  const Channel channel;
  MeshWriter writer([&](const void* data, std::size_t bytes) { write_all(channel.descriptor(), data, bytes); });
  std::uint64_t version = kStreamVersion;
  writer(version);
  writer(const_cast<TetMesh&>(mesh));  // one function moves both ways; this one only reads
  call(plugin, "write", path, temporary, channel, context, nullptr);
}

void require_format(const Plugin& plugin, const std::string& path) {
  const Channel channel;
  call(plugin, "check", path, path, channel, {}, nullptr);
}

}  // namespace tetune
