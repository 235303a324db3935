// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {

/// The words of the command line with the names that Mmg's users know (-ar, -nr, -nosurf, -hausd) replaced by ours.
std::vector<std::string> without_aliases(int argc, const char* const* argv);

/// A length as "0.01", in the mesh's unit, or as "0.1%" of the diagonal of its bounding box. Throws OptionError.
double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh);

/// A measure by its name in reports: "mean_ratio". Throws OptionError.
Measure parse_measure(const std::string& name);

/// Adds "tag=1,2,patch=7" to the frozen regions and patches. Throws OptionError.
void parse_freeze(const std::string& text, Options& options);

}  // namespace tetune::cli
