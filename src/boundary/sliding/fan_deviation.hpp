// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/surface_fan.hpp"
#include "boundary/sliding/triangle_deviation.hpp"
#include "mesh/small_set.hpp"

namespace tetune {

/// The test of all triangles of a fan against the bound in one traversal of the reference surface, with bit masks over
/// the triangles. It decides that the bound is exceeded only where a height over a triangle exceeds it, and that it
/// holds only for inputs where the heights of the vertices suffice; all other triangles remain undecided, and
/// TriangleDeviation decides them. A triangle i remains undecided where
///   - a reference triangle over it is not upright, that is, its normal points away from that of triangle i;
///   - a feature edge of the reference crosses its prism, or a vertex at its surface points is no sliding vertex;
///   - a reference vertex is in a wedge beside it;
///   - the surface point of one of its ring vertices is not over it;
///   - more than kMaxTriangles reference triangles or kMaxVertices vertices were found.
template <class Pack>
class FanDeviation : DeviationInput {
 public:
  using Fan = SurfaceFan<Pack>;

  TETUNE_HD FanDeviation(const Fan& fan, const DeviationInput& input, const TriangleDeviation& wedges)
      : DeviationInput(input), fan_(fan), wedges_(wedges) {}

  /// Tests the fan with its vertex on `on`. False: the bound is exceeded. True: it holds except for the triangles in
  /// `undecided`.
  TETUNE_HD bool is_within(const SurfacePoint& on, FanMask& undecided) {
    add_triangles_at(on);
    starts_ = triangles_.size();
    for (int i = 0; i < triangles_.size() && undecided_ != fan_.all; ++i) {
      over_[i] = 0;
      if (!visit(i)) return false;
    }
    if (undecided_ != fan_.all) undecided_ |= not_over_surface_points();
    undecided = undecided_;
    return true;
  }

 private:
  static constexpr int kMaxTriangles = 64;
  static constexpr int kMaxVertices = 64;

  /// The position of a reference vertex relative to the triangles of the fan.
  struct VertexRelation {
    Vec3 d;              ///< from x
    FanMask outside[3];  ///< per barycentric coordinate: outside the prism
    FanMask too_high;    ///< beyond the bound from the plane
    FanMask wedge;       ///< it may be in a wedge beside the triangle
    FanMask covers;      ///< triangles with a part of a reference triangle at this vertex over them
    FanMask behind;      ///< per ring vertex i: it is behind it, and may be in a wedge beside triangles i - 1 and i
  };

  TETUNE_HD void add_triangles_at(const SurfacePoint& on) {
    if (on.kind == SurfacePointKind::triangle) {
      add(on.item, fan_.all);
    } else if (on.kind == SurfacePointKind::edge && ref.across[on.item] != kFeatureEdge) {
      add(on.item / 3, fan_.all);
      add(ref.across[on.item] / 3, fan_.all);
    } else if (on.kind == SurfacePointKind::vertex && ref.dof[on.item] == VertexDof::surface) {
      for (Size c = ref.vertex2corner.begin(on.item); c < ref.vertex2corner.end(on.item); ++c)
        add(to_index(ref.vertex2corner.items[c] / 3), fan_.all);
    } else {
      undecided_ = fan_.all;
    }
  }
  TETUNE_HD void add(Index triangle, FanMask over) {
    backend::prefetch(&ref.across[3 * triangle]);
    if (triangles_.find(triangle) < 0 && triangles_.add(triangle) < 0) undecided_ |= over;
  }

  /// The relation of a reference vertex, computed once; null where the memory is full.
  TETUNE_HD VertexRelation* relation(Index v) {
    return relations_.find_or_make(v, [&](VertexRelation& r) { relate(v, r); });
  }

  /// Compares a reference vertex with all triangles. Each 64-bit word collects up to four masks of 16 bits, at bits 0,
  /// 16, 32 and 48.
  TETUNE_HD void relate(Index v, VertexRelation& r) const {
    const Vec3 d = ref.point(v) - fan_.x;
    using Bits = backend::BitsOf<Pack>;
    using backend::where;
    Bits sides{};
    Bits beside{};
    Bits along_edge{};
    const Pack max_height = Pack{} + limit;
    for (int i = 0; i < fan_.count; i += Fan::kLanes) {
      const auto bit = backend::load<Bits>(fan_.bit + i);
      const Pack la = fan_.slope_a.dots(i, d);
      const Pack lb = fan_.slope_b.dots(i, d);
      const Pack l0 = 1.0 - la - lb;
      const Pack height = fan_.unit.dots(i, d);
      const Pack along = fan_.edge.dots(i, d);
      sides |= where(l0 < kPrismInset, bit) | where(la < kPrismInset, bit << 16) | where(lb < kPrismInset, bit << 32);
      const auto low = where(height <= max_height, bit << 48) & where(height >= -max_height, bit << 48);
      sides |= low ^ (bit << 48);
      const auto beyond_outer =
          where(l0 < 0.0, bit) & where(fan_.inward.dots(i, d) <= backend::load<Pack>(fan_.inward_offset + i), bit);
      beside |= beyond_outer | where(la < 0.0, bit << 16) | where(lb < 0.0, bit << 32);
      along_edge |= where(along > 0.0, bit) | where(along >= backend::load<Pack>(fan_.edge2 + i), bit << 16);
    }
    const FanMask out_a = mask_at(backend::merged(beside), 16);
    const FanMask out_b = mask_at(backend::merged(beside), 32);
    const FanMask beyond_outer = mask_at(backend::merged(beside), 0);
    const FanMask behind = mask_at(backend::merged(along_edge), 16);
    // The edge from x to ring vertex i is between triangles i - 1 and i.
    const FanMask at_edge = fan_.to_next(out_a) & out_b & mask_at(backend::merged(along_edge), 0) & ~behind;
    const std::uint64_t side = backend::merged(sides);
    r.d = d;
    r.covers = 0;
    for (int k = 0; k < 3; ++k) r.outside[k] = mask_at(side, 16 * k);
    r.too_high = mask_at(side, 48);
    r.wedge = (out_a | out_b) == fan_.all ? fan_.all : beyond_outer | at_edge | fan_.to_previous(at_edge);
    r.behind = behind;
    if ((r.wedge | r.behind) != 0 && is_under_ring(v)) r.wedge = r.behind = 0;
  }
  TETUNE_HD FanMask mask_at(std::uint64_t bits, int position) const {
    return static_cast<FanMask>(bits >> position) & fan_.all;
  }
  /// Whether a vertex of the ring is on the reference vertex.
  TETUNE_HD bool is_under_ring(Index v) const {
    for (int i = 0; i < fan_.count; ++i) {
      const SurfacePoint on = surface_points[fan_.ring[i]];
      if (on.kind == SurfacePointKind::vertex && on.item == v) return true;
    }
    return false;
  }

  /// Processes a reference triangle and adds its neighbors. As all are upright over the triangles of the fan, and none
  /// over them has an edge without a neighbor, those triangles are covered. False: the bound is exceeded.
  TETUNE_HD bool visit(int position) {
    const bool is_start = position < starts_;
    const Index triangle = triangles_[position];
    const SurfaceTriangle t = ref.triangles[triangle];
    VertexRelation* corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = relation(t.v[k]);
    if (corner[0] == nullptr || corner[1] == nullptr || corner[2] == nullptr) {
      undecided_ = fan_.all;
      return true;
    }
    if (is_start) undecided_ |= not_upright(corner, fan_.all);
    FanMask over = fan_.all & ~undecided_;
    for (int k = 0; k < 3; ++k) over &= ~(corner[0]->outside[k] & corner[1]->outside[k] & corner[2]->outside[k]);
    if (over == 0) return true;
    if (!is_start) undecided_ |= not_upright(corner, over);
    over_[position] = over;
    for (VertexRelation* r : corner) r->covers |= over;
    const FanMask too_high = over & (corner[0]->too_high | corner[1]->too_high | corner[2]->too_high);
    for (int i = 0; i < fan_.count; ++i) {
      if ((too_high >> i & 1) != 0 && !clipped_is_within(corner, i)) return false;
    }
    VertexRelation* apex[3];
    for (int k = 0; k < 3; ++k) apex[k] = cross_edge(triangle, corner, k, over);
    for (int k = 0; k < 3; ++k) {
      test_wedges(corner[k], over);
      test_wedges(apex[k], over);
    }
    return true;
  }

  /// Adds the neighbor across edge k of a reference triangle where that edge crosses a prism; returns the relation of
  /// its apex, or null.
  TETUNE_HD VertexRelation* cross_edge(Index triangle, VertexRelation* const corner[3], int k, FanMask over) {
    const VertexRelation& a = *corner[(k + 1) % 3];
    const VertexRelation& b = *corner[(k + 2) % 3];
    FanMask crossed = over;
    for (int side = 0; side < 3; ++side) crossed &= ~(a.outside[side] & b.outside[side]);
    const Index opposite = ref.across[3 * triangle + k];
    if (opposite == kFeatureEdge) {
      undecided_ |= crossed;
      return nullptr;
    }
    VertexRelation* const apex = relation(ref.triangles[opposite / 3].v[opposite % 3]);
    if (apex == nullptr) undecided_ |= over;
    if (crossed != 0) add(opposite / 3, crossed);
    return apex;
  }

  TETUNE_HD void test_wedges(VertexRelation* r, FanMask over) {
    if (r == nullptr) return;
    FanMask behind = r->behind & (over | fan_.to_next(over));
    r->behind &= ~behind;
    for (int i = 0; behind != 0; ++i, behind >>= 1) {
      if ((behind & 1) != 0 && !leads_closer(i, r->d)) r->wedge |= (FanMask{1} << i) | (FanMask{1} << fan_.before(i));
    }
    const FanMask candidates = r->wedge & over;
    if (candidates == 0) return;
    for (int i = 0; i < fan_.count; ++i) {
      const FanMask bit = FanMask{1} << i;
      if ((candidates & bit) == 0) continue;
      const PrismPoint p = fan_.prism_point(i, r->d);
      if (wedges_.wedge_of(fan_.corner[i], fan_.x, fan_.x + r->d, p.l) == Wedge::none) {
        r->wedge &= ~bit;
      } else {
        undecided_ |= bit;
      }
    }
  }
  /// Whether an edge at ring vertex i, among those known here, leads closer to x + d.
  TETUNE_HD bool leads_closer(int i, const Vec3& d) const {
    const Vec3 v = fan_.edge[i];
    const Vec3 from = d - v;
    return dot(from, fan_.outer[i] - v) > 0 || dot(from, fan_.outer[fan_.before(i)] - v) > 0 ||
           dot(from, fan_.edge[fan_.after(i)] - v) > 0 || dot(from, fan_.edge[fan_.before(i)] - v) > 0;
  }

  /// Whether the part of a reference triangle over triangle i is within the bound: at its vertices inside the prism,
  /// where its edges cross the sides of the prism, and above the vertices of triangle i.
  TETUNE_HD bool clipped_is_within(VertexRelation* const corner[3], int i) const {
    const PrismPoint p[3] = {fan_.prism_point(i, corner[0]->d), fan_.prism_point(i, corner[1]->d),
                             fan_.prism_point(i, corner[2]->d)};
    // Per vertex of triangle i: its barycentric coordinates in the reference triangle, times twice the area.
    double weight[3][3];
    for (int k = 0; k < 3; ++k) {
      const PrismPoint& a = p[(k + 1) % 3];
      const PrismPoint& b = p[(k + 2) % 3];
      if (!edge_is_within(a, b, kPrismInset, limit)) return false;
      weight[0][k] = a.l[1] * b.l[2] - a.l[2] * b.l[1];
      weight[1][k] = a.l[2] * b.l[0] - a.l[0] * b.l[2];
      weight[2][k] = a.l[0] * b.l[1] - a.l[1] * b.l[0];
    }
    for (int j = 0; j < 3; ++j) {
      // Inset as the sides of the prism are, or rounding could miss a height at both an edge and a vertex.
      double w[3];
      for (int k = 0; k < 3; ++k)
        w[k] = (1 - 3 * kPrismInset) * weight[j][k] + kPrismInset * (weight[0][k] + weight[1][k] + weight[2][k]);
      if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
      const double sum = w[0] * p[0].height + w[1] * p[1].height + w[2] * p[2].height;
      const double max_sum = (w[0] + w[1] + w[2]) * limit;
      if (!(sum <= max_sum && sum >= -max_sum)) return false;
    }
    return true;
  }

  /// The triangles in `over` over which a reference triangle is not upright.
  TETUNE_HD FanMask not_upright(VertexRelation* const corner[3], FanMask over) const {
    const Vec3 normal = cross(corner[1]->d - corner[0]->d, corner[2]->d - corner[0]->d);
    const double up = dot(normal, fan_.axis);
    if (up > 0 && up * up > fan_.tilt2 * dot(normal, normal)) return 0;
    FanMask overturned = 0;
    for (int i = 0; i < fan_.count; ++i) {
      if (!(dot(normal, fan_.unit[i]) > 0)) overturned |= FanMask{1} << i;
    }
    return overturned & over;
  }

  /// The triangles over which the traversal did not find the surface points of their ring vertices.
  TETUNE_HD FanMask not_over_surface_points() const {
    FanMask missing = 0;
    for (int i = 0; i < fan_.count; ++i) {
      const FanMask over = over_surface_point(surface_points[fan_.ring[i]]);
      const FanMask bit = FanMask{1} << i;
      missing |= ~over & (bit | fan_.to_previous(bit));
    }
    return missing;
  }
  TETUNE_HD FanMask over_surface_point(const SurfacePoint& on) const {
    switch (on.kind) {
      case SurfacePointKind::triangle:
        return over_triangle(on.item);
      case SurfacePointKind::edge: {
        const Index opposite = ref.across[on.item];
        return over_triangle(on.item / 3) | (opposite != kFeatureEdge ? over_triangle(opposite / 3) : 0);
      }
      case SurfacePointKind::vertex:
        return over_vertex(on.item);
      case SurfacePointKind::segment:
        return over_vertex(on.item / 2);
      default:
        return 0;
    }
  }
  TETUNE_HD FanMask over_triangle(Index triangle) const {
    const int i = triangles_.find(triangle);
    return i < 0 ? 0 : over_[i];
  }
  TETUNE_HD FanMask over_vertex(Index v) const {
    const VertexRelation* const r = relations_.find(v);
    return r == nullptr ? 0 : r->covers;
  }

  const Fan& fan_;
  const TriangleDeviation& wedges_;
  FanMask undecided_ = 0;
  int starts_ = 0;  ///< number of the triangles at the surface point, which come first
  SmallSet<kMaxTriangles> triangles_;
  FanMask over_[kMaxTriangles];  ///< per visited reference triangle: the triangles it has a part over
  SmallMap<VertexRelation, kMaxVertices> relations_;  ///< by reference vertex
};

}  // namespace tetune
