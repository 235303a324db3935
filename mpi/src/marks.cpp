// SPDX-License-Identifier: Apache-2.0
// Marks of vertices and elements of a part.
#include <algorithm>

#include "lookup.hpp"
#include "part.hpp"

namespace tetune::mpi {
namespace {

template <std::size_t N>
Marks marks_in(const std::vector<std::array<Index, N>>& list, const std::vector<std::array<Index, 4>>& tets,
               std::size_t vertices) {
  Marks found(list.size(), 0);
  find_in(list, tets, vertices, [&found](Index i, std::size_t) { item(found, i) = 1; });
  return found;
}

}  // namespace

Marks on_surface(const TetMesh& mesh) {
  const auto mix = [](std::uint64_t x) {
    x = (x ^ (x >> 32U)) * 0x9E3779B97F4A7C15U;
    return (x ^ (x >> 29U)) * 0xBF58476D1CE4E5B9U;
  };
  // The XOR of the hashes of the faces at a vertex: a face inside a region occurs twice and cancels. Other sets cancel
  // with a probability of 2^-64.
  std::vector<std::uint64_t> remainder(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::array<std::uint64_t, 4> hash;
    for (std::size_t k = 0; k < 4; ++k) hash[k] = mix(std::uint64_t(mesh.tets[t][k]) + 1);
    const std::uint64_t all = hash[0] + hash[1] + hash[2] + hash[3] + mix(~std::uint64_t(mesh.tet_tags[t]));
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint64_t face = mix(all - hash[f]);
      for (std::size_t k = 0; k < 4; ++k) {
        if (k != f) item(remainder, mesh.tets[t][k]) ^= face;
      }
    }
  }
  Marks result;
  result.reserve(remainder.size());
  for (const std::uint64_t r : remainder) result.push_back(r != 0 ? 1 : 0);
  return result;
}

Marks held_vertices(const TetMesh& mesh, const std::vector<int>& frozen_regions) {
  Marks held = on_surface(mesh);
  const auto hold = [&held](const auto& vertices) {
    for (const Index v : vertices) item(held, v) = 1;
  };
  for (const auto& triangle : mesh.triangles) hold(triangle);
  for (const auto& edge : mesh.edges) hold(edge);
  hold(mesh.corners);
  hold(mesh.required_vertices);
  for (const Index t : mesh.required_tets) hold(item(mesh.tets, t));
  if (frozen_regions.empty()) return held;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (std::find(frozen_regions.begin(), frozen_regions.end(), mesh.tet_tags[t]) != frozen_regions.end()) {
      hold(mesh.tets[t]);
    }
  }
  return held;
}

Marks are_in(const std::vector<std::array<Index, 3>>& triangles, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices) {
  return marks_in(triangles, tets, vertices);
}
Marks are_in(const std::vector<std::array<Index, 2>>& edges, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices) {
  return marks_in(edges, tets, vertices);
}

}  // namespace tetune::mpi
