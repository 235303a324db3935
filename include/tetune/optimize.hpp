// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/targets.hpp"

namespace tetune {

enum class Device {
  automatic,  ///< as cuda for 1000000 tetrahedra or more where that can be, else the CPU
  cpu,        ///< threads
  cuda,       ///< the calling thread's current NVIDIA GPU, compute capability 7.5 or newer
};

enum class Boundary {
  fixed,     ///< no boundary vertex moves
  preserve,  ///< the surface stays as it is: vertices move in their plane or along their straight line (Sect. 4.2)
  slide,     ///< vertices slide on the input surface, and along its feature lines (Sect. 4.3)
};

/// What is made small: the sum over all tetrahedra of
enum class Energy {
  shape,  ///< (eta / eta_r)^(3/2), eta_r being that of the regular tetrahedron of the same volume: 1 or more, without
          ///< unit. Sees shapes alone, so that small elements count as much as large ones
  harmonic,  ///< eta, the paper's (Eq. 5), a length: large elements count for more, and sliding vertices drift to where
             ///< the elements become unequal
};

enum class Relocation {
  newton,    ///< over-relaxed Newton step on the convex one-ring energy
  gradient,  ///< steepest descent with Brent's line search, as in the paper (Alg. 1)
};

enum class Termination {
  relative,  ///< scale-free: the relative decrease of the energy
  paper,     ///< the conditions C1 to C3 of Sect. 4.5
};

/// How much is done.
enum class Effort {
  fast,      ///< one look for flips, and sweeps until one lowers the energy by less than 2e-2 of it
  standard,  ///< until 2e-3, then work on the worst elements and the smallest dihedral angles alone
  best,      ///< until 1e-4, then more of that, and vertices are inserted and removed there
};

/// What optimize() shall do.
struct Options {
  Device device = Device::cpu;
  Boundary boundary = Boundary::preserve;
  Energy energy = Energy::shape;
  /// Without effect under Termination::paper. Energy::harmonic leaves out the work on the worst elements.
  Effort effort = Effort::standard;
  /// With Effort::best: no vertex is inserted or removed.
  bool keep_vertices = false;
  Relocation relocation = Relocation::newton;
  Termination termination = Termination::relative;
  /// Inverted and flat tetrahedra are made positive before all else, instead of refused: vertices move as `boundary`
  /// allows, under an energy that does not end where a volume does.
  bool untangle = false;
  /// With Boundary::slide: an edge at which the surface turns by more than this many degrees, in (0, 180], is a
  /// feature, and so is a vertex at which a feature line does. 180: only borders between tags, edges not on two
  /// triangles and listed edges are.
  double feature_angle = 45;
  /// With Boundary::slide: no point of the new surface is farther than this from the old one, and none of the old one
  /// from the new; a length, 0 for no bound.
  double max_deviation = 0;
  /// Tagged triangles with the same region on both sides stay faces of the mesh, as interfaces do; otherwise they count
  /// for nothing and are dropped, unless they are required or frozen.
  bool open_boundaries = true;
  /// Tags of tetrahedra, and of listed triangles, that stay as they are to the last bit.
  std::vector<int> frozen_regions, frozen_patches;
  /// Empty, or for each vertex whether it must not move: not 0.
  std::vector<std::uint8_t> frozen_vertices;
  /// Most relocation sweeps, >= 0. 0 means flips alone.
  int max_iterations = 100;
  /// CPU threads; 0 means all, more than 4096 count as 4096. The result does not depend on it.
  int threads = 0;
  /// False: no edge and no face is flipped, vertices alone are moved (and with Effort::best inserted and removed).
  /// max_iterations must then be above 0.
  bool flips = true;
  /// Largest ring of a flip, 3 to 7: an edge with that many tetrahedra around it at most may be removed, or made in the
  /// place of faces. 3 is the paper's 3-2 and 2-3 flip; below 5 no faces are removed together.
  int max_ring = 7;
  /// Whether edges between coplanar triangles of one patch of the boundary, or of one interface, may be flipped away.
  /// Without effect under Boundary::fixed, where max_deviation is given, where max_ring is 3, without sweeps
  /// (max_iterations 0), and without flips.
  bool boundary_flips = true;
  /// What every element of the result is to reach. It changes nothing in what is done: Report::targets says which
  /// elements miss it, and why.
  std::vector<Target> targets;
  /// Whether the smallest dihedral angle is measured after each sweep and round: SweepReport::dihedral_min. It takes a
  /// twelfth of the time and changes nothing else.
  bool trace_angles = false;
};

/// One relocation sweep over all vertices (Alg. 1).
struct SweepReport {
  int iteration = 0;
  std::int64_t moved = 0;    ///< vertices that moved
  double energy_before = 0;  ///< the sum that Options::energy names; the harmonic one in the unit of the coordinates
  double decrease = 0;       ///< of the same
  double gradient_norm = 0;  ///< squared 2-norm of the gradient where each vertex stood when visited: of tr(L) = eta /
                             ///< 9, or of the shape energy, which rescaling divides
  double dihedral_min = 0;   ///< smallest dihedral angle afterwards, degrees; 0 without Options::trace_angles
  double seconds = 0;
};

/// One flip pass: propose, agree, apply (Alg. 5).
struct FlipReport {
  int iteration = 0;  ///< relocation sweeps done before
  int pass = 0;
  std::int64_t active = 0;     ///< tetrahedra examined
  std::int64_t evaluated = 0;  ///< candidate flips evaluated
  std::int64_t flips23 = 0, flips32 = 0;
  std::int64_t edge_removals = 0;   ///< of edges with four or more tetrahedra
  std::int64_t face_removals = 0;   ///< of two or more faces for an edge: passes of their own
  std::int64_t boundary_flips = 0;  ///< removals of edges within flat parts of the boundary and of interfaces: passes
                                    ///< of their own
  double decrease = 0;
  double seconds = 0;
  std::int64_t flips() const { return flips23 + flips32 + edge_removals + face_removals + boundary_flips; }
};

/// One round of work on the worst elements, or on those with the smallest angles: with Effort::best vertices inserted
/// and removed, flips around them, compound ones too, then their vertices moved.
struct WorstReport {
  int round = 0;
  std::int64_t worst = 0;                  ///< tetrahedra worked on
  std::int64_t inserted = 0, removed = 0;  ///< vertices
  std::int64_t flips = 0;
  std::int64_t moved = 0;   ///< vertices
  double dihedral_min = 0;  ///< as of SweepReport
  double seconds = 0;
};

enum class StopReason {
  converged,            ///< the energy no longer falls by a relevant part
  gradient_small,       ///< C1
  gradient_stationary,  ///< C2
  no_flips,             ///< C3
  iteration_limit,
  cancelled,
};

const char* to_string(StopReason reason);

struct PhaseTime {
  std::string phase;
  double seconds = 0;
};

/// What optimize() did.
struct Report {
  std::string device;         ///< "CPU", or the name of the GPU
  std::string device_reason;  ///< why that one, with Device::automatic; empty otherwise
  int threads = 0;            ///< that ran: fewer than asked for where the system gives no more; 0 on a GPU
  std::int64_t vertices = 0;  ///< of the input
  std::int64_t tets_before = 0, tets_after = 0;
  std::int64_t tets_untangled = 0;  ///< with Options::untangle: of the input, inverted or flat
  std::int64_t free_vertices = 0, plane_vertices = 0, line_vertices = 0, fixed_vertices = 0;
  std::int64_t surface_vertices = 0, curve_vertices = 0;  ///< with Boundary::slide
  /// Listed corners that may move, as the list names too many vertices on ground without features (TetGen lists all).
  std::int64_t corners_not_held = 0;
  /// The same for tagged edges that are no ridges: they stay edges of the mesh, but their vertices may leave the line.
  std::int64_t edges_not_held = 0;
  std::int64_t triangles_dropped = 0, edges_dropped = 0;
  int colors = 0;
  double energy_before = 0, energy_after = 0;
  std::int64_t flips23 = 0, flips32 = 0, edge_removals = 0, face_removals = 0, boundary_flips = 0;
  std::int64_t compound_flips = 0;  ///< edges removed together with a move of a vertex around them
  std::int64_t vertices_inserted = 0, vertices_removed = 0;  ///< with Effort::best
  /// For each vertex of the result the one of the input, or -1 for an inserted one. Empty where all were kept.
  std::vector<Index> vertex2original;
  /// For each tetrahedron of the result one of the input of the same region, whose place it took: itself where nothing
  /// was done, else one that flips, or a vertex inserted or removed, replaced near by.
  std::vector<Index> tet2original;
  /// For each listed triangle and edge of the result its position in the input's list. Empty where all were kept.
  std::vector<Index> triangle2original, edge2original;
  std::vector<SweepReport> sweeps;
  std::vector<FlipReport> flip_passes;
  std::vector<WorstReport> worst_rounds;
  std::vector<PhaseTime> phases;
  std::vector<TargetReport> targets;  ///< one for each of Options::targets, in order
  double seconds = 0;
  StopReason stop = StopReason::converged;
};

/// What the progress callback sees.
struct Progress {
  const char* phase;     ///< "untangling", "flips", "sweep", "worst" or "angles": what was just done
  int iteration;         ///< relocation sweeps done
  double energy;         ///< so far
  double energy_before;  ///< at the start
  double worst_angle;   ///< smallest dihedral angle, degrees. Measured anew while that costs less than 1 % of the time,
                        ///< so it may be that of some passes ago
  double fraction;      ///< of the whole run, 0 to 1, never falling: an estimate
  double seconds;       ///< since optimize() was called
  double seconds_left;  ///< an estimate; below 0 while there is no ground for one
};

/// Hooks of the caller, both called on the calling thread. What they do cannot change the result, but for stopping.
///
/// When one of them asks to stop, optimize() returns at the next safe point, with StopReason::cancelled: the mesh is
/// then the best so far, and as valid as any result. Safe points come several times a second, on large meshes too, from
/// when the mesh is loaded and checked.
struct Context {
  /// Called between passes. Return false to stop.
  std::function<bool(const Progress&)> progress;
  /// Asked at each safe point. Return true to stop.
  std::function<bool()> stop;
};

/// Improves a mesh in place: harmonic flips alternating with vertex relocation (Sect. 4.5).
///
/// On return the mesh is valid; its tags, the order and number of its vertices, and with Boundary::preserve and fixed
/// the shape of its boundary are as they were (boundary_flips change which triangles it has where it is flat), and the
/// energy is not larger. Effort::best may change the number of vertices, see Report::vertex2original: those of the
/// input come first, in their order, inserted ones last, with the tag 0; there are at most 10 % more tetrahedra, no
/// smaller dihedral angle, and the energy may be larger as there are more of them. Tetrahedra come out in another order
/// and number. Listed triangles without a tag that lie inside one region are no constraint and are dropped; so are
/// untagged listed edges that no longer exist. The result is bit for bit the same for any number of threads.
///
/// Throws MeshError when `validate(mesh)` finds something, UntangleError, OverlapError, OptionError, DeviceError or
/// std::bad_alloc, and hands on what the caller's hooks throw; the mesh is then as it was. Not for concurrent calls on
/// the same mesh.
Report optimize(TetMesh& mesh, const Options& options = {}, const Context& context = {});

/// About the most bytes of main memory that optimize() has in use at once, the mesh included: to refuse a mesh before
/// the work. Measured on meshes of 80 thousand to 1.5 million tetrahedra: docs/command-line.md, "Memory".
std::size_t memory_needed(const TetMesh& mesh, const Options& options = {});

/// The bytes of its own memory that a GPU sets aside for optimize(), whatever Options::device is. Where they are not
/// free, optimize() throws DeviceError before the work.
std::size_t memory_needed_on_device(const TetMesh& mesh, const Options& options = {});

}  // namespace tetune
