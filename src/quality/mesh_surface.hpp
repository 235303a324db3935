// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "backend/cpu.hpp"
#include "quality/sampled_distance.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The surface of a mesh: the boundary, and the interfaces between regions. Curved triangles are divided into facets.
struct MeshSurface {
  struct Vertex {
    Index id;
    Vec3 point;
    Size triangle;  ///< one of those at it
  };
  /// Oriented outward from the region of the lower tag, so that each edge is listed in both directions.
  std::vector<TrianglePoints> triangles;
  /// The ids of the vertices of each; empty where edges are curved.
  std::vector<std::array<Index, 3>> ids;
  std::vector<Vertex> vertices;
  Size mesh_vertices = 0;
  double area = 0;       ///< of the boundary
  double mean_edge = 0;  ///< of the boundary

  /// About the number of the vertices, triangles and edges of a closed surface.
  std::int64_t sample_count() const { return std::ssize(vertices) + std::ssize(triangles) * 5 / 2; }
};

/// The surface with coordinates multiplied by `scale`. `threads` 0 means all.
MeshSurface find_surface(const TetMesh& mesh, double scale, int threads);

/// Area of a triangle.
double area_of(const TrianglePoints& triangle);

/// The largest distances of one in `stride` of the vertices, of the midpoints of edges, and of the centroids of
/// triangles of a surface from another one that is not empty. A vertex or a triangle that both surfaces have, in all
/// bits, is at no distance. Takes the least time where both meshes have the same number of vertices, and each vertex is
/// near that of the same id.
LargestDistances max_distances(const MeshSurface& from, const MeshSurface& to, std::int64_t stride,
                               const backend::Cpu& cpu);

}  // namespace tetune
