// SPDX-License-Identifier: Apache-2.0
#include "tetune/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backend/span.hpp"
#include "io/geometry/geometry_requests.hpp"
#include "io/geometry/geometry_stream.hpp"
#include "io/msh/msh_format.hpp"
#include "math/constants.hpp"
#include "math/vec3.hpp"
#include "mesh/messages.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/validate_arrays.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

template <class Query, class Answer>
Answer ask(PluginSession& session, const char* verb, const Query& query) {
  Answer answer;
  session.call(
      verb, {}, [&](PluginWriter& out) { out(query); }, [&](MeshReader& in) { in(answer); });
  return answer;
}

Point3 scaled(const Point3& p, double factor) { return {factor * p[0], factor * p[1], factor * p[2]}; }

/// The surface of a mesh with its own numbers of points.
struct MeshSurface {
  std::vector<Index> surface2mesh;
  std::vector<std::array<Index, 3>> triangles;  ///< of mesh vertices
  std::vector<Index> listed;                    ///< per triangle: its position in the mesh's list, or -1
  std::vector<std::uint8_t> is_outer;           ///< per mesh vertex: on the outer boundary
  std::vector<double> lengths;                  ///< per mesh vertex: mean length of the edges of triangles
};

using Triangle = std::array<Index, 3>;

/// Adds the listed triangles, but for those that constrain nothing, and the other faces of boundary and interfaces.
void add_triangles(const TetMesh& mesh, int threads, MeshSurface& s) {
  std::vector<Triangle> faces;
  for_each_surface_face(mesh, threads, [&](const SortedHalfFace& face, bool is_outer) {
    for (const Index v : face.vertices) span_of(s.is_outer)[v] |= is_outer ? 1 : 0;
    faces.push_back(face.vertices);
  });
  std::vector<Triangle> listed;
  std::vector<std::uint8_t> is_required(mesh.triangles.size(), 0);
  for (const Index t : mesh.required_triangles) span_of(is_required)[t] = 1;
  for (Size t = 0; t < std::ssize(mesh.triangles); ++t) {
    const Triangle triangle = ascending(span_of(mesh.triangles)[t]);
    listed.push_back(triangle);
    const bool is_loose = span_of(mesh.triangle_tags)[t] == 0 && span_of(is_required)[t] == 0 &&
                          !std::binary_search(faces.begin(), faces.end(), triangle);
    if (is_loose) continue;
    s.triangles.push_back(span_of(mesh.triangles)[t]);
    s.listed.push_back(to_index(t));
  }
  std::sort(listed.begin(), listed.end());
  for (const Triangle& face : faces) {
    if (!std::binary_search(listed.begin(), listed.end(), face)) s.triangles.push_back(face);
  }
  s.listed.resize(s.triangles.size(), -1);
}

MeshSurface surface_of(const TetMesh& mesh, int threads) {
  MeshSurface s;
  s.is_outer.assign(mesh.points.size(), 0);
  add_triangles(mesh, threads, s);
  s.lengths.assign(mesh.points.size(), 0);
  std::vector<int> counts(mesh.points.size(), 0);
  for (const Triangle& t : s.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      for (const Index v : {a, b}) {
        span_of(s.lengths)[v] += distance(span_of(mesh.points)[a], span_of(mesh.points)[b]);
        ++span_of(counts)[v];
      }
    }
  }
  for (Size v = 0; v < std::ssize(counts); ++v) {
    if (span_of(counts)[v] == 0) continue;
    span_of(s.lengths)[v] /= span_of(counts)[v];
    s.surface2mesh.push_back(to_index(v));
  }
  return s;
}

double diagonal_of(const std::vector<Point3>& points, const std::vector<Index>& vertices) {
  Point3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (const Index v : vertices) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], span_of(points)[v][k]);
      high[k] = std::max(high[k], span_of(points)[v][k]);
    }
  }
  return distance(low, high);
}

/// A hint at the unit, where it explains the sizes of the mesh and of the geometry.
std::string unit_hint(double ratio, double unit) {
  constexpr double kTolerance = 0.05;
  for (const LengthUnit& u : kLengthUnits) {
    if (std::fabs(ratio / u.mm - 1) < kTolerance && std::fabs(unit / u.mm - 1) > kTolerance) {
      return "; geometry_unit=" + short_text(u.mm) + " (" + u.name + ") would make the sizes equal";
    }
  }
  return "";
}

[[noreturn]] void fail_to_match(const Geometry& geometry, const TetMesh& mesh, const MeshSurface& surface, double unit,
                                const std::vector<double>& distances, std::size_t farther) {
  Index worst = -1;
  for (const Index v : surface.surface2mesh) {
    if (span_of(surface.is_outer)[v] == 0) continue;
    if (worst < 0 || span_of(distances)[v] > span_of(distances)[worst]) worst = v;
  }
  const Point3& p = span_of(mesh.points)[worst];
  const double size = diagonal_of(mesh.points, surface.surface2mesh);
  const double farthest = span_of(distances)[worst];
  // The search is limited.
  const std::string distance =
      std::isinf(farthest) ? "such as that " : "the farthest by " + short_text(farthest) + ", ";
  throw MeshError("the mesh and the geometry of " + geometry.file() + " do not belong together: " +
                  std::to_string(farther) + " vertices of the boundary are too far from it, " + distance +
                  place_text(p) + "; the diagonal of the mesh is " + short_text(size) + ", that of the geometry " +
                  short_text(geometry.diagonal()) + unit_hint(unit * geometry.diagonal() / size, unit));
}

/// Per triangle of a surface the number of the surface of an .msh file; empty where the mesh is of another origin.
std::vector<std::int32_t> file_surfaces_of(const TetMesh& mesh, const MeshSurface& surface) {
  const std::vector<int>* numbers = mesh.cell_tags_name == kMshEntityTags ? &mesh.triangle_tags : nullptr;
  for (const DataArray& array : mesh.triangle_data) {
    if (array.name == kMshEntities && array.components == 1) numbers = std::get_if<std::vector<int>>(&array.values);
  }
  std::vector<std::int32_t> surfaces;
  if (numbers == nullptr) return surfaces;
  for (const Index listed : surface.listed) surfaces.push_back(listed < 0 ? 0 : span_of(*numbers)[listed]);
  return surfaces;
}

/// Sorts what the plugin found by the vertices of the mesh, and counts it.
GeometryMatch match_of(const MeshSurface& surface, const TetMesh& mesh, ClassifyAnswer answer, double unit) {
  GeometryMatch match;
  match.vertices.resize(mesh.points.size());
  match.distances.assign(mesh.points.size(), 0);
  for (Size i = 0; i < std::ssize(surface.surface2mesh); ++i) {
    const Index v = surface.surface2mesh[std::size_t(i)];
    const std::int32_t entity = span_of(answer.entities)[i];
    const std::int8_t dimension = entity == 0 ? kNoEntity : span_of(answer.dimensions)[i];
    span_of(match.vertices)[v] = {dimension, entity};
    span_of(match.distances)[v] = span_of(answer.distances)[i] / unit;
    ++(dimension < 0 ? match.without_entity : match.on_entities[std::size_t(dimension)]);
  }
  match.triangles = surface.triangles;
  match.listed = surface.listed;
  match.faces = std::move(answer.triangle_faces);
  match.edges = std::move(answer.edges);
  for (auto& edge : match.edges) {
    for (Index& v : edge) v = span_of(surface.surface2mesh)[v];
  }
  match.edge_numbers = std::move(answer.edge_entities);
  match.ambiguous_triangles = answer.ambiguous_triangles;
  match.unmatched_vertices = answer.unmatched_vertices;
  match.file_surfaces = answer.surfaces;
  match.file_surfaces_differing = answer.surfaces_differing;
  return match;
}

}  // namespace

Geometry::Geometry(std::string file, double unit, int threads)
    : file_(std::move(file)),
      unit_(unit),
      threads_(threads),
      session_(std::make_shared<PluginSession>(kOcctPlugin, file_)) {
  if (!(unit > 0 && std::isfinite(unit))) {
    throw OptionError("geometry_unit is " + number_text(unit) + "; it must be a positive length in mm");
  }
  if (threads < 0) throw OptionError("threads is " + std::to_string(threads) + "; it must be 0 or positive");
  { const MappedFile readable(file_); }  // an error of opening has the same message for all files
  const auto model = std::make_shared<LoadedModel>();
  IoContext context;
  context.warnings = &warnings_;
  session_->call("load", context, {}, [&](MeshReader& in) { in(*model); });
  model_ = model;
}

std::array<std::int32_t, 4> Geometry::counts() const { return model_->counts; }
Point3 Geometry::low() const { return scaled(model_->low, 1 / unit_); }
Point3 Geometry::high() const { return scaled(model_->high, 1 / unit_); }
double Geometry::diagonal() const { return distance(low(), high()); }

GeometryMatch Geometry::match(const TetMesh& mesh, double tolerance) const {
  require_arrays(mesh);
  const MeshSurface surface = surface_of(mesh, threads_);
  ClassifyQuery query{threads_, {}, {}, surface.triangles, file_surfaces_of(mesh, surface)};
  std::vector<Index> mesh2surface(mesh.points.size(), -1);
  for (const Index v : surface.surface2mesh) {
    span_of(mesh2surface)[v] = to_index(std::ssize(query.points));
    query.points.push_back(scaled(span_of(mesh.points)[v], unit_));
    query.radii.push_back(tolerance * unit_ * span_of(surface.lengths)[v]);
  }
  for (auto& t : query.triangles) {
    for (Index& v : t) v = span_of(mesh2surface)[v];
  }
  auto answer = ask<ClassifyQuery, ClassifyAnswer>(*session_, "classify", query);
  std::size_t farther = 0;
  for (std::size_t i = 0; i < query.points.size(); ++i) {
    const bool is_outer = span_of(surface.is_outer)[surface.surface2mesh[i]] != 0;
    if (is_outer && answer.distances[i] > query.radii[i]) ++farther;
  }
  GeometryMatch match = match_of(surface, mesh, std::move(answer), unit_);
  if (farther > 0) fail_to_match(*this, mesh, surface, unit_, match.distances, farther);
  return match;
}

std::vector<Point3> Geometry::project(const std::vector<Point3>& points, const std::vector<GeometryEntity>& entities,
                                      const std::vector<double>& radii) const {
  return request_projections(*session_, {unit_, threads_}, points, entities, radii);
}

std::vector<Point3> request_projections(PluginSession& session, const ProjectSettings& settings,
                                        const std::vector<Point3>& points, const std::vector<GeometryEntity>& entities,
                                        const std::vector<double>& radii) {
  ProjectQuery query{settings.threads, settings.precision, {}, {}, {}, {}};
  std::vector<Index> asked;
  for (Size i = 0; i < std::ssize(points); ++i) {
    const GeometryEntity& entity = span_of(entities)[i];
    if (entity.dimension < 0 || entity.dimension > 2) continue;
    asked.push_back(to_index(i));
    query.points.push_back(scaled(span_of(points)[i], settings.unit));
    query.radii.push_back(radii.empty() ? 0 : settings.unit * span_of(radii)[i]);
    query.dimensions.push_back(entity.dimension);
    query.entities.push_back(entity.number);
  }
  const auto answer = ask<ProjectQuery, ProjectAnswer>(session, "project", query);
  std::vector<Point3> projected = points;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    span_of(projected)[asked[i]] = scaled(answer.points.at(i), 1 / settings.unit);
  }
  return projected;
}

}  // namespace tetune
