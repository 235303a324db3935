// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/classify.hpp"
#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// Removes a vertex of the surface by contracting an edge. In a flat part of a patch, or on a straight feature line,
/// the edge must stay in the same planes; where the surface may bend, any vertex of a sheet or feature line can be
/// removed.
struct SurfaceContraction {
  static constexpr int kChoices = 12;
  /// As VertexContraction::kMaxTets.
  static constexpr int kMaxTets = 14;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int choice) {
    if (!p.edits || !p.removes || !p.edits_surface()) return;
    const Tet tet = p.mesh.tet2vertex[t];
    const int from = choice / 3;
    const Index v = tet[from];
    const Index apex = tet[(from + 1 + choice % 3) % 4];
    const Vec3 x = vec(p.mesh.points[apex]);
    if (!(p.surface.bends ? is_on_sheet(p, v, apex) : is_in_planes(p, v, x)) || p.constrained.has_end(v)) return;
    StarCavity star = p.cavity();
    ReplacedTriangles replaced;
    const SurfaceSimplex simplex{{v, -1, -1}, 1};
    const int max_tets = p.is_selective ? kMaxTets : kMaxStarTets;
    if (!star.take_surface(t, simplex, max_tets, p.team) || !(p.surface.bends || keeps_planes(p, star, v, apex)) ||
        !star.keeps_faces_of(apex) || !p.surface.find_replaced(star, simplex, replaced) ||
        touches_surface(p, star, v, apex)) {
      return;
    }
    if (p.is_contracted_earlier(star, apex, t)) return;
    if (p.surface.bends) {
      if (!is_beside(p, replaced, v, apex)) return;
      replaced.deviation =
          p.deviation_after([&](const SurfaceBend& bend) { return bend.after_contraction(v, apex, replaced); });
      if (!(replaced.deviation < kInfeasible)) return;
    }
    if (!p.grow(star, apex, x) || !star.keeps_faces_of(apex)) return;
    StarCandidate c = star.candidate(apex, v, x);
    c.replaced = replaced;
    if (bid_on_edges(star, v, p.proposals.highest.edges.size(), c)) p.add(star, c);
  }

 private:
  /// Whether the edge from v to x is in the plane or on the line of v.
  TETUNE_HD static bool is_in_planes(const StarContext& p, Index v, const Vec3& x) {
    const Vec3 edge = x - vec(p.mesh.points[v]);
    const double tolerance = kFlat * norm(edge);
    return (p.dof[v] == VertexDof::plane && std::fabs(dot(p.axis[v], edge)) <= tolerance) ||
           (p.dof[v] == VertexDof::line && norm(cross(p.axis[v], edge)) <= tolerance);
  }
  /// Whether v may move over the surface, and both vertices are on it.
  TETUNE_HD static bool is_on_sheet(const StarContext& p, Index v, Index apex) {
    return p.surface.has(apex) && p.dof[v] != VertexDof::fixed && p.surface.has(v);
  }
  /// Whether v has an edge of the surface to the apex, along its feature line where it is on one.
  TETUNE_HD static bool is_beside(const StarContext& p, const ReplacedTriangles& replaced, Index v, Index apex) {
    for (int i = 0; i < replaced.count; ++i) {
      const BoundaryTriangle& t = p.surface.triangles[replaced.triangle[i]];
      if (has_vertex(t, apex)) return p.dof[v] == VertexDof::surface || is_feature_edge(t, v, apex);
    }
    return false;
  }
  /// Whether an edge or triangle that the contraction would make is on the surface already: parts of the surface would
  /// touch there, or two of its triangles be one face (the link condition of Dey et al. 1999).
  TETUNE_HD static bool touches_surface(const StarContext& p, const StarCavity& star, Index v, Index apex) {
    for (int i = 0; i < star.base_count(); ++i) {
      LinkFace f = star.base(i);
      if (has_vertex(f, apex)) continue;
      for (Index& w : f.v) {
        if (w == v) {
          w = apex;
        } else if (!is_beside_edge(star, apex, w) && have_edge(p.surface.triangles, p.surface.vertex2corner, apex, w)) {
          return true;
        }
      }
      if (find_triangle(p.surface.triangles, p.surface.vertex2corner, f.v) >= 0) return true;
    }
    return false;
  }
  /// Lists the slots that stand for the edges from the apex to the vertices around v: two contractions that make the
  /// same edge or triangle have one of these in common. Returns false where there is no room for them.
  TETUNE_HD static bool bid_on_edges(const StarCavity& star, Index v, Size slots, StarCandidate& c) {
    Index around[kMaxStarTriangles];
    for (int i = 0; i < star.base_count(); ++i) {
      for (const Index w : star.base(i).v) {
        if (w == v || w == c.apex) continue;
        int k = 0;
        while (k < c.edges && around[k] != w) ++k;
        if (k < c.edges) continue;
        if (k == kMaxStarTriangles || star.tet_count() + k == kMaxStarTets) return false;
        around[k] = w;
        c.tets[star.tet_count() + c.edges++] = slot_of_edge(c.apex, w, slots);
      }
    }
    return true;
  }
  /// Whether a triangle at the removed vertex has both vertices.
  TETUNE_HD static bool is_beside_edge(const StarCavity& star, Index apex, Index w) {
    for (int i = 0; i < star.base_count(); ++i) {
      if (has_vertex(star.base(i), apex) && has_vertex(star.base(i), w)) return true;
    }
    return false;
  }
  /// Whether each triangle stays in its plane, and is not turned over, when v moves to the apex.
  TETUNE_HD static bool keeps_planes(const StarContext& p, const StarCavity& star, Index v, Index apex) {
    for (int i = 0; i < star.base_count(); ++i) {
      LinkFace f = star.base(i);
      if (has_vertex(f, apex)) continue;
      const Vec3 n = area_normal(p.mesh, f);
      const Vec3 d = vec(p.mesh.points[apex]) - vec(p.mesh.points[f.v[0]]);
      if (!(std::fabs(dot(n, d)) <= kFlat * norm(n) * norm(d))) return false;
      for (Index& w : f.v) w = w == v ? apex : w;
      if (!(dot(n, area_normal(p.mesh, f)) > 0)) return false;
    }
    return true;
  }
};

}  // namespace tetune
