// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tetune/optimize.hpp"

namespace tetune::test {

/// A mesh, options and the operations that it is there for: each of them must be done. Together the cases run all
/// kernels. The simulator takes 150 times as long as a CPU: with Effort::best meshes are as small as the operations
/// allow.
struct Case {
  std::string name;
  TetMesh mesh;
  Options options;
  std::vector<CountInfo<OperationCounts>::Member> operations;
};
void PrintTo(const Case& c, std::ostream* out);
std::vector<Case> cases();

/// Those that the case is there for were done.
void expect_operations(const Case& c, const Report& report);

/// Results that are the same on all backends (docs/architecture.md, "Equal results"): the operations one by one, the
/// number of sweeps and why they stopped; sums over the mesh to rounding.
void expect_parity(const Report& report, const Report& on_cpu);

/// The same bits.
void expect_same(const TetMesh& a, const TetMesh& b);

}  // namespace tetune::test
