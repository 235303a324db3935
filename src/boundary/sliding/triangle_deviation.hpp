// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/surface_element.hpp"

namespace tetune {

/// In the corner between a feature line and a triangle both deviations count: each may use this part of the bound.
inline constexpr double kDeviationShare = 0.7;

/// The position of a reference vertex beside the prisms over the triangles of the tested surface.
enum class Wedge {
  none,  ///< in no wedge between two prisms
  near,  ///< in a wedge, within the bound
  far,   ///< in a wedge, beyond the bound
};

/// A point relative to a triangle: the barycentric coordinates of its projection, and its height above the plane.
struct PrismPoint {
  double l[3];
  double height;
};

/// Reference triangles that only touch the boundary of a prism, to within this tolerance, are not over the triangle.
inline constexpr double kPrismInset = 1e-6;

/// Whether the part of a segment (a, b) inside a prism, where all coordinates are at least `inset`, has heights of at
/// most `max_height`.
TETUNE_HD inline bool edge_is_within(const PrismPoint& a, const PrismPoint& b, double inset, double max_height) {
  double from = 0;
  double to = 1;
  for (int side = 0; side < 3; ++side) {
    const double da = a.l[side] - inset;
    const double db = b.l[side] - inset;
    if (da < 0 && db < 0) {
      to = -1;
    } else if (da < 0) {
      const double s = da / (da - db);
      from = s > from ? s : from;
    } else if (db < 0) {
      const double s = da / (da - db);
      to = s < to ? s : to;
    }
  }
  if (from > to) return true;
  const double rise = b.height - a.height;
  const double first = a.height + from * rise;
  const double last = a.height + to * rise;
  return first <= max_height && first >= -max_height && last <= max_height && last >= -max_height;
}

/// A vertex that is to be moved on the surface, and the bound on its deviation.
struct DeviationInput {
  const ReferenceView& ref;
  Span<const Point> points;
  Span<const SurfacePoint> surface_points;
  Index vertex;
  double limit;  ///< 0: no bound
};

/// The test of one surface triangle at a moved vertex against the bound, for any input: the reference triangles are
/// found from the surface points of the triangle's vertices by traversal from neighbor to neighbor within the patch,
/// and clipped to the prism over the triangle. A test that exceeds the fixed memory of a thread counts as beyond the
/// bound.
class TriangleDeviation : DeviationInput {
 public:
  TETUNE_HD explicit TriangleDeviation(const DeviationInput& input) : DeviationInput(input) {}

  /// Whether the triangle at `corner` of the moved vertex is within the bound, with the vertex at x.
  TETUNE_HD TETUNE_OUTLINE bool is_within(std::uint32_t corner, const Vec3& x, const SurfacePoint& on) const {
    const SurfaceTriangle t = ref.triangles[corner / 3];
    const Index va = t.v[(corner + 1) % 3];
    const Index vb = t.v[(corner + 2) % 3];
    const Vec3 a = vec(points[va]) - x;
    const Vec3 b = vec(points[vb]) - x;
    const Vec3 normal = cross(a, b);
    const double n2 = dot(normal, normal);
    if (!(n2 > 0)) return false;
    const Prism prism{x, (1 / n2) * cross(b, normal), (1 / n2) * cross(normal, a), (1 / std::sqrt(n2)) * normal};

    Traversal traversal;
    ReferenceQueue& queue = traversal.queue;
    add_triangles_at(on, queue);
    add_triangles_at(surface_points[va], queue);
    add_triangles_at(surface_points[vb], queue);
    traversal.starts = queue.count;
    for (int i = 0; i < queue.count; ++i) {
      if (!visit(corner, prism, i, traversal)) return false;
    }
    const Coverage& coverage = traversal.coverage;
    const double uncovered = (1 - coverage.area) * std::sqrt(n2);
    if (uncovered <= kMaxUncovered * std::sqrt(n2)) return true;
    // Beside a feature line the triangle may extend beyond the patch by the area between the line and its chord.
    double beside_line = 0;
    if (!is_within_sheet(vertex) && !is_within_sheet(va)) beside_line += norm(a);
    if (!is_within_sheet(vertex) && !is_within_sheet(vb)) beside_line += norm(b);
    if (!is_within_sheet(va) && !is_within_sheet(vb)) beside_line += norm(b - a);
    return coverage.max_height <= kDeviationShare * limit && uncovered <= 2 * limit * beside_line;
  }

  /// Tests a reference vertex p outside the prism over the triangle at `corner`, where l are its coordinates from the
  /// corner's vertex on: whether p is in the wedge at an edge or vertex of the triangle, which no prism covers, and
  /// within the bound there.
  TETUNE_HD Wedge wedge_of(std::uint32_t corner, const Vec3& x, const Vec3& p, const double l[3]) const {
    const SurfaceTriangle t = ref.triangles[corner / 3];
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t k = (corner + side) % 3;
      const Vec3 a = position(t.v[(k + 1) % 3], x);
      const Vec3 e = position(t.v[(k + 2) % 3], x) - a;
      const Vec3 d = p - a;
      const double e2 = dot(e, e);
      const double s = dot(d, e) / e2;
      if (l[side] < 0 && s > 0 && s < 1) {
        const Index opposite = ref.across[Size{corner / 3} * 3 + k];
        // At a feature line the patch ends, and LineDeviation decides.
        if (opposite == kFeatureEdge) continue;
        const Vec3 apex = position(ref.triangles[opposite / 3].v[opposite % 3], x) - a;
        if (dot(d, apex - (dot(apex, e) / e2) * e) > 0) continue;
        return compare(d - s * e);
      }
      // The closest point is the vertex a unless one of its edges leads closer to p.
      if (s > 0 || dot(d, position(t.v[k], x) - a) > 0) continue;
      bool closer = false;
      const Index v = t.v[(k + 1) % 3];
      for (Size c = ref.vertex2corner.begin(v); c < ref.vertex2corner.end(v) && !closer; ++c) {
        const std::uint32_t o = ref.vertex2corner.items[c];
        const SurfaceTriangle q = ref.triangles[o / 3];
        closer = dot(d, position(q.v[(o + 1) % 3], x) - a) > 0 || dot(d, position(q.v[(o + 2) % 3], x) - a) > 0;
      }
      if (!closer) return compare(d);
    }
    return Wedge::none;
  }

 private:
  static constexpr int kMaxTriangles = 96;
  static constexpr Index kNone = -1;
  /// The part of a triangle that may extend beyond the patch.
  static constexpr double kMaxUncovered = 1e-3;
  static constexpr int kMaxPolygon = 9;

  /// The prism over a triangle of the tested surface with a vertex at `origin`.
  struct Prism {
    Vec3 origin, slope_a, slope_b, unit;
    TETUNE_HD PrismPoint point(const Vec3& p) const {
      const Vec3 d = p - origin;
      const double la = dot(slope_a, d);
      const double lb = dot(slope_b, d);
      return {{1 - la - lb, la, lb}, dot(unit, d)};
    }
  };

  /// The reference triangles found so far, in the order of traversal.
  struct ReferenceQueue {
    Index triangle[kMaxTriangles];
    bool relevant[kMaxTriangles];  ///< per visited triangle: it is over the surface triangle, or in a wedge beside it
    int count = 0;
    bool overflow = false;
    TETUNE_HD void add(Index t) {
      for (int i = 0; i < count; ++i) {
        if (triangle[i] == t) return;
      }
      if (count == kMaxTriangles) {
        overflow = true;
      } else {
        triangle[count++] = t;
      }
    }
  };

  /// The results of wedge_of() by reference vertex.
  struct WedgeCache {
    Index vertex[kMaxTriangles];
    Wedge wedge[kMaxTriangles];
    int count = 0;
    /// The position of a vertex: `count` where it is not stored.
    TETUNE_HD int find(Index v) const {
      int i = 0;
      while (i < count && vertex[i] != v) ++i;
      return i;
    }
  };

  /// The part of the triangle that visited reference triangles cover, and their largest height.
  struct Coverage {
    double area = 0;
    double max_height = 0;
  };

  /// The state of a traversal of the reference surface.
  struct Traversal {
    ReferenceQueue queue;
    int starts = 0;  ///< the number of triangles at the starting points, which come first in the queue
    WedgeCache wedges;
    Coverage coverage;
  };

  TETUNE_HD void add_triangles_at(const SurfacePoint& on, ReferenceQueue& queue) const {
    if (on.kind == SurfacePointKind::triangle) {
      queue.add(on.item);
    } else if (on.kind == SurfacePointKind::edge) {
      queue.add(on.item / 3);
      if (ref.across[on.item] != kFeatureEdge) queue.add(ref.across[on.item] / 3);
    } else if (on.kind == SurfacePointKind::vertex || on.kind == SurfacePointKind::segment) {
      const bool on_vertex = on.kind == SurfacePointKind::vertex;
      const EdgeVertices edge = on_vertex ? EdgeVertices{on.item, on.item} : edge_vertices(ref, on);
      const Index from = ref.vertex2corner.shorter(edge.a, edge.b);
      const Index to = edge.a ^ edge.b ^ from;
      for (Size c = ref.vertex2corner.begin(from); c < ref.vertex2corner.end(from); ++c) {
        const Index triangle = to_index(ref.vertex2corner.items[c] / 3);
        const SurfaceTriangle t = ref.triangles[triangle];
        if (t.v[0] == to || t.v[1] == to || t.v[2] == to) queue.add(triangle);
      }
    }
  }

  /// Processes reference triangle i of the queue and adds its neighbors. Returns false where the bound, or the memory
  /// for the traversal, is exceeded.
  TETUNE_HD bool visit(std::uint32_t corner, const Prism& prism, int i, Traversal& traversal) const {
    ReferenceQueue& queue = traversal.queue;
    WedgeCache& wedges = traversal.wedges;
    PrismPoint polygon[kMaxPolygon];
    PrismPoint corners[3];
    int n = 3;
    const SurfaceTriangle r = ref.triangles[queue.triangle[i]];
    for (int k = 0; k < 3; ++k) polygon[k] = corners[k] = prism.point(ref.point(r.v[k]));
    for (int side = 0; side < 3 && n > 0; ++side) n = clip(polygon, n, side);
    queue.relevant[i] = false;
    // Triangles at the starting points may belong to other patches; those of this patch may be reached again later.
    if (n < 3 && i < traversal.starts && !is_beside_relevant(queue, i)) {
      queue.triangle[i] = kNone;
      return true;
    }
    bool in_wedge = false;
    for (int k = 0; k < 3; ++k) {
      const double* l = corners[k].l;
      if (l[0] >= 0 && l[1] >= 0 && l[2] >= 0) continue;
      const int entry = wedges.find(r.v[k]);
      if (entry == kMaxTriangles) return false;
      if (entry == wedges.count) {
        wedges.vertex[wedges.count] = r.v[k];
        wedges.wedge[wedges.count++] = wedge_of(corner, prism.origin, ref.point(r.v[k]), l);
      }
      if (wedges.wedge[entry] == Wedge::far) return false;
      in_wedge = in_wedge || wedges.wedge[entry] == Wedge::near;
    }
    if (n < 3 && !in_wedge) return true;
    queue.relevant[i] = true;
    if (!add_coverage(polygon, n, traversal.coverage)) return false;
    for (Index k = 0; k < 3; ++k) {
      const Index opposite = ref.across[3 * queue.triangle[i] + k];
      if (opposite != kFeatureEdge) queue.add(opposite / 3);
    }
    return !queue.overflow;
  }

  /// Whether one of the first i triangles of the queue is relevant and a neighbor of triangle i within the patch.
  TETUNE_HD bool is_beside_relevant(const ReferenceQueue& queue, int i) const {
    for (Index k = 0; k < 3; ++k) {
      const Index opposite = ref.across[3 * queue.triangle[i] + k];
      for (int j = 0; opposite != kFeatureEdge && j < i; ++j) {
        if (queue.triangle[j] == opposite / 3 && queue.relevant[j]) return true;
      }
    }
    return false;
  }

  /// Adds a clipped reference triangle. False: one of its heights exceeds the bound.
  TETUNE_HD bool add_coverage(const PrismPoint* polygon, int n, Coverage& coverage) const {
    double twice_area = 0;
    for (int k = 0; k < n; ++k) {
      const double height = std::fabs(polygon[k].height);
      if (!(height <= limit)) return false;
      coverage.max_height = height > coverage.max_height ? height : coverage.max_height;
      const PrismPoint& p = polygon[k];
      const PrismPoint& q = polygon[(k + 1) % n];
      twice_area += p.l[1] * q.l[2] - p.l[2] * q.l[1];
    }
    coverage.area += std::fabs(twice_area);
    return true;
  }

  /// Clips a polygon at one coordinate (Sutherland & Hodgman); returns the number of corners left.
  TETUNE_HD static int clip(PrismPoint* polygon, int n, int side) {
    PrismPoint clipped[kMaxPolygon];
    int m = 0;
    for (int k = 0; k < n; ++k) {
      const PrismPoint& p = polygon[k];
      const PrismPoint& q = polygon[(k + 1) % n];
      const double dp = p.l[side] - kPrismInset;
      const double dq = q.l[side] - kPrismInset;
      if (dp >= 0) clipped[m++] = p;
      if ((dp < 0) == (dq < 0)) continue;
      const double s = dp / (dp - dq);
      PrismPoint cut;
      for (int j = 0; j < 3; ++j) cut.l[j] = p.l[j] + s * (q.l[j] - p.l[j]);
      cut.height = p.height + s * (q.height - p.height);
      clipped[m++] = cut;
    }
    for (int k = 0; k < m; ++k) polygon[k] = clipped[k];
    return m;
  }

  TETUNE_HD Vec3 position(Index v, const Vec3& x) const { return v == vertex ? x : vec(points[v]); }
  TETUNE_HD Wedge compare(const Vec3& d) const { return dot(d, d) <= limit * limit ? Wedge::near : Wedge::far; }
  TETUNE_HD bool is_within_sheet(Index v) const { return ref.dof[v] == VertexDof::surface; }
};

}  // namespace tetune
