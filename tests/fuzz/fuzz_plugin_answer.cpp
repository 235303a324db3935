// SPDX-License-Identifier: Apache-2.0
// The answer of a plugin, as src/io/plugin/plugin.cpp reads it: error, warnings, mesh.
#include <vector>

#include "fuzz.hpp"
#include "io/mesh_stream.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tetune::MeshReader in(tetune::fuzz::text(data, size));
  std::string error;
  std::vector<std::string> warnings;
  tetune::TetMesh mesh;
  try {
    in(error);
    in(warnings);
    in(mesh);
  } catch (const tetune::FileError&) {
    return 0;
  }
  // A mesh that is written reads back to the same bytes.
  const auto bytes_of = [](tetune::TetMesh& m) {
    std::string bytes;
    tetune::MeshWriter out(
        [&bytes](const void* from, std::size_t n) { bytes.append(static_cast<const char*>(from), n); });
    out(m);
    return bytes;
  };
  const std::string bytes = bytes_of(mesh);
  tetune::TetMesh again;
  tetune::MeshReader reader(bytes);
  reader(again);
  if (bytes_of(again) != bytes) std::abort();
  tetune::orient_uniformly(mesh, 1);
  tetune::fuzz::check(mesh);
  return 0;
}
