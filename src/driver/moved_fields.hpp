// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Sets Report::moved_fields for a result, and adds a warning if there are any.
void report_moved_fields(const TetMesh& result, const Options& options, Report& report);

}  // namespace tetune
