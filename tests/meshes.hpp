// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "tetune/mesh.hpp"

/// Meshes for tests: tiny exact ones, and a generator of any size.
namespace tetune::test {

inline TetMesh with_tags(TetMesh mesh) {
  mesh.point_tags.assign(mesh.points.size(), 0);
  mesh.tet_tags.resize(mesh.tets.size(), 0);
  mesh.triangle_tags.resize(mesh.triangles.size(), 0);
  mesh.edge_tags.resize(mesh.edges.size(), 0);
  return mesh;
}

inline TetMesh one_tet() {
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  m.tets = {{0, 1, 2, 3}};
  return with_tags(m);
}

/// Vertices 0 and 1 above and below the triangle 2, 3, 4: as two tetrahedra that share the triangle.
inline TetMesh two_tets(double apex_height) {
  TetMesh m;
  const double s = std::sqrt(3.0) / 2;
  m.points = {{0, 0, apex_height}, {0, 0, -apex_height}, {1, 0, 0}, {-0.5, s, 0}, {-0.5, -s, 0}};
  m.tets = {{0, 2, 4, 3}, {1, 2, 3, 4}};
  return with_tags(m);
}

/// The same five vertices as three tetrahedra around the edge (0, 1).
inline TetMesh three_tets(double apex_height) {
  TetMesh m = two_tets(apex_height);
  m.tets = {{0, 2, 4, 1}, {0, 4, 3, 1}, {0, 3, 2, 1}};
  return with_tags(m);
}

/// An n x n x n cube of unit edge, each cell cut into six tetrahedra along its diagonal, the inner vertices displaced
/// by at most `jitter` of a cell (0.2 keeps every volume positive) from a fixed seed.
inline TetMesh cube(int n, double jitter = 0, std::uint32_t seed = 1) {
  TetMesh m;
  std::mt19937 random(seed);
  const auto noise = [&] { return jitter * (2 * (static_cast<double>(random()) / 4294967295.0) - 1) / n; };
  const auto id = [n](int i, int j, int k) { return static_cast<Index>((k * (n + 1) + j) * (n + 1) + i); };
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        Point3 p{static_cast<double>(i) / n, static_cast<double>(j) / n, static_cast<double>(k) / n};
        const int at[3] = {i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          const double d = noise();
          if (at[a] > 0 && at[a] < n) p[a] += d;
        }
        m.points.push_back(p);
      }
    }
  }
  // The six paths from one corner of a cell to the opposite one, and whether each is an even permutation of x, y, z.
  static constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
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
  return with_tags(m);
}

/// Moves every vertex by the affine map x += shear * y: all volumes stay as they are.
inline TetMesh sheared(TetMesh mesh, double shear) {
  for (Point3& p : mesh.points) p[0] += shear * p[1];
  return mesh;
}

inline double volume6(const TetMesh& m, const std::array<Index, 4>& t) {
  const auto d = [&](std::size_t i, std::size_t k) {
    return m.points[static_cast<std::size_t>(t[i])][k] - m.points[static_cast<std::size_t>(t[0])][k];
  };
  return d(1, 0) * (d(2, 1) * d(3, 2) - d(2, 2) * d(3, 1)) - d(1, 1) * (d(2, 0) * d(3, 2) - d(2, 2) * d(3, 0)) +
         d(1, 2) * (d(2, 0) * d(3, 1) - d(2, 1) * d(3, 0));
}

/// Spoils a mesh by random valid 2-3 flips, some rounds of them: harmonic flips then have much to do. Flips stay within
/// a region.
inline TetMesh scrambled(TetMesh mesh, int rounds, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  static constexpr std::size_t kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::array<Index, 3>, std::vector<std::pair<std::size_t, std::size_t>>> sides;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      for (std::size_t f = 0; f < 4; ++f) {
        std::array<Index, 3> key{};
        for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.tets[t][kFaces[f][k]];
        std::sort(key.begin(), key.end());
        sides[key].push_back({t, f});
      }
    }
    std::vector<char> used(mesh.tets.size(), 0);
    for (const auto& [key, side] : sides) {
      if (side.size() != 2 || random() % 2 == 0) continue;
      const auto [t0, f0] = side[0];
      const auto [t1, f1] = side[1];
      if (used[t0] != 0 || used[t1] != 0 || mesh.tet_tags[t0] != mesh.tet_tags[t1]) continue;
      const Index a = mesh.tets[t0][f0];
      const Index b = mesh.tets[t1][f1];
      std::array<Index, 3> r{};
      for (std::size_t k = 0; k < 3; ++k) r[k] = mesh.tets[t0][kFaces[f0][k]];
      const std::array<std::array<Index, 4>, 3> made{{{a, r[0], r[1], b}, {a, r[1], r[2], b}, {a, r[2], r[0], b}}};
      const double least = 1e-4 * (volume6(mesh, mesh.tets[t0]) + volume6(mesh, mesh.tets[t1]));
      if (std::any_of(made.begin(), made.end(), [&](const auto& t) { return volume6(mesh, t) < least; })) continue;
      used[t0] = used[t1] = 1;
      mesh.tets[t0] = made[0];
      mesh.tets[t1] = made[1];
      mesh.tets.push_back(made[2]);
      mesh.tet_tags.push_back(mesh.tet_tags[t0]);
      used.push_back(1);
    }
  }
  return mesh;
}

/// cube() with its two halves tagged 1 and 2 along x: an interface at x = 1/2 for even n.
inline TetMesh two_materials(int n, double jitter = 0) {
  TetMesh m = cube(n, jitter);
  const int cells = n * n * n;
  for (int c = 0; c < cells; ++c) {
    for (int p = 0; p < 6; ++p) m.tet_tags[static_cast<std::size_t>(6 * c + p)] = c % n < n / 2 ? 1 : 2;
  }
  // The interface stays plane.
  for (auto& p : m.points) {
    if (std::fabs(p[0] - 0.5) < 0.5 / n) p[0] = 0.5;
  }
  return m;
}

}  // namespace tetune::test
