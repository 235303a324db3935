// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "backend/span.hpp"
#include "io/geometry/geometry_requests.hpp"
#include "math/vec3.hpp"
#include "mesh/matched_edges.hpp"
#include "tetune/geometry.hpp"

namespace tetune {
namespace {

/// ProjectSettings::precision with which distances have six digits at least.
constexpr double kPrecision = 1e-3;

/// The points to measure: of a kind, on a face's triangles.
struct Samples {
  std::vector<Point3> points;
  std::vector<GeometryEntity> entities;
  std::vector<double> radii;
  std::vector<std::array<std::int32_t, 2>> faces;  ///< 0: none

  void append(const Samples& more) {
    points.insert(points.end(), more.points.begin(), more.points.end());
    entities.insert(entities.end(), more.entities.begin(), more.entities.end());
    radii.insert(radii.end(), more.radii.begin(), more.radii.end());
    faces.insert(faces.end(), more.faces.begin(), more.faces.end());
  }
};

Point3 mean_of(const std::vector<Point3>& points, std::initializer_list<Index> vertices) {
  Point3 sum{};
  for (const Index v : vertices) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += span_of(points)[v][k] / double(vertices.size());
  }
  return sum;
}

class Sampling {
 public:
  Sampling(const std::vector<Point3>& points, const GeometryMatch& match) : points_(points), match_(match) {}

  /// Calls f(vertex, the faces on both sides).
  template <class F>
  void for_each_vertex(const F& f) const {
    std::vector<std::array<std::int32_t, 2>> faces(points_.size());
    for_each_triangle([&](const auto& t, std::int32_t face) {
      for (const Index v : t) span_of(faces)[v][span_of(faces)[v][0] != 0 ? 1 : 0] = face;
    });
    for (Size v = 0; v < std::ssize(points_); ++v) {
      if (span_of(faces)[v][0] == 0 || span_of(match_.vertices)[v].dimension < 0) continue;
      if (span_of(faces)[v][1] == span_of(faces)[v][0]) span_of(faces)[v][1] = 0;
      f(v, span_of(faces)[v]);
    }
  }

  Samples midpoints() const {
    Samples s;
    for (const MatchedEdge& edge : edges_of(match_)) {
      const auto [a, b] = edge.vertices;
      if (edge.entity.dimension > 0) add(s, mean_of(points_, {a, b}), edge.entity, length(a, b), edge.faces);
    }
    return s;
  }

  Samples centers() const {
    Samples s;
    for_each_triangle([&](const auto& t, std::int32_t face) {
      add(s, mean_of(points_, {t[0], t[1], t[2]}), {2, face}, length(t[0], t[1]), {face, 0});
    });
    return s;
  }

 private:
  template <class F>
  void for_each_triangle(const F& f) const {
    for (std::size_t t = 0; t < match_.triangles.size(); ++t) {
      if (match_.faces[t] > 0) f(match_.triangles[t], match_.faces[t]);
    }
  }
  double length(Index a, Index b) const { return norm(vec(span_of(points_)[a]) - vec(span_of(points_)[b])); }
  static void add(Samples& s, const Point3& p, GeometryEntity entity, double radius,
                  std::array<std::int32_t, 2> faces) {
    s.points.push_back(p);
    s.entities.push_back(entity);
    s.radii.push_back(radius);
    s.faces.push_back(faces);
  }

  const std::vector<Point3>& points_;
  const GeometryMatch& match_;
};

void add_distance(DistanceSummary& summary, double distance) {
  ++summary.points;
  summary.largest = std::max(summary.largest, distance);
  summary.mean += (distance - summary.mean) / double(summary.points);
}

}  // namespace

GeometryDeviation Geometry::measure(const std::vector<Point3>& points, const GeometryMatch& match) const {
  const Sampling sampling(points, match);
  GeometryDeviation deviation;
  std::map<std::int32_t, GeometryDeviation::Face> faces;
  using Face = GeometryDeviation::Face;
  const auto add = [&](DistanceSummary GeometryDeviation::*total, DistanceSummary Face::*part, double distance,
                       const std::array<std::int32_t, 2>& on) {
    add_distance(deviation.*total, distance);
    for (const std::int32_t face : on) {
      if (face > 0) add_distance(faces[face].*part, distance);
    }
  };
  sampling.for_each_vertex([&](Size v, const std::array<std::int32_t, 2>& on) {
    add(&GeometryDeviation::vertices, &Face::vertices, span_of(match.distances)[v], on);
  });
  Samples all = sampling.midpoints();
  const std::size_t midpoints = all.points.size();
  all.append(sampling.centers());
  const std::vector<Point3> closest_points =
      request_projections(*session_, {unit_, threads_, kPrecision}, all.points, all.entities, all.radii);
  for (std::size_t i = 0; i < closest_points.size(); ++i) {
    const double distance = norm(vec(closest_points[i]) - vec(all.points[i]));
    if (i < midpoints) {
      add(&GeometryDeviation::midpoints, &Face::midpoints, distance, all.faces[i]);
    } else {
      add(&GeometryDeviation::centers, &Face::centers, distance, all.faces[i]);
    }
  }
  for (auto& [number, face] : faces) {
    face.number = number;
    deviation.faces.push_back(face);
  }
  return deviation;
}

}  // namespace tetune
