// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tetune/report.hpp"

/// One report of several runs on a mesh.
namespace tetune {

/// The map from a result to the input, over the mesh between. An empty map is the identity.
std::vector<Index> compose(std::vector<Index> between2input, std::vector<Index> result2between);

/// Extends the report of the runs before by that of a further run on their result: counts, energies and maps.
void extend_report(Report& report, Report&& further);

}  // namespace tetune
