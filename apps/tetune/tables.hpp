// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/tetune.hpp"

namespace tetune::cli {

/// Numbers of elements of each kind, their tags, groups and data.
std::string mesh_summary(const TetMesh& mesh);

/// Five significant digits; angles to a thousandth of a degree.
std::string format_value(Measure measure, double value);

/// One column per mesh; `titles` and `columns` have the same length.
std::string quality_table(const std::vector<std::string>& titles, const std::vector<Quality>& columns);

/// All measures of the result of measure_all().
std::string measure_table(const std::string& title, const Quality& quality);

/// Validity and measures of curved tetrahedra, and the worst ones; empty without any.
std::string curved_table(const CurvedQuality& q);

/// The curved tetrahedra that are not proved valid, and the smallest Jacobian, before and after; empty without any.
std::string curved_change(const CurvedQuality& before, const CurvedQuality& after);

/// The worst tetrahedra of the result of measure_all(), with their centroids.
std::string worst_table(const std::string& title, const Quality& quality);

/// A histogram of the dihedral angles, in bins of 10 degrees.
std::string histogram(const Quality& quality);

/// Changes of volume and surface area, and distances of the surfaces.
std::string surface_table(const Comparison& comparison);

/// surface_table(), numbers of elements, and whether tags and listed vertices were kept.
std::string comparison_table(const Comparison& comparison);

/// The number of elements that miss a target, their constraints, and the worst of them.
std::string target_table(const TargetReport& report);

/// Numbers of vertices by their freedom to move.
std::string constraint_table(const Report& report);

/// Listed elements that do not constrain or were dropped.
std::vector<std::string> constraint_notes(const Report& report);

/// The verdict of each criterion. `title` says of which mesh: "acceptance", "acceptance before". `note` follows the
/// verdict on the mesh.
std::string acceptance_table(const std::string& title, const AcceptanceReport& report, const std::string& note = "");

/// The verdict of each criterion before and after a run.
std::string change_table(const CriteriaReport& report);

/// The rounds on what fails, and the constraints that limit what still does; empty if there is neither.
std::string criteria_table(const CriteriaReport& report);

/// With Options::only_below: how many tetrahedra might change. Empty without.
std::string active_line(const Report& report, const Options& options);

/// The edges with the part of the curvature that each has; empty without any.
std::string straightened_text(const std::vector<StraightenedEdge>& edges);

/// The line of all counters. `reason`: why the run ended.
std::string count_line(const Report& report, const char* reason);

/// Sweeps, flip passes, rounds on the worst elements, and phases.
std::string run_table(const Report& report);

}  // namespace tetune::cli
