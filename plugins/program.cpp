// SPDX-License-Identifier: Apache-2.0
// main() of every plugin: src/io/plugin_protocol.hpp.
#include "io/plugin_protocol.hpp"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <new>
#include <stdexcept>

#include "io/mesh_stream.hpp"
#include "plugin.hpp"

namespace tetune::plugin {
namespace {

/// Libraries believe the counts of a damaged file: no more memory than a file of its size can fill. Compressed files
/// are the reason for the factor.
void limit_memory(const std::string& file) {
#if !defined(__SANITIZE_ADDRESS__)  // whose shadow counts as memory
  constexpr rlim_t kAlways = 1'000'000'000;
  constexpr rlim_t kEachByte = 100;
  if (ending_of(file) == ".pvtu") return;  // the bytes are in other files
  const auto size = static_cast<rlim_t>(std::filesystem::file_size(file));
  const rlim_t most = kAlways + kEachByte * size;
  const rlimit limit{most, most};
  ::setrlimit(RLIMIT_DATA, &limit);
#else
  static_cast<void>(file);
#endif
}

constexpr const char* kTooMuch = "it asks for more memory than a file of its size can fill: it is damaged";

TetMesh receive() {
  struct stat info {};
  if (::fstat(kPluginDescriptor, &info) != 0) throw FileError("started without a channel");
  const auto size = static_cast<std::size_t>(info.st_size);
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, kPluginDescriptor, 0);
  if (memory == MAP_FAILED) throw FileError("started without a mesh");
  MeshReader in({static_cast<const char*>(memory), size});
  std::uint64_t version = 0;
  in(version);
  if (version != kStreamVersion) throw FileError("the plugin is of another build; install tetune anew");
  TetMesh mesh;
  in(mesh);
  ::munmap(memory, size);
  return mesh;
}

/// What a library says may have bytes of the file in it.
std::string printable(std::string text) {
  constexpr std::size_t kLongest = 300;
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, " ...");
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

void answer(std::string error, Warnings warnings, TetMesh* mesh) {
  if (::ftruncate(kPluginDescriptor, 0) != 0 || ::lseek(kPluginDescriptor, 0, SEEK_SET) != 0) {
    throw FileError("cannot answer");
  }
  MeshWriter out([](const void* data, std::size_t bytes) { write_all(kPluginDescriptor, data, bytes); });
  std::uint64_t version = kAnswerVersion;
  out(version);
  out(error);
  out(warnings);
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
      // As the caller's file listed them.
      if (mesh.listed_inside_out) {
        for (auto& tet : mesh.tets) std::swap(tet[2], tet[3]);
      }
      write(file, std::move(mesh), warnings);
      answer("", warnings, nullptr);
    }
  } catch (const std::bad_alloc&) {
    answer(kTooMuch, {}, nullptr);
  } catch (const std::length_error&) {
    answer(kTooMuch, {}, nullptr);
  } catch (const std::exception& e) {
    answer(printable(e.what()), {}, nullptr);
  }
  return 0;
}

}  // namespace
}  // namespace tetune::plugin

int main(int argc, char** argv) {
  // An interrupt is tetune's to deal with; without tetune there is nothing to do.
  ::signal(SIGINT, SIG_IGN);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  struct stat info {};
  if (argc != 3 || ::fstat(tetune::kPluginDescriptor, &info) != 0) return 2;
  // Without leaving through the destructors of the library's globals, some of which take long.
  ::_exit(tetune::plugin::run(argv[1], argv[2]));
}
