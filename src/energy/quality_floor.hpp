// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/pack.hpp"
#include "energy/objective.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// The extreme cotangents of the dihedral angles of a tetrahedron: `max` is that of the smallest angle, `min` that of
/// the largest. T is double or a pack of doubles. The initial values are exceeded by those of every tetrahedron, whose
/// smallest angle is below 135 degrees and whose largest is above 45.
template <class T>
struct DihedralCotsT {
  T max = T{} - 1.0, min = T{} + 1.0;

  /// The measure that is minimized to open small angles and to close large ones: the largest cotangent, or the largest
  /// negative one times a weight. With weight 0 large angles do not count.
  TETUNE_HD TETUNE_INLINE T cost(double obtuse_weight) const {
    const T obtuse = -obtuse_weight * min;
    return obtuse > max ? obtuse : max;
  }
  TETUNE_HD void merge(const DihedralCotsT& other) {
    max = other.max > max ? other.max : max;
    min = other.min < min ? other.min : min;
  }
};
using DihedralCots = DihedralCotsT<double>;

/// The outward cross product of two edges of face f of a tetrahedron; its length is twice the area of the face.
template <class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> area_normal(const Vec3T<T> p[4], int f) {
  const Vec3T<T>& a = p[face_vertex(f, 0)];
  return cross(p[face_vertex(f, 1)] - a, p[face_vertex(f, 2)] - a);
}

/// Visits the dihedral angles of a tetrahedron: `visit(cot, i, j, k, l)` gets the cotangent at edge (k, l) between the
/// faces opposite i and j. With n_i, n_j the outward cross products of these faces and e the edge,
/// cos = -n_i . n_j / (|n_i| |n_j|) and sin = w |e| / (|n_i| |n_j|): nothing cancels in a flat tetrahedron.
template <class T, class Visit>
TETUNE_HD TETUNE_INLINE void for_each_dihedral_cot(const Vec3T<T> p[4], const Vec3T<T> n[4], const T& w,
                                                   const Visit& visit) {
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const int k = i == 0 ? (j == 1 ? 2 : 1) : 0;
      const int l = 6 - i - j - k;
      const Vec3T<T> edge = p[k] - p[l];
      visit(-dot(n[i], n[j]) / (w * square_root(dot(edge, edge))), i, j, k, l);
    }
  }
}

/// The sum of the squared edge lengths of a tetrahedron, cubed and divided by w^2, with w = 6 * volume: 432 times the
/// mean ratio to the power of -3, without roots.
template <class T>
TETUNE_HD TETUNE_INLINE T edge_term(const Vec3T<T> p[4], const T& w) {
  T sum{};
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const Vec3T<T> edge = p[j] - p[i];
      sum += dot(edge, edge);
    }
  }
  return sum * (sum / w) * (sum / w);
}

/// The worst quality in a mesh: no operation may create a tetrahedron that is worse.
struct QualityFloor {
  /// Relative tolerance for rounding.
  static constexpr double kTolerance = 1e-12;
  /// The cotangent of 165 degrees. Angles up to there are allowed in every mesh: where all are small, a limit at the
  /// largest would leave no room to enlarge the smallest.
  static constexpr double kAllowedCot = -3.7320508075688776;

  double worst_shape = 0;              ///< largest shape energy
  double max_cot = -1;                 ///< cotangent of the smallest dihedral angle
  double min_cot = -kInfeasible;       ///< cotangent of the largest dihedral angle
  double max_edge_term = kInfeasible;  ///< edge_term() of the smallest mean ratio
  /// No tetrahedron with a shape energy up to this has a smaller mean ratio: the shape energy to the power of 4/3 times
  /// the mean ratio is at least 1 (docs/method.md, "Quality floor").
  double safe_shape_of_mean_ratio = kInfeasible;
  /// No tetrahedron with a shape energy up to this has a smaller mean ratio or a smaller angle: the shape energy times
  /// the sine of any dihedral angle is at least (3 - its cosine) / sqrt(8).
  double safe_shape = 0;

  /// Lower bound on the shape energy of a tetrahedron with a dihedral angle of this cotangent.
  TETUNE_HD static double min_shape(double cot) {
    return (1 - kTolerance) * std::sqrt(0.125) * (3 * std::sqrt(1 + cot * cot) - cot);
  }
  /// Lower bound on the shape energy of a tetrahedron with this edge_term().
  TETUNE_HD static double min_shape_of_mean_ratio(double term) {
    return (1 - kTolerance) * std::sqrt(std::sqrt(term / kMinEdgeTerm));
  }
  /// The floor that allows every tetrahedron.
  TETUNE_HD static QualityFloor none() {
    return {kInfeasible, kInfeasible, -kInfeasible, kInfeasible, kInfeasible, kInfeasible};
  }
  /// Relaxes measured values by the tolerance. Called once, after the measurement.
  TETUNE_HD void add_tolerance() {
    worst_shape *= 1 + kTolerance;
    max_cot *= 1 + kTolerance;
    if (min_cot > -kInfeasible) min_cot *= 1 + kTolerance;
    max_edge_term *= 1 + kTolerance;
    update_safe_shape();
  }
  /// Allows a mean ratio of a part of the smallest one.
  TETUNE_HD void relax_mean_ratio(double part) {
    max_edge_term /= part * part * part;
    update_safe_shape();
  }
  /// Allows no angle of a larger cost (DihedralCots::cost()). Adds no tolerance: over several calls it would
  /// accumulate.
  TETUNE_HD void limit_cost(double cost, double obtuse_weight) {
    limit_angles({cost, obtuse_weight > 0 ? -cost / obtuse_weight : -kInfeasible});
  }
  /// Allows no angle beyond these.
  TETUNE_HD void limit_angles(const DihedralCots& extremes) {
    max_cot = extremes.max < max_cot ? extremes.max : max_cot;
    min_cot = extremes.min > min_cot ? extremes.min : min_cot;
    update_safe_shape();
  }
  TETUNE_HD DihedralCots extremes() const { return {max_cot, min_cot}; }

  /// Whether the tetrahedron p, of this shape energy and with w = 6 * volume, is no worse than the floor.
  TETUNE_HD bool allows(double shape, const Vec3 p[4], double w) const {
    return shape <= safe_shape || (allows_shape(shape, p, w) && allows(dihedral_cots(p, w)));
  }
  /// Whether the shape energy and the mean ratio of the tetrahedron p are no worse than the floor. A bool, or one per
  /// lane.
  template <class T>
  TETUNE_HD TETUNE_INLINE decltype(T{} > T{}) allows_shape(const T& shape, const Vec3T<T> p[4], const T& w) const {
    if (!backend::any(shape > safe_shape_of_mean_ratio)) return shape <= worst_shape;
    return (shape <= worst_shape) & ((shape <= safe_shape_of_mean_ratio) | (edge_term(p, w) <= max_edge_term));
  }
  /// A bool, or one per lane.
  template <class T>
  TETUNE_HD TETUNE_INLINE decltype(T{} > T{}) allows(const DihedralCotsT<T>& cots) const {
    return (cots.max <= max_cot) & (cots.min >= min_cot);
  }

  template <class T>
  TETUNE_HD static DihedralCotsT<T> dihedral_cots(const Vec3T<T> p[4], const T& w) {
    const Vec3T<T> n[4] = {area_normal(p, 0), area_normal(p, 1), area_normal(p, 2), area_normal(p, 3)};
    DihedralCotsT<T> cots;
    for_each_dihedral_cot(p, n, w, [&cots](const T& cot, int, int, int, int) {
      cots.max = cot > cots.max ? cot : cots.max;
      cots.min = cot < cots.min ? cot : cots.min;
    });
    return cots;
  }

 private:
  static constexpr double kMinEdgeTerm = 432;  ///< that of a regular tetrahedron

  TETUNE_HD void update_safe_shape() {
    safe_shape_of_mean_ratio = min_shape_of_mean_ratio(max_edge_term);
    safe_shape = min_shape(max_cot);
    if (safe_shape_of_mean_ratio < safe_shape) safe_shape = safe_shape_of_mean_ratio;
    if (min_cot > -kInfeasible && min_shape(min_cot) < safe_shape) safe_shape = min_shape(min_cot);
    if (worst_shape < safe_shape) safe_shape = worst_shape;
  }
};

}  // namespace tetune
