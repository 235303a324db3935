// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/optimize.hpp"

namespace tetune::cli {

/// Which vertex and tetrahedron became which (docs/formats.md, "Map"). `vertices` and `tets` are those of the result.
std::string map_text(const Report& report, std::size_t vertices, std::size_t tets);

}  // namespace tetune::cli
