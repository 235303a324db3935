// SPDX-License-Identifier: Apache-2.0
#include "curved/finer_surface.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "math/constants.hpp"
#include "mesh/messages.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The largest distance of a vertex from the finer surface, relative to the shortest edge at it.
constexpr double kMaxDistance = 0.1;

}  // namespace

FinerSurface::FinerSurface(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles,
                           const SurfaceParts& parts, const std::vector<CurvedEdge>& middles) {
  const QuadraticTriangles quadratic(points, middles);
  std::vector<std::vector<QuadraticSheet::Triangle>> sheets(to_size_t(parts.sheets));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    span_of(sheets)[parts.triangle2sheet[t]].push_back(quadratic.of(triangles[t].vertices));
  }
  for (auto& sheet : sheets) sheets_.emplace_back(std::move(sheet));
  if (parts.features.empty()) return;
  std::vector<QuadraticSheet::Triangle> lines;
  for (const auto& edge : parts.features) lines.push_back(quadratic.of(edge));
  lines_.emplace(std::move(lines));
}

Vec3 FinerSurface::point_near(const Vec3& p, const Vec3& q, const Vec3& guess) const {
  const QuadraticSheet* nearest = &sheets_.front();  // where squared distances overflow
  double least = kInfinity;
  for (const QuadraticSheet& sheet : sheets_) {
    double sum = sheet.distance2_of_box(p) + sheet.distance2_of_box(q) + sheet.distance2_of_box(guess);
    if (sum >= least) continue;
    sum = sheet.distance2(p) + sheet.distance2(q) + sheet.distance2(guess);
    if (sum >= least) continue;
    least = sum;
    nearest = &sheet;
  }
  return nearest->lift(guess);
}

std::optional<Vec3> FinerSurface::point_on_lines(const Vec3& p, const Vec3& q, const Vec3& guess) const {
  const double near2 = kMaxDistance * kMaxDistance * dot(q - p, q - p);
  if (!lines_ || lines_->distance2(p) > near2 || lines_->distance2(q) > near2) return {};
  return lines_->lift(guess);
}

double FinerSurface::distance(const Vec3& p) const {
  double least = kInfinity;
  for (const QuadraticSheet& sheet : sheets_) {
    if (sheet.distance2_of_box(p) < least) least = std::min(least, sheet.distance2(p));
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
  throw MeshError("the finer surface is not that of the mesh: " + std::to_string(far) +
                  " vertices are farther from it than a tenth of their shortest edge on the surface; the largest "
                  "distance is " +
                  short_text(largest) + ", of vertex " + std::to_string(farthest + 1) + " (counted from 1) " +
                  place_text(points[farthest]) +
                  "\n  give a mesh of the same part, in the same place and unit, with smaller triangles.");
}

}  // namespace tetune
