// SPDX-License-Identifier: Apache-2.0
#include <tetune/tetune.hpp>

/// With an argument, writes the mesh to that file and reads it.
int main(int argc, char** argv) {
  tetune::TetMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.point_tags = {0, 0, 0, 0};
  mesh.tets = {{0, 1, 2, 3}};
  mesh.tet_tags = {1};
  if (tetune::optimize(mesh).tets_after != 1) return 1;
  if (argc < 2) return 0;
  tetune::write_mesh(argv[1], mesh);
  return tetune::read_mesh(argv[1]).tets.size() == 1 ? 0 : 1;
}
