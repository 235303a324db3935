// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/tet.hpp"

namespace tetune {

/// A feature edge of the reference surface.
struct FeatureEdge {
  Index ends[2];
  Index corner;           ///< a corner opposite the edge
  std::uint32_t is_weak;  ///< an edge within a patch, where the surface turns by little more than the feature angle
};
static_assert(sizeof(FeatureEdge) == 16, "copies between host and device read no padding");

/// Finds the edges of feature lines that are noise: all edges of such a line are weak, and it has an open end, where no
/// other line continues. Without these edges further lines may have an open end: they are found too. Returns
/// FeatureEdge::corner of each edge. Compare Jiao and Bayyana, "Identification of C1 and C2 discontinuities for surface
/// meshes in CAD", 2008.
std::vector<Index> find_weak_lines(std::vector<FeatureEdge> edges);

}  // namespace tetune
