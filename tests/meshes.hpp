// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

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

/// An n x n x n cube of unit edge, each cell cut into six tetrahedra along its diagonal, the inner vertices displaced by at most
/// `jitter` of a cell (0.2 keeps every volume positive) from a fixed seed.
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
