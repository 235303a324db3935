// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/criteria.hpp"

namespace tetune {

/// Says what criteria lose from one mesh to another, which has the same criteria; empty if nothing. A better verdict on
/// the mesh is no loss; else a criterion loses with a worse verdict, or more failing elements, and all of them where as
/// many fail, and more warn.
std::string losses_in(const AcceptanceReport& before, const AcceptanceReport& after);

}  // namespace tetune
