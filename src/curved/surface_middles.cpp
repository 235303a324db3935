// SPDX-License-Identifier: Apache-2.0
#include "curved/surface_middles.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "backend/span.hpp"
#include "curved/finer_surface.hpp"
#include "curved/vertex_normal.hpp"
#include "math/elementary.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"

namespace tetune {
namespace {

/// Distances below this part of an edge count as zero.
constexpr double kNegligible = 1e-6;
/// A mid-side node farther from the midpoint than this part of the edge is not plausible.
constexpr double kMaxOffset = 0.25;

using Edge = std::array<Index, 2>;
/// Sheets::across() of a corner whose edge is a feature.
constexpr Index kFeature = -1;

Vec3 unit(const Vec3& v) { return (1 / norm(v)) * v; }

/// Divides a surface into sheets, and finds the mid-side nodes of its edges. Corner k of a triangle is 3 * triangle +
/// k; the edge of a corner is the one opposite it.
class Sheets {
 public:
  Sheets(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles, const std::vector<Edge>& lines,
         double feature_angle)
      : points_(points), triangles_(triangles), cos_angle_(elementary::cos(feature_angle * std::numbers::pi / 180)) {
    for (Index t = 0; t < std::ssize(triangles); ++t) {
      for (Index k = 0; k < 3; ++k) edge2corners_[edge_of(3 * t + k)].push_back(3 * t + k);
    }
    find_features(lines);
  }

  SurfaceParts parts() const {
    SurfaceParts parts;
    parts.triangle2sheet.assign(triangles_.size(), -1);
    for (Index first = 0; first < std::ssize(triangles_); ++first) {
      if (span_of(parts.triangle2sheet)[first] >= 0) continue;
      std::vector<Index> sheet{first};
      span_of(parts.triangle2sheet)[first] = parts.sheets;
      for (std::size_t i = 0; i < sheet.size(); ++i) {
        for (Index corner = 3 * sheet[i]; corner < 3 * sheet[i] + 3; ++corner) {
          const Index other = across(corner);
          if (other == kFeature || span_of(parts.triangle2sheet)[other / 3] >= 0) continue;
          span_of(parts.triangle2sheet)[other / 3] = parts.sheets;
          sheet.push_back(other / 3);
        }
      }
      ++parts.sheets;
    }
    for (const auto& [edge, corners] : edge2corners_) {
      if (across(corners[0]) == kFeature) parts.features.push_back(edge);
    }
    return parts;
  }

  std::vector<CurvedEdge> curved(const FinerSurface* finer) {
    find_normals();
    find_flat_parts();
    std::vector<CurvedEdge> result;
    for (const auto& [edge, corners] : edge2corners_) {
      const bool is_feature = across(corners[0]) == kFeature;
      const Vec3 p = at(edge[0]);
      const Vec3 q = at(edge[1]);
      const double length = norm(q - p);
      const auto is_plausible = [length](const Vec3& v) { return norm(v) <= kMaxOffset * length; };
      Vec3 offset = is_feature ? offset_on_line(edge, corners) : offset_in_sheet(edge, corners);
      if (!is_plausible(offset)) offset = {0, 0, 0};
      if (finer != nullptr) {
        const Vec3 middle = 0.5 * (p + q);
        std::optional<Vec3> found;
        if (is_feature) found = finer->point_on_lines(p, q, middle + offset);
        if (!found || !is_plausible(*found - middle)) found = finer->point_near(p, q, middle + offset);
        if (is_plausible(*found - middle)) offset = *found - middle;
      }
      if (!(norm(offset) > kNegligible * length)) continue;
      const Vec3 middle = 0.5 * (p + q) + offset;
      result.push_back({edge, to_point(middle)});
    }
    return result;
  }

 private:
  Vec3 at(Index v) const { return vec(span_of(points_)[v]); }
  Index vertex(Index corner) const { return span_of(triangles_)[corner / 3].vertices[to_size_t(corner % 3)]; }
  static Index next(Index corner) { return corner - corner % 3 + (corner + 1) % 3; }
  Edge edge_of(Index corner) const { return ascending(vertex(next(corner)), vertex(next(next(corner)))); }
  /// The corner with the same edge in the other triangle, or kFeature.
  Index across(Index corner) const { return span_of(across_)[corner]; }
  bool is_flat(Index triangle) const { return span_of(flat_)[triangle] != 0; }
  Vec3 area_vector(Index t) const {
    return cross(at(vertex(3 * t + 1)) - at(vertex(3 * t)), at(vertex(3 * t + 2)) - at(vertex(3 * t)));
  }
  /// The unit vector in the triangle of a corner from its edge to the corner.
  Vec3 from_edge(Index corner) const {
    const Vec3 a = at(vertex(next(corner)));
    const Vec3 along = at(vertex(next(next(corner)))) - a;
    const Vec3 d = at(vertex(corner)) - a;
    return unit(d - (dot(d, along) / dot(along, along)) * along);
  }

  void find_features(const std::vector<Edge>& lines) {
    across_.assign(3 * triangles_.size(), kFeature);
    for (const auto& [edge, corners] : edge2corners_) {
      const bool is_line = std::binary_search(lines.begin(), lines.end(), edge);
      const bool joins = corners.size() == 2 && !is_line &&
                         span_of(triangles_)[corners[0] / 3].sides == span_of(triangles_)[corners[1] / 3].sides &&
                         -dot(from_edge(corners[0]), from_edge(corners[1])) >= cos_angle_;
      if (joins) {
        span_of(across_)[corners[0]] = corners[1];
        span_of(across_)[corners[1]] = corners[0];
      } else {
        line_ends_[edge[0]].push_back(edge[1]);
        line_ends_[edge[1]].push_back(edge[0]);
      }
    }
  }

  /// The sector of a corner: the corners at its vertex that can be reached across edges that are no features. Marks
  /// them in `is_done`.
  std::vector<Index> sector(Index corner, std::vector<std::uint8_t>& is_done) const {
    std::vector<Index> corners{corner};
    span_of(is_done)[corner] = 1;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (const Index side : {next(corners[i]), next(next(corners[i]))}) {
        const Index other = across(side);
        if (other == kFeature) continue;
        const Index first = next(other);
        const Index found = vertex(first) == vertex(corner) ? first : next(first);
        if (std::exchange(span_of(is_done)[found], std::uint8_t{1}) == 0) corners.push_back(found);
      }
    }
    return corners;
  }

  void find_normals() {
    normals_.assign(3 * triangles_.size(), Vec3{0, 0, 0});
    flat_sectors_.assign(3 * triangles_.size(), 0);
    std::vector<std::uint8_t> is_done(3 * triangles_.size(), 0);
    std::vector<std::uint8_t> is_around(triangles_.size(), 0);
    for (Index corner = 0; corner < std::ssize(is_done); ++corner) {
      if (span_of(is_done)[corner] != 0) continue;
      const std::vector<Index> corners = sector(corner, is_done);
      const Vec3 rough = rough_normal(corners);
      const Vec3 normal = norm(rough) > 0 ? fit_normal(points_around(corners, is_around), unit(rough)) : rough;
      const bool is_inner = has_no_feature(corners) && lies_in_plane(corners, rough);
      for (const Index c : corners) {
        span_of(normals_)[c] = normal;
        span_of(flat_sectors_)[c] = is_inner ? 1 : 0;
      }
    }
  }

  /// The sum of the normals with the weights of Max (1999), exact for a sphere.
  Vec3 rough_normal(const std::vector<Index>& corners) const {
    Vec3 sum{0, 0, 0};
    for (const Index c : corners) {
      const Vec3 a = at(vertex(next(c))) - at(vertex(c));
      const Vec3 b = at(vertex(next(next(c)))) - at(vertex(c));
      const Vec3 n = (1 / (dot(a, a) * dot(b, b))) * cross(a, b);
      sum = sum + (dot(n, sum) < 0 ? -1.0 : 1.0) * n;
    }
    return sum;
  }

  /// The vertices of a sector and of two more rows of triangles of its sheet, relative to its vertex. `is_around`: 0
  /// per triangle, before and after.
  std::vector<Vec3> points_around(const std::vector<Index>& corners, std::vector<std::uint8_t>& is_around) const {
    std::vector<Index> triangles;
    const auto add = [&](Index t) {
      if (std::exchange(span_of(is_around)[t], std::uint8_t{1}) == 0) triangles.push_back(t);
    };
    for (const Index c : corners) add(c / 3);
    for (std::size_t begin = 0, row = 0; row < 2; ++row) {
      const std::size_t end = triangles.size();
      for (std::size_t i = begin; i < end; ++i) {
        for (Index k = 0; k < 3; ++k) {
          const Index other = across(3 * triangles[i] + k);
          if (other != kFeature) add(other / 3);
        }
      }
      begin = end;
    }
    std::vector<Index> vertices;
    for (const Index t : triangles) {
      span_of(is_around)[t] = 0;
      for (const Index v : span_of(triangles_)[t].vertices) vertices.push_back(v);
    }
    sort_unique(vertices);
    std::vector<Vec3> around;
    const Index center = vertex(corners[0]);
    for (const Index v : vertices) {
      if (v != center) around.push_back(at(v) - at(center));
    }
    return around;
  }

  bool has_no_feature(const std::vector<Index>& corners) const {
    return std::all_of(corners.begin(), corners.end(),
                       [this](Index c) { return across(next(c)) != kFeature && across(next(next(c))) != kFeature; });
  }
  bool lies_in_plane(const std::vector<Index>& corners, const Vec3& normal) const {
    return std::all_of(corners.begin(), corners.end(), [&](Index c) {
      const Vec3 d = at(vertex(next(c))) - at(vertex(c));
      const Vec3 e = at(vertex(next(next(c)))) - at(vertex(c));
      return std::fabs(dot(d, normal)) <= kNegligible * norm(d) * norm(normal) &&
             std::fabs(dot(e, normal)) <= kNegligible * norm(e) * norm(normal);
    });
  }

  /// Marks the triangles of connected coplanar parts that have an inner vertex, or that features alone bound: a facet
  /// of a curved surface has neither.
  void find_flat_parts() {
    flat_.assign(triangles_.size(), 0);
    std::vector<std::uint8_t> is_done(triangles_.size(), 0);
    for (Index first = 0; first < std::ssize(triangles_); ++first) {
      if (std::exchange(span_of(is_done)[first], std::uint8_t{1}) != 0) continue;
      std::vector<Index> part{first};
      bool has_inner = false;
      bool is_bounded = true;
      for (std::size_t i = 0; i < part.size(); ++i) {
        for (Index corner = 3 * part[i]; corner < 3 * part[i] + 3; ++corner) {
          has_inner = has_inner || span_of(flat_sectors_)[corner] != 0;
          const Index other = across(corner);
          if (other == kFeature) continue;
          const Vec3 n = area_vector(part[i]);
          const Vec3 d = at(vertex(other)) - at(vertex(next(corner)));
          if (!(std::fabs(dot(d, n)) <= kNegligible * norm(d) * norm(n))) {
            is_bounded = false;
          } else if (std::exchange(span_of(is_done)[other / 3], std::uint8_t{1}) == 0) {
            part.push_back(other / 3);
          }
        }
      }
      for (const Index t : part) span_of(flat_)[t] = has_inner || is_bounded ? 1 : 0;
    }
  }

  /// The normal of the sheet of a corner's edge at one of its ends.
  const Vec3& normal_at(Index corner, Index v) const {
    return span_of(normals_)[vertex(next(corner)) == v ? next(corner) : next(next(corner))];
  }

  Vec3 offset_in_sheet(const Edge& edge, const std::vector<Index>& corners) const {
    if (is_flat(corners[0] / 3) || is_flat(corners[1] / 3)) return {0, 0, 0};
    return offset_on_sheet(edge, corners[0]);
  }

  /// The vector from the midpoint of an edge to the middle of the cubic that leaves both ends in their tangent planes
  /// (the edge curve of PN triangles: Vlachos et al. 2001).
  Vec3 offset_on_sheet(const Edge& edge, Index corner) const {
    const Vec3 d = at(edge[1]) - at(edge[0]);
    const Vec3& n = normal_at(corner, edge[0]);
    const Vec3& m = normal_at(corner, edge[1]);
    return 0.125 * (dot(d, m) * m - dot(d, n) * n);
  }

  /// The next vertex of the feature line that comes from `from` to `v`, unless it ends or turns there.
  std::optional<Index> continue_line(Index from, Index v) const {
    const std::vector<Index>& ends = line_ends_.at(v);
    if (ends.size() != 2) return {};
    const Index to = ends[0] == from ? ends[1] : ends[0];
    const bool turns = dot(unit(at(v) - at(from)), unit(at(to) - at(v))) < cos_angle_;
    return turns ? std::optional<Index>() : to;
  }

  /// The vector from the midpoint of an edge of a feature line to the point of the polynomial through its vertices and
  /// those before and behind it, over the length of the chords. For an edge without such vertices it is the shortest
  /// one with the offsets of both sheets along their normals.
  Vec3 offset_on_line(const Edge& edge, const std::vector<Index>& corners) const {
    const Vec3 p = at(edge[0]);
    const Vec3 q = at(edge[1]);
    const double length = norm(q - p);
    std::vector<std::pair<double, Vec3>> knots{{-0.5, p}, {0.5, q}};
    if (const auto before = continue_line(edge[1], edge[0]))
      knots.emplace_back(-0.5 - norm(at(*before) - p) / length, at(*before));
    if (const auto behind = continue_line(edge[0], edge[1]))
      knots.emplace_back(0.5 + norm(at(*behind) - q) / length, at(*behind));
    if (knots.size() == 2) return offset_on_sheets(edge, corners);
    const Vec3 middle = 0.5 * (p + q);
    Vec3 offset{0, 0, 0};
    for (const auto& [s, x] : knots) {
      double weight = 1;
      for (const auto& [r, other] : knots) weight *= r == s ? 1 : r / (r - s);
      offset = offset + weight * (x - middle);
    }
    return offset;
  }

  Vec3 offset_on_sheets(const Edge& edge, const std::vector<Index>& corners) const {
    if (corners.size() != 2) return {0, 0, 0};
    std::array<Vec3, 2> normal{};
    std::array<double, 2> height{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3& n = normal_at(corners[k], edge[0]);
      const Vec3& m = normal_at(corners[k], edge[1]);
      normal[k] = unit(n + (dot(n, m) < 0 ? -1.0 : 1.0) * m);
      height[k] = is_flat(corners[k] / 3) ? 0 : dot(offset_on_sheet(edge, corners[k]), normal[k]);
    }
    // The smallest x with normal . x = height for both. Its determinant is the squared sine of the angle between the
    // normals, which must be at least about 6 degrees.
    constexpr double kMinDeterminant = 0.01;
    const double c = dot(normal[0], normal[1]);
    const double determinant = 1 - c * c;
    if (!(determinant > kMinDeterminant)) return {0, 0, 0};
    return ((height[0] - c * height[1]) / determinant) * normal[0] +
           ((height[1] - c * height[0]) / determinant) * normal[1];
  }

  const std::vector<Point3>& points_;
  const std::vector<SheetTriangle>& triangles_;
  double cos_angle_;
  std::map<Edge, std::vector<Index>> edge2corners_;
  std::map<Index, std::vector<Index>> line_ends_;
  std::vector<Index> across_;
  std::vector<Vec3> normals_;               ///< per corner
  std::vector<std::uint8_t> flat_sectors_;  ///< per corner: an inner vertex whose triangles are coplanar
  std::vector<std::uint8_t> flat_;          ///< per triangle
};

}  // namespace

std::vector<CurvedEdge> find_surface_middles(const std::vector<Point3>& points,
                                             const std::vector<SheetTriangle>& triangles,
                                             const std::vector<std::array<Index, 2>>& lines, double feature_angle,
                                             const FinerSurface* finer) {
  return Sheets(points, triangles, lines, feature_angle).curved(finer);
}

SurfaceParts find_surface_parts(const std::vector<Point3>& points, const std::vector<SheetTriangle>& triangles,
                                const std::vector<std::array<Index, 2>>& lines, double feature_angle) {
  return Sheets(points, triangles, lines, feature_angle).parts();
}

}  // namespace tetune
