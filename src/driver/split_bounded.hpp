// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "curved/curved_splits.hpp"
#include "curved/relaxation.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Splits elements of a valid mesh whose held nodes keep the scaled Jacobian below kSmallBound (bound_by_held()), as
/// where two faces on a smooth surface meet: each part has one of them. Relaxes what is not valid then; splits after
/// which something stays so are undone. `held` and `origins` follow.
void split_bounded(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal);

}  // namespace tetune
