// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

/// The tags of regions and patches of a deck, and the names of sets that stand for them.
namespace tetune {

/// The tag of each combination of sets: the number in the names of its sets, as 50 of Volume50 with the start "Volume",
/// where they have one number that no earlier combination has; else a free number from 1. The first combination, which
/// is empty, gets 0, as do those that do not occur.
std::vector<int> number_inp_tags(const std::vector<std::vector<std::string>>& names, const std::vector<bool>& occurs,
                                 const char* start);

/// Whether number_inp_tags() gives this tag by this name.
bool is_inp_tag_name(const std::string& name, const char* start, int tag);

}  // namespace tetune
