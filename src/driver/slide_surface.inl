// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/features.inl"
#include "driver/working_set.hpp"
#include "surface/primitive.hpp"
#include "surface/slide_surface.hpp"

/// A SlideSurface on its way into and out of the working set.
namespace tetune {
namespace slide_surface_detail {

using features_detail::opposite_corner;

/// As many vertices of the reference as a site has.
using SiteVertices = SurfaceTriangle;

struct JoinTriangles {
  Span<const SurfaceTriangle> triangles;
  RowsView vertex2corner;
  Span<const std::uint8_t> walls;
  Span<Index> across;
  TETUNE_HD void operator()(Size corner) const {
    const bool wall = (walls[corner / 3] >> corner % 3 & 1) != 0;
    const Index other = wall ? kWall : opposite_corner(triangles, vertex2corner, corner);
    const bool wall_there = other != kWall && (walls[other / 3] >> other % 3 & 1) != 0;
    across[corner] = wall_there ? kWall : other;
  }
};

/// Puts each vertex on the reference, and lets it go where it may; one that is not on it stays.
struct PlaceVertex {
  ReferenceView reference;
  Span<const SiteVertices> on;
  Span<const std::uint8_t> frozen;
  Span<Site> site;
  Span<Mobility> kind;

  TETUNE_HD void operator()(Size v) const {
    const Mobility walker = reference.kind[v];
    site[v] = find(walker, on[v]);
    const bool lost = site[v].kind == SiteKind::none && walker != Mobility::free;
    kind[v] = lost || frozen[v] == kFrozen ? Mobility::fixed : walker;
  }

 private:
  TETUNE_HD Site find(Mobility walker, const SiteVertices& s) const {
    const Index a = s.v[0];
    if (a < 0) return {};
    if (s.v[1] < 0) return reference.kind[a] == walker ? Site{SiteKind::vertex, a} : Site{};
    if (walker == Mobility::curve) return s.v[2] < 0 ? segment(a, s.v[1]) : Site{};
    const Index from = reference.vertex2corner.shorter(a, s.v[1]);
    const Index to = a ^ s.v[1] ^ from;
    for (Size c = reference.vertex2corner.begin(from); c < reference.vertex2corner.end(from); ++c) {
      const auto corner = static_cast<Index>(reference.vertex2corner.items[c]);
      const SurfaceTriangle t = reference.triangles[corner / 3];
      const int b = place(t, to);
      if (b < 0) continue;
      if (s.v[2] >= 0) {
        if (place(t, s.v[2]) >= 0) return {SiteKind::triangle, corner / 3};
      } else {
        const Index opposite = corner / 3 * 3 + 3 - corner % 3 - b;
        return reference.across[opposite] == kWall ? Site{} : Site{SiteKind::edge, opposite};
      }
    }
    return {};
  }
  TETUNE_HD static int place(const SurfaceTriangle& t, Index v) {
    return t.v[0] == v ? 0 : t.v[1] == v ? 1 : t.v[2] == v ? 2 : -1;
  }
  TETUNE_HD Site segment(Index a, Index b) const {
    for (Index way = 0; way < 4; ++way) {
      const Index from = way < 2 ? a : b;
      if (reference.kind[from] == Mobility::curve && reference.line[from].next[way % 2] == (way < 2 ? b : a))
        return {SiteKind::segment, 2 * from + way % 2};
    }
    return {};
  }
};

struct TellSite {
  ReferenceView reference;
  Span<const Site> site;
  Span<SiteVertices> on;
  TETUNE_HD void operator()(Size v) const {
    SiteVertices s{{-1, -1, -1}};
    if (site[v].kind == SiteKind::triangle) {
      s = reference.triangles[site[v].item];
    } else if (site[v].kind == SiteKind::vertex) {
      s.v[0] = site[v].item;
    } else if (site[v].kind != SiteKind::none) {
      const Ends ends = ends_of(reference, site[v]);
      s.v[0] = ends.a;
      s.v[1] = ends.b;
    }
    on[v] = s;
  }
};

}  // namespace slide_surface_detail

/// Makes a given surface the reference, and decides where each vertex may go. `original2vertex`: the work vertex of
/// each of the caller's.
template <class Backend>
void take_surface(const Backend& par, const SlideSurface& given, const std::vector<Index>& original2vertex,
                  Span<const std::uint8_t> frozen, WorkingSet<Backend>& work) {
  using namespace slide_surface_detail;
  const std::size_t vertices = original2vertex.size();
  const auto to_work = [&original2vertex](Index v) { return v < 0 ? v : original2vertex[static_cast<std::size_t>(v)]; };
  const auto all_to_work = [&to_work](const std::array<Index, 3>& v) {
    return SurfaceTriangle{{to_work(v[0]), to_work(v[1]), to_work(v[2])}};
  };
  std::vector<Point> points(vertices);
  std::vector<Mobility> kind(vertices);
  std::vector<LineVertex> line(vertices);
  std::vector<SiteVertices> on(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto w = static_cast<std::size_t>(original2vertex[v]);
    points[w] = point(work.scale * vec(given.points[v]));
    kind[w] = given.kind[v];
    line[w] = {{to_work(given.line[v][0]), to_work(given.line[v][1])}};
    on[w] = all_to_work(given.site[v]);
  }
  std::vector<SurfaceTriangle> triangles;
  triangles.reserve(given.triangles.size());
  for (const auto& t : given.triangles) triangles.push_back(all_to_work(t));

  ReferenceSurface<Backend>& reference = work.mobilities.reference;
  reference.points.upload(points);
  reference.kind.upload(kind);
  reference.line.upload(line);
  reference.triangles.upload(triangles);
  const Size corners = 3 * reference.triangles.size();
  build_rows(par, work.mesh.vertices(), corners, classify_detail::VertexOfSurfaceCorner{reference.triangles.span()},
             reference.vertex2corner);
  reference.across.resize(corners);
  typename Backend::template Buffer<std::uint8_t> walls;
  walls.upload(given.walls);
  par.for_each(corners, JoinTriangles{reference.triangles.span(), reference.vertex2corner.view(), walls.span(),
                                      reference.across.span()});
  typename Backend::template Buffer<SiteVertices> on_buffer;
  on_buffer.upload(on);
  par.for_each(work.mesh.vertices(), PlaceVertex{reference.view(), on_buffer.span(), frozen,
                                                 work.mobilities.site.span(), work.mobilities.kind.span()});
}

/// Where the vertices are on the reference, in the caller's numbers and order.
template <class Backend>
std::vector<std::array<Index, 3>> tell_sites(const Backend& par, const WorkingSet<Backend>& work,
                                             const std::vector<Index>& vertex2original) {
  using namespace slide_surface_detail;
  const Size vertices = work.mobilities.reference.points.size();
  typename Backend::template Buffer<SiteVertices> on(vertices);
  par.for_each(vertices, TellSite{work.mobilities.reference.view(), work.mobilities.site.span(), on.span()});
  std::vector<std::array<Index, 3>> site(static_cast<std::size_t>(vertices), kNoSite);
  const std::vector<SiteVertices> told = on.download();
  for (std::size_t w = 0; w < told.size(); ++w) {
    if (vertex2original[w] < 0) continue;
    auto& s = site[static_cast<std::size_t>(vertex2original[w])];
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = told[w].v[k];
      s[k] = v < 0 ? v : vertex2original[static_cast<std::size_t>(v)];
    }
  }
  return site;
}

}  // namespace tetune
