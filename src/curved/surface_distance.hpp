// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "curved/quadratic_sheet.hpp"

/// The distance between surfaces of quadratic triangles.
namespace tetune {

/// Straight triangles in place of quadratic ones: each is divided into n * n facets, with the smallest n up to a limit
/// for which facets and triangle are within `tolerance` of each other.
struct SurfaceFacets {
  /// Where a facet lies: the triangle, and two barycentric coordinates of each corner.
  struct FacetOrigin {
    Index triangle;
    std::array<std::array<double, 2>, 3> corners;
  };
  std::vector<TrianglePoints> facets;
  std::vector<FacetOrigin> origins;
  double error = 0;  ///< the largest distance between facets and triangles, by a bound
};
SurfaceFacets divide_into_facets(const std::vector<QuadraticSheet::Triangle>& triangles, double tolerance);

/// For each triangle an upper bound on the largest distance of its points from the surface `to`, sharp to half of the
/// limit, where it is at most the limit. A larger value only says that no such bound was found: the search ends at the
/// first part of the triangle that exceeds the limit. Once `stop`, which all threads call, is set and true, the values
/// of the triangles that are left are infinite.
///
/// A triangle is divided into parts. Where the points of `to` beside the corners of a part are on one quadratic
/// triangle, the difference of both surfaces is a quadratic polynomial, which they bound. Elsewhere the distance from
/// a facet of `to` that is beside a corner counts: it is convex, and so largest at a corner of the part.
std::vector<double> bound_distances(const std::vector<QuadraticSheet::Triangle>& from,
                                    const std::vector<QuadraticSheet::Triangle>& to, double limit, int threads,
                                    const std::function<bool()>& stop = {});

}  // namespace tetune
