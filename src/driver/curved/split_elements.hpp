// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "curved/curved_splits.hpp"
#include "curved/relaxation.hpp"
#include "tetune/mesh.hpp"

/// Splits of second-order elements of a mesh for which vertices may be inserted. They update the held nodes and the
/// origins of the mesh.
namespace tetune {

/// The number of tetrahedra that splits of invalid elements may make.
inline constexpr double kUnlimitedSplits = std::numeric_limits<double>::infinity();

/// Splits elements that are not valid, and relaxes those around new vertices, until all are valid, except for those
/// with a folded face, which it leaves. A round that does not lower the number of these elements is undone, and is the
/// last one: further rounds would only enlarge the patches to relax.
void split_invalid(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal);

/// Splits elements of a valid mesh whose held nodes keep the scaled Jacobian below kSmallBound (bound_by_held()), as
/// where two faces on a smooth surface meet: each part has one of them. Relaxes elements that are not valid then,
/// and undoes splits after which one still is not.
void split_bounded(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal, double max_tets);

}  // namespace tetune
