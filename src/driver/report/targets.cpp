// SPDX-License-Identifier: Apache-2.0
#include "driver/report/targets.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "backend/cpu.hpp"
#include "boundary/vertex_dof.hpp"
#include "math/angle.hpp"
#include "math/elementary.hpp"
#include "mesh/edge_star.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/messages.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "quality/check_measures.hpp"
#include "quality/limits.hpp"
#include "quality/tet_measures.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Slots are searched in this many ranges in parallel.
constexpr Size kRanges = 64;

/// The best known value that a tetrahedron with a dihedral angle of `degrees` can have (docs/quality.md).
double best_at(Measure measure, double degrees) {
  if (measure == Measure::min_dihedral) return std::min(degrees, kRegularDihedral);
  const double angle = degrees / kDegreesPerRadian;
  return degrees >= kRegularDihedral ? 1
                                     : elementary::cbrt(8 * elementary::repeated_square(elementary::sin(angle), 1) /
                                                        elementary::repeated_square(3 - elementary::cos(angle), 1));
}

/// Whether best_at() bounds the measure.
bool is_bounded_by_angle(Measure measure) {
  return measure == Measure::min_dihedral || measure == Measure::mean_ratio || measure == Measure::sicn ||
         measure == Measure::harmonic;
}

/// Finds the limiting constraint of the tetrahedra of a mesh.
class ConstraintFinder {
 public:
  ConstraintFinder(const ConstrainedMesh& mesh, const Options& options)
      : options_(options),
        mesh_(mesh),
        points_(span_of(mesh.points)),
        tets_(span_of(mesh.tets)),
        tet2tet_(span_of(mesh.tet2tet)),
        regions_(span_of(mesh.regions)),
        on_surface_(mesh.points.size(), 0),
        on_interface_(mesh.points.size(), 0),
        required_(mesh.tets.size(), 0) {
    for (const Index t : mesh.required_slots) span_of(required_)[t] = 1;
    for (Size t = 0; t < tets_.size(); ++t) {
      if (tets_[t][0] == kFreeSlot) continue;
      for (int f = 0; f < 4; ++f) {
        if (is_locked(tet2tet_[t][f])) flag_face(t, f);
      }
    }
  }

  /// Sets the constraint of a tetrahedron that misses a target, and for LimitingConstraint::surface_angle the edge and
  /// the angle. Without a target, no angle of the surface bounds the measure.
  void find(Index t, const std::optional<Target>& target, MissedTet& missed) const {
    const auto& frozen = options_.frozen_regions;
    if (span_of(required_)[t] != 0 || std::find(frozen.begin(), frozen.end(), regions_[t]) != frozen.end()) {
      missed.held_by = LimitingConstraint::locked_element;
      return;
    }
    if (target && is_bounded_by_angle(target->measure)) {
      find_surface_angle(t, missed);
      if (misses(*target, best_at(target->measure, missed.surface_angle))) {
        missed.held_by = LimitingConstraint::surface_angle;
        return;
      }
    }
    missed.held_by = strongest_of_vertices(t);
    missed.edge = {-1, -1};
    missed.surface_angle = 0;
  }

 private:
  void flag_face(Size t, int f) {
    const HalfFace across = tet2tet_[t][f];
    const bool is_interface = across != kNoHalfFace && regions_[tet_of(across)] != regions_[t];
    for (int k = 0; k < 3; ++k) {
      const Index v = tets_[t][face_vertex(f, k)];
      span_of(on_surface_)[v] = 1;
      if (is_interface) span_of(on_interface_)[v] = 1;
    }
  }

  LimitingConstraint strongest_of_vertices(Index t) const {
    int fixed = 0;
    int on_surface = 0;
    LimitingConstraint strongest = LimitingConstraint::none;
    for (const Index v : tets_[t].v) {
      fixed += span_of(mesh_.dof)[v] == VertexDof::fixed ? 1 : 0;
      on_surface += span_of(on_surface_)[v];
      strongest = std::min(strongest, constraint_of_vertex(v));
    }
    return fixed == 4        ? LimitingConstraint::fixed_vertices
           : on_surface == 4 ? LimitingConstraint::surface_element
                             : strongest;
  }

  LimitingConstraint constraint_of_vertex(Index v) const {
    const VertexDof dof = span_of(mesh_.dof)[v];
    if (dof == VertexDof::free) return LimitingConstraint::none;
    if (span_of(mesh_.vertex_constraints)[v] == VertexConstraint::frozen) return LimitingConstraint::frozen_vertex;
    if (dof == VertexDof::fixed && options_.boundary != Boundary::fixed) return LimitingConstraint::feature_corner;
    if (dof == VertexDof::line || dof == VertexDof::curve) return LimitingConstraint::feature_line;
    return span_of(on_interface_)[v] != 0 ? LimitingConstraint::region_interface : LimitingConstraint::boundary;
  }

  /// Sets the smallest angle of the surface at an edge of the tetrahedron, measured on its side; 360 if there is none.
  void find_surface_angle(Index t, MissedTet& missed) const {
    missed.surface_angle = 360;
    for (int edge = 0; edge < 6; ++edge) {
      const EdgeCorners e = edge_corners(edge);
      const Index a = tets_[t][e.i];
      const Index b = tets_[t][e.j];
      const double angle = angle_at(t, a, b);
      const double beyond_k = angle_to_surface(t, e.k, a, b);
      const double beyond_l = beyond_k < 0 ? -1 : angle_to_surface(t, e.l, a, b);
      if (beyond_l < 0 || !(angle + beyond_k + beyond_l < missed.surface_angle)) continue;
      missed.surface_angle = angle + beyond_k + beyond_l;
      missed.edge = {span_of(mesh_.vertex2original)[a], span_of(mesh_.vertex2original)[b]};
    }
  }

  /// The angle about edge (a, b) from a face of t to the surface; -1 if the edge is not on the surface.
  double angle_to_surface(Index t, int face, Index a, Index b) const {
    const HalfFace across = tet2tet_[t][face];
    if (is_locked(across)) return 0;
    double sum = 0;
    EdgeWalk walk{tets_[t][6 - local_index(tets_[t], a) - local_index(tets_[t], b) - face], across};
    do {
      if (walk.tet() == t) return -1;
      sum += angle_at(walk.tet(), a, b);
    } while (walk.step(tets_, tet2tet_));
    return sum;
  }

  /// The dihedral angle of a tetrahedron at its edge (a, b), in degrees.
  double angle_at(Index t, Index a, Index b) const {
    Vec3 normals[2];
    int n = 0;
    const Vec3 origin = vec(points_[a]);
    const Vec3 edge = vec(points_[b]) - origin;
    for (const Index v : tets_[t].v) {
      if (v != a && v != b) normals[n++] = cross(edge, vec(points_[v]) - origin);
    }
    return kDegreesPerRadian * elementary::atan2(norm(cross(normals[0], normals[1])), dot(normals[0], normals[1]));
  }

  const Options& options_;
  const ConstrainedMesh& mesh_;
  Span<const Point> points_;
  Span<const Tet> tets_;
  Span<const FaceAdjacency> tet2tet_;
  Span<const int> regions_;
  std::vector<std::uint8_t> on_surface_, on_interface_, required_;
};

/// The order of TargetReport::worst. A value that is not a number, as measures of criteria may be of tiny elements, is
/// the worst.
struct IsWorse {
  bool larger_is_better;
  bool operator()(const MissedTet& x, const MissedTet& y) const {
    if (std::isnan(x.value) != std::isnan(y.value)) return std::isnan(x.value);
    if (x.value < y.value || x.value > y.value) return (x.value < y.value) == larger_is_better;
    return x.tet < y.tet;
  }
};

/// The tetrahedra of a range of slots that miss a target: their numbers by constraint, and at most 2 * kMaxMissed of
/// the worst.
struct MissedInRange {
  std::array<std::int64_t, kLimitingConstraints> counts{};
  std::vector<MissedTet> worst;  ///< by slots
};

MissedInRange find_missed(const ConstrainedMesh& mesh, const ConstraintFinder& constraints, const Target& target,
                          Size begin, Size end) {
  const Span<const Tet> tets = span_of(mesh.tets);
  const Span<const Point> points = span_of(mesh.points);
  const IsWorse is_worse{larger_is_better(target.measure)};
  MissedInRange result;
  for (Size t = begin; t < end; ++t) {
    const Tet& tet = tets[t];
    if (tet[0] == kFreeSlot) continue;
    Vec3 p[4];
    for (int k = 0; k < 4; ++k) p[k] = vec(points[tet[k]]);
    const double measured = value(all_measures(TetShape(p)), target.measure);
    if (!misses(target, measured)) continue;
    MissedTet missed;
    missed.tet = to_index(t);
    missed.value = measured;
    missed.centroid = to_point((1 / mesh.scale) * centroid(p[0], p[1], p[2], p[3]));
    constraints.find(missed.tet, target, missed);
    ++result.counts[std::size_t(missed.held_by)];
    result.worst.push_back(missed);
    if (result.worst.size() < 2 * kMaxMissed) continue;
    std::nth_element(result.worst.begin(), result.worst.begin() + kMaxMissed, result.worst.end(), is_worse);
    result.worst.resize(kMaxMissed);
  }
  return result;
}

/// The number of tetrahedra before each slot: their ids after compaction, which keeps the order of the slots. The last
/// entry is the number of tetrahedra.
std::vector<Index> slot2tet_of(const std::vector<Tet>& tets) {
  std::vector<Index> slot2tet(tets.size() + 1, 0);
  std::transform_inclusive_scan(
      tets.begin(), tets.end(), slot2tet.begin() + 1, std::plus<>(),
      [](const Tet& tet) { return tet[0] != kFreeSlot ? 1 : 0; }, Index{0});
  return slot2tet;
}

}  // namespace

const char* to_string(LimitingConstraint constraint) {
  return name_of(constraint,
                 {"locked element", "angle of the surface", "no vertex may move", "all four vertices on the surface",
                  "frozen vertex", "feature corner", "feature line", "interface", "boundary", "no constraint"});
}

void check_target(const Target& target, const std::string& what) {
  const bool is_angle = target.measure == Measure::min_dihedral || target.measure == Measure::max_dihedral;
  const double regular = is_angle ? kRegularDihedral : 1;
  const double worst = larger_is_better(target.measure) ? 0 : is_angle ? 180 : kFlatRatio;
  const auto [low, high] = std::minmax(worst, regular);
  if (target.value >= low && target.value <= high && target.value != worst) return;
  const std::string range =
      worst == kFlatRatio ? "1 or more"
      : worst < regular
          ? "above 0 and at most " + (regular == 1 ? std::string("1") : "70.528, the regular tetrahedron's")
          : std::string("at least 70.529, the regular tetrahedron's, and below 180");
  throw OptionError(what + to_string(target.measure) + " is " + number_text(target.value) + "; it must be " + range);
}

void keep_worst(bool larger_is_better, std::vector<MissedTet>& missed) {
  std::sort(missed.begin(), missed.end(), IsWorse{larger_is_better});
  if (missed.size() > kMaxMissed) missed.resize(kMaxMissed);
}

void add_locked(const TetMesh& mesh, const std::vector<std::uint8_t>& flags, int threads,
                const std::function<Index(Index)>& number, std::vector<TargetReport>& targets) {
  if (targets.empty()) return;
  const std::vector<Measures> measures = measure_each(mesh, threads);
  const TetMeshView view(mesh);
  for (TargetReport& r : targets) {
    for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
      const double measured = value(span_of(measures)[t], r.target.measure);
      if (span_of(flags)[t] != 0 || !misses(r.target, measured)) continue;
      MissedTet missed;
      missed.tet = number(t);
      missed.value = measured;
      missed.centroid = view.centroid(t);
      missed.held_by = LimitingConstraint::locked_element;
      r.worst.push_back(missed);
      ++r.missed;
      ++r.held_by[std::size_t(LimitingConstraint::locked_element)];
      if (r.worst.size() >= 2 * kMaxMissed) keep_worst(larger_is_better(r.target.measure), r.worst);
    }
    keep_worst(larger_is_better(r.target.measure), r.worst);
  }
}

void find_limiting(const ConstrainedMesh& mesh, const Options& options, const std::optional<Target>& target,
                   std::vector<MissedTet>& missed) {
  const ConstraintFinder constraints(mesh, options);
  for (MissedTet& m : missed) constraints.find(m.tet, target, m);
}

Options follow_vertices(Options options, const std::vector<Index>& vertex2original) {
  if (options.frozen_vertices.empty() || vertex2original.empty()) return options;
  options.frozen_vertices = gather_entries_or(options.frozen_vertices, vertex2original, std::uint8_t{0});
  return options;
}

Options options_for_result(const Options& options, const std::vector<Index>& vertex2original) {
  Options result = follow_vertices(options, vertex2original);
  result.only_below.clear();
  result.untangle = false;
  result.max_deviation = 0;
  return result;
}

std::vector<TargetReport> report_targets(const TetMesh& result, const Options& options,
                                         const std::vector<Index>& vertex2original) {
  if (options.targets.empty()) return {};
  const Options of_result = options_for_result(options, vertex2original);
  return report_targets(imported_mesh(result, of_result), of_result);
}

std::vector<TargetReport> report_targets(const ImportedMesh& imported, const Options& options) {
  std::vector<TargetReport> reports = report_targets(imported.mesh, options);
  for (TargetReport& r : reports) {
    for (MissedTet& m : r.worst) m.tet = span_of(imported.slot2tet)[m.tet];
  }
  return reports;
}

std::vector<TargetReport> report_targets(const ConstrainedMesh& mesh, const Options& options) {
  const Size slots = std::ssize(mesh.tets);
  const backend::Cpu cpu(options.threads);
  const std::vector<Index> slot2tet = slot2tet_of(mesh.tets);
  const ConstraintFinder constraints(mesh, options);
  std::vector<TargetReport> reports;
  for (const Target& target : options.targets) {
    std::vector<MissedInRange> ranges(to_size_t(kRanges));
    cpu.for_parts(kRanges, [&](Size i) {
      span_of(ranges)[i] = find_missed(mesh, constraints, target, slots * i / kRanges, slots * (i + 1) / kRanges);
    });
    TargetReport report;
    report.target = target;
    report.tets = slot2tet.back();
    for (const MissedInRange& range : ranges) {
      report.worst.insert(report.worst.end(), range.worst.begin(), range.worst.end());
      for (std::size_t k = 0; k < kLimitingConstraints; ++k) report.held_by[k] += range.counts[k];
    }
    report.missed = std::accumulate(report.held_by.begin(), report.held_by.end(), std::int64_t{0});
    keep_worst(larger_is_better(target.measure), report.worst);
    for (MissedTet& missed : report.worst) missed.tet = span_of(slot2tet)[missed.tet];
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace tetune
