// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/motion.hpp"
#include "core/rows.hpp"

/// The input surface, kept as it was: what the boundary vertices slide on (Sect. 4.3). Its corners are numbered
/// 3 * triangle + k; the edge of a corner is the one opposite it.
namespace tetune {

/// Where a sliding vertex is on the reference surface.
enum class SiteKind : std::uint8_t {
  none,      ///< not on it
  vertex,    ///< item: the reference vertex
  edge,      ///< between the ends of an edge; item: one of its two corners
  triangle,  ///< inside; item: the triangle
  segment,   ///< between two vertices of a feature line; item: 2 * vertex + way, from that vertex to
             ///< line[vertex].next[way]
};

struct Site {
  SiteKind kind = SiteKind::none;
  Index item = -1;
};

struct SurfaceTriangle {
  Index v[3];
};

/// The next vertices along the feature line at a vertex that slides on it.
struct LineVertex {
  Index next[2];
};

/// No way across an edge: it is a feature.
inline constexpr Index kWall = -1;

struct ReferenceView {
  Span<const Point> points;  ///< where the vertices of the mesh were at the start
  Span<const SurfaceTriangle> triangles;
  Span<const Index> across;  ///< for each corner the one on the other side of its edge, or kWall
  RowsView vertex2corner;
  Span<const LineVertex> line;  ///< for each vertex; meaningful for Mobility::curve
  Span<const Mobility> kind;    ///< of each vertex

  TETUNE_HD Vec3 point(Index v) const { return vec(points[v]); }
};

/// Owns the reference surface, in a backend's memory. Empty unless vertices slide.
template <class Backend>
struct ReferenceSurface {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  Buffer<Point> points;
  Buffer<SurfaceTriangle> triangles;
  Buffer<Index> across;
  Rows<Backend> vertex2corner;
  Buffer<LineVertex> line;
  Buffer<Mobility> kind;  ///< where vertices may go, those aside that are held where they are for now

  ReferenceView view() const {
    return {points.span(), triangles.span(), across.span(), vertex2corner.view(), line.span(), kind.span()};
  }
};

}  // namespace tetune
