// SPDX-License-Identifier: Apache-2.0
#include "driver/geometry/geometry_middles.hpp"

#include <array>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "math/vec3.hpp"
#include "mesh/matched_edges.hpp"

namespace tetune {

GeometryMiddles find_geometry_middles(const TetMesh& mesh, const Geometry& geometry) {
  constexpr double kFarthest = 0.25;
  std::vector<std::array<Index, 2>> edges;
  std::vector<Point3> midpoints;
  std::vector<GeometryEntity> entities;
  std::vector<double> lengths;
  GeometryMiddles middles;
  for (const MatchedEdge& edge : edges_of(geometry.match(mesh))) {
    if (edge.entity.dimension < 0) {
      ++middles.off_geometry;
      continue;
    }
    const Vec3 a = vec(span_of(mesh.points)[edge.vertices[0]]), b = vec(span_of(mesh.points)[edge.vertices[1]]);
    const Vec3 middle = 0.5 * (a + b);
    edges.push_back(edge.vertices);
    midpoints.push_back(to_point(middle));
    entities.push_back(edge.entity);
    lengths.push_back(norm(b - a));
  }
  std::vector<double> radii = lengths;
  for (double& radius : radii) radius *= kFarthest;
  const std::vector<Point3> closest_points = geometry.project(midpoints, entities, radii);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double distance = norm(vec(closest_points[i]) - vec(midpoints[i]));
    if (distance > kFarthest * lengths[i]) {
      ++middles.off_geometry;
    } else if (distance > kStraight * lengths[i]) {
      middles.edges.push_back({edges[i], closest_points[i]});
    }
  }
  return middles;
}

}  // namespace tetune
