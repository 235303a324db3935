// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "boundary/classify.hpp"
#include "boundary/sliding/slide_surface.hpp"
#include "boundary/sliding/surface_element.hpp"
#include "boundary/vertex_dofs.hpp"

namespace tetune {
namespace slide_surface_detail {

/// The vertices of the surface element that a vertex is on; unused entries are -1.
using ElementVertices = SurfaceTriangle;

struct JoinTriangles {
  Span<const SurfaceTriangle> triangles;
  CsrView vertex2corner;
  Span<const std::uint8_t> feature_edges;
  Span<Index> across;
  TETUNE_HD void operator()(Size corner) const {
    const Index opposite = is_feature(corner) ? kFeatureEdge : opposite_corner(triangles, vertex2corner, corner);
    across[corner] = opposite != kFeatureEdge && is_feature(opposite) ? kFeatureEdge : opposite;
  }

 private:
  TETUNE_HD bool is_feature(Size corner) const { return (feature_edges[corner / 3] >> corner % 3 & 1) != 0; }
};

/// Finds the surface points of vertices from the vertices of the surface elements that they are on.
struct FindSurfacePoint {
  ReferenceView reference;
  Span<const ElementVertices> on;
  Span<SurfacePoint> surface_point;

  TETUNE_HD void operator()(Size v) const { surface_point[v] = find(reference.dof[v], on[v]); }

 private:
  TETUNE_HD SurfacePoint find(VertexDof on_reference, const ElementVertices& s) const {
    const Index a = s.v[0];
    if (a < 0) return {};
    if (s.v[1] < 0) {
      return reference.dof[a] == on_reference ? SurfacePoint{SurfacePointKind::vertex, a} : SurfacePoint{};
    }
    if (on_reference == VertexDof::curve) return s.v[2] < 0 ? segment(a, s.v[1]) : SurfacePoint{};
    const Index from = reference.vertex2corner.shorter(a, s.v[1]);
    const Index to = a ^ s.v[1] ^ from;
    for (Size c = reference.vertex2corner.begin(from); c < reference.vertex2corner.end(from); ++c) {
      const Index corner = to_index(reference.vertex2corner.items[c]);
      const SurfaceTriangle t = reference.triangles[corner / 3];
      const int b = position(t, to);
      if (b < 0) continue;
      if (s.v[2] >= 0) {
        if (position(t, s.v[2]) >= 0) return {SurfacePointKind::triangle, corner / 3};
      } else {
        const Index opposite = corner / 3 * 3 + 3 - corner % 3 - b;
        return reference.across[opposite] == kFeatureEdge ? SurfacePoint{}
                                                          : SurfacePoint{SurfacePointKind::edge, opposite};
      }
    }
    return {};
  }
  TETUNE_HD static int position(const SurfaceTriangle& t, Index v) {
    return t.v[0] == v ? 0 : t.v[1] == v ? 1 : t.v[2] == v ? 2 : -1;
  }
  TETUNE_HD SurfacePoint segment(Index a, Index b) const {
    for (const Index from : {a, b}) {
      for (Index side = 0; side < 2 && reference.dof[from] == VertexDof::curve; ++side) {
        if (reference.line[from].next[side] == (a ^ b ^ from)) return {SurfacePointKind::segment, 2 * from + side};
      }
    }
    return {};
  }
};

/// Lets each vertex go where the reference says; one that is not on it is fixed.
struct FindDofOnReference {
  ReferenceView reference;
  Span<const SurfacePoint> surface_point;
  Span<const VertexConstraint> constraints;
  Span<VertexDof> dof;

  TETUNE_HD void operator()(Size v) const {
    const VertexDof on_reference = reference.dof[v];
    const bool off_surface = surface_point[v].kind == SurfacePointKind::none && on_reference != VertexDof::free;
    dof[v] = off_surface || constraints[v] == VertexConstraint::frozen ? VertexDof::fixed : on_reference;
  }
};

struct ExportSurfacePoint {
  ReferenceView reference;
  Span<const SurfacePoint> surface_point;
  Span<ElementVertices> on;
  TETUNE_HD void operator()(Size v) const {
    const SurfacePoint p = surface_point[v];
    ElementVertices s{{-1, -1, -1}};
    if (p.kind == SurfacePointKind::triangle) {
      s = reference.triangles[p.item];
    } else if (p.kind == SurfacePointKind::vertex) {
      s.v[0] = p.item;
    } else if (p.kind != SurfacePointKind::none) {
      const EdgeVertices edge = edge_vertices(reference, p);
      s.v[0] = edge.a;
      s.v[1] = edge.b;
    }
    on[v] = s;
  }
};

/// Renumbers vertices; -1 remains.
struct VertexMap {
  Span<const Index> from2to;
  Index operator()(Index v) const { return v < 0 ? v : from2to[v]; }
  std::array<Index, 3> operator()(const SurfaceTriangle& t) const {
    return {(*this)(t.v[0]), (*this)(t.v[1]), (*this)(t.v[2])};
  }
  SurfaceTriangle operator()(const std::array<Index, 3>& v) const {
    return {{(*this)(v[0]), (*this)(v[1]), (*this)(v[2])}};
  }
};

/// Uploads the positions of vertices to the work mesh.
template <class Backend>
void upload_points(const Backend& backend, const std::vector<Point3>& given, const std::vector<Index>& original2vertex,
                   double scale, BufferOf<Backend, Point>& points) {
  std::vector<Point> uploaded(original2vertex.size());
  for (std::size_t v = 0; v < uploaded.size(); ++v)
    span_of(uploaded)[span_of(original2vertex)[to_index(v)]] = point(scale * vec(given[v]));
  points.upload(backend, uploaded);
}

/// Finds the surface points of vertices, which are given as in SlideSurface.
template <class Backend>
void import_surface_points(const Backend& backend, const ReferenceSurface<Backend>& reference,
                           const std::vector<std::array<Index, 3>>& given, const std::vector<Index>& original2vertex,
                           Span<SurfacePoint> surface_point) {
  const VertexMap to_work{span_of(original2vertex)};
  std::vector<ElementVertices> on(original2vertex.size());
  for (std::size_t v = 0; v < on.size(); ++v) span_of(on)[to_work(to_index(v))] = to_work(given[v]);
  BufferOf<Backend, ElementVertices> on_buffer;
  on_buffer.upload(backend, on);
  backend.for_each(surface_point.size(), FindSurfacePoint{reference.view(), on_buffer, surface_point});
}

}  // namespace slide_surface_detail

/// Makes a given surface the reference surface, and decides where each vertex may go; one that is not on it is fixed.
/// `scale`: coordinates of the work mesh per unit of the caller's.
template <class Backend>
void import_slide_surface(const Backend& backend, const SlideSurface& given, const std::vector<Index>& original2vertex,
                          Span<const VertexConstraint> constraints, double scale, VertexDofs<Backend>& dofs) {
  using namespace slide_surface_detail;
  const VertexMap to_work{span_of(original2vertex)};
  const Size vertices = std::ssize(original2vertex);
  std::vector<VertexDof> dof(original2vertex.size());
  std::vector<LineVertex> line(original2vertex.size());
  for (Size v = 0; v < vertices; ++v) {
    const Index w = to_work.from2to[v];
    const std::array<Index, 2>& next = span_of(given.line)[v];
    span_of(dof)[w] = span_of(given.dof)[v];
    span_of(line)[w] = {{to_work(next[0]), to_work(next[1])}};
  }
  std::vector<SurfaceTriangle> triangles(given.triangles.size());
  std::transform(given.triangles.begin(), given.triangles.end(), triangles.begin(),
                 [&to_work](const std::array<Index, 3>& t) { return to_work(t); });

  ReferenceSurface<Backend>& reference = dofs.reference;
  upload_points(backend, given.points, original2vertex, scale, reference.points);
  reference.dof.upload(backend, dof);
  reference.line.upload(backend, line);
  reference.triangles.upload(backend, triangles);
  const Size corners = 3 * reference.triangles.size();
  build_csr(backend, vertices, corners, VertexOfCorner<SurfaceTriangle>{reference.triangles}, reference.vertex2corner,
            corners);
  reference.across.resize(backend, corners);
  BufferOf<Backend, std::uint8_t> feature_edges;
  feature_edges.upload(backend, given.feature_edges);
  backend.for_each(corners,
                   JoinTriangles{reference.triangles, reference.vertex2corner.view(), feature_edges, reference.across});
  import_surface_points(backend, reference, given.surface_point, original2vertex, dofs.surface_point.span());
  backend.for_each(vertices, FindDofOnReference{reference.view(), dofs.surface_point, constraints, dofs.dof});
  if (given.checked_points.empty()) return;
  upload_points(backend, given.checked_points, original2vertex, scale, dofs.checked.points);
  dofs.checked.surface_points.resize(backend, vertices);
  import_surface_points(backend, reference, given.checked_surface_point, original2vertex,
                        dofs.checked.surface_points.span());
}

/// The surface that the vertices of a mesh slide on at the start: the reference surface in the caller's ids.
template <class Backend>
SlideSurface export_slide_surface(const ReferenceSurface<Backend>& reference, const std::vector<Point3>& points,
                                  const std::vector<Index>& vertex2original) {
  using namespace slide_surface_detail;
  const VertexMap to_original{span_of(vertex2original)};
  const std::vector<VertexDof> dof = reference.dof.download();
  const std::vector<LineVertex> line = reference.line.download();
  const std::vector<SurfaceTriangle> triangles = reference.triangles.download();
  const std::vector<Index> across = reference.across.download();
  SlideSurface surface;
  surface.points = points;
  surface.dof.resize(points.size());
  surface.line.resize(points.size());
  surface.surface_point.resize(points.size(), kNoSurfacePoint);
  for (Size w = 0; w < std::ssize(vertex2original); ++w) {
    const Index v = to_original(to_index(w));
    const LineVertex& next = span_of(line)[w];
    span_of(surface.dof)[v] = span_of(dof)[w];
    span_of(surface.line)[v] = {to_original(next.next[0]), to_original(next.next[1])};
    if (span_of(dof)[w] != VertexDof::free) span_of(surface.surface_point)[v][0] = v;
  }
  for (const SurfaceTriangle& t : triangles) surface.triangles.push_back(to_original(t));
  for (auto corner = across.begin(); corner != across.end(); corner += 3) {
    unsigned features = 0;
    for (unsigned k = 0; k < 3; ++k) features |= corner[k] == kFeatureEdge ? 1U << k : 0U;
    surface.feature_edges.push_back(static_cast<std::uint8_t>(features));
  }
  return surface;
}

namespace slide_surface_detail {

/// Surface points, given as in SlideSurface.
template <class Backend>
std::vector<std::array<Index, 3>> export_surface_points(const Backend& backend,
                                                        const ReferenceSurface<Backend>& reference,
                                                        Span<const SurfacePoint> surface_point,
                                                        const std::vector<Index>& vertex2original) {
  const VertexMap to_original{span_of(vertex2original)};
  const Size vertices = reference.points.size();
  BufferOf<Backend, ElementVertices> on(backend, vertices);
  backend.for_each(vertices, ExportSurfacePoint{reference.view(), surface_point, on});
  const std::vector<ElementVertices> exported = on.download();
  std::vector<std::array<Index, 3>> surface_points(exported.size(), kNoSurfacePoint);
  for (Size w = 0; w < vertices; ++w) {
    const Index v = to_original.from2to[w];
    if (v >= 0) span_of(surface_points)[v] = to_original(span_of(exported)[w]);
  }
  return surface_points;
}

}  // namespace slide_surface_detail

/// The current places of the vertices. `scale`: as of import_slide_surface().
template <class Backend>
PlacesOnSurface export_places(const Backend& backend, const VertexDofs<Backend>& dofs,
                              const std::vector<Index>& vertex2original, double scale) {
  using slide_surface_detail::export_surface_points;
  PlacesOnSurface places;
  places.surface_point = export_surface_points(backend, dofs.reference, dofs.surface_point.span(), vertex2original);
  if (dofs.checked.points.size() == 0) return places;
  places.checked_surface_point =
      export_surface_points(backend, dofs.reference, dofs.checked.surface_points.span(), vertex2original);
  const std::vector<Point> points = dofs.checked.points.download();
  places.checked_points.resize(places.surface_point.size());
  for (Size w = 0; w < std::ssize(places.surface_point); ++w) {
    const Index v = span_of(vertex2original)[w];
    if (v >= 0) span_of(places.checked_points)[v] = to_point((1 / scale) * vec(span_of(points)[w]));
  }
  return places;
}

}  // namespace tetune
