// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "mesh/tet_orientation.hpp"
#include "support/meshes.hpp"

namespace tetune::test {

/// A rotated cube of n x n x n cells of edge 0.1 with planes of vertices in which some squares, whose corners are not
/// in one plane by rounding, have one diagonal on one side and the other diagonal on the other. The tetrahedra between
/// are valid, with exact volumes of about 1e-19; by rounding some are flat or inverted.
inline TetMesh with_flat_tets(int n) {
  TetMesh mesh;
  const auto vertex = [n](int i, int j, int k) { return Index((k * (n + 1) + j) * (n + 1) + i); };
  for (int v = 0; v < (n + 1) * (n + 1) * (n + 1); ++v) {
    const double x = 0.1 * (v % (n + 1));
    const double y = 0.1 * (v / (n + 1) % (n + 1));
    const double z = 0.1 * (v / (n + 1) / (n + 1));
    mesh.points.push_back({(2 * x - y + 2 * z) / 3, (2 * x + 2 * y - z) / 3, (2 * y + 2 * z - x) / 3});
  }
  /// The corners of a square in a plane of constant i, in order, behind the vertex across its cell.
  std::vector<std::array<Index, 5>> squares;
  for (int cell = 0; cell < n * n * n; ++cell) {
    const int i = cell % n;
    const int j = cell / n % n;
    const int k = cell / n / n;
    const auto at = [&](int di, int dj, int dk) { return vertex(i + di, j + dj, k + dk); };
    const Index first = at(0, 0, 0);
    const Index last = at(1, 1, 1);
    mesh.tets.push_back({first, at(0, 1, 0), at(0, 1, 1), last});
    mesh.tets.push_back({first, at(0, 0, 1), at(1, 0, 1), last});
    mesh.tets.push_back({first, at(1, 1, 0), at(0, 1, 0), last});
    mesh.tets.push_back({first, at(0, 1, 1), at(0, 0, 1), last});
    squares.push_back({first, at(1, 0, 0), at(1, 1, 0), last, at(1, 0, 1)});
  }
  // The signs of three tetrahedra per square: of its corners, and of those of one triangle with the rest and the apex.
  TetMesh trial;
  trial.points = mesh.points;
  for (const auto& [u, a, b, c, d] : squares) {
    trial.tets.insert(trial.tets.end(), {{a, b, c, d}, {a, b, d, c}, {a, b, d, u}});
  }
  const std::vector<std::int8_t> signs = volume_signs(with_tags(trial), 1);
  for (std::size_t s = 0; s < squares.size(); ++s) {
    const auto& [u, a, b, c, d] = squares[s];
    const bool is_inside = (s + 1) % static_cast<std::size_t>(n) != 0;
    if (is_inside && signs[3 * s + 1] * signs[3 * s + 2] < 0) {
      mesh.tets.push_back({u, a, b, d});
      mesh.tets.push_back({u, b, c, d});
      mesh.tets.push_back(signs[3 * s] > 0 ? std::array{a, b, c, d} : std::array{a, b, d, c});
    } else {
      mesh.tets.push_back({u, a, b, c});
      mesh.tets.push_back({u, a, c, d});
    }
  }
  return with_tags(mesh);
}

}  // namespace tetune::test
