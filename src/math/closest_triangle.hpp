// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "backend/span.hpp"
#include "math/box.hpp"

namespace tetune {

using TrianglePoints = std::array<Vec3, 3>;

/// A triangle is degenerate, and its normal is made of rounding errors, where the squared sine of its angle at the
/// first corner is at most this.
inline constexpr double kDegenerateSine2 = 1e-28;

/// The squared distance of a point from a triangle.
double distance2(const Vec3& p, const TrianglePoints& t);

/// Finds the closest point of a set of triangles by a bounding volume hierarchy. Host only; queries may run
/// concurrently.
class ClosestTriangle {
 public:
  explicit ClosestTriangle(const std::vector<TrianglePoints>& triangles);
  struct Hit {
    Vec3 point;          ///< on the closest triangle
    double distance2;    ///< squared; infinity if there is no triangle, or where it overflows
    Size triangle = -1;  ///< its position in the list; -1 if there is no triangle
  };
  /// The search ends early at any point within the squared distance `sufficient`.
  Hit closest(const Vec3& p, double sufficient = 0) const;
  double distance2(const Vec3& p) const { return closest(p).distance2; }

 private:
  struct Node {
    Box box;
    Size left = -1, right = -1;  ///< children, or -1 in a leaf
    Size begin = 0, end = 0;     ///< range of triangles
  };
  struct Item;
  Size build(std::vector<Item>& items, Size begin, Size end);

  std::vector<TrianglePoints> triangles_;  ///< by leaf
  std::vector<Size> order_;                ///< their positions in the list
  std::vector<Node> nodes_;
};

}  // namespace tetune
