// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

/// Reports on a mesh that stays as it is. Their targets count all tetrahedra as locked.
namespace tetune {

/// The report where there is nothing to optimize.
Report report_unchanged(const TetMesh& mesh, const Options& options);

/// Changes the report of a run whose result is discarded: its description of the result becomes that of `mesh`, the
/// input, and it warns of the reason. The device, the times, the numbers of vertices and why the run ended stay.
void discard_result(const TetMesh& mesh, const Options& options, std::string reason, Report& report);

}  // namespace tetune
