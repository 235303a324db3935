// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "tetune/mesh.hpp"
#include "tetune/option_table.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// The largest Options::max_growth with which a run on a mesh that has tetrahedra makes at most `max_tets`.
inline double growth_up_to(double max_tets, const TetMesh& mesh) {
  return std::clamp(max_tets / double(mesh.tets.size()), 1.0, find_option("max_growth")->range.max);
}

/// Lowers Options::max_growth for one of several runs that may make at most `max_tets` tetrahedra in all. Where it has
/// no effect it stays: another value would cause a warning about an option that the caller did not set.
inline void limit_growth(Options& options, double max_tets, const TetMesh& mesh) {
  if (mesh.tets.empty() || why_ineffective(*find_option("max_growth"), options) != nullptr) return;
  options.max_growth = std::min(options.max_growth, growth_up_to(max_tets, mesh));
}

}  // namespace tetune
