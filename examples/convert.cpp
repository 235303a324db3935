// SPDX-License-Identifier: Apache-2.0
// Reads a mesh in one format and writes it in another: convert IN OUT
#include <cstdio>

#include "tetune/tetune.hpp"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: convert IN OUT\n");
    return 2;
  }
  try {
    std::vector<std::string> warnings;
    const tetune::TetMesh mesh = tetune::read_mesh(argv[1], &warnings);
    tetune::write_mesh(argv[2], mesh, 0, &warnings);
    for (const std::string& w : warnings) std::fprintf(stderr, "%s\n", w.c_str());
    std::printf("%zu vertices, %zu tetrahedra\n", mesh.points.size(), mesh.tets.size());
  } catch (const tetune::Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
