// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "curved/curved_splits.hpp"
#include "curved/relaxation.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Splits elements of a valid mesh whose held nodes keep the scaled Jacobian below kSmallBound (bound_by_held()), as
/// where two faces on a smooth surface meet: each part has one of them. Relaxes elements that are not valid then,
/// and undoes splits after which one still is not. Updates `held` and `origins`.
void split_bounded(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal, double max_tets);

}  // namespace tetune
