// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iterator>

#include "fuzz.hpp"

namespace {

/// A deck whose mesh is valid and did not change is written back to the byte, unless it includes files or the reader
/// has changed it with a warning.
void check_identity(const std::string& path, std::string_view bytes, const std::string& out) {
  std::vector<std::string> warnings;
  const tetune::TetMesh mesh = tetune::read_mesh(path, &warnings, 1);
  tetune::write_mesh(out, mesh, 1);
  std::string lower(bytes);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  if (!warnings.empty() || lower.find("include") != std::string::npos || !tetune::validate(mesh, 1).ok()) return;
  std::ifstream file(out, std::ios::binary);
  const std::string written{std::istreambuf_iterator<char>(file), {}};
  if (written != bytes) tetune::fuzz::fail("an unchanged deck was written in another form");
}

/// The deck of an optimized mesh is read back as that mesh.
void check_changed(const std::string& path, const std::string& out) {
  tetune::TetMesh mesh = tetune::read_mesh(path, nullptr, 1);
  if (mesh.tets.empty() || !tetune::validate(mesh, 1).ok() || mesh.tets.size() >= 2000) return;
  if (tetune::fuzz::has_invalid_curved(mesh)) return;
  // A patch of flat triangles may vanish with a vertex on their line.
  if (tetune::fuzz::is_doubtful(mesh, tetune::quality(mesh, 1))) return;
  tetune::Options options;
  options.device = tetune::Device::cpu;
  options.effort = tetune::Effort::best;
  options.max_iterations = 2;
  options.threads = 1;
  try {
    tetune::optimize(mesh, options);
  } catch (const tetune::OverlapError&) {
    return;
  }
  tetune::write_mesh(out, mesh, 1);
  const tetune::TetMesh back = tetune::read_mesh(out, nullptr, 1);
  if (back.points.size() != mesh.points.size() || back.tets.size() != mesh.tets.size() ||
      back.triangles.size() < mesh.triangles.size()) {
    tetune::fuzz::fail("an optimized deck was read back as another mesh");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tetune::fuzz::Folder folder;
  const std::string_view bytes = tetune::fuzz::text(data, size);
  const std::string path = folder.put("in.inp", bytes);
  const std::string out = folder.path("out.inp");
  try {
    check_identity(path, bytes, out);
  } catch (const tetune::FileError&) {
    return 0;
  }
  tetune::fuzz::check(path);
  check_changed(path, out);
  return 0;
}
