// SPDX-License-Identifier: Apache-2.0
#include "curved/held_bound.hpp"

#include <algorithm>
#include <utility>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "math/constants.hpp"

namespace tetune {

double bound_by_held(const std::array<Index, 4>& tet, const TenNodes& nodes, const HeldNodes& held) {
  constexpr int kSamples = 16;  // along an edge
  std::array<std::array<bool, 4>, 4> is_held{};
  for (const auto& [i, j] : kCurvedTetEdges) is_held[i][j] = is_held[j][i] = held.has_edge(tet[i], tet[j]);
  double least = kInfinity;
  const ScaledJacobian jacobian = jacobian_of(nodes);
  for (std::size_t v = 0; v < 4; ++v) {
    if (is_held[v][(v + 1) % 4] && is_held[v][(v + 2) % 4] && is_held[v][(v + 3) % 4]) {
      least = std::min(least, jacobian.polynomial.corner(v));
    }
  }
  for (const auto& [i, j] : kCurvedTetEdges) {
    const bool is_fixed = std::all_of(kCurvedTetEdges.begin(), kCurvedTetEdges.end(), [&, i = i, j = j](const auto& e) {
      const bool is_opposite = e[0] != i && e[0] != j && e[1] != i && e[1] != j;
      return is_opposite || is_held[e[0]][e[1]];
    });
    for (int s = 1; s < kSamples && is_fixed; ++s) {
      std::array<double, 4> at{};
      at[j] = double(s) / kSamples;
      at[i] = 1 - at[j];
      least = std::min(least, evaluate(jacobian.polynomial, at));
    }
  }
  return least / jacobian.straight;
}

std::vector<Index> find_bounded(const TetMesh& mesh, const HeldNodes& held, double limit) {
  const CurvedEdges edges(mesh);
  std::vector<std::pair<double, Index>> bounded;
  for (const Index t : curved_tets(mesh, edges)) {
    const auto& tet = span_of(mesh.tets)[t];
    const double bound = bound_by_held(tet, edges.nodes(tet), held);
    if (bound < limit) bounded.emplace_back(bound, t);
  }
  std::sort(bounded.begin(), bounded.end());
  std::vector<Index> tets;
  for (const auto& [bound, t] : bounded) tets.push_back(t);
  return tets;
}

}  // namespace tetune
