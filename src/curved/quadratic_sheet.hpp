// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "math/closest_triangle.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Barycentric coordinates of a point of a triangle. A degenerate one counts as the segment between its first two
/// corners.
std::array<double, 3> barycentric(const TrianglePoints& t, const Vec3& p);

/// A part of a surface of quadratic triangles over its straight triangles, or a set of quadratic lines, which are
/// triangles whose last two corners are equal. Queries may run concurrently.
class QuadraticSheet {
 public:
  /// A quadratic triangle: its corners, and the offsets of the mid-side nodes from the midpoints of the sides 01, 12
  /// and 20.
  struct Triangle {
    TrianglePoints corners;
    std::array<Vec3, 3> offsets;
  };
  explicit QuadraticSheet(std::vector<Triangle> triangles);

  /// The point of the quadratic triangle with the barycentric coordinates of the closest point of the straight
  /// triangles: continuous over the sheet. Returns p where squared distances overflow.
  Vec3 lift(const Vec3& p) const;
  /// The squared distance from the straight triangles.
  double distance2(const Vec3& p) const { return search_.distance2(p); }
  double distance2_of_box(const Vec3& p) const { return box_.distance2(p); }

 private:
  std::vector<Triangle> triangles_;
  ClosestTriangle search_;
  Box box_;
};

/// The triangle with coordinates multiplied by `scale`.
inline QuadraticSheet::Triangle scaled(QuadraticSheet::Triangle triangle, double scale) {
  for (std::size_t k = 0; k < 3; ++k) {
    triangle.corners[k] = scale * triangle.corners[k];
    triangle.offsets[k] = scale * triangle.offsets[k];
  }
  return triangle;
}

/// The area of a quadratic triangle by a rule of seven points of degree 5; exact for a flat one that is not folded.
double area_of(const QuadraticSheet::Triangle& triangle);

/// Makes triangles and segments of a quadratic surface.
class QuadraticTriangles {
 public:
  /// `edges`: the curved ones, sorted by vertices. Refers to both.
  QuadraticTriangles(const std::vector<Point3>& points, const std::vector<CurvedEdge>& edges)
      : points_(points), edges_(edges) {}
  QuadraticSheet::Triangle of(const std::array<Index, 3>& triangle) const;
  QuadraticSheet::Triangle of(const std::array<Index, 2>& edge) const;

 private:
  Vec3 at(Index v) const;
  Vec3 offset(Index a, Index b) const;

  const std::vector<Point3>& points_;
  const std::vector<CurvedEdge>& edges_;
};

}  // namespace tetune
