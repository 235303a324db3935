// SPDX-License-Identifier: Apache-2.0
// main() of every plugin: src/io/plugin_protocol.hpp.
#include "io/plugin_protocol.hpp"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <new>
#include <stdexcept>

#include "io/mesh_stream.hpp"
#include "plugin.hpp"
#include "system/write_all.hpp"

namespace tetune::plugin {
namespace {

/// Limits the memory of this process to what a file of its size can fill: libraries trust the counts of a damaged file.
/// The factor allows for compressed files.
void limit_memory(const std::string& file) {
#if !defined(__SANITIZE_ADDRESS__)  // whose shadow memory counts too
  constexpr rlim_t kBaseBytes = 1'000'000'000;
  constexpr rlim_t kPerFileByte = 100;
  if (ending_of(file) == ".pvtu") return;  // the data are in other files
  const rlim_t bytes = kBaseBytes + kPerFileByte * std::filesystem::file_size(file);
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_DATA, &limit);
#else
  (void)file;
#endif
}

constexpr const char* kTooMuchMemory = "reading it takes more memory than a file of its size can fill: it is damaged";

TetMesh receive() {
  struct stat info {};
  if (::fstat(kPluginDescriptor, &info) != 0) throw FileError("started without a channel");
  const std::size_t size(info.st_size);
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, kPluginDescriptor, 0);
  if (memory == MAP_FAILED) throw FileError("started without a mesh");
  MeshReader in({static_cast<const char*>(memory), size});
  std::uint64_t version = 0;
  in(version);
  if (version != kStreamVersion) throw FileError("the plugin is of another build; install tetune again");
  TetMesh mesh;
  in(mesh);
  ::munmap(memory, size);
  return mesh;
}

/// Makes a library's message printable: it may contain bytes of the file.
std::string printable(std::string text) {
  constexpr std::size_t kMaxLength = 300;
  if (text.size() > kMaxLength) text.replace(kMaxLength, std::string::npos, " ...");
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

void answer(const std::string& error, const Warnings& warnings, const TetMesh* mesh) {
  if (::ftruncate(kPluginDescriptor, 0) != 0 || ::lseek(kPluginDescriptor, 0, SEEK_SET) != 0) {
    throw FileError("cannot answer");
  }
  MeshWriter out([](const void* data, std::size_t bytes) {
    if (!write_all(kPluginDescriptor, data, bytes)) throw FileError("no memory for handing a mesh over");
  });
  out(kAnswerVersion, error, warnings);
  if (mesh != nullptr) out(*mesh);
}

int run(const std::string& verb, const std::string& file) {
  Warnings warnings;
  try {
    if (verb == "read") {
      limit_memory(file);
      TetMesh mesh = read(file, warnings);
      if (mesh.points.empty()) throw FileError("there is no mesh in this file");
      answer("", warnings, &mesh);
    } else if (verb == "check") {
      check(file);
      answer("", warnings, nullptr);
    } else {
      TetMesh mesh = receive();
      // Restores the orientation of the caller's file.
      if (mesh.listed_inside_out) {
        for (auto& tet : mesh.tets) std::swap(tet[2], tet[3]);
      }
      write(file, std::move(mesh), warnings);
      answer("", warnings, nullptr);
    }
  } catch (const std::bad_alloc&) {
    answer(kTooMuchMemory, {}, nullptr);
  } catch (const std::length_error&) {
    answer(kTooMuchMemory, {}, nullptr);
  } catch (const std::exception& e) {
    answer(printable(e.what()), {}, nullptr);
  }
  return 0;
}

/// The file that this process writes, if any, and the process that started it.
const char* written_file = nullptr;
pid_t parent = 0;

/// Ends this process after tetune, and leaves no half-written file.
void handle_end_of_parent(int) {
  if (::getppid() == parent) return;
  if (written_file != nullptr) ::unlink(written_file);
  ::_exit(1);
}

/// An interrupt from the terminal is for tetune to handle. When tetune ends, this process is to end, too.
void install_signal_handlers() {
  parent = ::getppid();
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, handle_end_of_parent);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
}

}  // namespace
}  // namespace tetune::plugin

int main(int argc, char** argv) {
  namespace plugin = tetune::plugin;
  struct stat info {};
  if (argc != 3 || ::fstat(tetune::kPluginDescriptor, &info) != 0) return 2;
  const std::string verb = argv[1];
  if (verb == "write") plugin::written_file = argv[2];
  plugin::install_signal_handlers();
  // _exit() skips the destructors of the library's globals, some of which take long.
  ::_exit(plugin::run(verb, argv[2]));
}
