// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

/// One report of several runs on a mesh.
namespace tetune {

/// Adds to the time of a phase.
void add_seconds(Report& report, const std::string& phase, double seconds);
/// The sum over the phases.
double seconds_of_phases(const Report& report);

/// Extends the report of the runs before by that of a further run on their result: counts, steps, energies, maps and
/// times. `result`: the mesh after the further run.
void extend_report(Report& report, Report&& further, const TetMesh& result);

}  // namespace tetune
