// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "tetune/error.hpp"

/// The reference surface: the input surface as it was, on which the boundary vertices slide (Sect. 4.3).
namespace tetune {

/// The kind of element of the reference surface that a point lies in. As wide as an index, so that SurfacePoint has no
/// padding.
enum class SurfacePointKind : std::int32_t {
  none,      ///< not on the surface
  vertex,    ///< item: the reference vertex
  edge,      ///< inside an edge; item: one of its two corners
  triangle,  ///< inside; item: the triangle
  segment,   ///< inside an edge of a feature line; item: 2 * vertex + side, from that vertex to line[vertex].next[side]
};

/// Segments are numbered by Index.
inline void check_sliding_vertices(Size vertices) {
  constexpr Size kMaxVertices = Size{std::numeric_limits<Index>::max()} / 2 + 1;
  if (vertices <= kMaxVertices) return;
  throw MeshError("the mesh has " + std::to_string(vertices) + " vertices; with boundary=slide it can have at most " +
                  std::to_string(kMaxVertices) + ". Use boundary=preserve, or remove vertices of no tetrahedron.");
}

/// The element of the reference surface that a vertex is on; its position is stored elsewhere.
struct SurfacePoint {
  SurfacePointKind kind = SurfacePointKind::none;
  Index item = -1;
};

/// The next vertices along the feature line at a vertex that slides on it.
struct LineVertex {
  Index next[2];
};

struct ReferenceView {
  Span<const Point> points;  ///< the initial positions of the vertices of the mesh
  Span<const SurfaceTriangle> triangles;
  Span<const Index> across;  ///< per corner: the corner on the other side of its edge, or kFeatureEdge
  CsrView vertex2corner;
  Span<const LineVertex> line;  ///< per vertex; meaningful for VertexDof::curve
  Span<const VertexDof> dof;    ///< per vertex

  TETUNE_HD Vec3 point(Index v) const { return vec(points[v]); }
  TETUNE_HD Vec3 centroid(Index triangle) const {
    const SurfaceTriangle& t = triangles[triangle];
    return (1.0 / 3) * (point(t.v[0]) + point(t.v[1]) + point(t.v[2]));
  }
};

/// The checked surface as kernels access it: see DeviationBound.
struct CheckedSurfaceView {
  Span<Point> points;                 ///< per vertex
  Span<SurfacePoint> surface_points;  ///< and their surface points
  Span<std::uint8_t> is_edited;       ///< see CheckedSurface
  Span<Point> edited_points;          ///< see CheckedSurface
};

/// The checked surface in the host's memory.
struct CheckedSurfaceOnHost {
  std::vector<Point> points;
  std::vector<SurfacePoint> surface_points;
  std::vector<std::uint8_t> is_edited;
  std::vector<Point> edited_points;
};

/// The checked surface in a backend's memory. Empty without a bound on the deviation.
template <class Backend>
struct CheckedSurface {
  BufferOf<Backend, Point> points;
  BufferOf<Backend, SurfacePoint> surface_points;
  /// Per vertex: 1 where an operation has changed the triangles of the mesh's surface at it, so that they are no longer
  /// those of the reference surface. The checked position does not change any more. Empty, as the next, where no
  /// operation changes the surface.
  BufferOf<Backend, std::uint8_t> is_edited;
  /// The positions in the edited surface, which has the triangles of the mesh's surface; those in the checked surface
  /// for vertices that are not marked.
  BufferOf<Backend, Point> edited_points;

  void assign(const Backend& backend, const CheckedSurface& from) {
    points.assign(backend, from.points);
    surface_points.assign(backend, from.surface_points);
    is_edited.assign(backend, from.is_edited);
    edited_points.assign(backend, from.edited_points);
  }
  void upload(const Backend& backend, const CheckedSurfaceOnHost& from) {
    points.upload(backend, from.points);
    surface_points.upload(backend, from.surface_points);
    is_edited.upload(backend, from.is_edited);
    edited_points.upload(backend, from.edited_points);
  }
  CheckedSurfaceOnHost download() const {
    return {points.download(), surface_points.download(), is_edited.download(), edited_points.download()};
  }
  CheckedSurfaceView view() { return {points, surface_points, is_edited, edited_points}; }
};

/// The reference surface in the host's memory.
struct ReferenceSurfaceOnHost {
  std::vector<Point> points;
  std::vector<SurfaceTriangle> triangles;
  std::vector<Index> across;
  std::vector<std::uint32_t> offsets, corners;  ///< ReferenceView::vertex2corner
  std::vector<LineVertex> line;
  std::vector<VertexDof> dof;

  /// The corners of triangles at a vertex.
  std::span<const std::uint32_t> corners_at(Index v) const {
    return std::span(corners).subspan(span_of(offsets)[v], span_of(offsets)[v + 1] - span_of(offsets)[v]);
  }
};

/// The reference surface in a backend's memory. Empty unless vertices slide.
template <class Backend>
struct ReferenceSurface {
  template <class T>
  using Buffer = BufferOf<Backend, T>;
  Buffer<Point> points;
  Buffer<SurfaceTriangle> triangles;
  Buffer<Index> across;
  Csr<Backend> vertex2corner;
  Buffer<LineVertex> line;
  Buffer<VertexDof> dof;  ///< where vertices may go, regardless of those that are fixed temporarily

  ReferenceView view() const {
    return {points.span(), triangles.span(), across.span(), vertex2corner.view(), line.span(), dof.span()};
  }
  void upload(const Backend& backend, const ReferenceSurfaceOnHost& from) {
    points.upload(backend, from.points);
    triangles.upload(backend, from.triangles);
    across.upload(backend, from.across);
    vertex2corner.offsets.upload(backend, from.offsets);
    vertex2corner.items.upload(backend, from.corners);
    line.upload(backend, from.line);
    dof.upload(backend, from.dof);
  }
  ReferenceSurfaceOnHost download() const {
    return {points.download(),
            triangles.download(),
            across.download(),
            vertex2corner.offsets.download(),
            vertex2corner.items.download(),
            line.download(),
            dof.download()};
  }
};

}  // namespace tetune
