// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/criteria.hpp"

namespace tetune {

/// Returns a text on what is lost from one mesh to another by the same criteria; empty if nothing. With a better
/// verdict on the mesh nothing is lost. Else a criterion loses if its verdict is worse or more elements fail. If none
/// does, and as many elements fail in all, a larger number of elements that warn is a loss.
std::string losses_in(const AcceptanceReport& before, const AcceptanceReport& after);

/// Whether the worst value of a criterion with a verdict of at least `level` in `after` is worse than before. A value
/// that is not a number is worse than all others, and not worse than another one.
bool has_worse_value(const AcceptanceReport& before, const AcceptanceReport& after, Verdict level);

}  // namespace tetune
