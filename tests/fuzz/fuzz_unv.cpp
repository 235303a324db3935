// SPDX-License-Identifier: Apache-2.0
#include "fuzz.hpp"

namespace {

/// A mesh is read back as it was written.
void check_written(const std::string& path, const std::string& out) {
  const tetune::TetMesh mesh = tetune::read_mesh(path, nullptr, 1);
  if (!tetune::validate(mesh, 1).ok()) return;
  tetune::write_mesh(out, mesh, 1);
  const tetune::TetMesh back = tetune::read_mesh(out, nullptr, 1);
  if (back.points != mesh.points || back.tets.size() != mesh.tets.size() || back.triangles != mesh.triangles ||
      back.edges != mesh.edges) {
    tetune::fuzz::fail("a written mesh was read back as another one");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tetune::fuzz::Folder folder;
  const std::string path = folder.put("in.unv", tetune::fuzz::text(data, size));
  try {
    check_written(path, folder.path("out.unv"));
  } catch (const tetune::FileError&) {
    return 0;
  }
  tetune::fuzz::check(path);
  return 0;
}
