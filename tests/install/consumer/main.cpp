// SPDX-License-Identifier: Apache-2.0
#include <tetune/tetune.hpp>

int main() {
  tetune::TetMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.point_tags = {0, 0, 0, 0};
  mesh.tets = {{0, 1, 2, 3}};
  mesh.tet_tags = {1};
  return tetune::optimize(mesh).tets_after == 1 ? 0 : 1;
}
