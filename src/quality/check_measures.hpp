// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/angle.hpp"
#include "quality/tet_measures.hpp"
#include "tetune/criteria.hpp"

/// The measures of acceptance criteria. Formulas and sources: docs/quality.md, "Acceptance".
namespace tetune {

inline Vec3 centroid_of(const Vec3 (&p)[4]) { return centroid(p[0], p[1], p[2], p[3]); }

inline Vec3 face_centroid(const Vec3 (&p)[4], int face) {
  return (1.0 / 3) * (p[face_vertex(face, 0)] + p[face_vertex(face, 1)] + p[face_vertex(face, 2)]);
}

/// The angle between two vectors, in degrees; with the same bits on every platform, as limits are compared with it.
inline double angle_between(const Vec3& a, const Vec3& b) {
  return kDegreesPerRadian * upper_atan2(norm(cross(a, b)), dot(a, b));
}

struct Range {
  double min = 0, max = 0;
};

/// The dihedral angle of the regular tetrahedron, in degrees.
inline constexpr double kRegularDihedral = 70.528779365509308;

/// The largest deviation of angles from that of a regular shape, relative: 0 for this shape, 1 for an angle of 0 or 180
/// degrees.
inline double angle_skew(const Range& angles, double regular) {
  return std::max((angles.max - regular) / (180 - regular), (regular - angles.min) / regular);
}

/// The angles of the faces at their corners, in degrees.
inline Range face_angles(const TetShape& s) {
  Range range{180, 0};
  for (int f = 0; f < 4; ++f) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& x = s.p[face_vertex(f, k)];
      const double angle = angle_between(s.p[face_vertex(f, (k + 1) % 3)] - x, s.p[face_vertex(f, (k + 2) % 3)] - x);
      range = {std::min(range.min, angle), std::max(range.max, angle)};
    }
  }
  return range;
}

inline Range edge_lengths(const TetShape& s) {
  Range range{norm(s.p[1] - s.p[0]), 0};
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const double length = norm(s.p[j] - s.p[i]);
      range = {std::min(range.min, length), std::max(range.max, length)};
    }
  }
  return range;
}

inline double max_face_area(const TetShape& s) {
  double area = 0;
  for (const Vec3& n : s.n) area = std::max(area, norm(n));
  return area;
}

/// The volume relative to that of the regular tetrahedron of the same circumscribed sphere.
inline double relative_volume(const TetShape& s) {
  const Vec3 a = s.p[1] - s.p[0];
  const Vec3 b = s.p[2] - s.p[0];
  const Vec3 c = s.p[3] - s.p[0];
  const double radius =
      norm(dot(c, c) * cross(a, b) + dot(b, b) * cross(c, a) + dot(a, a) * cross(b, c)) / (12 * s.volume);
  return s.volume > 0 ? 27 * s.volume / (8 * std::numbers::sqrt3 * radius * radius * radius) : 0;
}

/// The aspect ratio of a triangle: the largest one of the rectangles about its medians and about the lines between the
/// midpoints of two edges, relative to that of the equilateral triangle.
inline double triangle_aspect_ratio(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 corners[3] = {a, b, c};
  const auto stretch = [](double x, double y) { return x > y ? x / y : y / x; };
  const double area = 0.5 * norm(cross(b - a, c - a));
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 base = corners[(k + 2) % 3] - corners[(k + 1) % 3];
    const double median = norm(corners[k] - corners[(k + 1) % 3] - 0.5 * base);
    const double middle_line = 0.5 * norm(base);
    // The sides of the rectangle along and across the line: about the median, and about the line between midpoints.
    largest = std::max({largest, stretch(median, area / median), stretch(middle_line, area / middle_line)});
  }
  return largest / std::numbers::sqrt3;
}

inline double max_triangle_aspect(const TetShape& s) {
  double largest = 0;
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    const int k = (i + 2) % 4;
    largest = std::max(largest, triangle_aspect_ratio(s.p[i], s.p[j], s.p[k]));
    for (int other = i + 1; other < 4; ++other) {
      const int u = i == 0 ? (other == 1 ? 2 : 1) : 0;
      const int v = 6 - i - other - u;
      largest = std::max(largest, triangle_aspect_ratio(s.p[i], s.p[other], 0.5 * (s.p[u] + s.p[v])));
    }
  }
  return largest;
}

/// A measure that depends on one tetrahedron alone; lengths are in the unit of the shape.
inline double shape_measure(const TetShape& s, CheckMeasure measure) {
  const Range angles = measure == CheckMeasure::min_face_angle || measure == CheckMeasure::max_face_angle ||
                               measure == CheckMeasure::equiangle_skew
                           ? face_angles(s)
                           : Range{};
  const double max_area = max_face_area(s);
  switch (measure) {
    case CheckMeasure::volume:
      return s.volume;
    case CheckMeasure::jacobian_ratio:
      return 1;
    case CheckMeasure::min_face_angle:
      return angles.min;
    case CheckMeasure::max_face_angle:
      return angles.max;
    case CheckMeasure::equiangle_skew:
      return std::max(angle_skew(angles, 60), angle_skew({min_angle(s), max_angle(s)}, kRegularDihedral));
    case CheckMeasure::volume_skew:
      return 1 - relative_volume(s);
    case CheckMeasure::collapse: {
      constexpr double kRegular = 2 * std::numbers::sqrt2 / 2.2795070569547775;  // the divisor: 3^(3/4)
      return 3 * s.volume / (max_area * std::sqrt(max_area)) / kRegular;
    }
    case CheckMeasure::edge_ratio: {
      const Range edges = edge_lengths(s);
      return edges.max / edges.min;
    }
    case CheckMeasure::edge_altitude_ratio:
      return s.volume > 0 ? edge_lengths(s).max * max_area / (3 * s.volume) : kFlatRatio;
    case CheckMeasure::triangle_aspect:
      return max_triangle_aspect(s);
    case CheckMeasure::shortest_edge:
      return edge_lengths(s).min;
    case CheckMeasure::min_altitude:
      return 3 * s.volume / max_area;
    default:
      return value(all_measures(s), Measure(measure));
  }
}

/// The cosine of the angle between two vectors.
inline double cosine(const Vec3& a, const Vec3& b) { return dot(a, b) / (norm(a) * norm(b)); }

/// The skewness of a face as OpenFOAM's checkMesh measures it. `normal` points from the cell `own` outward; `neighbor`
/// is the centroid of the cell across, or null on the boundary, where the line is the normal through the face.
inline double face_skewness(const Vec3 (&corners)[3], const Vec3& normal, const Vec3& own, const Vec3* neighbor) {
  const Vec3 center = (1.0 / 3) * (corners[0] + corners[1] + corners[2]);
  const Vec3 to_face = center - own;
  const Vec3 line = neighbor != nullptr ? *neighbor - own : dot(normal, to_face) / dot(normal, normal) * normal;
  const Vec3 skew = to_face - dot(normal, to_face) / dot(normal, line) * line;
  const double length = norm(skew);
  double size = (neighbor != nullptr ? 0.2 : 0.4) * norm(line);
  if (length > 0) {
    for (const Vec3& x : corners) size = std::max(size, std::fabs(dot(skew, x - center)) / length);
  }
  const double ratio = length / size;
  return std::isfinite(ratio) ? ratio : kFlatRatio;
}

}  // namespace tetune
