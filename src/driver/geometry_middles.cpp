// SPDX-License-Identifier: Apache-2.0
#include "driver/geometry_middles.hpp"

#include <map>

#include "backend/span.hpp"
#include "math/vec3.hpp"
#include "mesh/tet.hpp"

namespace tetune {
namespace {

using Edge = std::array<Index, 2>;

/// What each edge of the surface is on; no entity where that is not clear.
std::map<Edge, GeometryEntity> entities_of_edges(const GeometryMatch& match) {
  std::map<Edge, GeometryEntity> entities;
  for (std::size_t t = 0; t < match.triangles.size(); ++t) {
    const auto& triangle = match.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const GeometryEntity face{match.faces[t] > 0 ? std::int8_t{2} : kNoEntity, match.faces[t]};
      const auto [at, is_new] = entities.try_emplace(ascending(triangle[k], triangle[(k + 1) % 3]), face);
      if (!is_new && at->second != face) at->second = {kNoEntity, 0};
    }
  }
  for (std::size_t i = 0; i < match.edges.size(); ++i) {
    entities[ascending(match.edges[i])] = {1, match.edge_numbers[i]};
  }
  return entities;
}

}  // namespace

GeometryMiddles find_geometry_middles(const TetMesh& mesh, const Geometry& geometry) {
  // An edge that is nearer to the model than this part of its length is straight.
  constexpr double kStraight = 1e-12;
  constexpr double kFarthest = 0.25;
  std::vector<Edge> edges;
  std::vector<Point3> midpoints;
  std::vector<GeometryEntity> entities;
  std::vector<double> lengths;
  GeometryMiddles middles;
  for (const auto& [edge, entity] : entities_of_edges(geometry.match(mesh))) {
    if (entity.dimension < 0) {
      ++middles.off_geometry;
      continue;
    }
    const Vec3 a = vec(span_of(mesh.points)[edge[0]]), b = vec(span_of(mesh.points)[edge[1]]);
    const Vec3 middle = 0.5 * (a + b);
    edges.push_back(edge);
    midpoints.push_back({middle.x, middle.y, middle.z});
    entities.push_back(entity);
    lengths.push_back(norm(b - a));
  }
  std::vector<double> radii = lengths;
  for (double& radius : radii) radius *= kFarthest;
  const std::vector<Point3> feet = geometry.project(midpoints, entities, radii);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double distance = norm(vec(feet[i]) - vec(midpoints[i]));
    if (distance > kFarthest * lengths[i]) {
      ++middles.off_geometry;
    } else if (distance > kStraight * lengths[i]) {
      middles.edges.push_back({edges[i], feet[i]});
    }
  }
  return middles;
}

}  // namespace tetune
