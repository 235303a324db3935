// SPDX-License-Identifier: Apache-2.0
#include "curved/quadratic_sheet.hpp"

#include <utility>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "math/constants.hpp"
#include "mesh/tet.hpp"

namespace tetune {
namespace {

std::vector<TrianglePoints> corners_of(const std::vector<QuadraticSheet::Triangle>& triangles) {
  std::vector<TrianglePoints> corners;
  corners.reserve(triangles.size());
  for (const QuadraticSheet::Triangle& t : triangles) corners.push_back(t.corners);
  return corners;
}

}  // namespace

std::array<double, 3> barycentric(const TrianglePoints& t, const Vec3& p) {
  const Vec3 a = t[1] - t[0];
  const Vec3 b = t[2] - t[0];
  const Vec3 n = cross(a, b);
  const double n2 = dot(n, n);
  if (!(n2 > kDegenerateSine2 * dot(a, a) * dot(b, b))) {
    const double s = dot(a, a) > 0 ? dot(p - t[0], a) / dot(a, a) : 0;
    return {1 - s, s, 0};
  }
  const double u = dot(cross(p - t[0], b), n) / n2;
  const double v = dot(cross(a, p - t[0]), n) / n2;
  return {1 - u - v, u, v};
}

QuadraticSheet::QuadraticSheet(std::vector<Triangle> triangles)
    : triangles_(std::move(triangles)),
      search_(corners_of(triangles_)),
      box_{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}} {
  for (const Triangle& t : triangles_) {
    for (const Vec3& p : t.corners) box_.include(p);
  }
}

Vec3 QuadraticSheet::lift(const Vec3& p) const {
  const ClosestTriangle::Hit hit = search_.closest(p);
  if (hit.distance2 == kInfinity) return p;
  const Triangle& t = span_of(triangles_)[hit.triangle];
  const auto [l0, l1, l2] = barycentric(t.corners, hit.point);
  return hit.point + 4 * (l0 * l1) * t.offsets[0] + 4 * (l1 * l2) * t.offsets[1] + 4 * (l2 * l0) * t.offsets[2];
}

double area_of(const QuadraticSheet::Triangle& triangle) {
  struct Node {
    std::array<double, 3> at;
    double weight;
  };
  // J. Radon: Zur mechanischen Kubatur (1948). (6 -+ sqrt(15)) / 21 and (155 -+ sqrt(15)) / 1200.
  constexpr double kSmall = 0.10128650732345634;
  constexpr double kLarge = 0.47014206410511509;
  constexpr double kCornerWeight = 0.12593918054482715;
  constexpr double kSideWeight = 0.13239415278850618;
  constexpr std::array<Node, 7> kNodes{{{{1.0 / 3, 1.0 / 3, 1.0 / 3}, 0.225},
                                        {{1 - 2 * kSmall, kSmall, kSmall}, kCornerWeight},
                                        {{kSmall, 1 - 2 * kSmall, kSmall}, kCornerWeight},
                                        {{kSmall, kSmall, 1 - 2 * kSmall}, kCornerWeight},
                                        {{1 - 2 * kLarge, kLarge, kLarge}, kSideWeight},
                                        {{kLarge, 1 - 2 * kLarge, kLarge}, kSideWeight},
                                        {{kLarge, kLarge, 1 - 2 * kLarge}, kSideWeight}}};
  const auto& [p, q, r] = triangle.corners;
  const auto& [o, s, t] = triangle.offsets;
  double sum = 0;
  for (const auto& [l, weight] : kNodes) {
    const Vec3 du = (q - p) + 4 * ((l[0] - l[1]) * o + l[2] * (s - t));
    const Vec3 dv = (r - p) + 4 * ((l[0] - l[2]) * t + l[1] * (s - o));
    sum += weight * norm(cross(du, dv));
  }
  return 0.5 * sum;
}

Vec3 QuadraticTriangles::at(Index v) const { return vec(span_of(points_)[v]); }

Vec3 QuadraticTriangles::offset(Index a, Index b) const {
  const CurvedEdge* const edge = find_edge(edges_, ascending(a, b));
  return edge == nullptr ? Vec3{0, 0, 0} : vec(edge->middle) - 0.5 * (at(a) + at(b));
}

QuadraticSheet::Triangle QuadraticTriangles::of(const std::array<Index, 3>& triangle) const {
  const auto& [a, b, c] = triangle;
  return {{at(a), at(b), at(c)}, {offset(a, b), offset(b, c), offset(c, a)}};
}

QuadraticSheet::Triangle QuadraticTriangles::of(const std::array<Index, 2>& edge) const {
  return {{at(edge[0]), at(edge[1]), at(edge[1])}, {offset(edge[0], edge[1]), Vec3{0, 0, 0}, Vec3{0, 0, 0}}};
}

}  // namespace tetune
