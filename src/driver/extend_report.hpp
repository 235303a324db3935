// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/report.hpp"

namespace tetune {

/// Extends the report of the runs before by that of a further run on their result: counts, energies and maps.
void extend_report(Report& report, Report&& further);

}  // namespace tetune
