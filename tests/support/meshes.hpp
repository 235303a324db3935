// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "math/vec3.hpp"
#include "reference/generate.hpp"
#include "tetune/mesh.hpp"

/// Meshes for tests: small ones with exact coordinates, and generated ones of any size.
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

/// Two tetrahedra with apexes 0 and 1 above and below their common triangle 2, 3, 4.
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

using reference::scrambled;

inline Vec3 at(const TetMesh& mesh, Index vertex) { return vec(mesh.points[static_cast<std::size_t>(vertex)]); }

inline Point3 centroid(const TetMesh& mesh, std::size_t tet) {
  Point3 sum{};
  for (const Index v : mesh.tets[tet]) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.25 * mesh.points[static_cast<std::size_t>(v)][k];
  }
  return sum;
}

/// An n x n x n cube of unit edge: see reference::lattice().
inline TetMesh cube(int n, double jitter = 0, std::uint32_t seed = 1) { return reference::lattice(n, jitter, seed); }

/// Multiplies all coordinates by a factor.
inline TetMesh scaled(TetMesh mesh, double factor) {
  for (Point3& p : mesh.points) {
    for (double& x : p) x *= factor;
  }
  return mesh;
}

/// Applies the affine map x += shear * y, which preserves all volumes.
inline TetMesh sheared(TetMesh mesh, double shear) {
  for (Point3& p : mesh.points) p[0] += shear * p[1];
  return mesh;
}

/// cube() with its two halves tagged 1 and 2 along x: an interface at x = 1/2 for even n.
inline TetMesh two_materials(int n, double jitter = 0) {
  TetMesh m = cube(n, jitter);
  const int cells = n * n * n;
  for (int c = 0; c < cells; ++c) {
    for (int p = 0; p < 6; ++p) m.tet_tags[static_cast<std::size_t>(6 * c + p)] = c % n < n / 2 ? 1 : 2;
  }
  // The interface remains planar.
  for (auto& p : m.points) {
    if (std::fabs(p[0] - 0.5) < 0.5 / n) p[0] = 0.5;
  }
  return m;
}

/// Whether a point is neither on the boundary of the unit cube nor on its middle plane.
inline bool is_inner(const Point3& p) {
  return std::all_of(p.begin(), p.end(), [](double x) { return x > 1e-9 && x < 1 - 1e-9; }) &&
         std::fabs(p[0] - 0.5) > 1e-9;
}

/// two_materials() with inner vertices displaced by up to `noise` edges.
inline TetMesh tangled(int n, double noise, std::uint32_t seed) {
  TetMesh m = two_materials(n);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> offset(-noise / n, noise / n);
  for (Point3& p : m.points) {
    if (!is_inner(p)) continue;
    for (double& x : p) x += offset(random);
  }
  return m;
}

}  // namespace tetune::test
