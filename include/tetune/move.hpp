// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tetune/context.hpp"
#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// One position per vertex of a mesh, in the mesh's unit. A vertex with a position is *prescribed*: it ends there.
/// Three NaN stand for a vertex without one.
using VertexTargets = std::vector<Point3>;

/// One step of move(): all vertices move at once, then the mesh is improved.
struct MoveStep {
  std::size_t target = 0;     ///< position in the list of targets
  double fraction = 0;        ///< of the straight way to that target that is done after the step, 0 to 1
  int solver_iterations = 0;  ///< of the conjugate gradient method
  double dihedral_moved = 0;  ///< smallest dihedral angle after the motion, degrees
  double dihedral_min = 0;    ///< smallest dihedral angle after the improvement, degrees
  double seconds = 0;
};

/// Elements of a block that move() inverted: in the input the Jacobian determinant has the same sign at all corners,
/// and in the result it has another sign, or is 0, at one of them. Of second-order elements the vertices count alone.
struct InvertedOthers {
  std::string kind;             ///< ElementBlock::kind
  std::size_t block = 0;        ///< position in TetMesh::others
  std::vector<Index> elements;  ///< positions in the block, in increasing order
};

/// The account of a run of move().
struct MoveReport {
  /// The account of the work on the mesh, all steps together. Its maps are from the result to the input.
  Report optimization;
  std::int64_t prescribed = 0;  ///< number of vertices with a position in at least one target
  std::vector<MoveStep> steps;
  std::size_t targets = 0, targets_reached = 0;  ///< numbers of targets given, and reached in full
  /// Of the straight way to the first target that was not reached, the part that is done, from 0 and below 1; 1 if all
  /// targets were reached.
  double fraction = 1;
  /// If a target was not reached: tetrahedra of the result that a further step would invert, at most kMaxBlocking, in
  /// increasing order; and the prescribed vertices of the result nearest to them in the mesh. Empty after a requested
  /// stop.
  std::vector<Index> blocking_tets, blocking_vertices;
  bool reached() const { return targets_reached == targets; }
  /// The number of vertices that targets move although the options freeze them.
  std::int64_t frozen_moved = 0;
  /// Pyramids, prisms and hexahedra that the motion inverted.
  std::vector<InvertedOthers> inverted_others;
  /// The warnings on frozen vertices and inverted elements, whose ids count from 1 or 0; Report::warnings has the
  /// latter.
  TETUNE_API std::vector<std::string> warnings(bool one_based) const;
};
inline constexpr std::size_t kMaxBlocking = 1000;

/// Moves vertices of a mesh to prescribed positions, one target after the other; the other vertices follow, so that
/// every volume stays positive (docs/method.md, "Moving a mesh").
///
/// A prescribed vertex ends bit for bit at its position in the last target that has one, whatever freezes it otherwise;
/// until then, and in targets in which it has none, it stays where the target before left it. The others follow by a
/// harmonic extension of the motion, in as many steps as positive volumes take; after each step the mesh is improved as
/// by optimize() with `options`. The vertices of the boundary and of interfaces that are not prescribed move as
/// Options::boundary allows: `fixed` and `preserve` as in optimize(), in the plane or along the line of the input, but
/// not at all beside prescribed vertices that leave that plane; with `slide` on the surface of the input, but for
/// triangles of it all of whose vertices are prescribed and some of which move. Inner vertices that the lists of the
/// mesh hold and that are not prescribed stay, or on straight tagged lines move along these: see surface_targets().
/// Elements of other kinds follow their vertices; the report names those that are inverted.
///
/// If a target cannot be reached, or a hook of `context` requests a stop, move() returns the valid mesh of the last
/// fraction that was reached; the report says how far that is and which elements block the way. A straight way to a
/// target approximates a rotation by a few degrees only: larger ones take several targets.
///
/// The same entities are kept, renumbered and dropped as by optimize(). The result is the same bit for bit for any
/// number of threads. Data of vertices follow their vertex. Throws as optimize() does, and OptionError if `targets` is
/// empty, has another length than mesh.points, infinite coordinates, or no position at all, or if
/// Options::max_deviation bounds a surface that slides; the mesh is then unchanged.
TETUNE_API MoveReport move(TetMesh& mesh, std::span<const VertexTargets> targets, const Options& options = {},
                           const Context& context = {});

/// A single target.
TETUNE_API MoveReport move(TetMesh& mesh, const VertexTargets& target, const Options& options = {},
                           const Context& context = {});

/// An estimate of the peak of main memory of move(), in bytes, including mesh and targets: as memory_needed().
TETUNE_API std::size_t memory_needed_to_move(const TetMesh& mesh, std::size_t targets, const Options& options = {});

/// The positions `points` as targets of the vertices that optimize() holds, so that the others follow: those of the
/// faces that are on one tetrahedron, or between different regions, and of listed triangles; and inside the mesh those
/// of tagged, required and ridge edges, of required entities and of elements of other kinds, and corners, but none that
/// are not held because a list is exhaustive (Report::corners_not_held, edges_not_held). With `patches` only those of
/// the listed triangles with one of these tags: OptionError if no triangle has the tag.
TETUNE_API VertexTargets surface_targets(const TetMesh& mesh, const std::vector<Point3>& points,
                                         const std::vector<int>& patches = {});

}  // namespace tetune
