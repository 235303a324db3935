// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/pack.hpp"
#include "backend/prefetch.hpp"
#include "boundary/sliding/triangle_deviation.hpp"

namespace tetune {

/// A set of triangles of a SurfaceFan: bit i stands for triangle i.
using FanMask = std::uint32_t;

/// The fan of surface triangles at a vertex that is moved to x: triangle i is between ring vertices i and i + 1. The
/// arrays hold one entry per triangle, for loops over packs of triangles.
template <class Pack>
struct SurfaceFan {
  static constexpr int kMaxTriangles = 16;
  static constexpr int kLanes = kLanesOf<Pack>;

  /// A vector per triangle.
  struct Vectors {
    double x[kMaxTriangles], y[kMaxTriangles], z[kMaxTriangles];
    TETUNE_HD Pack dots(int i, const Vec3& d) const {
      return backend::load<Pack>(x + i) * d.x + backend::load<Pack>(y + i) * d.y + backend::load<Pack>(z + i) * d.z;
    }
    TETUNE_HD void set(int i, const Vec3& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
    TETUNE_HD Vec3 operator[](int i) const { return {x[i], y[i], z[i]}; }
    TETUNE_HD double dot(int i, const Vec3& d) const { return x[i] * d.x + y[i] * d.y + z[i] * d.z; }
  };

  Vec3 x{};
  int count = 0;
  FanMask all = 0;
  std::uint64_t bit[kMaxTriangles];
  std::uint32_t corner[kMaxTriangles];  ///< the triangle's corner at the vertex
  Index ring[kMaxTriangles];
  bool at_feature[kMaxTriangles];  ///< the edge opposite x is a feature edge
  Vectors edge;                    ///< from x to the ring
  Vectors outer;                   ///< from x to the vertex across the edge opposite x
  Vectors slope_a, slope_b;        ///< the gradients of the barycentric coordinates
  Vectors unit;                    ///< the unit normal
  Vectors inward;                  ///< from the edge opposite x into the triangle across it
  double edge2[kMaxTriangles];
  double inward_offset[kMaxTriangles];
  Vec3 axis{};       ///< the mean direction of the normals
  double tilt2 = 0;  ///< squared sine of the largest angle between the axis and a normal

  /// Collects the fan. False: the triangles are fewer than 3 or more than kMaxTriangles, do not form one closed fan
  /// without feature edges at the vertex, are degenerate, or have a normal at 90 degrees or more from the axis.
  TETUNE_HD bool build(const ReferenceView& ref, Span<const Point> points, Index vertex, const Vec3& position) {
    x = position;
    return collect(ref, points, vertex) && find_axis();
  }
  /// Finds the prisms over the triangles: `slope_a`, `slope_b`, `edge2`, `inward` and `inward_offset`.
  TETUNE_HD void find_prisms() {
    for (int i = 0; i < count; ++i) {
      const Vec3 a = edge[i];
      const Vec3 b = edge[after(i)];
      const Vec3 normal = cross(a, b);
      const double inverse = 1 / dot(normal, normal);
      slope_a.set(i, inverse * cross(b, normal));
      slope_b.set(i, inverse * cross(normal, a));
      edge2[i] = dot(a, a);
      const Vec3 e = b - a;
      const Vec3 apex = outer[i] - a;
      inward.set(i, at_feature[i] ? Vec3{} : apex - (dot(apex, e) / dot(e, e)) * e);
      inward_offset[i] = at_feature[i] ? -1 : dot(a, inward[i]);
    }
    for (int i = count; i % kLanes != 0; ++i) {
      for (Vectors* v : {&slope_a, &slope_b, &unit, &edge, &inward}) v->set(i, {});
      edge2[i] = inward_offset[i] = 0;
    }
  }

  TETUNE_HD int after(int i) const { return i + 1 < count ? i + 1 : 0; }
  TETUNE_HD int before(int i) const { return i > 0 ? i - 1 : count - 1; }
  /// Moves bit i to bit i + 1, and bit i + 1 to bit i.
  TETUNE_HD FanMask to_next(FanMask m) const { return ((m << 1) | (m >> (count - 1))) & all; }
  TETUNE_HD FanMask to_previous(FanMask m) const { return (m >> 1) | ((m & 1) << (count - 1)); }

  /// A point at x + d relative to triangle i.
  TETUNE_HD PrismPoint prism_point(int i, const Vec3& d) const {
    const double la = slope_a.dot(i, d);
    const double lb = slope_b.dot(i, d);
    return {{1 - la - lb, la, lb}, unit.dot(i, d)};
  }

 private:
  TETUNE_HD bool collect(const ReferenceView& ref, Span<const Point> points, Index vertex) {
    const Size begin = ref.vertex2corner.begin(vertex);
    const Size size = ref.vertex2corner.size(vertex);
    if (size < 3 || size > kMaxTriangles) return false;
    count = static_cast<int>(size);
    all = (FanMask{1} << count) - 1;
    Index c = to_index(ref.vertex2corner.items[begin]);
    for (int i = 0; i < count; ++i) {
      const Index k = c % 3;
      bit[i] = std::uint64_t{1} << i;
      corner[i] = static_cast<std::uint32_t>(c);
      ring[i] = ref.triangles[c / 3].v[(k + 1) % 3];
      edge.set(i, vec(points[ring[i]]) - x);
      // The reference vertices of the same ids are likely to be near.
      backend::prefetch(&ref.points[ring[i]]);
      const Index opposite = ref.across[c];
      at_feature[i] = opposite == kFeatureEdge;
      if (at_feature[i]) {
        outer.set(i, {});
      } else {
        const Index apex = ref.triangles[opposite / 3].v[opposite % 3];
        backend::prefetch(&ref.points[apex]);
        outer.set(i, vec(points[apex]) - x);
      }
      const Index next = ref.across[c - k + (k + 1) % 3];
      if (next == kFeatureEdge) return false;
      c = next - next % 3 + (next + 1) % 3;
      if (ref.triangles[next / 3].v[c % 3] != vertex) return false;
    }
    return static_cast<std::uint32_t>(c) == corner[0];
  }

  TETUNE_HD bool find_axis() {
    Vec3 sum{};
    for (int i = 0; i < count; ++i) {
      const Vec3 normal = cross(edge[i], edge[after(i)]);
      const double n2 = dot(normal, normal);
      if (!(n2 > 0)) return false;
      unit.set(i, (1 / std::sqrt(n2)) * normal);
      sum = sum + unit[i];
    }
    for (int i = count; i % kLanes != 0; ++i) bit[i] = 0;
    axis = (1 / norm(sum)) * sum;
    double min_cos = 1;
    for (int i = 0; i < count; ++i) {
      const double c = dot(axis, unit[i]);
      min_cos = c < min_cos ? c : min_cos;
    }
    tilt2 = 1 - min_cos * min_cos;
    return min_cos > 0;
  }
};

}  // namespace tetune
