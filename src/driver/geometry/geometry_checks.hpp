// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/mesh.hpp"
#include "tetune/optimize_on_geometry.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// Throws OptionError unless optimize_on_geometry() takes the options, which must fit the mesh.
void check_geometry_options(const TetMesh& mesh, const Options& options);

/// The warning of vertices that are held off the geometry.
std::string warning_of_left_off(const GeometryReport& report);

}  // namespace tetune
