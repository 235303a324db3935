// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tetune/optimize.hpp"

namespace tetune::test {

/// A mesh and options. Together the cases run all kernels.
struct Case {
  std::string name;
  TetMesh mesh;
  Options options;
};
void PrintTo(const Case& c, std::ostream* out);
std::vector<Case> cases();

/// What is the same on all backends (docs/architecture.md, "Equal results"): the operations one by one, the number of
/// sweeps and why they stopped; sums over the mesh to rounding.
void expect_parity(const Report& report, const Report& on_cpu);

/// The same bits.
void expect_same(const TetMesh& a, const TetMesh& b);

}  // namespace tetune::test
