// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/cpu.hpp"
#include "math/closest_triangle.hpp"

namespace tetune {

/// A point of a surface whose distance from another one is measured: a vertex, the midpoint of an edge or a centroid.
struct SurfaceSample {
  Vec3 point;
  double radius;  ///< where the search begins, a part of the size of the triangles there
  bool is_vertex;
};

/// Where the search around a point of the triangle starts.
double search_radius(const TrianglePoints& triangle);

struct LargestDistances {
  double vertices = 0;  ///< of the samples that are vertices
  double all = 0;
};

/// The largest distances of samples from a surface that is not empty. They do not depend on the number of threads.
LargestDistances max_distances(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                               const backend::Cpu& cpu);

}  // namespace tetune
