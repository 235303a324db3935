// SPDX-License-Identifier: Apache-2.0
// main() of the plugins for formats of meshes: src/io/plugin/plugin_protocol.hpp.
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "process.hpp"

namespace tetune::plugin {
namespace {

AnswerBody run(const std::string& verb, const std::string& file, int time, Warnings& warnings) {
  TetMesh mesh;
  if (verb == "read") {
    const MemoryLimit memory(file);
    mesh = read(file, time, warnings);
    if (mesh.points.empty()) throw FileError("there is no mesh in this file");
    return [mesh = std::move(mesh)](AnswerWriter& out) { out(mesh); };
  }
  if (verb == "times") return [known = times(file)](AnswerWriter& out) { out(known); };
  if (verb == "check") {
    check(file);
    return {};
  }
  receive([&](MeshReader& in) { in(mesh); });
  // Restores the orientation of the caller's file.
  if (mesh.listed_inside_out) {
    for (auto& tet : mesh.tets) std::swap(tet[2], tet[3]);
  }
  write(file, std::move(mesh), warnings);
  return {};
}

}  // namespace
}  // namespace tetune::plugin

int main(int argc, char** argv) {
  namespace plugin = tetune::plugin;
  if (argc < 3 || argc > 4 || !plugin::has_channel()) return 2;
  const int time = argc > 3 ? std::atoi(argv[3]) : 0;
  const std::string verb = argv[1];
  plugin::install_signal_handlers(verb == "write" ? argv[2] : nullptr);
  // _exit() skips the destructors of the library's globals, some of which take long.
  ::_exit(
      plugin::run_and_answer([&](plugin::Warnings& warnings) { return plugin::run(verb, argv[2], time, warnings); }));
}
