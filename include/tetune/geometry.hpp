// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

struct LoadedModel;
class PluginSession;

/// The vertex, edge or face of a CAD model that a vertex of a mesh is on.
struct GeometryEntity {
  /// 0 to 2; 3: the vertex is not on the surface; kNoEntity: it is on none, or it is not clear on which.
  std::int8_t dimension = 3;
  /// From 1, in the order of the model; 0 without an entity.
  std::int32_t number = 0;
  friend bool operator==(const GeometryEntity&, const GeometryEntity&) = default;
};
inline constexpr std::int8_t kNoEntity = -1;

/// How the surface of a mesh corresponds to a CAD model.
struct GeometryMatch {
  /// Per vertex of the mesh.
  std::vector<GeometryEntity> vertices;
  /// Per vertex: distance from its entity, or from the nearest face; 0 inside.
  std::vector<double> distances;
  /// The triangles of the surface: the listed ones in their order, but for those without a tag inside a region, then
  /// the other faces of the boundary and of interfaces between regions. The number of each one's face, 0 where it is
  /// not clear or there is none; and its position in the mesh's list, or -1.
  std::vector<std::array<Index, 3>> triangles;
  std::vector<std::int32_t> faces;
  std::vector<Index> listed;
  /// The edges of these triangles on edges of the model, and the number of each one's edge.
  std::vector<std::array<Index, 2>> edges;
  std::vector<std::int32_t> edge_numbers;
  /// Numbers of vertices per dimension of their entity, and of those of the surface without an entity.
  std::array<std::int64_t, 3> on_entities{};
  std::int64_t without_entity = 0;
  /// Number of triangles of which it is not clear which face they are on.
  std::int64_t ambiguous_triangles = 0;
  /// Number of the model's vertices at which the mesh has no vertex.
  std::int64_t unmatched_vertices = 0;
  /// Number of surfaces of an .msh file (entities of Gmsh's model), and of those whose triangles are not near the face
  /// of the same number, so that distances alone decide.
  std::int64_t file_surfaces = 0, file_surfaces_differing = 0;
};

/// A unit of length that geometry is converted to.
struct LengthUnit {
  const char* name;
  double mm;
};
inline constexpr LengthUnit kLengthUnits[] = {{"um", 1e-3}, {"mm", 1},      {"cm", 10},
                                              {"m", 1000},  {"inch", 25.4}, {"ft", 304.8}};

/// Distances of a set of points from the geometry.
struct DistanceSummary {
  std::int64_t points = 0;
  double largest = 0, mean = 0;
};

/// Distances of a mesh's surface from the faces and edges of a CAD model that it is on.
struct GeometryDeviation {
  DistanceSummary vertices, midpoints, centers;  ///< of vertices, edges and triangles
  /// Of one face of the model: of the vertices and edges of its triangles.
  struct Face {
    std::int32_t number = 0;
    DistanceSummary vertices, midpoints, centers;
  };
  /// Of faces with triangles, in increasing order.
  std::vector<Face> faces;
};

/// The exact surface of a part: a STEP (.step, .stp), IGES (.iges, .igs) or BREP (.brep, .brp) file, read by
/// OpenCASCADE in a process of its own, which lives as long as the copies of this object. Numbers of entities are those
/// of their order in the model. Seams of periodic faces and poles are no edges; a vertex of the model where only a seam
/// and one closed smooth edge end is none.
class TETUNE_API Geometry {
 public:
  /// `unit`: the length of the mesh's unit in mm; OpenCASCADE converts STEP and IGES to mm, and BREP is taken as such.
  /// `threads`: that the process may use, 0 for all cores; results are the same. Throws FileError, also where this
  /// installation lacks the plugin, and OptionError for a unit that is not positive or a negative number of threads.
  explicit Geometry(std::string file, double unit = 1, int threads = 0);

  const std::string& file() const { return file_; }
  /// Numbers of vertices, edges, faces and solids.
  std::array<std::int32_t, 4> counts() const;
  /// The bounding box, in the mesh's unit.
  Point3 low() const;
  Point3 high() const;
  /// In the mesh's unit.
  double diagonal() const;
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Finds the entity of each vertex of the surface of a mesh, by distances up to `tolerance` times the mean length of
  /// the surface's edges at the vertex, consistently with the triangles around it. Surfaces of an .msh file are taken
  /// for the faces of their numbers where all their triangles are near these. Throws MeshError if a vertex of the
  /// outer boundary is farther from the geometry than that, with the largest distance and its place, or if
  /// validate_arrays() finds a defect.
  GeometryMatch match(const TetMesh& mesh, double tolerance = kGeometryTolerance) const;

  /// The nearest points of the entities, which are of dimension 0 to 2; other points are returned as they are. `radii`:
  /// about the distances that are expected, for speed; empty if unknown.
  std::vector<Point3> project(const std::vector<Point3>& points, const std::vector<GeometryEntity>& entities,
                              const std::vector<double>& radii = {}) const;

  /// Measures triangles that have a face, and edges: midpoints of edges on edges of the model from these, others from
  /// the face of the triangles beside them; edges between faces that are on no edge of the model are left out.
  /// Distances of vertices are those of `match`, which is of these points. Throws FileError.
  GeometryDeviation measure(const std::vector<Point3>& points, const GeometryMatch& match) const;

  static constexpr double kGeometryTolerance = 0.25;

 private:
  std::string file_;
  double unit_;
  int threads_;
  std::shared_ptr<PluginSession> session_;
  std::shared_ptr<const LoadedModel> model_;
  std::vector<std::string> warnings_;
};

}  // namespace tetune
