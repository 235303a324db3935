// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {

/// A length as "0.01", in the mesh's unit, or as "0.1%" of the diagonal of its bounding box. Throws OptionError.
double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh);

/// A measure by its name in reports: "mean_ratio". Throws OptionError that names `option`.
Measure parse_measure(const std::string& option, const std::string& name);

/// A bound for `info --min-quality`: "0.2", of the mean ratio, or "radius_ratio=5". Throws OptionError.
Target parse_bound(const std::string& text);

/// Adds "tag=1,2,patch=7" to the frozen regions and patches. Throws OptionError.
void parse_freeze(const std::string& text, Options& options);

}  // namespace tetune::cli
