// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/cpu.hpp"
#include "math/closest_triangle.hpp"

namespace tetune {

/// Points of a surface whose distance from another one is measured: vertices, midpoints of edges and centroids.
struct SurfaceSamples {
  /// The search around a point starts within its radius, a part of the size of the triangles there.
  struct Sample {
    Vec3 point;
    double radius;
    Index triangle;  ///< one that has the point; -1 for a vertex
  };
  const std::vector<TrianglePoints>& triangles;
  std::vector<Sample> samples;
};

/// Where the search around a point of the triangle starts.
double search_radius(const TrianglePoints& triangle);

struct LargestDistances {
  double vertices = 0;  ///< of the samples that are vertices
  double all = 0;
};

/// The largest distances of the samples from a surface that is not empty. Exactly 0 where the surface has the same
/// vertices and triangles. They do not depend on the number of threads.
LargestDistances max_distances(const SurfaceSamples& from, const std::vector<TrianglePoints>& surface,
                               const backend::Cpu& cpu);

}  // namespace tetune
