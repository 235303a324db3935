// SPDX-License-Identifier: Apache-2.0
#include "curved/finer_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "mesh/tet.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The largest distance of a vertex from the finer surface, relative to the shortest edge at it.
constexpr double kMaxDistance = 0.1;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Offsets of mid-side nodes from the midpoints of straight edges.
class Offsets {
 public:
  Offsets(const std::vector<Point3>& points, const std::vector<CurvedEdge>& middles)
      : points_(points), middles_(middles) {}
  Vec3 of(Index a, Index b) const {
    const auto edge = ascending(a, b);
    const auto at = std::lower_bound(middles_.begin(), middles_.end(), edge,
                                     [](const CurvedEdge& e, const auto& sought) { return e.vertices < sought; });
    if (at == middles_.end() || at->vertices != edge) return {0, 0, 0};
    return vec(at->middle) - 0.5 * (vec(span_of(points_)[a]) + vec(span_of(points_)[b]));
  }

 private:
  const std::vector<Point3>& points_;
  const std::vector<CurvedEdge>& middles_;
};

/// Barycentric coordinates of a point of a triangle; of a segment if that has two equal corners.
std::array<double, 3> coordinates(const TrianglePoints& t, const Vec3& p) {
  const Vec3 a = t[1] - t[0];
  const Vec3 b = t[2] - t[0];
  const Vec3 n = cross(a, b);
  const double n2 = dot(n, n);
  if (!(n2 > 1e-28 * dot(a, a) * dot(b, b))) {
    const double s = dot(a, a) > 0 ? dot(p - t[0], a) / dot(a, a) : 0;
    return {1 - s, s, 0};
  }
  const double u = dot(cross(p - t[0], b), n) / n2;
  const double v = dot(cross(a, p - t[0]), n) / n2;
  return {1 - u - v, u, v};
}

}  // namespace

FinerSurface::Sheet::Sheet(std::vector<TrianglePoints> corners, std::vector<std::array<Vec3, 3>> side_offsets)
    : triangles(std::move(corners)),
      offsets(std::move(side_offsets)),
      search(triangles),
      low{kInfinity, kInfinity, kInfinity},
      high{-kInfinity, -kInfinity, -kInfinity} {
  for (const TrianglePoints& t : triangles) {
    for (const Vec3& p : t) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
}

double FinerSurface::Sheet::distance2_of_box(const Vec3& p) const {
  const Vec3 d{std::max({low.x - p.x, p.x - high.x, 0.0}), std::max({low.y - p.y, p.y - high.y, 0.0}),
               std::max({low.z - p.z, p.z - high.z, 0.0})};
  return dot(d, d);
}

Vec3 FinerSurface::Sheet::point_beside(const Vec3& p) const {
  const ClosestTriangle::Hit hit = search.closest(p);
  const auto [l0, l1, l2] = coordinates(span_of(triangles)[hit.triangle], hit.point);
  const auto& o = span_of(offsets)[hit.triangle];
  return hit.point + 4 * (l0 * l1) * o[0] + 4 * (l1 * l2) * o[1] + 4 * (l2 * l0) * o[2];
}

FinerSurface::FinerSurface(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles,
                           const SurfaceParts& parts, const std::vector<CurvedEdge>& middles) {
  const Offsets offsets(points, middles);
  const auto at = [&points](Index v) { return vec(span_of(points)[v]); };
  std::vector<std::vector<TrianglePoints>> corners(to_size_t(parts.sheets));
  std::vector<std::vector<std::array<Vec3, 3>>> side_offsets(corners.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t].vertices;
    const std::size_t sheet = to_size_t(parts.triangle2sheet[t]);
    corners[sheet].push_back({at(a), at(b), at(c)});
    side_offsets[sheet].push_back({offsets.of(a, b), offsets.of(b, c), offsets.of(c, a)});
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    sheets_.emplace_back(std::move(corners[i]), std::move(side_offsets[i]));
  }
  if (parts.features.empty()) return;
  std::vector<TrianglePoints> lines;
  std::vector<std::array<Vec3, 3>> line_offsets;
  for (const auto& [a, b] : parts.features) {
    lines.push_back({at(a), at(b), at(b)});
    line_offsets.push_back({offsets.of(a, b), Vec3{0, 0, 0}, Vec3{0, 0, 0}});
  }
  lines_.emplace(std::move(lines), std::move(line_offsets));
}

Vec3 FinerSurface::point_near(const Vec3& p, const Vec3& q, const Vec3& guess) const {
  const Sheet* nearest = nullptr;
  double least = kInfinity;
  for (const Sheet& sheet : sheets_) {
    double sum = sheet.distance2_of_box(p) + sheet.distance2_of_box(q) + sheet.distance2_of_box(guess);
    if (sum >= least) continue;
    sum = sheet.search.distance2(p) + sheet.search.distance2(q) + sheet.search.distance2(guess);
    if (sum >= least) continue;
    least = sum;
    nearest = &sheet;
  }
  return nearest->point_beside(guess);
}

std::optional<Vec3> FinerSurface::point_on_lines(const Vec3& p, const Vec3& q, const Vec3& guess) const {
  const double near2 = kMaxDistance * kMaxDistance * dot(q - p, q - p);
  if (!lines_ || lines_->search.distance2(p) > near2 || lines_->search.distance2(q) > near2) return {};
  return lines_->point_beside(guess);
}

double FinerSurface::distance(const Vec3& p) const {
  double least = kInfinity;
  for (const Sheet& sheet : sheets_) {
    if (sheet.distance2_of_box(p) < least) least = std::min(least, sheet.search.distance2(p));
  }
  return std::sqrt(least);
}

void check_is_near(const FinerSurface& finer, const std::vector<Point3>& points,
                   const std::vector<SheetTriangle>& triangles) {
  std::vector<double> shortest(points.size(), kInfinity);
  for (const SheetTriangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = t.vertices[k];
      const Index b = t.vertices[(k + 1) % 3];
      const double length = norm(vec(span_of(points)[b]) - vec(span_of(points)[a]));
      for (const Index v : {a, b}) span_of(shortest)[v] = std::min(span_of(shortest)[v], length);
    }
  }
  double largest = 0;
  std::size_t farthest = 0;
  std::int64_t far = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (shortest[v] == kInfinity) continue;
    const double distance = finer.distance(vec(points[v]));
    if (!(distance > kMaxDistance * shortest[v])) continue;
    ++far;
    if (distance <= largest) continue;
    largest = distance;
    farthest = v;
  }
  if (far == 0) return;
  const Point3& p = points[farthest];
  throw MeshError("the finer surface is not that of the mesh: " + std::to_string(far) +
                  " vertices are farther from it than a tenth of their shortest edge on the surface; the largest "
                  "distance is " +
                  std::to_string(largest) + ", of vertex " + std::to_string(farthest + 1) + " (counted from 1) at " +
                  std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) +
                  "\n  give a mesh of the same part, in the same place and unit, with smaller triangles.");
}

}  // namespace tetune
