// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "curved/curved_edges.hpp"
#include "math/closest_triangle.hpp"
#include "mesh/tet.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"
#include "tetune/curve.hpp"

/// Curved meshes, and plain oracles for their surfaces after optimization.
namespace tetune::test {

/// A lattice mapped to a ball of radius 1, with vertices displaced at random.
inline TetMesh ball(int n, double jitter = 0.15, std::uint32_t seed = 1) {
  TetMesh m = cube(n, jitter, seed);
  for (Point3& p : m.points) {
    const double x = 2 * p[0] - 1;
    const double y = 2 * p[1] - 1;
    const double z = 2 * p[2] - 1;
    p = {x * std::sqrt(1 - y * y / 2 - z * z / 2 + y * y * z * z / 3),
         y * std::sqrt(1 - z * z / 2 - x * x / 2 + z * z * x * x / 3),
         z * std::sqrt(1 - x * x / 2 - y * y / 2 + x * x * y * y / 3)};
  }
  return scrambled(std::move(m), 2, seed);
}

/// Deforms a lattice of the unit cube by waves in z and a bulge along x.
inline TetMesh waved(TetMesh mesh, std::uint32_t seed = 1, double height = 0.08) {
  for (Point3& p : mesh.points) {
    p[2] += height * std::sin(5 * p[0] + 1) * std::cos(4 * p[1]);
    p[0] += 0.5 * height * std::sin(4 * p[1] + 2 * p[2]);
  }
  return scrambled(std::move(mesh), 2, seed);
}

/// One face of the boundary or of an interface: its vertices in increasing order, and the lower and higher of the
/// region tags beside it (the boundary has kOutside for the lower).
struct SkinFace {
  static constexpr int kOutside = -1000000;
  std::array<Index, 3> v;
  std::array<int, 2> regions;
  int tag = 0;  ///< of the listed triangle
  bool operator<(const SkinFace& o) const { return std::tie(v, regions) < std::tie(o.v, o.regions); }
  bool operator==(const SkinFace& o) const { return v == o.v && regions == o.regions; }
};

inline std::vector<SkinFace> skin(const TetMesh& m) {
  std::map<std::array<Index, 3>, int> tags;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    if (m.triangle_tags[t] != 0) tags[ascending(m.triangles[t])] = m.triangle_tags[t];
  }
  std::vector<SkinFace> faces;
  for (const auto& [f, regions] : face2tags(m)) {
    if (regions.size() == 2 && regions[0] == regions[1]) continue;
    const int other = regions.size() == 2 ? regions[1] : SkinFace::kOutside;
    const auto tag = tags.find(f);
    faces.push_back(
        {f, {std::min(regions[0], other), std::max(regions[0], other)}, tag == tags.end() ? 0 : tag->second});
  }
  return faces;
}

inline TrianglePoints corners(const TetMesh& m, const SkinFace& f) {
  return {at(m, f.v[0]), at(m, f.v[1]), at(m, f.v[2])};
}

/// Lists the faces of the skin as triangles: of tag 7 where x of the centroid is below `split`, else of tag 0 where y
/// is, else of tag 9.
inline TetMesh with_patches(TetMesh m, double split) {
  for (const SkinFace& f : skin(m)) {
    const Vec3 c = (1.0 / 3) * (at(m, f.v[0]) + at(m, f.v[1]) + at(m, f.v[2]));
    m.triangles.push_back(f.v);
    m.triangle_tags.push_back(c.x < split ? 7 : c.y < split ? 0 : 9);
  }
  return m;
}

/// Oracle: the feature edges of a surface and the classification of its vertices.
struct PlainFeatures {
  std::vector<std::array<Index, 2>> edges;
  std::map<Index, int> degree;  ///< of each vertex of the surface: number of feature edges
  std::map<Index, bool> turns;  ///< of vertices with two: whether the line turns by more than the angle
  bool fixed(Index v) const { return degree.at(v) == 1 || degree.at(v) > 2 || (degree.at(v) == 2 && turns.at(v)); }
  bool curve(Index v) const { return degree.at(v) == 2 && !turns.at(v); }
};

inline PlainFeatures plain_features(const TetMesh& m, const std::vector<SkinFace>& faces, double angle) {
  PlainFeatures result;
  std::map<std::array<Index, 2>, std::vector<const SkinFace*>> edge2faces;
  for (const SkinFace& f : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      edge2faces[ascending(f.v[k], f.v[(k + 1) % 3])].push_back(&f);
      result.degree[f.v[k]];
    }
  }
  const auto from_edge = [&m](const std::array<Index, 2>& e, const SkinFace& f) {
    Vec3 apex{};
    for (const Index v : f.v) {
      if (v != e[0] && v != e[1]) apex = at(m, v);
    }
    const Vec3 along = at(m, e[1]) - at(m, e[0]);
    const Vec3 d = apex - at(m, e[0]);
    const Vec3 off = d - (dot(d, along) / dot(along, along)) * along;
    return (1 / norm(off)) * off;
  };
  std::map<Index, std::vector<Vec3>> leaving;
  for (const auto& [e, sides] : edge2faces) {
    bool feature = sides.size() != 2 || sides[0]->tag != sides[1]->tag;
    if (!feature) {
      const double cosine = -dot(from_edge(e, *sides[0]), from_edge(e, *sides[1]));
      feature = angle < 180 && cosine < std::cos(angle * std::numbers::pi / 180);
    }
    if (!feature) continue;
    result.edges.push_back(e);
    for (const Index v : e) {
      ++result.degree[v];
      const Vec3 d = at(m, e[0] == v ? e[1] : e[0]) - at(m, v);
      leaving[v].push_back((1 / norm(d)) * d);
    }
  }
  for (const auto& [v, d] : leaving) {
    result.turns[v] = angle < 180 && d.size() == 2 && -dot(d[0], d[1]) < std::cos(angle * std::numbers::pi / 180);
  }
  return result;
}

/// The largest distance of points of one set of triangles from another, by dense sampling.
inline double sampled_distance(const std::vector<TrianglePoints>& from, const ClosestTriangle& to, int samples) {
  double max2 = 0;
  for (const TrianglePoints& t : from) {
    for (int a = 0; a <= samples; ++a) {
      for (int b = 0; a + b <= samples; ++b) {
        const double s = static_cast<double>(a) / samples;
        const double r = static_cast<double>(b) / samples;
        max2 = std::max(max2, to.distance2(t[0] + s * (t[1] - t[0]) + r * (t[2] - t[0])));
      }
    }
  }
  return std::sqrt(max2);
}

inline std::vector<TrianglePoints> corners(const TetMesh& m, const std::vector<SkinFace>& faces) {
  std::vector<TrianglePoints> all;
  for (const SkinFace& f : faces) all.push_back(corners(m, f));
  return all;
}

inline std::vector<TrianglePoints> corners(const TetMesh& m, const std::vector<std::array<Index, 2>>& edges) {
  std::vector<TrianglePoints> all;
  for (const auto& e : edges) all.push_back({at(m, e[0]), at(m, e[1]), at(m, e[1])});
  return all;
}

/// A cube whose upper face has mid-side nodes that are shifted upward or downward, but for those on its border.
inline TetMesh bulged_cube(double shift) {
  TetMesh m = cube(3, 0.15);
  m.second_order = true;
  std::vector<std::array<Index, 2>> edges;
  const auto top = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][2] == 1; };
  const auto on_side = [&m](Index v, Index w) {
    const Point3& p = m.points[static_cast<std::size_t>(v)];
    const Point3& q = m.points[static_cast<std::size_t>(w)];
    return (p[0] == q[0] && (p[0] == 0 || p[0] == 1)) || (p[1] == q[1] && (p[1] == 0 || p[1] == 1));
  };
  for (const auto& tet : m.tets) {
    for (const auto& [i, j] : kCurvedTetEdges) {
      if (top(tet[i]) && top(tet[j]) && !on_side(tet[i], tet[j])) edges.push_back(ascending(tet[i], tet[j]));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& e : edges) {
    const Point3& p = m.points[static_cast<std::size_t>(e[0])];
    const Point3& q = m.points[static_cast<std::size_t>(e[1])];
    m.curved_edges.push_back({e, {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, 1 + shift}});
  }
  return m;
}

/// A ball whose mid-side nodes of the surface are on the sphere: elements at former edges of the cube have two faces
/// there.
inline TetMesh curved_ball() {
  TetMesh m = ball(2, 0);
  m.second_order = true;
  std::set<std::array<Index, 2>> edges;
  for (const auto& face : skin(m)) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(ascending(face.v[k], face.v[(k + 1) % 3]));
  }
  for (const auto& edge : edges) {
    const Vec3 middle = at(m, edge[0]) + at(m, edge[1]);
    const Vec3 on_sphere = (1 / norm(middle)) * middle;
    m.curved_edges.push_back({edge, {on_sphere.x, on_sphere.y, on_sphere.z}});
  }
  return m;
}

/// The positions of the mid-side nodes of curved edges on the upper face, sorted.
inline std::vector<Point3> upper_middles(const TetMesh& m) {
  std::vector<Point3> middles;
  for (const CurvedEdge& e : m.curved_edges) {
    const auto z = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][2]; };
    if (z(e.vertices[0]) == 1 && z(e.vertices[1]) == 1) middles.push_back(e.middle);
  }
  std::sort(middles.begin(), middles.end());
  return middles;
}

}  // namespace tetune::test
