// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/tetune.hpp"

namespace tetune::cli {

/// Counts and tags of a mesh.
std::string mesh_summary(const TetMesh& mesh);

/// One column of figures a mesh: `titles` and `columns` are as long as each other.
std::string quality_table(const std::vector<std::string>& titles, const std::vector<Quality>& columns);

/// All measures of a mesh that measure_all() measured, under a title.
std::string measure_table(const std::string& title, const Quality& quality);

/// Its worst tetrahedra with their places, under a title.
std::string worst_table(const std::string& title, const Quality& quality);

/// Dihedral angles in bins of 10 degrees.
std::string histogram(const Quality& quality);

/// What became of volume, area and place of the surface.
std::string surface_table(const Comparison& comparison);

/// The same and what was kept.
std::string comparison_table(const Comparison& comparison);

/// How many elements miss a target, what holds them, and the worst ones.
std::string target_table(const TargetReport& report);

/// How many vertices may go where.
std::string constraint_table(const Report& report);

/// What of the file's lists does not count, and was dropped.
std::string notes(const Report& report);

/// Sweeps, flip passes and phases.
std::string run_table(const Report& report);

/// MEDIT counts from 1, and so do these messages.
std::string validity_message(const ValidationReport& report);

}  // namespace tetune::cli
