// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "curved/quadratic_sheet.hpp"
#include "curved/surface_middles.hpp"
#include "math/vec3.hpp"

namespace tetune {

/// The quadratic triangles of a finer mesh of a surface, by its sheets, and its feature lines. Queries may run
/// concurrently.
class FinerSurface {
 public:
  /// `middles`: the curved edges of the triangles, sorted by vertices.
  FinerSurface(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles,
               const SurfaceParts& parts, const std::vector<CurvedEdge>& middles);

  /// The point of the surface near `guess`, a position for the mid-side node of the edge pq: in the sheet that is
  /// nearest to these three points.
  Vec3 point_near(const Vec3& p, const Vec3& q, const Vec3& guess) const;
  /// The point of a feature line near `guess`, if both ends of the edge are near feature lines.
  std::optional<Vec3> point_on_lines(const Vec3& p, const Vec3& q, const Vec3& guess) const;
  /// The distance of a point from the straight triangles.
  double distance(const Vec3& p) const;

 private:
  std::vector<QuadraticSheet> sheets_;
  std::optional<QuadraticSheet> lines_;
};

/// Throws MeshError if a vertex of the triangles is farther from the finer surface than a tenth of its shortest edge.
void check_is_near(const FinerSurface& finer, const std::vector<Point3>& points,
                   const std::vector<SheetTriangle>& triangles);

}  // namespace tetune
