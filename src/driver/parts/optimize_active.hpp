// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "driver/parts/active_part.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// Checks options and the lists of a mesh, and finds the constraints. Throws OptionError or MeshError.
Constraints checked_constraints(const TetMesh& mesh, const Options& options);

/// Decides whether the lists of a mesh are of features. Few corners, junctions and ends are, whatever the geometry;
/// else the whole mesh is classified, and `report` says what does not constrain.
ListedFeatures find_listed_features(const TetMesh& mesh, const Options& options, const Constraints& constraints,
                                    Report& report);

/// optimize() with Options::only_below: optimizes the active tetrahedra as a mesh of their own.
Report optimize_active(TetMesh& mesh, const Options& options, const Context& context);

/// Flagged tetrahedra, and those within some rings around them.
struct FlaggedPart {
  std::vector<std::uint8_t> flags;
  int rings;
};

/// Optimizes a part as a mesh of its own.
Report optimize_tets(TetMesh& mesh, FlaggedPart part, const Options& options, const Context& context);

/// Changes a part, with the hooks of the run, and returns whether the result is to be taken.
using ChangePart = std::function<bool(ActivePart&, const Context&)>;

/// Takes a part, changes it, and puts it in its place; `report` is that of the part, which `change` fills, and becomes
/// one of the whole mesh. Without tetrahedra that may change, nothing is called. Where the result is not taken, returns
/// nothing, and the mesh is as before.
std::optional<PartMaps> change_tets(TetMesh& mesh, FlaggedPart part, const Options& options, const Context& context,
                                    const ChangePart& change, Report& report);

/// Returns the error of a part. Where that is the validation report of the part, returns the report of the whole mesh,
/// which has its numbers.
MeshError error_of_whole(const MeshError& of_part, const TetMesh& part, const TetMesh& whole, int threads);

/// The constraints of a mesh, as optimize() reports them: vertices by degrees of freedom, listed corners and edges that
/// do not constrain. Computed on the CPU.
Report report_constraints(const TetMesh& mesh, const Options& options);

}  // namespace tetune
