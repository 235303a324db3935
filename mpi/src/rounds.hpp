// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "distribute.hpp"
#include "tetune/mpi.hpp"

namespace tetune::mpi {

/// Optimizes a distributed mesh. Collective: all ranks throw where one fails. Ids in messages start from 1 or from 0.
DistributedReport optimize_parts(MPI_Comm comm, Part& part, Totals& totals, Options options,
                                 const std::function<bool()>& stop, bool one_based = false);

}  // namespace tetune::mpi
