// SPDX-License-Identifier: Apache-2.0
// Optimizes a mesh that a program has in memory: a rod of cubes, each cut into five tetrahedra, with displaced
// vertices.
#include <cstdio>

#include "tetune/tetune.hpp"

int main() {
  constexpr int kLength = 20;
  constexpr int kSide = 4;
  const auto id = [](int i, int j, int k) { return (k * (kSide + 1) + j) * (kLength + 1) + i; };

  tetune::TetMesh mesh;
  unsigned random = 1;
  const auto shake = [&random](int at, int last) {
    random = random * 1664525U + 1013904223U;
    return at > 0 && at < last ? 0.3 * (random / 4294967296.0 - 0.5) : 0.0;
  };
  for (int k = 0; k <= kSide; ++k) {
    for (int j = 0; j <= kSide; ++j) {
      for (int i = 0; i <= kLength; ++i)
        mesh.points.push_back({i + shake(i, kLength), j + shake(j, kSide), k + shake(k, kSide)});
    }
  }
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kLength; ++i) {
        const int turn = (i + j + k) % 2;  // neighbors mirror each other, so that their faces match
        const auto v = [&](int a, int b, int c) { return id(i + (turn == 0 ? a : 1 - a), j + b, k + c); };
        std::array<std::array<int, 4>, 5> cell{{{v(0, 0, 0), v(1, 0, 0), v(0, 1, 0), v(0, 0, 1)},
                                                {v(1, 1, 0), v(0, 1, 0), v(1, 0, 0), v(1, 1, 1)},
                                                {v(1, 0, 1), v(0, 0, 1), v(1, 1, 1), v(1, 0, 0)},
                                                {v(0, 1, 1), v(1, 1, 1), v(0, 0, 1), v(0, 1, 0)},
                                                {v(1, 0, 0), v(0, 1, 0), v(0, 0, 1), v(1, 1, 1)}}};
        for (auto& tet : cell) {
          if (turn == 1) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  // A tag for each vertex and tetrahedron: here a material per half.
  mesh.point_tags.assign(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.tet_tags.push_back(t < mesh.tets.size() / 2 ? 1 : 2);

  const double before = tetune::quality(mesh).dihedral_min;
  const tetune::Report report = tetune::optimize(mesh);
  std::printf("smallest dihedral angle %.1f -> %.1f degrees, energy %.1f -> %.1f, %s\n", before,
              tetune::quality(mesh).dihedral_min, report.energy_before, report.energy_after,
              tetune::to_string(report.stop));
  return tetune::validate(mesh).ok() ? 0 : 1;
}
