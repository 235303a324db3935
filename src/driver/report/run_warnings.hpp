// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/quality.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The warnings of a run. They are made before the mesh changes, so that little memory is needed afterwards.
class RunWarnings {
 public:
  RunWarnings(const TetMesh& mesh, const Options& options);
  /// Sets Report::warnings, Report::repeated_numbers, and Report::moved_fields where vertices have moved: in steps of
  /// the report, or `moved_besides`. `of_run`: at most two more warnings.
  void add_to(Report& report, std::vector<std::string> of_run = {}, bool moved_besides = false);

 private:
  void add_numbers(const std::string& text, Report& report);

  std::vector<std::string> warnings_;  ///< with room for more, also those of move()
  std::vector<std::string> fields_;    ///< that move with their vertices
  std::string of_fields_;
  std::string of_vertex_numbers_, of_tet_numbers_;  ///< see Report::repeated_numbers; empty where there are none
};

/// A warning where the smallest dihedral angle of a result is below that of the input, as it may be where curved
/// elements have been made valid; else nothing.
std::vector<std::string> warn_of_smaller_angle(const Quality& before, const Quality& after);

}  // namespace tetune
