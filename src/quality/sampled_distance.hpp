// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "backend/cpu.hpp"
#include "math/closest_triangle.hpp"
#include "mesh/csr.hpp"

namespace tetune {

/// A point of a surface whose distance from another one is measured: a vertex, the midpoint of an edge or a centroid.
struct SurfaceSample {
  Vec3 point;
  double radius;  ///< of the first search, a fraction of the size of the triangles there
  bool is_vertex;
  Index start = -1;  ///< a vertex of the other surface that is probably near; -1: none is known
};

/// The radius of the first search around a point of a triangle.
double search_radius(const TrianglePoints& triangle);

struct LargestDistances {
  double vertices = 0;  ///< of the samples that are vertices
  double all = 0;
};

/// Finds triangles of a surface near a point by descent from one vertex to the next. Queries may run concurrently.
class SurfaceDescent {
 public:
  /// `ids`: of the vertices of each triangle, in [0, vertices). Refers to the triangles.
  SurfaceDescent(const std::vector<TrianglePoints>& triangles, const std::vector<std::array<Index, 3>>& ids,
                 Size vertices, const backend::Cpu& cpu);

  /// An upper bound on the squared distance of a point from the surface, as a rule the distance itself: that from the
  /// triangles at the start, at the vertex of the closest of these that is closest, and so on while it falls. Infinity
  /// where the start has no triangle. Ends early at any point within the squared distance `sufficient`.
  double distance2(const Vec3& p, Index start, double sufficient) const;

 private:
  const std::vector<TrianglePoints>& triangles_;
  const std::vector<std::array<Index, 3>>& ids_;
  Csr<backend::Cpu> vertex2corner_;
};

/// The largest distances of samples from a surface that is not empty. They do not depend on the number of threads, nor
/// on `descent`, which finds bounds for the samples that have a start, so that few of them need a search.
LargestDistances max_distances(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                               const backend::Cpu& cpu, const SurfaceDescent* descent = nullptr);

}  // namespace tetune
