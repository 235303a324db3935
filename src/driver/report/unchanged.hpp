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

/// Makes the report of a run that of one whose result was not taken, for a reason: what describes the result is that of
/// `mesh`, the input; the device, the times, the numbers of vertices and why the run ended stay.
void discard_result(const TetMesh& mesh, const Options& options, std::string reason, Report& report);

}  // namespace tetune
