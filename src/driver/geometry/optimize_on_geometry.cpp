// SPDX-License-Identifier: Apache-2.0
#include "tetune/optimize_on_geometry.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "driver/geometry/geometry_checks.hpp"
#include "driver/geometry/geometry_work.hpp"
#include "driver/limit_growth.hpp"
#include "driver/report/extend_report.hpp"
#include "driver/report/run_warnings.hpp"
#include "driver/report/targets.hpp"
#include "math/constants.hpp"
#include "math/vec3.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/keep_entities.hpp"
#include "mesh/tet_orientation.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/progress/phase_timer.hpp"
#include "quality/smallest_angle.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"
#include "tetune/move.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// A vertex is on the geometry if its distance is at most this fraction of the diagonal.
constexpr double kOnGeometry = 1e-10;
/// The distance from the geometry that is expected of a vertex, as a fraction of the diagonal.
constexpr double kExpectedDistance = 0.01;
/// The fractions of the progress that the steps of a round take.
constexpr double kSnapFraction = 0.1, kSlideFraction = 0.6, kInsideFraction = 0.35, kWorstFraction = 0.05;
/// A round is repeated, with vertices of bad elements held, at most this many times.
constexpr int kMaxRetries = 3;

/// The smallest dihedral angle per tetrahedron.
std::vector<double> angles_of(const TetMesh& mesh, int threads) {
  std::vector<double> angles;
  for (const Measures& m : measure_each(mesh, threads)) angles.push_back(m[std::size_t(Measure::min_dihedral)]);
  return angles;
}

bool all_positive(const TetMesh& mesh, int threads) {
  const std::vector<std::int8_t> signs = volume_signs(mesh, threads);
  return std::all_of(signs.begin(), signs.end(), [](std::int8_t sign) { return sign > 0; });
}

class GeometryRun {
 public:
  GeometryRun(const Geometry& geometry, const Options& options, const GeometryOptions& on_geometry,
              const Context& caller)
      : geometry_(geometry),
        options_(options),
        on_geometry_(on_geometry),
        hooks_(caller),
        tolerance_(kOnGeometry * geometry.diagonal()) {}

  /// `warnings`: those of the caller's options, as those of the runs are of other options.
  GeometryReport run(TetMesh& input, RunWarnings warnings) {
    timed([&] {
      report_.before = geometry_.match(input);
      if (on_geometry_.measures) report_.deviation_before = geometry_.measure(input.points, report_.before);
    });
    max_tets_ = options_.max_growth * double(input.tets.size());
    load(input);
    if (on_geometry_.snap) {
      move_onto_geometry();
    } else {
      report_.snapped = 0;
    }
    hold_corners();
    bool is_done = false;
    for (int retry = 0; retry <= kMaxRetries && !is_done && !hooks_.is_stopped(); ++retry) is_done = make_round();
    if (report_.rounds == 0) {
      add(optimize(work_.mesh, fixed_options(work_), context_for(kSlideFraction, 1 - kSlideFraction)));
    }
    store(input);
    add_seconds(report_.optimization, "geometry", seconds_);
    if (hooks_.is_stopped()) report_.optimization.stop = StopReason::cancelled;
    warnings.add_to(report_.optimization, std::move(warnings_), report_.vertices_snapped > 0);
    return std::move(report_);
  }

 private:
  /// Runs work on the geometry, and adds the time that it takes.
  template <class F>
  void timed(const F& work) {
    const auto start = PhaseTimer::SteadyClock::now();
    work();
    seconds_ += PhaseTimer::seconds_since(start);
  }

  void load(const TetMesh& input) {
    const GeometryMatch& match = report_.before;
    TetMesh& mesh = work_.mesh;
    mesh = input;
    mesh.triangle_data.clear();
    mesh.triangles = match.triangles;
    mesh.triangle_tags.clear();
    std::vector<Index> input2work(input.triangles.size(), -1);
    for (Size t = 0; t < std::ssize(match.triangles); ++t) {
      const Index listed = span_of(match.listed)[t];
      const std::optional<int> caller = listed < 0 ? std::nullopt : std::optional(span_of(input.triangle_tags)[listed]);
      mesh.triangle_tags.push_back(tags_.add(span_of(match.faces)[t], caller));
      if (listed >= 0) span_of(input2work)[listed] = to_index(t);
    }
    mesh.required_triangles.clear();
    for (const Index t : input.required_triangles) {
      if (span_of(input2work)[t] >= 0) mesh.required_triangles.push_back(span_of(input2work)[t]);
    }
    work_.entities = match.vertices;
    work_.held = held_by_caller(input, options_, PointElements::hold);
    held_firmly_ = held_by_caller(input, options_, PointElements::do_not_hold);
  }

  /// Positions on the geometry of the vertices on an entity that are not held.
  std::vector<Point3> closest_points(const WorkState& state, const std::vector<std::uint8_t>& held) {
    std::vector<GeometryEntity> entities = state.entities;
    for (Size v = 0; v < std::ssize(entities); ++v) {
      if (span_of(held)[v] != 0 || !has_entity(span_of(entities)[v])) span_of(entities)[v] = {};
    }
    return project(state.mesh.points, entities);
  }
  std::vector<Point3> closest_points(const WorkState& state) { return closest_points(state, state.held); }

  std::vector<Point3> project(const std::vector<Point3>& points, const std::vector<GeometryEntity>& entities) {
    std::vector<Point3> projected;
    timed([&] { projected = geometry_.project(points, entities, std::vector<double>(points.size(), radius_)); });
    return projected;
  }

  void move_onto_geometry() {
    const std::vector<double>& distances = report_.before.distances;
    const auto is_off = [this](double distance) { return distance > tolerance_; };
    if (std::none_of(distances.begin(), distances.end(), is_off)) return;
    count_left_off();
    const std::vector<Point3> on_geometry = closest_points(work_, held_firmly_);
    VertexTargets targets(on_geometry.size(), Point3{kNan, kNan, kNan});
    TetMesh moved = work_.mesh;
    for (Size v = 0; v < std::ssize(targets); ++v) {
      if (span_of(work_.entities)[v].dimension == 3) continue;
      Point3& p = span_of(moved.points)[v];
      const double distance = norm(vec(span_of(on_geometry)[v]) - vec(p));
      if (distance > tolerance_) {
        p = span_of(on_geometry)[v];
        ++report_.vertices_snapped;
      }
      span_of(targets)[v] = p;
    }
    if (report_.vertices_snapped == 0) return;
    if (all_positive(moved, options_.threads)) {
      work_.mesh = std::move(moved);
      return;
    }
    MoveReport motion = move(work_.mesh, targets, fixed_options(work_), context_for(0, kSnapFraction));
    report_.snapped = motion.fraction;
    work_.follow_result(motion.optimization.vertex2original);
    add(std::move(motion.optimization));
  }

  void count_left_off() {
    for (Size v = 0; v < std::ssize(held_firmly_); ++v) {
      const double distance = span_of(report_.before.distances)[v];
      if (span_of(held_firmly_)[v] == 0 || !has_entity(span_of(work_.entities)[v]) || distance <= tolerance_) continue;
      ++report_.vertices_left_off;
      report_.largest_left_off = std::max(report_.largest_left_off, distance);
    }
    if (report_.vertices_left_off > 0) warnings_.push_back(warning_of_left_off(report_));
  }

  /// Vertices at vertices of the model, and those whose entity is not clear, stay.
  void hold_corners() {
    for (Size v = 0; v < std::ssize(work_.held); ++v) {
      const std::int8_t dimension = span_of(work_.entities)[v].dimension;
      if (dimension <= 0) span_of(work_.held)[v] = 1;
    }
  }

  Options options_for(const WorkState& state, Boundary boundary) const {
    Options options = options_;
    options.boundary = boundary;
    options.surface_vertices = SurfaceVertices::keep;
    options.frozen_vertices = state.held;
    options.frozen_patches = tags_.of_caller(options_.frozen_patches);
    // The growth of all runs together is limited.
    limit_growth(options, max_tets_, state.mesh);
    return options;
  }
  Options fixed_options(const WorkState& state) const { return options_for(state, Boundary::fixed); }

  Context context_for(double done, double fraction) const { return scaled_progress(hooks_.context(), done, fraction); }

  void add(Report&& run) {
    Report& total = report_.optimization;
    if (!has_run_) {
      total = std::move(run);
    } else {
      total.stop = run.stop;
      extend_report(total, std::move(run), work_.mesh);
    }
    has_run_ = true;
  }

  /// Slides, returns to the geometry and improves the inside. Returns false if the round is to be repeated, with the
  /// vertices of elements that became bad held.
  bool make_round() {
    const double least = smallest_dihedral(work_.mesh, options_.threads) - kAngleRounding;
    WorkState next = work_;
    Options sliding = options_for(work_, Boundary::slide);
    sliding.targets.clear();
    Report slide = optimize(next.mesh, sliding, context_for(0, kSlideFraction));
    next.follow_result(slide.vertex2original);
    const double slid_least = smallest_dihedral(next.mesh, options_.threads);
    std::vector<Point3> points = closest_points(next);
    next.mesh.points.swap(points);
    const std::vector<std::int8_t> signs = volume_signs(next.mesh, options_.threads);
    const auto inverted = [&](Size t) { return span_of(signs)[t] <= 0; };
    if (hold_vertices_of(next, slide.vertex2original, inverted)) return false;
    Report inside = optimize(next.mesh, fixed_options(next), context_for(kSlideFraction, kInsideFraction));
    next.follow_result(inside.vertex2original);
    const double next_least = smallest_dihedral(next.mesh, options_.threads);
    if (next_least < least) {
      const std::vector<double> angles = angles_of(next.mesh, options_.threads);
      const std::vector<Index> next2work = compose(slide.vertex2original, inside.vertex2original);
      const auto is_worse = [&](Size t) { return span_of(angles)[t] < least; };
      // Where no vertex is to be held, all vertices of the worse tetrahedra are held already.
      return !hold_vertices_of(next, next2work, is_worse);
    }
    work_ = std::move(next);
    ++report_.rounds;
    add(std::move(slide));
    add(std::move(inside));
    improve_worst(next_least, slid_least);
    return true;
  }

  /// The way back to the geometry may have made the smallest angle worse than it was on the triangles. Slides around
  /// the tetrahedra below that angle once more: now the triangles are nearer to the geometry.
  void improve_worst(double least, double slid_least) {
    for (int i = 0; i < kMaxRetries && least < slid_least && !hooks_.is_stopped(); ++i) {
      WorkState next = work_;
      Options sliding = options_for(work_, Boundary::slide);
      sliding.targets.clear();
      sliding.only_below = {{Measure::min_dihedral, slid_least}};
      Report slide = optimize(next.mesh, sliding, context_for(kSlideFraction + kInsideFraction, kWorstFraction / 2));
      next.follow_result(slide.vertex2original);
      next.mesh.points = closest_points(next);
      if (!all_positive(next.mesh, options_.threads)) return;
      Options fixed = fixed_options(next);
      if (fixed.targets.empty()) fixed.only_below = sliding.only_below;
      Report inside = optimize(next.mesh, fixed, context_for(1 - kWorstFraction / 2, kWorstFraction / 2));
      next.follow_result(inside.vertex2original);
      const double next_least = smallest_dihedral(next.mesh, options_.threads);
      if (next_least <= least) return;
      least = next_least;
      work_ = std::move(next);
      add(std::move(slide));
      add(std::move(inside));
    }
  }

  /// Holds the vertices of bad tetrahedra of a result that may move; false if there is none.
  template <class IsBad>
  bool hold_vertices_of(const WorkState& result, const std::vector<Index>& result2work, const IsBad& is_bad) {
    std::int64_t count = 0;
    for (Size t = 0; t < std::ssize(result.mesh.tets); ++t) {
      if (!is_bad(t)) continue;
      for (const Index v : span_of(result.mesh.tets)[t]) {
        if (!result.may_move(v)) continue;
        std::uint8_t& held = span_of(work_.held)[original_of(result2work, v)];
        count += held == 0 ? 1 : 0;
        held = 1;
      }
    }
    report_.vertices_held += count;
    return count > 0;
  }

  /// Replaces the caller's mesh by the result, with those of its triangles that the caller listed.
  void store(TetMesh& input) {
    judge_targets();
    match_result();
    if (on_geometry_.measures) {
      timed([&] { report_.deviation_after = geometry_.measure(work_.mesh.points, report_.after); });
    }
    TetMesh& mesh = work_.mesh;
    Report& total = report_.optimization;
    std::vector<std::uint8_t> keep;
    std::vector<Index> new2input;
    for (Size t = 0; t < std::ssize(mesh.triangles); ++t) {
      const Index listed = span_of(report_.before.listed)[original_of(total.triangle2original, to_index(t))];
      keep.push_back(listed >= 0 ? 1 : 0);
      report_.after.listed.push_back(listed >= 0 ? to_index(std::ssize(new2input)) : -1);
      if (listed >= 0) new2input.push_back(listed);
      span_of(mesh.triangle_tags)[t] = listed >= 0 ? *tags_.caller(span_of(mesh.triangle_tags)[t]) : 0;
    }
    keep_triangles(mesh, positions_of_kept(keep));
    mesh.triangle_data = take_entries(input.triangle_data, new2input);
    total.triangles_dropped = std::ssize(input.triangles) - std::ssize(mesh.triangles);
    total.triangle2original = empty_if_identity(std::move(new2input), input.triangles.size());
    // The total has the changes of the energy by runs, but not those by projections.
    const Quality measured = quality(mesh, options_.threads);
    total.energy_after = options_.energy == Energy::harmonic ? measured.eta_sum : measured.shape_sum;
    input = std::move(mesh);
  }

  /// Judges Options::targets as if the surface slid: it is fixed in the last run alone.
  void judge_targets() {
    if (options_.targets.empty()) return;
    Report& total = report_.optimization;
    Options sliding = options_for(work_, Boundary::slide);
    sliding.frozen_vertices = follow_vertices(options_, total.vertex2original).frozen_vertices;
    total.targets = report_targets(work_.mesh, sliding, {});
  }

  /// The match of the result.
  void match_result() {
    const TetMesh& mesh = work_.mesh;
    GeometryMatch& after = report_.after;
    after = report_.before;
    after.vertices = work_.entities;
    after.triangles = mesh.triangles;
    after.faces.clear();
    after.listed.clear();
    for (const int tag : mesh.triangle_tags) after.faces.push_back(tags_.face(tag));
    const std::vector<Index>& new2old = report_.optimization.vertex2original;
    if (!new2old.empty()) {
      const std::vector<Index> old2new = inverse_map(new2old, report_.before.vertices.size());
      for (auto& edge : after.edges) {
        for (Index& v : edge) v = span_of(old2new)[v];
      }
    }
    const std::vector<Point3> on_geometry = project(mesh.points, work_.entities);
    after.distances.clear();
    for (Size v = 0; v < std::ssize(mesh.points); ++v) {
      after.distances.push_back(norm(vec(span_of(on_geometry)[v]) - vec(span_of(mesh.points)[v])));
    }
  }

  static constexpr double kAngleRounding = 1e-9;  ///< degrees

  const Geometry& geometry_;
  const Options& options_;
  const GeometryOptions& on_geometry_;
  const LatchedHooks hooks_;
  const double tolerance_;
  /// The expected distance: a search within it is faster.
  const double radius_ = kExpectedDistance * geometry_.diagonal();
  GeometryReport report_;
  PatchTags tags_;
  WorkState work_;
  std::vector<std::uint8_t> held_firmly_;  ///< flags the vertices of the input that do not move onto the geometry
  std::vector<std::string> warnings_;      ///< made before the caller's mesh changes
  bool has_run_ = false;
  double max_tets_ = 0;
  double seconds_ = 0;  ///< of work on the geometry
};

}  // namespace

GeometryReport optimize_on_geometry(TetMesh& mesh, const Geometry& geometry, const Options& options,
                                    const GeometryOptions& on_geometry, const Context& context) {
  const auto start = PhaseTimer::SteadyClock::now();
  check_geometry_options(mesh, options);
  GeometryReport report;
  try {
    report = GeometryRun(geometry, options, on_geometry, context).run(mesh, RunWarnings(mesh, options));
  } catch (const MeshError&) {
    // Where the input is not valid, the error says that alone, with the ids of the input.
    if (const ValidationReport valid = validate(mesh, options.threads); !valid.ok()) {
      throw MeshError(valid.message(false));
    }
    throw;
  }
  report.optimization.seconds = PhaseTimer::seconds_since(start);
  return report;
}

}  // namespace tetune
