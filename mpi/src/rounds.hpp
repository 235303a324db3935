// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "distribute.hpp"
#include "one_part.hpp"
#include "tetune/mpi.hpp"

namespace tetune::mpi {

/// Optimizes a distributed mesh. Collective: all ranks throw where one fails.
DistributedReport optimize_parts(MPI_Comm comm, Part& part, Totals& totals, Options options,
                                 const std::function<bool()>& stop, const MessageForm& form = {});

}  // namespace tetune::mpi
