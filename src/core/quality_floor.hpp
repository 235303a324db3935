// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/types.hpp"

namespace tetune {

/// The worst of a mesh: no move and no flip may leave anything worse behind.
struct QualityFloor {
  /// The part by which rounding may make the worst worse.
  static constexpr double kRounding = 1e-12;

  double worst_shape = 0;  ///< largest shape energy
  double most_cot = -1;    ///< cotangent of the smallest dihedral angle
  /// Tetrahedra below this shape energy have no smaller angle: shape energy times the sine of any dihedral angle is at
  /// least (3 - its cosine) / sqrt(8) (docs/method.md, "Never worse").
  double safe_shape = 0;

  /// The least shape energy of a tetrahedron with an angle of this cotangent.
  TETUNE_HD static double least_shape(double cot) {
    return (1 - kRounding) * std::sqrt(0.125) * (3 * std::sqrt(1 + cot * cot) - cot);
  }
  /// No floor.
  TETUNE_HD static QualityFloor none() { return {1e300, 1e300, 1e300}; }
  /// Once, when the worst are found.
  TETUNE_HD void settle() {
    worst_shape *= 1 + kRounding;
    most_cot *= 1 + kRounding;
    find_safe_shape();
  }
  /// No larger cotangent either: not settle() again, as what it allows for rounding would add up.
  TETUNE_HD void limit_cot(double cot) {
    most_cot = cot < most_cot ? cot : most_cot;
    find_safe_shape();
  }

  /// Whether a tetrahedron of this shape energy, with w = 6 * volume, is no worse.
  TETUNE_HD bool allows(double shape, const Vec3 p[4], double w) const {
    return shape <= safe_shape || (shape <= worst_shape && largest_cot(p, w) <= most_cot);
  }

  /// Cotangent of the smallest dihedral angle. With n_i, n_j the cross products of two faces, pointing outwards, and e
  /// their edge, cos = -n_i . n_j / (|n_i| |n_j|) and sin = w |e| / (|n_i| |n_j|): nothing cancels where it is flat.
  TETUNE_HD static double largest_cot(const Vec3 p[4], double w) {
    Vec3 n[4];
    for (int f = 0; f < 4; ++f) {
      const Vec3& a = p[face_vertex(f, 0)];
      n[f] = cross(p[face_vertex(f, 1)] - a, p[face_vertex(f, 2)] - a);
    }
    double most = -1;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        // The faces opposite i and j share the edge of the other two.
        const int k = i == 0 ? (j == 1 ? 2 : 1) : 0;
        const int l = 6 - i - j - k;
        const double cot = -dot(n[i], n[j]) / (w * norm(p[k] - p[l]));
        most = cot > most ? cot : most;
      }
    }
    return most;
  }

 private:
  TETUNE_HD void find_safe_shape() {
    safe_shape = least_shape(most_cot);
    if (worst_shape < safe_shape) safe_shape = worst_shape;
  }
};

}  // namespace tetune
