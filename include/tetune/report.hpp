// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/flip_counts.hpp"
#include "tetune/targets.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// One relocation sweep over the active vertices (Stroeter et al. 2022, Alg. 1).
struct SweepReport {
  int iteration = 0;         ///< from 1
  std::int64_t moved = 0;    ///< number of vertices that moved
  double energy_before = 0;  ///< the sum that Options::energy names; Energy::harmonic is a length, in the mesh's unit
  double decrease = 0;       ///< of that sum
  union {
    /// Squared 2-norm of the gradient with respect to the vertices, each one's when it was visited: of tr(L) = eta / 9
    /// with Energy::harmonic, else of the shape energy (inversely proportional to the square of the mesh's unit).
    double gradient_norm2 = 0;
    double gradient_norm;  ///< former name, until version 0.3
  };
  double dihedral_min = 0;  ///< smallest dihedral angle afterwards, degrees; 0 without Options::trace_angles
  double seconds = 0;
};

/// One flip pass: candidates are evaluated, an independent set of them is selected and applied (Alg. 5).
struct FlipReport : FlipCounts {
  int iteration = 0;  ///< number of relocation sweeps before
  int pass = 0;
  std::int64_t active = 0;     ///< number of tetrahedra examined
  std::int64_t evaluated = 0;  ///< number of candidate flips evaluated
  double decrease = 0;         ///< of the energy
  double seconds = 0;
};

/// One round of work on the worst elements, on those with the smallest dihedral angles, or on the mean energy: with
/// Effort::best or SurfaceVertices::edit vertices are inserted and removed, then edges and faces are flipped around
/// them, then their vertices are moved. With Effort::best the rounds are, in this order, on the mean energy, the worst
/// elements, the angles, restarts, and the mean energy again; `round` starts from 1 for each of them.
struct WorstReport {
  std::string work;  ///< "mean energy", "worst", "angles" or "restarts"
  int round = 0;
  std::int64_t worst = 0;                  ///< number of tetrahedra worked on; of spots in a round of restarts
  std::int64_t inserted = 0, removed = 0;  ///< numbers of vertices
  std::int64_t flips = 0;
  std::int64_t moved = 0;   ///< number of vertices
  double dihedral_min = 0;  ///< as in SweepReport
  double seconds = 0;
};

enum class StopReason {
  converged,            ///< the relative decrease of the energy fell below the bound that Options::effort sets
  gradient_small,       ///< condition C1 of the paper (Sect. 4.5)
  gradient_stationary,  ///< C2
  no_flips,             ///< C3
  iteration_limit,      ///< Options::max_iterations
  cancelled,            ///< by a hook of Context
};

/// In words: "converged", "gradient small (C1)", ...
TETUNE_API const char* to_string(StopReason reason);

/// A point of a mesh: the barycentric coordinates of vertices of a tetrahedron, none negative, which sum to 1.
struct MeshPlace {
  std::array<Index, 4> vertices{-1, -1, -1, -1};
  std::array<double, 4> weights{1, 0, 0, 0};
};

/// The time spent in one phase, summed over its parts.
struct PhaseTime {
  std::string phase;
  double seconds = 0;
};

/// An edge of a curved surface that keeps a part of its curvature alone, so that elements are valid.
struct StraightenedEdge {
  std::array<Index, 2> vertices{};  ///< of the input, in ascending order
  double kept = 0;   ///< distance of the mid-side node from the midpoint, relative to that on the curved surface
  double moved = 0;  ///< distance of the mid-side node from its place on the curved surface
};

/// The account of a run of optimize().
struct Report : OperationCounts {
  std::string device;         ///< "CPU", or the name of the GPU
  std::string device_reason;  ///< the reason of the choice, with Device::automatic; empty otherwise
  int threads = 0;            ///< that ran: fewer than Options::threads where the system gives no more; 0 on a GPU
  std::int64_t vertices = 0;  ///< of the input
  std::int64_t tets_before = 0, tets_after = 0;
  std::int64_t tets_untangled = 0;  ///< with Options::untangle: number of inverted or flat ones in the input
  /// With Options::max_deviation on a curved second-order surface: a bound on its distance from that of the input, in
  /// both directions.
  double deviation = 0;
  /// With Options::straighten, sorted by vertices.
  std::vector<StraightenedEdge> straightened;
  /// With Options::only_below: numbers of tetrahedra of the input that miss a limit, and of those that might change.
  std::int64_t tets_bad = 0, tets_active = 0;
  /// Numbers of vertices of the input that may move anywhere, in a plane, along a line, not at all. In second-order
  /// meshes those of curved triangles do not move, unless they slide.
  std::int64_t free_vertices = 0, plane_vertices = 0, line_vertices = 0, fixed_vertices = 0;
  /// With Boundary::slide: numbers of vertices that slide on the surface and along its feature lines.
  std::int64_t surface_vertices = 0, curve_vertices = 0;
  /// With Boundary::slide and no Options::max_deviation: number of vertices that do not slide, as they are on curved
  /// sheets that are thin for their triangles, or at curved rims of thin sheets (docs/method.md, "Thin sheets").
  std::int64_t thin_vertices = 0;
  /// Number of vertices that move together with their images (TetMesh::periodic).
  std::int64_t periodic_vertices = 0;
  /// Number of listed corners that may move, because the list is exhaustive (TetGen lists all vertices) and the surface
  /// has no feature there.
  std::int64_t corners_not_held = 0;
  /// Number of tagged edges that do not constrain their vertices, for the same reason; they stay edges of the mesh.
  std::int64_t edges_not_held = 0;
  /// Number of ends and junctions of tagged edges that may move along these, for the same reason.
  std::int64_t line_ends_not_held = 0;
  /// Number of listed triangles that the result lacks because they constrain nothing. Those of the boundary and of
  /// interfaces that flips or SurfaceVertices::edit replace by others do not count.
  std::int64_t triangles_dropped = 0;
  std::int64_t edges_dropped = 0;  ///< number of listed edges that the result lacks
  int colors = 0;                  ///< of the graph of vertices that must not move at once
  /// The sum that Options::energy names; with Options::only_below that of the active tetrahedra, of second-order meshes
  /// that of the straight ones of the input and of the result.
  double energy_before = 0, energy_after = 0;
  /// For each vertex of the result that of the input, or -1 for an inserted one. Empty if all vertices were kept.
  std::vector<Index> vertex2original;
  /// With DataTransfer::interpolate and conserve: the place of each vertex of the result in the input. A vertex that
  /// did not move has the weight 1. Where the surface has moved outward, the closest point of the input; a vertex that
  /// is in no tetrahedron is at its own place. After move(), a place is the material (Lagrangian) coordinate of the
  /// vertex.
  std::vector<MeshPlace> places;
  /// With DataTransfer::conserve: fraction of the input's volume that no tetrahedron of the result covers, 0 where the
  /// surface keeps its shape; its data were assigned to the nearest tetrahedra.
  double uncovered = 0;
  /// With DataTransfer::conserve: the run was stopped, and the transfer would have taken longer than the run before it;
  /// data are those of DataTransfer::interpolate.
  bool transfer_stopped = false;
  /// For each tetrahedron of the result one of the input in the same region: itself if it was not changed, else one
  /// that was replaced near it.
  std::vector<Index> tet2original;
  /// For each listed triangle and edge of the result its position in the input's list. Empty if all were kept, or
  /// none.
  std::vector<Index> triangle2original, edge2original;
  std::vector<SweepReport> sweeps;
  std::vector<FlipReport> flip_passes;
  std::vector<WorstReport> worst_rounds;
  int restarts = 0, restarts_kept = 0;  ///< tries in neighborhoods of the worst elements, and those that were taken
  std::vector<PhaseTime> phases;
  std::vector<TargetReport> targets;  ///< one per entry of Options::targets, in the same order
  /// With DataTransfer::carry: the names of floating-point data of vertices that the improvement has moved; values of a
  /// field are then at other places than before.
  std::vector<std::string> moved_fields;
  /// Of integer data of vertices or tetrahedra that number them in ascending order: that numbers may occur more than
  /// once in the result, as new entities have those of the ones that they descend from.
  std::vector<std::string> repeated_numbers;
  /// With Options::only_below, and of optimize_towards(): the reason why the mesh was left as it is; else empty.
  std::string unchanged;
  /// Of second-order meshes with Options::untangle: that the smallest angle is smaller than in the input, and that
  /// max_growth leaves no room to split elements whose scaled Jacobian the surface bounds.
  std::vector<std::string> curved_warnings;
  /// Of options without effect, see ineffective_options(), those above, and MoveReport::warnings().
  std::vector<std::string> warnings;
  double seconds = 0;  ///< wall-clock time of optimize()
  StopReason stop = StopReason::converged;
};

}  // namespace tetune
