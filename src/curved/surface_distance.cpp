// SPDX-License-Identifier: Apache-2.0
#include "curved/surface_distance.hpp"

#include <algorithm>
#include <cmath>

#include "backend/cpu.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

constexpr int kMaxDivision = 32;
constexpr int kMaxDepth = 12;

Vec3 point_at(const QuadraticSheet::Triangle& t, double u, double v) {
  const double w = 1 - u - v;
  const Vec3 straight = w * t.corners[0] + u * t.corners[1] + v * t.corners[2];
  return straight + 4 * (w * u) * t.offsets[0] + 4 * (u * v) * t.offsets[1] + 4 * (v * w) * t.offsets[2];
}

/// A bound on the distance between a quadratic triangle and its facets: four times the sum of the products of two
/// barycentric coordinates is at most 4/3.
double facet_error(const QuadraticSheet::Triangle& t, int division) {
  const double offset = std::max({norm(t.offsets[0]), norm(t.offsets[1]), norm(t.offsets[2])});
  return 4.0 / 3 * offset / (double(division) * division);
}

/// The distance of the quadratic triangle from the midpoint of a chord whose ends differ by (u, v) in barycentric
/// coordinates. Of the three chords of a part of it, 4/3 of the largest bounds its distance from the straight part.
double middle_offset(const QuadraticSheet::Triangle& t, double u, double v) {
  const double w = -u - v;
  return norm(w * u * t.offsets[0] + u * v * t.offsets[1] + v * w * t.offsets[2]);
}

/// A point of a triangle by two barycentric coordinates, and a point of the other surface near it.
struct Sample {
  double u, v;
  Vec3 point;
  Size facet;
  double other_u, other_v;
  double distance;
};

class DistanceBound {
 public:
  DistanceBound(const std::vector<QuadraticSheet::Triangle>& triangles, const SurfaceFacets& surface,
                const ClosestTriangle& search, double limit)
      : triangles_(triangles), surface_(surface), search_(search), limit_(limit) {}

  double of(const QuadraticSheet::Triangle& t) const {
    return bound(t, {sample(t, 0, 0), sample(t, 1, 0), sample(t, 0, 1)}, 0);
  }

 private:
  Sample sample(const QuadraticSheet::Triangle& t, double u, double v) const {
    const Vec3 p = point_at(t, u, v);
    const ClosestTriangle::Hit hit = search_.closest(p);
    const SurfaceFacets::FacetOrigin& origin = span_of(surface_.origins)[hit.triangle];
    const auto l = barycentric(span_of(surface_.facets)[hit.triangle], hit.point);
    Sample s{u, v, p, hit.triangle, 0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      s.other_u += std::clamp(l[k], 0.0, 1.0) * origin.corners[k][0];
      s.other_v += std::clamp(l[k], 0.0, 1.0) * origin.corners[k][1];
    }
    s.distance = norm(p - point_at(span_of(triangles_)[origin.triangle], s.other_u, s.other_v));
    return s;
  }

  Index triangle_of(const Sample& s) const { return span_of(surface_.origins)[s.facet].triangle; }

  /// A bound for a part of a triangle, where the points beside its corners are all on one triangle.
  double bound_on_one(const QuadraticSheet::Triangle& t, const std::array<Sample, 3>& corners, double largest) const {
    const QuadraticSheet::Triangle& other = span_of(triangles_)[triangle_of(corners[0])];
    double offset = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Sample& a = corners[k];
      const Sample& b = corners[(k + 1) % 3];
      offset = std::max(offset, middle_offset(t, b.u - a.u, b.v - a.v) +
                                    middle_offset(other, b.other_u - a.other_u, b.other_v - a.other_v));
    }
    return largest + 4.0 / 3 * offset;
  }

  double bound_by_facet(const QuadraticSheet::Triangle& t, const std::array<Sample, 3>& corners, int depth) const {
    double least = kInfinity;
    for (const Sample& s : corners) {
      double largest2 = 0;
      for (const Sample& other : corners) {
        largest2 = std::max(largest2, distance2(other.point, span_of(surface_.facets)[s.facet]));
      }
      least = std::min(least, std::sqrt(largest2));
    }
    return least + facet_error(t, 1 << depth) + surface_.error;
  }

  /// A bound for a part of a triangle that has been divided `depth` times.
  double bound(const QuadraticSheet::Triangle& t, const std::array<Sample, 3>& corners, int depth) const {
    const double largest = std::max({corners[0].distance, corners[1].distance, corners[2].distance});
    const bool on_one =
        triangle_of(corners[0]) == triangle_of(corners[1]) && triangle_of(corners[0]) == triangle_of(corners[2]);
    const double upper = on_one ? bound_on_one(t, corners, largest) : bound_by_facet(t, corners, depth);
    if (upper <= limit_ / 2 || upper - largest <= limit_ / 10 || largest > limit_ || depth == kMaxDepth) return upper;
    std::array<Sample, 3> middles{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Sample& next = corners[(k + 1) % 3];
      middles[k] = sample(t, 0.5 * (corners[k].u + next.u), 0.5 * (corners[k].v + next.v));
    }
    double result = bound(t, middles, depth + 1);
    for (std::size_t k = 0; k < 3 && result <= limit_; ++k) {
      result = std::max(result, bound(t, {corners[k], middles[k], middles[(k + 2) % 3]}, depth + 1));
    }
    return result;
  }

  const std::vector<QuadraticSheet::Triangle>& triangles_;
  const SurfaceFacets& surface_;
  const ClosestTriangle& search_;
  double limit_;
};

}  // namespace

SurfaceFacets divide_into_facets(const std::vector<QuadraticSheet::Triangle>& triangles, double tolerance) {
  SurfaceFacets result;
  for (Index i = 0; i < std::ssize(triangles); ++i) {
    const QuadraticSheet::Triangle& t = span_of(triangles)[i];
    int n = 1;
    while (n < kMaxDivision && facet_error(t, n) > tolerance) ++n;
    result.error = std::max(result.error, facet_error(t, n));
    using Corner = std::array<double, 2>;
    const auto add = [&](const Corner& a, const Corner& b, const Corner& c) {
      const SurfaceFacets::FacetOrigin origin{i, {{{a[0] / n, a[1] / n}, {b[0] / n, b[1] / n}, {c[0] / n, c[1] / n}}}};
      TrianglePoints facet{};
      for (std::size_t k = 0; k < 3; ++k) facet[k] = point_at(t, origin.corners[k][0], origin.corners[k][1]);
      result.facets.push_back(facet);
      result.origins.push_back(origin);
    };
    for (double u = 0; u < n; ++u) {
      for (double v = 0; u + v < n; ++v) {
        add({u, v}, {u + 1, v}, {u, v + 1});
        if (u + v + 1 < n) add({u + 1, v}, {u + 1, v + 1}, {u, v + 1});
      }
    }
  }
  return result;
}

std::vector<double> bound_distances(const std::vector<QuadraticSheet::Triangle>& from,
                                    const std::vector<QuadraticSheet::Triangle>& to, double limit, int threads,
                                    const std::function<bool()>& stop) {
  std::vector<double> result(from.size(), kInfinity);
  if (to.empty()) return result;
  const SurfaceFacets surface = divide_into_facets(to, limit / 8);
  const ClosestTriangle search(surface.facets);
  const DistanceBound bound(to, surface, search, limit);
  backend::Cpu(threads).for_each(std::ssize(from), [&](Size i) {
    if (!stop || !stop()) span_of(result)[i] = bound.of(span_of(from)[i]);
  });
  return result;
}

}  // namespace tetune
