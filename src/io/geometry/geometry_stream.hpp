// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/mesh_stream.hpp"
#include "tetune/types.hpp"

/// The requests to the plugin of CAD geometry and its answers, encoded by mesh_stream.hpp.
/// Entities of one dimension are numbered from 1, in the order in which they occur in the model; 0 is none.
namespace tetune {

/// The answer to `load`. Lengths are in mm, as of OpenCASCADE.
struct LoadedModel {
  std::array<std::int32_t, 4> counts{};  ///< of vertices, edges, faces, solids
  Point3 low{}, high{};                  ///< bounding box
};

/// The input of `classify`: the points of a surface and its triangles, in mm.
struct ClassifyQuery {
  std::int32_t threads = 1;
  std::vector<Point3> points;
  std::vector<double> radii;  ///< per point: distance up to which an entity of the model is the point's own
  std::vector<std::array<Index, 3>> triangles;
  /// Per triangle: the number of the surface that the mesh's file has it on, which may be that of the model's face; 0:
  /// none. Empty without such numbers.
  std::vector<std::int32_t> surfaces;
};

struct ClassifyAnswer {
  /// Per point: the dimension of its entity (0 to 2) and its number; number 0: ambiguous or on none.
  std::vector<std::int8_t> dimensions;
  std::vector<std::int32_t> entities;
  std::vector<double> distances;             ///< per point: to its entity, or to the nearest face
  std::vector<std::int32_t> triangle_faces;  ///< per triangle; 0: ambiguous or on none
  std::vector<std::array<Index, 2>> edges;   ///< of triangles, that are on edges of the model
  std::vector<std::int32_t> edge_entities;
  std::int64_t ambiguous_triangles = 0;  ///< on several faces, or between faces that do not meet
  std::int32_t unmatched_vertices = 0;   ///< vertices of the model at which there is no point
  std::int32_t surfaces = 0;             ///< number of surfaces of the mesh's file
  std::int32_t surfaces_differing = 0;   ///< number of those that are not on the face of the same number
};

/// The input of `project`: points whose entities are known.
struct ProjectQuery {
  std::int32_t threads = 1;
  double precision = 0;  ///< points may be off along their surface by this part of their distance
  std::vector<Point3> points;
  std::vector<double> radii;  ///< per point: an upper bound that its distance should have
  std::vector<std::int8_t> dimensions;
  std::vector<std::int32_t> entities;
};

/// The nearest points of the entities.
struct ProjectAnswer {
  std::vector<Point3> points;
};

template <class Archive, MaybeConst<LoadedModel> Model>
void transfer(Archive& archive, Model& m) {
  for (auto& count : m.counts) archive(count);
  for (auto& x : m.low) archive(x);
  for (auto& x : m.high) archive(x);
}
template <class Archive, MaybeConst<ClassifyQuery> Query>
void transfer(Archive& archive, Query& q) {
  archive(q.threads, q.points, q.radii, q.triangles, q.surfaces);
}
template <class Archive, MaybeConst<ClassifyAnswer> Answer>
void transfer(Archive& archive, Answer& a) {
  archive(a.dimensions, a.entities, a.distances, a.triangle_faces, a.edges, a.edge_entities, a.ambiguous_triangles,
          a.unmatched_vertices, a.surfaces, a.surfaces_differing);
}
template <class Archive, MaybeConst<ProjectQuery> Query>
void transfer(Archive& archive, Query& q) {
  archive(q.threads, q.precision, q.points, q.radii, q.dimensions, q.entities);
}
template <class Archive, MaybeConst<ProjectAnswer> Answer>
void transfer(Archive& archive, Answer& a) {
  archive(a.points);
}

}  // namespace tetune
