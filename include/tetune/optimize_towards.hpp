// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tetune/criteria.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// One round on the tetrahedra that fail; on an input that only warns, on those that warn.
struct CriteriaRound {
  int rings = 0;            ///< around those that fail, as Options::rings
  std::int64_t active = 0;  ///< number of tetrahedra that might change
  /// Numbers of tetrahedra (or faces) that miss the limit of a criterion that fails, or warns.
  std::int64_t failed_before = 0, failed_after = 0;
  bool kept = false;  ///< whether the result was taken
  double seconds = 0;
};

/// The constraints of the tetrahedra that miss the limit of a criterion that fails.
struct CriterionLimits {
  AcceptanceCriterion criterion;
  /// How many of them each LimitingConstraint holds.
  std::array<std::int64_t, kLimitingConstraints> held_by{};
  std::vector<MissedTet> worst;  ///< the worst of them, at most kMaxMissed: by value, then by id
};

/// The account of a run of optimize_towards().
struct CriteriaReport {
  Report optimization;  ///< of the whole run: its maps are from the result to the input
  AcceptanceReport before, after;
  std::vector<CriteriaRound> rounds;  ///< on the input where `undone` says so, else on the result of optimize()
  /// What criteria would lose by the optimization of the whole mesh, which was undone for that; else empty. It is among
  /// Report::warnings.
  std::string undone;
  std::string no_rounds;  ///< the reason why no rounds are made with these options; else empty
  /// One per criterion that fails on the result. Empty for curved meshes, with Options::only_below, and after a
  /// requested stop.
  std::vector<CriterionLimits> limits;
};

/// Optimizes a mesh as optimize() does; then, while a criterion fails, works in rounds on the tetrahedra that miss its
/// limit and those around them, in a growing neighborhood, as Effort::best does (docs/quality.md, "Acceptance"). A
/// round is kept if fewer criteria fail afterwards, or as many with fewer tetrahedra that miss a limit, and the worst
/// value of none of these gets worse; else it is undone. The smallest dihedral angle does not fall, and the smallest
/// mean ratio not below what optimize() allows.
///
/// Unless the verdict on the mesh is better than on the input, no criterion has a worse one than there or more failing
/// elements, nor, where as many fail, do more warn in all: a result with such losses is undone. The rounds are then
/// made on the input, on the tetrahedra that fail or, if no criterion fails, on those that warn, and kept without such
/// losses; where none is, the mesh stays as it is (CriteriaReport::undone).
///
/// The rounds insert and remove vertices only where optimize() does with these options, within Options::max_growth of
/// the input; an inserted vertex may take the number of a removed one. With Boundary::slide they keep the surface as
/// with Boundary::preserve, and in all rounds linked periodic vertices and their triangles stay. No rounds are made on
/// curved meshes, with Options::only_below, DataTransfer::interpolate and conserve, Energy::harmonic and
/// Termination::paper.
///
/// The result is bit for bit the same for any number of threads. Throws as check() and optimize() do; the mesh is then
/// unchanged.
TETUNE_API CriteriaReport optimize_towards(TetMesh& mesh, const AcceptanceCriteria& criteria,
                                           const Options& options = {}, const Context& context = {});

}  // namespace tetune
