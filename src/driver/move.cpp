// SPDX-License-Identifier: Apache-2.0
#include "tetune/move.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "boundary/constraints.hpp"
#include "boundary/vertex_dof.hpp"
#include "driver/devices.hpp"
#include "driver/move_job.hpp"
#include "driver/move_warnings.hpp"
#include "driver/parts/optimize_active.hpp"
#include "math/constants.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/validate_arrays.hpp"
#include "mesh/vertex_layers.hpp"
#include "mesh/work_mesh.hpp"
#include "phases/motion/sliding_motion.hpp"
#include "tetune/error.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Returns VertexMotion per vertex. Throws OptionError for unusable targets.
std::vector<std::uint8_t> find_motion(const TetMesh& mesh, std::span<const VertexTargets> targets) {
  if (targets.empty()) throw OptionError("there is no target to move to");
  std::vector<std::uint8_t> motion(mesh.points.size(), 0);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::string target = "target " + std::to_string(i + 1);
    if (targets[i].size() != mesh.points.size()) {
      throw OptionError(target + " has " + std::to_string(targets[i].size()) + " positions for " +
                        std::to_string(mesh.points.size()) + " vertices; it must have one per vertex");
    }
    for (std::size_t v = 0; v < targets[i].size(); ++v) {
      const Point3& p = targets[i][v];
      if (is_free(p)) continue;
      if (!is_finite(p)) {
        throw OptionError(target + ": the position of vertex " + std::to_string(v) +
                          " is not finite; three NaN stand for a vertex that is free to follow");
      }
      motion[v] |= kPrescribed;
      if (p != mesh.points[v]) motion[v] |= kMoves;
    }
  }
  if (std::all_of(motion.begin(), motion.end(), [](std::uint8_t m) { return m == 0; })) {
    throw OptionError("no target has a position for any vertex: there is nothing to move");
  }
  return motion;
}

/// The scale for the coordinates of all targets, a power of two: see unit_scale().
double scale_of(std::span<const VertexTargets> targets) {
  std::vector<Point3> given;
  double scale = kInfinity;
  for (const VertexTargets& target : targets) {
    given.clear();
    std::copy_if(target.begin(), target.end(), std::back_inserter(given), [](const Point3& p) { return !is_free(p); });
    if (!given.empty()) scale = std::min(scale, unit_scale(given));
  }
  return scale;
}

/// Sets the vertices of the result to the last position that they reached, to the last bit: coordinates far below the
/// largest ones are rounded by the scale of the work mesh. Vertices that are on their way to a further target stay.
void restore_bits(TetMesh& mesh, std::span<const VertexTargets> targets, const MoveReport& report) {
  const std::vector<Index>& vertex2original = report.optimization.vertex2original;
  const std::span<const VertexTargets> reached = targets.first(report.targets_reached);
  const VertexTargets* const next =
      report.fraction > 0 && reached.size() < targets.size() ? &targets[reached.size()] : nullptr;
  for (Size v = 0; v < std::ssize(mesh.points); ++v) {
    const Index original = original_of(vertex2original, to_index(v));
    if (original < 0 || (next != nullptr && !is_free(span_of(*next)[original]))) continue;
    for (auto target = reached.rbegin(); target != reached.rend(); ++target) {
      const Point3& p = span_of(*target)[original];
      if (is_free(p)) continue;
      span_of(mesh.points)[v] = p;
      break;
    }
  }
}

/// find_listed_features(), or none in a mesh that is not valid, which move() refuses.
ListedFeatures features_that_hold(const TetMesh& mesh, const Options& options, const Constraints& constraints) {
  try {
    Report unused;
    return find_listed_features(mesh, options, constraints, unused);
  } catch (const MeshError&) {
    return {};
  }
}

/// Calls add(vertex) for the vertices that the lists of a mesh hold in place or on a line, on the surface or not.
template <class Add>
void for_each_held(const TetMesh& mesh, const Add& add) {
  Options options;
  options.untangle = true;  // move() reports volumes that are not positive
  const Constraints constraints = find_constraints(mesh, options);
  const ListedFeatures are_held = features_that_hold(mesh, options, constraints);
  for (Index v = 0; v < std::ssize(constraints.vertices); ++v) {
    const VertexConstraint constraint = span_of(constraints.vertices)[v];
    if (constraint == VertexConstraint::frozen || (constraint == VertexConstraint::corner && are_held.corners)) add(v);
  }
  const std::size_t lines = are_held.edges ? constraints.edges.size() : constraints.ridges;
  for (std::size_t e = 0; e < lines; ++e) {
    for (const Index v : constraints.edges[e]) add(v);
  }
}

}  // namespace

WorkTarget work_target(const VertexTargets& targets, const std::vector<Index>& vertex2original, double scale) {
  WorkTarget work{std::vector<Vec3>(vertex2original.size(), Vec3{0, 0, 0}),
                  std::vector<std::uint8_t>(vertex2original.size(), 0)};
  for (Size v = 0; v < std::ssize(vertex2original); ++v) {
    const Point3& p = span_of(targets)[span_of(vertex2original)[v]];
    if (is_free(p)) continue;
    span_of(work.positions)[v] = scale * vec(p);
    span_of(work.prescribed)[v] = 1;
  }
  return work;
}

void report_blocking(const BlockedMesh& blocked, MoveReport& report) {
  std::vector<std::uint8_t> flags(blocked.unfinished.size(), 0);
  for (const Index slot : blocked.slots) {
    for (const Index v : span_of(blocked.tets)[slot].v) span_of(flags)[v] = 1;
  }
  Index tet = -1;
  auto next = blocked.slots.begin();
  for (Size slot = 0; slot < std::ssize(blocked.tets) && next != blocked.slots.end(); ++slot) {
    if (span_of(blocked.tets)[slot][0] != kFreeSlot) ++tet;
    if (slot != *next) continue;
    ++next;
    if (report.blocking_tets.size() < kMaxBlocking) report.blocking_tets.push_back(tet);
  }
  // The blocking tetrahedra need not have a prescribed vertex themselves.
  constexpr int kMaxLayers = 100;
  for (int layer = 0; layer < kMaxLayers && !blocked.slots.empty() && report.blocking_vertices.empty(); ++layer) {
    for (Size v = 0; v < std::ssize(flags) && report.blocking_vertices.size() < kMaxBlocking; ++v) {
      if (span_of(flags)[v] != 0 && span_of(blocked.unfinished)[v] != 0) {
        report.blocking_vertices.push_back(span_of(blocked.work2new)[v]);
      }
    }
    add_layer(blocked.tets, flags);
  }
  std::sort(report.blocking_vertices.begin(), report.blocking_vertices.end());
}

MoveReport move_on(TetMesh& mesh, std::span<const VertexTargets> targets, const Options& options,
                   const Context& context, SlideSurface* surface) {
  if (options.boundary == Boundary::slide && options.max_deviation > 0) {
    throw OptionError(
        "max_deviation bounds the distance to the input surface, which move() changes: leave it 0, or use "
        "boundary=preserve or boundary=fixed");
  }
  if (!options.only_below.empty()) throw OptionError("only_below is for optimize(): move() changes the whole mesh");
  MoveReport report;
  std::vector<std::uint8_t> motion = find_motion(mesh, targets);
  MoveJob job{targets, scale_of(targets), std::move(motion), report};
  report.prescribed = std::count_if(job.motion.begin(), job.motion.end(), [](std::uint8_t m) { return m != 0; });
  report.targets = targets.size();
  require_arrays(mesh);
  std::vector<std::uint8_t> moves(job.motion.size(), 0);
  for (Size v = 0; v < std::ssize(moves); ++v) span_of(moves)[v] = (span_of(job.motion)[v] & kMoves) != 0 ? 1 : 0;
  MoveWarnings warnings(mesh, options, moves);
  Options held = options;
  if (held.frozen_vertices.empty()) held.frozen_vertices.resize(job.motion.size(), 0);
  // Another length is refused later.
  for (Size v = 0; v < std::min(std::ssize(job.motion), std::ssize(held.frozen_vertices)); ++v) {
    if (span_of(job.motion)[v] != 0) span_of(held.frozen_vertices)[v] = 1;
  }
  report.optimization = run_on_device(mesh, held, context, surface, &job);
  restore_bits(mesh, targets, report);
  warnings.add_to(mesh, report);
  return report;
}

MoveReport move(TetMesh& mesh, std::span<const VertexTargets> targets, const Options& options, const Context& context) {
  return move_on(mesh, targets, options, context, nullptr);
}

MoveReport move(TetMesh& mesh, const VertexTargets& target, const Options& options, const Context& context) {
  return move(mesh, std::span<const VertexTargets>(&target, 1), options, context);
}

VertexTargets surface_targets(const TetMesh& mesh, const std::vector<Point3>& points, const std::vector<int>& patches) {
  require_arrays(mesh);
  if (points.size() != mesh.points.size()) {
    throw OptionError(std::to_string(points.size()) + " positions for " + std::to_string(mesh.points.size()) +
                      " vertices; there must be one per vertex");
  }
  VertexTargets targets(points.size(), Point3{kNan, kNan, kNan});
  const auto add_vertex = [&](Index v) { span_of(targets)[v] = span_of(points)[v]; };
  const auto add = [&](const std::array<Index, 3>& triangle) {
    for (const Index v : triangle) add_vertex(v);
  };
  for (const int patch : patches) {
    if (std::find(mesh.triangle_tags.begin(), mesh.triangle_tags.end(), patch) == mesh.triangle_tags.end()) {
      throw OptionError("no triangle has the tag " + std::to_string(patch));
    }
  }
  for (Size t = 0; t < std::ssize(mesh.triangles); ++t) {
    const int tag = span_of(mesh.triangle_tags)[t];
    if (patches.empty() || std::find(patches.begin(), patches.end(), tag) != patches.end()) {
      add(span_of(mesh.triangles)[t]);
    }
  }
  if (!patches.empty()) return targets;
  for_each_surface_face(mesh, 1, [&](const SortedHalfFace& face, bool) { add(face.vertices); });
  for_each_held(mesh, add_vertex);
  return targets;
}

}  // namespace tetune
