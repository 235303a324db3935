// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "boundary/sliding/surface_fan.hpp"
#include "boundary/sliding/triangle_deviation.hpp"
#include "mesh/small_set.hpp"

namespace tetune {

/// The test of all triangles of a fan against the bound along one direction, the fan's axis. It proves that the bound
/// holds, or leaves the fan undecided. It takes about half the time of FanDeviation, as there are no wedges within the
/// fan, and decides most fans of smooth surfaces.
///
/// Along the axis both the fan and the reference over it are heights over a plane, and as the vertices of the fan are
/// on the reference, their difference is largest at a corner of a reference triangle clipped to a triangle of the fan.
/// Other tests of this fan's triangles and of their neighbors measure along other directions, at most 20 degrees from
/// the normals. Reference points that are over a triangle along one direction and beside it along the other are within
/// the bound of the edge between if
///   - they are found: the test covers a margin around the fan;
///   - heights over the planes of the triangles, margin included, are at most a fraction of the bound.
template <class Pack>
class AxisDeviation : DeviationInput {
 public:
  using Fan = SurfaceFan<Pack>;

  TETUNE_HD AxisDeviation(const Fan& fan, const DeviationInput& input) : DeviationInput(input), fan_(fan) {}

  /// Whether the fan with its vertex on `on` is proven to be within the bound.
  TETUNE_HD bool is_within(const SurfacePoint& on) {
    if (!find_limits() || !add_triangles_at(on)) return false;
    find_planes();
    for (int i = 0; i < triangles_.size(); ++i) {
      if (!visit(i)) return false;
    }
    for (int i = 0; i < fan_.count; ++i) {
      if (!is_covered(surface_points[fan_.ring[i]])) return false;
    }
    return true;
  }

 private:
  static constexpr int kMaxTriangles = 64;
  static constexpr int kMaxVertices = 64;
  /// The largest angle between the axis and the normals of the fan and of its neighbors: 20 degrees.
  static constexpr double kMinCos = 0.9396926207859084;
  static constexpr double kMaxSin = 0.3420201433256687;

  /// The derivatives of a linear function per triangle, which is 0 at x, along the plane.
  struct Slopes {
    double x[Fan::kMaxTriangles], y[Fan::kMaxTriangles];
    TETUNE_HD void set(int i, double of_x, double of_y) { x[i] = of_x, y[i] = of_y; }
    /// The functions of the triangles from i on at a point.
    template <class P = Pack>
    TETUNE_HD P at(int i, const Vec3& d) const {
      return backend::load<P>(x + i) * d.x + backend::load<P>(y + i) * d.y;
    }
  };
  /// A reference vertex relative to the triangles of the fan.
  struct VertexRelation {
    Vec3 d;              ///< from x, in the frame of the axis
    FanMask outside[3];  ///< per barycentric coordinate: outside the triangle and its margin
    FanMask too_high;    ///< above or below the plane by more than the limit
    bool is_covered;     ///< a corner of a visited triangle
  };

  /// Finds the width of the margin and the limit of the heights. False: a triangle is tilted too much, or the patch
  /// ends at the fan.
  ///
  /// With tilts up to a here and 20 degrees elsewhere, the directions of two tests of an edge differ by at most
  /// p = a + 20 degrees. A reference point between them, at the height z above the edge, is at most z sin p / cos p
  /// beside it and so at the distance z / cos p, which is within the bound D if z <= D cos p. All such points are in
  /// the margin D sin p, where z differs from the height over the plane by at most D sin p tan a.
  TETUNE_HD bool find_limits() {
    double min_cos2 = 1 - fan_.tilt2;
    for (int i = 0; i < fan_.count; ++i) {
      if (fan_.at_feature[i]) return false;
      const Vec3 a = fan_.edge[fan_.after(i)];
      const Vec3 normal = cross(fan_.edge[i] - a, fan_.outer[i] - a);
      const double up = dot(normal, fan_.axis);
      if (!(up > 0)) return false;
      const double cos2 = up * up / dot(normal, normal);
      min_cos2 = cos2 < min_cos2 ? cos2 : min_cos2;
    }
    if (!(min_cos2 >= kMinCos * kMinCos)) return false;
    const double c = std::sqrt(min_cos2 < 1 ? min_cos2 : 1);
    const double s = std::sqrt(1 - c * c);
    margin_ = limit * (s * kMinCos + c * kMaxSin);
    max_height_ = limit * (c * kMinCos - s * kMaxSin) - margin_ * s / c;
    return true;
  }
  TETUNE_HD void find_planes() {
    basis_ = plane_basis(fan_.axis);
    for (int i = 0; i < fan_.count; ++i) {
      const Vec3 a = in_frame(fan_.edge[i]);
      const Vec3 b = in_frame(fan_.edge[fan_.after(i)]);
      const double inverse = 1 / (a.x * b.y - a.y * b.x);
      const double ax = inverse * b.y, ay = -inverse * b.x;
      const double bx = -inverse * a.y, by = inverse * a.x;
      slope_a_.set(i, ax, ay);
      slope_b_.set(i, bx, by);
      rise_.set(i, a.z * ax + b.z * bx, a.z * ay + b.z * by);
      beyond_[i] = -margin_ * std::sqrt((ax + bx) * (ax + bx) + (ay + by) * (ay + by));
    }
    for (int i = fan_.count; i % Fan::kLanes != 0; ++i) {
      for (Slopes* s : {&slope_a_, &slope_b_, &rise_}) s->set(i, 0, 0);
      beyond_[i] = 0;
    }
  }
  /// The components of a vector in the plane and along the axis.
  TETUNE_HD Vec3 in_frame(const Vec3& d) const { return {dot(basis_.u, d), dot(basis_.v, d), dot(fan_.axis, d)}; }

  TETUNE_HD bool add_triangles_at(const SurfacePoint& on) {
    if (on.kind == SurfacePointKind::triangle) return add(on.item);
    if (on.kind == SurfacePointKind::edge) {
      return ref.across[on.item] != kFeatureEdge && add(on.item / 3) && add(ref.across[on.item] / 3);
    }
    if (on.kind != SurfacePointKind::vertex || ref.dof[on.item] != VertexDof::surface) return false;
    for (Size c = ref.vertex2corner.begin(on.item); c < ref.vertex2corner.end(on.item); ++c) {
      if (!add(to_index(ref.vertex2corner.items[c] / 3))) return false;
    }
    return true;
  }
  TETUNE_HD bool add(Index triangle) {
    backend::prefetch(&ref.across[3 * triangle]);
    return triangles_.find(triangle) >= 0 || triangles_.add(triangle) >= 0;
  }

  /// The relation of a reference vertex, computed once; null where the memory is full.
  TETUNE_HD VertexRelation* relation(Index v) {
    return relations_.find_or_make(v, [&](VertexRelation& r) { relate(v, r); });
  }
  TETUNE_HD void relate(Index v, VertexRelation& r) const {
    const Vec3 d = in_frame(ref.point(v) - fan_.x);
    using Bits = backend::BitsOf<Pack>;
    using backend::where;
    Bits sides{};
    const Pack max_height = Pack{} + max_height_;
    for (int i = 0; i < fan_.count; i += Fan::kLanes) {
      const auto bit = backend::load<Bits>(fan_.bit + i);
      const Pack la = slope_a_.at(i, d);
      const Pack lb = slope_b_.at(i, d);
      const Pack l0 = 1.0 - la - lb;
      const Pack height = d.z - rise_.at(i, d);
      sides |= where(l0 < backend::load<Pack>(beyond_ + i), bit) | where(la < kPrismInset, bit << 16) |
               where(lb < kPrismInset, bit << 32) | where(height > max_height, bit << 48) |
               where(height < -max_height, bit << 48);
    }
    const std::uint64_t side = backend::merged(sides);
    r.d = d;
    for (int k = 0; k < 3; ++k) r.outside[k] = FanMask(side >> 16 * k) & fan_.all;
    r.too_high = FanMask(side >> 48) & fan_.all;
    r.is_covered = false;
  }

  /// Tests a reference triangle and adds its neighbors. False: undecided.
  TETUNE_HD bool visit(int position) {
    const Index triangle = triangles_[position];
    const SurfaceTriangle t = ref.triangles[triangle];
    VertexRelation* corner[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = relation(t.v[k]);
      if (corner[k] == nullptr) return false;
    }
    FanMask over = fan_.all;
    for (int k = 0; k < 3; ++k) over &= ~(corner[0]->outside[k] & corner[1]->outside[k] & corner[2]->outside[k]);
    over_[position] = over;
    if (over == 0) return true;
    const Vec3 a = corner[1]->d - corner[0]->d;
    const Vec3 b = corner[2]->d - corner[0]->d;
    if (!(a.x * b.y - a.y * b.x > 0)) return false;
    FanMask too_high = 0;
    for (VertexRelation* r : corner) {
      r->is_covered = true;
      too_high |= over & r->too_high;
    }
    for (int i = 0; too_high != 0; ++i, too_high >>= 1) {
      if ((too_high & 1) != 0 && !clipped_is_within(corner, i)) return false;
    }
    for (int k = 0; k < 3; ++k) {
      const VertexRelation& from = *corner[(k + 1) % 3];
      const VertexRelation& to = *corner[(k + 2) % 3];
      FanMask crossed = over;
      for (int side = 0; side < 3; ++side) crossed &= ~(from.outside[side] & to.outside[side]);
      if (crossed == 0) continue;
      const Index opposite = ref.across[3 * triangle + k];
      if (opposite == kFeatureEdge || !add(opposite / 3)) return false;
    }
    return true;
  }

  /// Whether the parts of the edges of a reference triangle over triangle i and its margin are within the limit.
  TETUNE_HD bool clipped_is_within(VertexRelation* const corner[3], int i) const {
    PrismPoint p[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = corner[k]->d;
      const double la = slope_a_.template at<double>(i, d);
      const double lb = slope_b_.template at<double>(i, d);
      p[k] = {{1 - la - lb - beyond_[i] + kPrismInset, la, lb}, d.z - rise_.template at<double>(i, d)};
    }
    for (int k = 0; k < 3; ++k) {
      if (!edge_is_within(p[(k + 1) % 3], p[(k + 2) % 3], kPrismInset, max_height_)) return false;
    }
    return true;
  }

  /// Whether a surface point of the ring is on a visited triangle.
  TETUNE_HD bool is_covered(const SurfacePoint& on) const {
    switch (on.kind) {
      case SurfacePointKind::triangle:
        return is_over(on.item);
      case SurfacePointKind::edge:
        return is_over(on.item / 3) || (ref.across[on.item] != kFeatureEdge && is_over(ref.across[on.item] / 3));
      case SurfacePointKind::vertex: {
        const VertexRelation* const r = relations_.find(on.item);
        return r != nullptr && r->is_covered;
      }
      default:
        return false;
    }
  }
  TETUNE_HD bool is_over(Index triangle) const {
    const int i = triangles_.find(triangle);
    return i >= 0 && over_[i] != 0;
  }

  const Fan& fan_;
  double margin_;
  double max_height_;
  PlaneBasis basis_;                   ///< of the plane whose normal is the axis
  Slopes slope_a_, slope_b_;           ///< of the barycentric coordinates
  Slopes rise_;                        ///< of the triangle's plane
  double beyond_[Fan::kMaxTriangles];  ///< the coordinate of the vertex, 0 at the edge opposite, at the margin
  SmallSet<kMaxTriangles> triangles_;
  FanMask over_[kMaxTriangles];  ///< per visited reference triangle: the triangles it has a part over
  SmallMap<VertexRelation, kMaxVertices> relations_;  ///< by reference vertex
};

}  // namespace tetune
