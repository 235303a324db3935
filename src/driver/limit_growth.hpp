// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "tetune/mesh.hpp"
#include "tetune/option_table.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// Lowers Options::max_growth for one of several runs that may make at most `max_tets` tetrahedra in all. Where it has
/// no effect it stays: another value would be a warning of an option that the caller did not set.
inline void limit_growth(Options& options, double max_tets, const TetMesh& mesh) {
  if (mesh.tets.empty() || why_ineffective(*find_option("max_growth"), options) != nullptr) return;
  options.max_growth = std::min(options.max_growth, std::max(1.0, max_tets / double(mesh.tets.size())));
}

}  // namespace tetune
