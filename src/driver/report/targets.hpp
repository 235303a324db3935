// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "boundary/vertex_dof.hpp"
#include "mesh/half_face.hpp"
#include "mesh/tet.hpp"
#include "tetune/options.hpp"

/// The elements that miss a target, and the constraints that limit them (docs/quality.md, "Targets").
namespace tetune {

/// Throws OptionError for a target that every element meets or that none can. `what` names it: "the target for ".
void check_target(const Target& target, const std::string& what);

/// A mesh on the host with the constraints of its vertices, by slots, before they are compacted.
struct ConstrainedMesh {
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<FaceAdjacency> tet2tet;
  std::vector<int> regions;  ///< tags of the tetrahedra
  std::vector<Index> vertex2original;
  std::vector<VertexDof> dof;
  std::vector<VertexConstraint> vertex_constraints;
  std::vector<Index> required_slots;
  double scale;  ///< coordinates per unit of the caller's
};

/// A mesh that is not optimized, and the tetrahedron in each slot.
struct ImportedMesh {
  ConstrainedMesh mesh;
  std::vector<Index> slot2tet;
};
ImportedMesh imported_mesh(const TetMesh& mesh, const Options& options);

/// The options for the vertices of a result, of which inserted ones are not frozen; `vertex2original` is
/// Report::vertex2original.
Options follow_vertices(Options options, const std::vector<Index>& vertex2original);
/// The caller's options for the vertices of a result, to judge it: `vertex2original` is Report::vertex2original.
Options options_for_result(const Options& options, const std::vector<Index>& vertex2original);
/// One report per entry of Options::targets, with the mesh's own numbers of tetrahedra.
std::vector<TargetReport> report_targets(const ImportedMesh& imported, const Options& options);
/// report_targets() of a result, with the caller's options.
std::vector<TargetReport> report_targets(const TetMesh& result, const Options& options,
                                         const std::vector<Index>& vertex2original);

/// Finds the constraints of tetrahedra that miss a limit; angles of the surface are among them only where a target is
/// given. MissedTet::tet is a slot.
void find_limiting(const ConstrainedMesh& mesh, const Options& options, const std::optional<Target>& target,
                   std::vector<MissedTet>& missed);

/// Sorts tetrahedra that miss a target or a limit, the worst value first, then by id, and keeps at most kMaxMissed.
void keep_worst(bool larger_is_better, std::vector<MissedTet>& missed);

/// Adds the tetrahedra without a flag that miss a target, as locked ones; `number` returns the id that a tetrahedron
/// has in the result.
void add_locked(const TetMesh& mesh, const std::vector<std::uint8_t>& flags, int threads,
                const std::function<Index(Index)>& number, std::vector<TargetReport>& targets);

/// Returns one report per entry of Options::targets.
std::vector<TargetReport> report_targets(const ConstrainedMesh& mesh, const Options& options);

}  // namespace tetune
