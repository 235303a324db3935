// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "tetune/report.hpp"

/// One report of several runs on a mesh.
namespace tetune {

/// The map from a result to the input, over the mesh between. An empty map is the identity.
inline std::vector<Index> compose(std::vector<Index> between2input, std::vector<Index> result2between) {
  if (between2input.empty()) return result2between;
  if (result2between.empty()) return between2input;
  for (Index& i : result2between) i = i < 0 ? i : span_of(between2input)[i];
  return result2between;
}

/// Extends the report of the runs before by that of a round.
inline void add_round(Report& report, Report&& round) {
  report.OperationCounts::operator+=(round);
  report.tets_after = round.tets_after;
  report.energy_after += round.energy_after - round.energy_before;
  report.triangles_dropped += round.triangles_dropped;
  report.edges_dropped += round.edges_dropped;
  report.vertex2original = compose(std::move(report.vertex2original), std::move(round.vertex2original));
  report.tet2original = compose(std::move(report.tet2original), std::move(round.tet2original));
  report.triangle2original = compose(std::move(report.triangle2original), std::move(round.triangle2original));
  report.edge2original = compose(std::move(report.edge2original), std::move(round.edge2original));
}

}  // namespace tetune
