// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/types.hpp"

namespace tetune {

using TrianglePoints = std::array<Vec3, 3>;

/// Nearest point of a set of triangles, by a tree of bounding boxes. Host only; queries may run concurrently.
class ClosestTriangle {
 public:
  explicit ClosestTriangle(std::vector<TrianglePoints> triangles);
  struct Hit {
    Vec3 point;        ///< on the nearest triangle
    double distance2;  ///< infinity when there is no triangle
  };
  /// `enough`: a hit at no more than this squared distance will do, though there be a nearer one.
  Hit closest(const Vec3& p, double enough = 0) const;
  double distance2(const Vec3& p) const { return closest(p).distance2; }

 private:
  struct Node {
    Vec3 low, high;
    int left = -1, right = -1;  ///< children, or -1 in a leaf
    std::size_t begin = 0, end = 0;
  };
  int build(std::size_t begin, std::size_t end);

  std::vector<TrianglePoints> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace tetune
