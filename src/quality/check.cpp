// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "mesh/connect.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/validate_arrays.hpp"
#include "mesh/work_mesh.hpp"
#include "quality/check_measures.hpp"
#include "quality/find_failed.hpp"
#include "quality/shape_loop.hpp"
#include "tetune/criteria.hpp"

namespace tetune {
namespace {

/// The counts and the worst value of one criterion for a part of the mesh.
struct CriterionSums {
  std::int64_t count = 0, warned = 0, failed = 0;
  double worst = 0;
  Size worst_tet = -1;
  std::vector<FailedTet> failed_tets;  ///< if they are listed
};

/// Whether the tetrahedra that fail a criterion are listed too.
enum class FailedTets : std::uint8_t { counted, listed };

/// Counts values by the limits of a criterion.
class CriterionCounter {
 public:
  explicit CriterionCounter(const AcceptanceCriterion& criterion, FailedTets failed = FailedTets::counted)
      : criterion_(criterion), larger_is_better_(info_of(criterion.measure).larger_is_better), failed_(failed) {}

  void add(CriterionSums& sums, double value, Size tet) const {
    ++sums.count;
    if (criterion_.fail && misses(value, *criterion_.fail)) {
      ++sums.failed;
      if (failed_ == FailedTets::listed) list(sums.failed_tets, value, to_index(tet));
    } else if (criterion_.warn && misses(value, *criterion_.warn)) {
      ++sums.warned;
    }
    if (is_new_worst(sums, value)) {
      sums.worst = value;
      sums.worst_tet = tet;
    }
  }
  void merge(CriterionSums& sums, const CriterionSums& next) const {
    sums.count += next.count;
    sums.warned += next.warned;
    sums.failed += next.failed;
    sums.failed_tets.insert(sums.failed_tets.end(), next.failed_tets.begin(), next.failed_tets.end());
    if (next.worst_tet >= 0 && is_new_worst(sums, next.worst)) {
      sums.worst = next.worst;
      sums.worst_tet = next.worst_tet;
    }
  }
  Verdict verdict(const CriterionSums& sums) const {
    const double allowed = criterion_.allowed_percent / 100 * double(sums.count);
    if (double(sums.failed) > allowed) return Verdict::fail;
    const bool many = criterion_.warn && double(sums.warned + sums.failed) > allowed;
    return sums.failed > 0 || many ? Verdict::warn : Verdict::pass;
  }

 private:
  /// Of several faces of one tetrahedron, the worst one is listed.
  void list(std::vector<FailedTet>& failed, double value, Index tet) const {
    if (failed.empty() || failed.back().tet != tet) {
      failed.push_back({tet, value});
    } else if (larger_is_better_ ? !(value >= failed.back().value) : !(value <= failed.back().value)) {
      failed.back().value = value;
    }
  }
  /// A value that is not a number misses every limit.
  bool misses(double value, double limit) const { return larger_is_better_ ? !(value >= limit) : !(value <= limit); }
  bool is_new_worst(const CriterionSums& sums, double value) const {
    if (sums.worst_tet < 0) return true;
    if (std::isnan(sums.worst)) return false;
    return larger_is_better_ ? !(value >= sums.worst) : !(value <= sums.worst);
  }

  const AcceptanceCriterion& criterion_;
  bool larger_is_better_;
  FailedTets failed_;
};

/// Whether a measure depends on the tetrahedra across the faces too.
bool is_of_neighbors(CheckMeasure measure) {
  return measure == CheckMeasure::orthogonal_quality || info_of(measure).of_faces;
}

/// Measures tetrahedra and faces of a mesh, in the caller's unit.
class CheckedMesh {
 public:
  /// Prepares for these measures.
  CheckedMesh(const TetMesh& mesh, std::span<const AcceptanceCriterion> criteria, int threads)
      : view_(mesh, unit_scale(mesh)), cpu_(threads) {
    const auto is_of_volumes = [](const AcceptanceCriterion& c) { return c.measure == CheckMeasure::volume; };
    const auto has_neighbors = [](const AcceptanceCriterion& c) { return is_of_neighbors(c.measure); };
    if (std::any_of(criteria.begin(), criteria.end(), is_of_volumes)) signs_ = volume_signs(mesh, threads);
    if (std::none_of(criteria.begin(), criteria.end(), has_neighbors)) return;
    work_ = upload_mesh(cpu_, mesh);
    build_adjacency(cpu_, work_);
  }

  CriterionSums measure(const AcceptanceCriterion& criterion, FailedTets failed = FailedTets::counted) {
    const CriterionCounter counter(criterion, failed);
    std::vector<CriterionSums> chunks(to_size_t(shape_chunk_count(view_.tets.size())));
    cpu_.for_parts(std::ssize(chunks), [&](Size chunk) {
      CriterionSums& sums = span_of(chunks)[chunk];
      for_each_shape(view_, chunk, [&](const TetShapeT<ShapePack>& shapes, int l, Size t) {
        add(counter, criterion.measure, lane(shapes, l), t, sums);
      });
    });
    CriterionSums sums;
    for (const CriterionSums& chunk : chunks) counter.merge(sums, chunk);
    return sums;
  }

 private:
  void add(const CriterionCounter& counter, CheckMeasure measure, const TetShape& shape, Size t,
           CriterionSums& sums) const {
    if (measure == CheckMeasure::orthogonal_quality) {
      counter.add(sums, orthogonal_quality(shape, t), t);
    } else if (info_of(measure).of_faces) {
      for (int f = 0; f < 4; ++f) add_face(counter, measure, shape, t, f, sums);
    } else if (measure == CheckMeasure::volume) {
      counter.add(sums, volume(shape, t), t);
    } else {
      const bool is_length = measure == CheckMeasure::shortest_edge || measure == CheckMeasure::min_altitude;
      counter.add(sums, shape_measure(shape, measure) / (is_length ? view_.scale : 1), t);
    }
  }

  /// The volume, with its exact sign and the nearest size in the range of normal doubles.
  double volume(const TetShape& shape, Size t) const {
    const int sign = span_of(signs_)[t];
    if (sign == 0) return 0;
    const double size = std::fabs(shape.volume) / view_.scale / view_.scale / view_.scale;
    using Limits = std::numeric_limits<double>;
    return std::copysign(std::clamp(size, Limits::min(), Limits::max()), sign);
  }

  HalfFace across(Size t, int face) const { return std::as_const(work_.tet2tet).span()[t][face]; }
  Vec3 centroid_of_tet(Size t) const {
    const Tet tet = view_.tet(t);
    return centroid(view_.position(tet[0]), view_.position(tet[1]), view_.position(tet[2]), view_.position(tet[3]));
  }

  double orthogonal_quality(const TetShape& s, Size t) const {
    const Vec3 center = centroid_of(s.p);
    double quality = relative_volume(s);
    for (int f = 0; f < 4; ++f) {
      const Vec3 outward = outward_normal(s, f);
      quality = std::min(quality, cosine(outward, face_centroid(s.p, f) - center));
      const HalfFace other = across(t, f);
      if (other != kNoHalfFace) quality = std::min(quality, cosine(outward, centroid_of_tet(tet_of(other)) - center));
    }
    return quality;
  }

  /// The normal of a face that points away from the vertex opposite it, whatever the orientation.
  static Vec3 outward_normal(const TetShape& s, int f) {
    const Vec3 n = s.n[f];
    return dot(n, s.p[face_vertex(f, 0)] - s.p[f]) < 0 ? -1.0 * n : n;
  }

  /// Counts the value of a face, unless the tetrahedron across has the smaller id, which counts it.
  void add_face(const CriterionCounter& counter, CheckMeasure measure, const TetShape& s, Size t, int f,
                CriterionSums& sums) const {
    const HalfFace other = across(t, f);
    const bool inside = other != kNoHalfFace;
    if (inside && tet_of(other) < t) return;
    const Vec3 own = centroid_of(s.p);
    const Vec3 neighbor = inside ? centroid_of_tet(tet_of(other)) : own;
    const Vec3 normal = outward_normal(s, f);
    if (measure == CheckMeasure::non_orthogonality) {
      if (inside) counter.add(sums, angle_between(normal, neighbor - own), t);
      return;
    }
    const Vec3 corners[3] = {s.p[face_vertex(f, 0)], s.p[face_vertex(f, 1)], s.p[face_vertex(f, 2)]};
    counter.add(sums, face_skewness(corners, normal, own, inside ? &neighbor : nullptr), t);
  }

  TetMeshView view_;
  backend::Cpu cpu_;
  std::vector<std::int8_t> signs_;  ///< of the volumes, if these are measured
  WorkMesh<backend::Cpu> work_;
};

}  // namespace

std::vector<FailedTet> find_failed(const TetMesh& mesh, const AcceptanceCriterion& criterion, int threads) {
  return CheckedMesh(mesh, {&criterion, 1}, threads).measure(criterion, FailedTets::listed).failed_tets;
}

AcceptanceReport check(const TetMesh& mesh, const AcceptanceCriteria& criteria, int threads) {
  require_arrays(mesh);
  for (const AcceptanceCriterion& c : criteria.criteria) check_criterion(c);
  AcceptanceReport report;
  report.name = criteria.name;
  if (mesh.tets.empty()) {
    report.verdict = Verdict::fail;
    return report;
  }
  CheckedMesh checked(mesh, criteria.criteria, threads);
  for (const AcceptanceCriterion& c : criteria.criteria) {
    const CriterionSums sums = checked.measure(c);
    CriterionResult result{c, CriterionCounter(c).verdict(sums), sums.count, sums.warned, sums.failed, sums.worst};
    if (sums.worst_tet >= 0) {
      result.worst_tet = to_index(sums.worst_tet);
      result.centroid = TetMeshView(mesh).centroid(sums.worst_tet);
    }
    report.verdict = std::max(report.verdict, result.verdict);
    report.results.push_back(result);
  }
  return report;
}

}  // namespace tetune
