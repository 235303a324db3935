// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// A triangle of the surface of a mesh, and what it separates: triangles of one sheet have the same `sides`.
struct SheetTriangle {
  std::array<Index, 3> vertices;
  std::array<int, 3> sides;  ///< tag of the patch, and the regions beside it
};

/// The sheets of a surface: its parts between features.
struct SurfaceParts {
  std::vector<Index> triangle2sheet;
  Index sheets = 0;
  std::vector<std::array<Index, 2>> features;
};

SurfaceParts find_surface_parts(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles,
                                const std::vector<std::array<Index, 2>>& lines, double feature_angle);

class FinerSurface;

/// The curved edges of a surface that is known by the triangles of a straight mesh. Edges of the surface that are not
/// on two triangles of one sheet, where it turns by more than `feature_angle` degrees, or that are in `lines`, are
/// features. Middles are accurate to O(h^3) (docs/method.md, "Making curved tetrahedra"). Edges in flat parts and on
/// straight lines are not among the result, which is sorted by vertices. With a finer surface middles are points of it;
/// where these are farther than a quarter of the edge from its midpoint, as without.
std::vector<CurvedEdge> find_surface_middles(const std::vector<Point3>& points,
                                             const std::vector<SheetTriangle>& triangles,
                                             const std::vector<std::array<Index, 2>>& lines, double feature_angle,
                                             const FinerSurface* finer = nullptr);

}  // namespace tetune
