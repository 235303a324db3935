// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "backend/pack.hpp"
#include "energy/objective.hpp"
#include "math/angle.hpp"
#include "math/elementary.hpp"
#include "mesh/tet.hpp"
#include "tetune/quality.hpp"

/// The measures of one tetrahedron. Formulas and sources: docs/quality.md.
namespace tetune {

/// The quantities that all measures are computed from, for one tetrahedron or for one per SIMD lane.
template <class Real>
struct TetShapeT {
  Vec3T<Real> p[4];
  Vec3T<Real> n[4];  ///< area vectors of the faces
  Real volume{};     ///< signed
  Real area2{};      ///< sum of squared face areas
  Real length2{};    ///< sum of squared edge lengths
  Real angles[6];    ///< dihedral, in degrees

  TetShapeT() = default;
  TETUNE_INLINE explicit TetShapeT(const Vec3T<Real> (&points)[4]) : p{points[0], points[1], points[2], points[3]} {
    for (int f = 0; f < 4; ++f) {
      const Vec3T<Real>& a = p[face_vertex(f, 0)];
      n[f] = 0.5 * cross(p[face_vertex(f, 1)] - a, p[face_vertex(f, 2)] - a);
      area2 += dot(n[f], n[f]);
    }
    volume = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) / 6;
    Real sines[6];
    Real cosines[6];
    int edge = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const Vec3T<Real> both = cross(n[i], n[j]);
        sines[edge] = dot(both, both);
        cosines[edge++] = -dot(n[i], n[j]);
        const Vec3T<Real> e = p[j] - p[i];
        length2 += dot(e, e);
      }
    }
    for (int k = 0; k < 6; ++k) angles[k] = kDegreesPerRadian * upper_atan2(square_root(sines[k]), cosines[k]);
  }

  Real eta() const { return area2 / (volume < 0 ? -volume : volume); }
  /// relative_eta() to the power of 3 / 2.
  Real shape_energy() const { return area2 * square_root(area2) / (27 * std::numbers::sqrt3 * volume * volume); }
};
using TetShape = TetShapeT<double>;

/// Extracts the tetrahedron of one lane.
template <class Pack>
TetShape lane(const TetShapeT<Pack>& shapes, int l) {
  TetShape s;
  const auto of = [l](const Vec3T<Pack>& v) { return Vec3{lane(v.x, l), lane(v.y, l), lane(v.z, l)}; };
  for (int k = 0; k < 4; ++k) {
    s.p[k] = of(shapes.p[k]);
    s.n[k] = of(shapes.n[k]);
  }
  s.volume = lane(shapes.volume, l);
  s.area2 = lane(shapes.area2, l);
  s.length2 = lane(shapes.length2, l);
  for (int k = 0; k < 6; ++k) s.angles[k] = lane(shapes.angles[k], l);
  return s;
}

inline double min_angle(const TetShape& s) { return *std::min_element(s.angles, s.angles + 6); }
inline double max_angle(const TetShape& s) { return *std::max_element(s.angles, s.angles + 6); }
/// eta divided by that of the regular tetrahedron of the same volume V, which has edges a = (6 sqrt(2) V)^(1/3) and
/// eta = 9 a / sqrt(2).
inline double relative_eta(const TetShape& s) {
  return s.eta() / (4.5 * std::numbers::sqrt2 * elementary::cbrt(6 * std::numbers::sqrt2 * std::fabs(s.volume)));
}
template <class Real>
TETUNE_INLINE Real mean_ratio(Real volume, Real length2) {
  return volume > 0 ? 12 * elementary::cbrt(9 * volume * volume) / length2 : Real{};
}

inline double value(const Measures& measures, Measure measure) { return measures[static_cast<std::size_t>(measure)]; }

inline Measures all_measures(const TetShape& s) {
  const bool positive = s.volume > 0;
  double area = 0;
  for (const Vec3& n : s.n) area += norm(n);
  double longest2 = 0;
  double max_product2 = 0;  // of the squared lengths of the three edges at a vertex
  for (int i = 0; i < 4; ++i) {
    double product = 1;
    for (int j = 0; j < 4; ++j) {
      if (j == i) continue;
      const Vec3 e = s.p[j] - s.p[i];
      const double length2 = dot(e, e);
      longest2 = std::max(longest2, length2);
      product *= length2;
    }
    max_product2 = std::max(max_product2, product);
  }
  const Vec3 a = s.p[1] - s.p[0];
  const Vec3 b = s.p[2] - s.p[0];
  const Vec3 c = s.p[3] - s.p[0];
  // 12 V times the distance from vertex 0 to the circumcenter.
  const double to_center = norm(dot(c, c) * cross(a, b) + dot(b, b) * cross(c, a) + dot(a, a) * cross(b, c));
  double gamma = 108 * s.volume * s.volume / (area * to_center);  // 3 r / R
  if (!std::isfinite(gamma)) gamma = 0;

  // A flat tetrahedron, or one so small that products of its lengths underflow, gets the worst value.
  Measures m{};
  constexpr bool kAlways = true;
  const auto set = [&m](Measure which, bool defined, double value, double worst) {
    m[static_cast<std::size_t>(which)] = defined && std::isfinite(value) ? value : worst;
  };
  set(Measure::min_dihedral, kAlways, min_angle(s), 0);
  set(Measure::max_dihedral, kAlways, max_angle(s), 180);
  set(Measure::mean_ratio, positive, mean_ratio(s.volume, s.length2), 0);
  set(Measure::sicn, kAlways, 18 * s.volume / std::sqrt(s.length2 * s.area2), 0);
  set(Measure::gamma, positive, gamma, 0);
  set(Measure::scaled_jacobian, kAlways, std::numbers::sqrt2 * 6 * s.volume / std::sqrt(max_product2), 0);
  set(Measure::radius_ratio, positive, std::min(1 / gamma, kFlatRatio), kFlatRatio);
  set(Measure::aspect_ratio, positive, std::min(std::sqrt(6 * longest2) / 36 * area / s.volume, kFlatRatio),
      kFlatRatio);
  set(Measure::harmonic, positive, 1 / relative_eta(s), 0);
  return m;
}

}  // namespace tetune
