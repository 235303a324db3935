// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tetune/context.hpp"
#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/move.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

struct SlideSurface;

/// A mesh that a simulation changes step after step, and of which each step disturbs a part: only that part and its
/// neighborhood are worked on, and all else keeps its coordinates and numbers bit for bit.
///
/// The work of a step is that of optimize() or move() on the part, and a few passes over the lists of the whole mesh.
/// Vertices keep their numbers in work on a part. With Effort::best vertices are inserted, behind all others or with
/// the numbers of removed ones; none is removed unless as many are inserted. A step that works on the whole mesh, as
/// the first one with Boundary::slide may, can remove more: Report::vertex2original then has the numbers before.
/// Results are the same bit for bit for any number of threads. Not for concurrent calls on one object.
class TETUNE_API LiveMesh {
 public:
  /// `options` hold for all calls; those with one entry per vertex follow its vertices. Options::max_growth limits the
  /// number of tetrahedra after any number of calls, by that of the mesh given here. `neighborhood`, from 1 to 100:
  /// the number of rings of tetrahedra around a disturbed one that may change.
  ///
  /// Throws MeshError if the lists of the mesh are not consistent or it is curved, and OptionError; Options::only_below
  /// must be empty.
  explicit LiveMesh(TetMesh mesh, Options options = {}, int neighborhood = 3);

  const TetMesh& mesh() const { return mesh_; }
  /// Moves the mesh out; the object is then empty.
  TetMesh release() && { return std::move(mesh_); }

  /// Sets positions of vertices, as many as `vertices`, and marks these as disturbed. Tetrahedra may become inverted:
  /// then optimize() requires Options::untangle. Throws OptionError for a vertex that does not exist or a position that
  /// is not finite; the mesh is then unchanged.
  void set_points(std::span<const Index> vertices, std::span<const Point3> positions);

  /// The number of vertices that were disturbed since the last call of optimize() or optimize_all().
  std::int64_t disturbed() const;

  /// Optimizes the tetrahedra with a disturbed vertex and their neighborhood, as optimize() with Options::only_below
  /// does; Report::tets_bad is the number of those with a disturbed vertex. Without disturbed vertices nothing changes.
  /// When it throws, the mesh is unchanged.
  Report optimize(const Context& context = {});

  /// Optimizes the whole mesh; tetrahedra get other numbers, and with Effort::best vertices too
  /// (Report::vertex2original).
  Report optimize_all(const Context& context = {});

  /// move() with one target for the neighborhood of the prescribed vertices whose position changes. Where the target
  /// cannot be reached there, the neighborhood is doubled, up to the whole mesh. The whole mesh is worked on as well
  /// where it has locked tetrahedra or elements of other kinds. Where no position changes, nothing does.
  ///
  /// With Boundary::slide the whole mesh is worked on. All calls slide on the surface as it was at the first one, or at
  /// the first one after set_points(), optimize_all() or the optimize() of disturbed vertices. The vertices of the
  /// surface stay, whatever the effort.
  MoveReport move(const VertexTargets& target, const Context& context = {});

 private:
  bool moves_in_parts(const std::vector<std::uint8_t>& moves) const;
  /// move() of flagged vertices in their neighborhood. Nothing if a part of the mesh is refused.
  std::optional<MoveReport> move_part(const VertexTargets& target, const std::vector<std::uint8_t>& moves,
                                      const Context& context);
  /// move() with Boundary::slide.
  MoveReport move_sliding(const VertexTargets& target, const std::vector<std::uint8_t>& moves, const Context& context);
  /// The options of the next call, which may add what others have left of the growth.
  Options next_options() const;
  /// Takes the arrays with an entry per vertex along.
  void follow(const Report& report);

  TetMesh mesh_;
  Options options_;
  int neighborhood_;
  double max_tets_;
  std::vector<std::uint8_t> disturbed_;
  /// The surface that the vertices slide on; null: that of the mesh as it is.
  std::shared_ptr<const SlideSurface> surface_;
};

}  // namespace tetune
