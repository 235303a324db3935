// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <vector>

#include "tetune/types.hpp"

namespace tetune::mpi {

/// Recursive coordinate bisection: returns for each of this rank's points the rank that it is assigned to, such that
/// the numbers of points of the ranks differ little. Collective.
std::vector<int> bisect(MPI_Comm comm, const std::vector<Point3>& points);

}  // namespace tetune::mpi
