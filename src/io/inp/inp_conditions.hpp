// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/inp/inp_inserted.hpp"
#include "io/io_context.hpp"

namespace tetune {

/// Lines with the values of inserted nodes, per entry of InpModel::conditions. A node has a value where all nodes
/// between which it is have one. It gets no line where these have theirs by sets and it is in one of the sets; supports
/// by sets alone are left to the sets. `sets_of`: the sets of each inserted node. Warns of nodes that lack values.
std::vector<std::string> extend_inp_conditions(const InpModel& model, const InpMatch& match,
                                               const std::vector<InpInserted>& inserted,
                                               const std::vector<std::vector<Index>>& sets_of,
                                               const IoContext& context);

}  // namespace tetune
