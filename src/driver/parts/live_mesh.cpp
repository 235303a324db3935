// SPDX-License-Identifier: Apache-2.0
#include "tetune/live_mesh.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/limit_growth.hpp"
#include "driver/move_job.hpp"
#include "driver/move_warnings.hpp"
#include "driver/parts/live_surface.hpp"
#include "driver/parts/optimize_active.hpp"
#include "driver/report/targets.hpp"
#include "driver/report/unchanged.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/vertex_layers.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/option_table.hpp"

namespace tetune {

LiveMesh::LiveMesh(TetMesh mesh, Options options, int neighborhood)
    : mesh_(std::move(mesh)),
      options_(std::move(options)),
      neighborhood_(neighborhood),
      max_tets_(options_.max_growth * double(mesh_.tets.size())),
      disturbed_(mesh_.points.size(), 0) {
  if (!options_.only_below.empty()) {
    throw OptionError("only_below: a live mesh works on the tetrahedra that were disturbed; leave it empty");
  }
  const double most = find_option("rings")->range.max;
  if (neighborhood < 1 || neighborhood > most) {
    throw OptionError("neighborhood: must be from 1 to " + std::to_string(int(most)));
  }
  if (!mesh_.curved_edges.empty()) throw MeshError("a live mesh has straight elements; this one has curved edges");
  checked_constraints(mesh_, options_);
}

void LiveMesh::set_points(std::span<const Index> vertices, std::span<const Point3> positions) {
  if (vertices.size() != positions.size()) {
    throw OptionError(std::to_string(positions.size()) + " positions for " + std::to_string(vertices.size()) +
                      " vertices");
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i] < 0 || vertices[i] >= std::ssize(mesh_.points)) {
      throw OptionError("vertex " + std::to_string(vertices[i]) + " does not exist; the mesh has " +
                        std::to_string(mesh_.points.size()));
    }
    if (!is_finite(positions[i])) {
      throw OptionError("the position of vertex " + std::to_string(vertices[i]) + " is not finite");
    }
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    Point3& p = span_of(mesh_.points)[vertices[i]];
    if (p == positions[i]) continue;
    p = positions[i];
    surface_ = nullptr;
    span_of(disturbed_)[vertices[i]] = 1;
  }
}

std::int64_t LiveMesh::disturbed() const { return std::count(disturbed_.begin(), disturbed_.end(), 1); }

Report LiveMesh::optimize(const Context& context) {
  if (disturbed() > 0) surface_ = nullptr;
  Report report = optimize_tets(mesh_, {tets_at(mesh_.tets, disturbed_), neighborhood_}, next_options(), context);
  follow(report);
  std::fill(disturbed_.begin(), disturbed_.end(), 0);
  return report;
}

Report LiveMesh::optimize_all(const Context& context) {
  surface_ = nullptr;
  Report report = tetune::optimize(mesh_, next_options(), context);
  follow(report);
  std::fill(disturbed_.begin(), disturbed_.end(), 0);
  return report;
}

MoveReport LiveMesh::move(const VertexTargets& target, const Context& caller) {
  const LatchedHooks hooks(caller);
  const Context& context = hooks.context();
  const std::size_t n = mesh_.points.size();
  bool is_usable = target.size() == n && !std::all_of(target.begin(), target.end(), is_free);
  std::vector<std::uint8_t> moves(n, 0);
  for (std::size_t v = 0; v < n && is_usable; ++v) {
    is_usable = is_free(target[v]) || is_finite(target[v]);
    moves[v] = !is_free(target[v]) && target[v] != mesh_.points[v] ? 1 : 0;
  }
  if (is_usable && std::all_of(moves.begin(), moves.end(), [](std::uint8_t m) { return m == 0; })) {
    MoveReport report;
    report.optimization = report_unchanged(mesh_, next_options());
    report.prescribed = std::count_if(target.begin(), target.end(), is_finite);
    report.targets = report.targets_reached = 1;
    return report;
  }
  if (is_usable && options_.boundary == Boundary::slide) return move_sliding(target, moves, context);
  if (is_usable && moves_in_parts(moves)) {
    if (std::optional<MoveReport> report = move_part(target, moves, context)) {
      report->prescribed = std::count_if(target.begin(), target.end(), is_finite);
      return *std::move(report);
    }
  }
  // Errors of the motion of the whole mesh have the numbers of this mesh.
  MoveReport report = tetune::move(mesh_, target, next_options(), context);
  follow(report.optimization);
  return report;
}

MoveReport LiveMesh::move_sliding(const VertexTargets& target, const std::vector<std::uint8_t>& moves,
                                  const Context& context) {
  Options options = next_options();
  if (options.surface_vertices == SurfaceVertices::edit) {
    throw OptionError(
        "surface_vertices=edit: while a live mesh moves with boundary=slide, the vertices of its surface "
        "stay; use surface_vertices=keep");
  }
  options.surface_vertices = SurfaceVertices::keep;
  SlideSurface surface = surface_ != nullptr ? *surface_ : find_slide_surface(mesh_, options);
  leave_surface(surface, target, moves);
  MoveReport report = move_on(mesh_, std::span(&target, 1), options, context, &surface);
  follow(report.optimization);
  renumber_surface(surface, report.optimization.vertex2original, mesh_.points);
  surface_ = std::make_shared<const SlideSurface>(std::move(surface));
  return report;
}

std::optional<MoveReport> LiveMesh::move_part(const VertexTargets& target, const std::vector<std::uint8_t>& moves,
                                              const Context& context) {
  MoveReport report;
  report.targets = report.targets_reached = 1;
  const std::int64_t frozen_moved = count_frozen_moved(mesh_, options_, moves);
  std::string frozen_warning = frozen_text(frozen_moved);
  int rings = neighborhood_;
  for (std::size_t size = 0, last = 0;; last = size) {
    const auto change = [&](ActivePart& part, const Context& hooks) {
      const VertexTargets targets = gather_entries(target, part.vertex2whole);
      report = tetune::move(part.mesh, targets, part.options, hooks);
      part.is_moved = true;
      size = part.tet2whole.size();
      const bool can_grow = size > last && size < mesh_.tets.size();
      return report.reached() || !can_grow || report.optimization.stop == StopReason::cancelled;
    };
    try {
      const auto maps =
          change_tets(mesh_, {tets_at(mesh_.tets, moves), rings}, next_options(), context, change, report.optimization);
      if (!maps) {
        rings *= 2;
        continue;
      }
      report.blocking_tets = translated_ids(std::move(report.blocking_tets), maps->tet2whole);
      report.blocking_vertices = translated_ids(std::move(report.blocking_vertices), maps->vertex2whole);
    } catch (const Error&) {
      return std::nullopt;
    }
    // The options of a part freeze other vertices than those of the mesh.
    report.frozen_moved = frozen_moved;
    if (frozen_moved > 0) report.optimization.warnings.push_back(std::move(frozen_warning));
    follow(report.optimization);
    return report;
  }
}

/// Parts have all tetrahedra of the vertices that move: none of these may be locked, nor have elements of other kinds.
bool LiveMesh::moves_in_parts(const std::vector<std::uint8_t>& moves) const {
  if (!mesh_.required_tets.empty() || !options_.frozen_regions.empty() || !mesh_.others.empty()) return false;
  std::vector<std::uint8_t> has_tet(moves.size(), 0);
  for (const auto& tet : mesh_.tets) {
    for (const Index v : tet) span_of(has_tet)[v] = 1;
  }
  for (std::size_t v = 0; v < moves.size(); ++v) {
    if (moves[v] != 0 && has_tet[v] == 0) return false;
  }
  return true;
}

Options LiveMesh::next_options() const {
  Options options = options_;
  limit_growth(options, max_tets_, mesh_);
  return options;
}

void LiveMesh::follow(const Report& report) {
  if (report.vertex2original.empty()) return;
  disturbed_ = gather_entries_or(disturbed_, report.vertex2original, std::uint8_t{0});
  options_ = follow_vertices(options_, report.vertex2original);
}

}  // namespace tetune
