// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/quality.hpp"

namespace tetune::cli {

/// A warning where the largest dihedral angle, the angle that 5 % of the angles are below, or the mean ratio of an
/// optimized mesh is clearly worse than that of the input; otherwise none. The sum of the energy falls nevertheless: in
/// layers that are much wider than thick, few of the elements have most of it. `local`: the option that restricts the
/// work to the worst elements.
std::vector<std::string> declined_measures(const Quality& before, const Quality& after, const std::string& local);

/// A warning where the volume of a region is clearly another one than in the input, as on coarse round surfaces and in
/// thin sheets whose vertices slide; otherwise none.
std::vector<std::string> changed_volume(const Comparison& change);

}  // namespace tetune::cli
