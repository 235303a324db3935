// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "backend/cpu.hpp"
#include "boundary/sliding/surface_element.hpp"
#include "mesh/csr.hpp"
#include "support/random.hpp"

/// Small reference surfaces for tests.
namespace tetune::test {

struct TinySurface {
  std::vector<Point> points;
  std::vector<SurfaceTriangle> triangles;
  std::vector<Index> across;
  Csr<backend::Cpu> vertex2corner;
  std::vector<LineVertex> line;
  std::vector<VertexDof> dof;

  /// Edges on two triangles are no features, except `feature_edges`. Vertices slide on the surface; those of feature
  /// edges are fixed unless the test changes that.
  TinySurface(std::vector<Vec3> at, std::vector<std::array<Index, 3>> faces,
              const std::set<std::pair<Index, Index>>& feature_edges = {}) {
    for (const Vec3& p : at) points.push_back(point(p));
    for (const auto& f : faces) triangles.push_back({{f[0], f[1], f[2]}});
    dof.assign(points.size(), VertexDof::surface);
    line.assign(points.size(), {{-1, -1}});
    across.assign(3 * triangles.size(), kFeatureEdge);
    std::map<std::pair<Index, Index>, std::vector<Index>> edges;
    for (std::size_t c = 0; c < across.size(); ++c) {
      const SurfaceTriangle t = triangles[c / 3];
      edges[std::minmax(t.v[(c + 1) % 3], t.v[(c + 2) % 3])].push_back(static_cast<Index>(c));
    }
    for (const auto& [edge, corners] : edges) {
      if (corners.size() == 2 && feature_edges.count(edge) == 0) {
        across[static_cast<std::size_t>(corners[0])] = corners[1];
        across[static_cast<std::size_t>(corners[1])] = corners[0];
      } else {
        dof[static_cast<std::size_t>(edge.first)] = dof[static_cast<std::size_t>(edge.second)] = VertexDof::fixed;
      }
    }
    struct RowOf {
      const SurfaceTriangle* triangles;
      Size operator()(Size c) const { return triangles[c / 3].v[c % 3]; }
    };
    build_csr(backend::Cpu(1), static_cast<Size>(points.size()), 3 * static_cast<Size>(triangles.size()),
              RowOf{triangles.data()}, vertex2corner);
  }

  /// Makes a feature line of vertices; its ends stay fixed.
  void add_line(const std::vector<Index>& vertices, bool closed = false) {
    const std::size_t n = vertices.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (!closed && (i == 0 || i + 1 == n)) continue;
      const auto v = static_cast<std::size_t>(vertices[i]);
      dof[v] = VertexDof::curve;
      line[v] = {{vertices[(i + n - 1) % n], vertices[(i + 1) % n]}};
    }
  }

  ReferenceView view() const {
    return {span_of(points), span_of(triangles), span_of(across), vertex2corner.view(), span_of(line), span_of(dof)};
  }
};

/// An n x n grid of squares of two triangles each over [0, 1]^2, at heights z(x, y). Its boundary edges are features.
template <class Height>
TinySurface height_field(int n, const Height& z, const std::set<std::pair<Index, Index>>& feature_edges = {}) {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;
  const auto id = [n](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n;
      const double y = static_cast<double>(j) / n;
      points.push_back({x, y, z(x, y)});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return {std::move(points), std::move(triangles), feature_edges};
}

/// Same as height_field(), with a feature line across the middle, x = 1/2. Requires an even n.
template <class Height>
TinySurface height_field_with_line(int n, const Height& z) {
  std::vector<Index> line;
  std::set<std::pair<Index, Index>> feature_edges;
  for (int j = 0; j <= n; ++j) {
    line.push_back(static_cast<Index>(j * (n + 1) + n / 2));
    if (j > 0) feature_edges.insert({line[static_cast<std::size_t>(j - 1)], line.back()});
  }
  TinySurface surface = height_field(n, z, feature_edges);
  surface.add_line(line);
  return surface;
}

/// Two triangles folded upwards at their common edge (0, 1).
inline TinySurface folded(double apex_height) {
  return {{{0, 0, 0}, {0, 1, 0}, {-1, 0.5, apex_height}, {1, 0.5, apex_height}}, {{0, 1, 2}, {1, 0, 3}}};
}

inline double flat(double, double) { return 0; }

inline double bumpy(double x, double y) { return 0.08 * std::sin(7 * x) * std::cos(5 * y + 1); }

inline Vec3 descent(const SurfaceElement& p) { return p.frame.in_space(p.descent); }

}  // namespace tetune::test
