// SPDX-License-Identifier: Apache-2.0
#include "reference/generate.hpp"

#include <random>

#include "core/connect.hpp"
#include "core/orient.hpp"
#include "core/upload.hpp"
#include "par/cpu.hpp"

namespace tetune::reference {

TetMesh lattice(int n, double jitter, std::uint32_t seed) {
  TetMesh m;
  std::mt19937 random(seed);
  const auto id = [n](int i, int j, int k) { return static_cast<Index>((k * (n + 1) + j) * (n + 1) + i); };
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const int at[3] = {i, j, k};
        Point3 p{};
        for (std::size_t a = 0; a < 3; ++a) {
          const double shift = jitter * (2 * (static_cast<double>(random()) / 4294967295.0) - 1);
          p[a] = (at[a] + (at[a] > 0 && at[a] < n ? shift : 0)) / n;
        }
        m.points.push_back(p);
      }
    }
  }
  // The six paths from one corner of a cell to the opposite one; the last three are odd permutations of x, y, z.
  static constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  m.tets.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * 6);
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (int p = 0; p < 6; ++p) {
          int at[3] = {i, j, k};
          std::array<Index, 4> tet{id(i, j, k), 0, 0, 0};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[kPaths[p][s]];
            tet[s + 1] = id(at[0], at[1], at[2]);
          }
          if (p >= 3) std::swap(tet[2], tet[3]);
          m.tets.push_back(tet);
        }
      }
    }
  }
  m.point_tags.assign(m.points.size(), 0);
  m.tet_tags.assign(m.tets.size(), 0);
  return m;
}

TetMesh scrambled(TetMesh mesh, int rounds, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (int round = 0; round < rounds; ++round) {
    WorkMesh<par::Cpu> work = upload_mesh<par::Cpu>(mesh);
    build_adjacency(par::Cpu(1), work);
    const MeshView view = work.view();
    std::vector<char> used(mesh.tets.size(), 0);
    const auto volume = [&mesh](const std::array<Index, 4>& t) {
      const auto p = [&](std::size_t k) { return vec(mesh.points[static_cast<std::size_t>(t[k])]); };
      return orient(p(0), p(1), p(2), p(3)).det;
    };
    const std::size_t before = mesh.tets.size();
    for (std::size_t t = 0; t < before; ++t) {
      for (int f = 0; f < 4; ++f) {
        const Link link = view.tet2tet[static_cast<Size>(t)][f];
        if (link == kNoLink || random() % 2 == 0) continue;
        const auto other = static_cast<std::size_t>(link_tet(link));
        if (other < t || used[t] != 0 || used[other] != 0 || mesh.tet_tags[t] != mesh.tet_tags[other]) continue;
        const auto v = [&](int k) { return mesh.tets[t][static_cast<std::size_t>(face_vertex(f, k))]; };
        const Index a = mesh.tets[t][static_cast<std::size_t>(f)];
        const Index b = mesh.tets[other][static_cast<std::size_t>(link_face(link))];
        const std::array<std::array<Index, 4>, 3> made{{{a, v(0), v(1), b}, {a, v(1), v(2), b}, {a, v(2), v(0), b}}};
        const double least = 1e-4 * (volume(mesh.tets[t]) + volume(mesh.tets[other]));
        if (volume(made[0]) < least || volume(made[1]) < least || volume(made[2]) < least) continue;
        used[t] = used[other] = 1;
        mesh.tets[t] = made[0];
        mesh.tets[other] = made[1];
        mesh.tets.push_back(made[2]);
        mesh.tet_tags.push_back(mesh.tet_tags[t]);
      }
    }
  }
  return mesh;
}

}  // namespace tetune::reference
