// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/inp/inp_inserted.hpp"
#include "io/io_context.hpp"

namespace tetune {

/// Lines with the values of inserted nodes, per entry of InpModel::conditions. A node has a value where all nodes
/// between which it is have one, and one of these by its number: where all have theirs by sets, so has the inserted
/// one. Warns of fields that lack values.
std::vector<std::string> extend_inp_conditions(const InpModel& model, const InpMatch& match,
                                               const std::vector<InpInserted>& inserted, const IoContext& context);

}  // namespace tetune
