// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/optimize.hpp"

namespace tetune::cli {

/// The correspondence between old and new vertices and tetrahedra, as text (docs/formats.md, "Map"). `vertices` and
/// `tets` are the numbers of the result.
std::string map_text(const Report& report, std::size_t vertices, std::size_t tets);

}  // namespace tetune::cli
