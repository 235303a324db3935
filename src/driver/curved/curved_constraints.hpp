// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

/// The constraints of the vertices of a mesh with curved edges, for its report.
namespace tetune {

/// Sets the numbers of vertices of the report by where they may go. `mesh` is the input; curved elements of it need not
/// be valid.
void count_curved_vertices(const TetMesh& mesh, const Options& options, Report& report);

/// report_targets() of a result. With Boundary::slide the features of the surface are those of the curved triangles.
std::vector<TargetReport> report_curved_targets(const TetMesh& result, const Options& options,
                                                const std::vector<Index>& vertex2original);

}  // namespace tetune
