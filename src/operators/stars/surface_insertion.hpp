// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/classify.hpp"
#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// A vertex inserted on each edge and each triangle that a tetrahedron has on the surface; it moves within flat parts
/// of one patch, along its edge, or on the reference surface, and its cavity grows while that lowers the energy
/// (Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement", 2007).
struct SurfaceInsertion {
  static constexpr int kChoices = 10;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int choice) {
    if (!p.edits || !p.inserts || !p.edits_surface()) return;
    const Tet tet = p.mesh.tet2vertex[t];
    SurfaceSimplex simplex;
    if (choice < 6) {
      const EdgeCorners e = edge_corners(choice);
      simplex = {{tet[e.i], tet[e.j], -1}, 2};
      if (p.constrained.contains(simplex.v[0], simplex.v[1])) return;
    } else {
      if (p.is_selective) return;
      const LinkFace f = link_face(tet, choice - 6);
      simplex = {{f.v[0], f.v[1], f.v[2]}, 3};
    }
    Vec3 x{0, 0, 0};
    for (int k = 0; k < simplex.size; ++k) {
      if (!p.surface.has(simplex.v[k])) return;
      x = x + (1.0 / simplex.size) * vec(p.mesh.points[simplex.v[k]]);
    }
    StarCavity star = p.cavity();
    ReplacedTriangles replaced;
    if (!star.take_surface(t, simplex, kMaxStarTets, p.team) ||
        (simplex.size == 2 && !p.is_long_enough(star, simplex.v[0], simplex.v[1])) ||
        p.is_shared_with_earlier(star, t) || !p.surface.find_replaced(star, simplex, replaced)) {
      return;
    }
    NewVertexDof dof =
        p.surface.bends ? place_on_reference(p, replaced, simplex, x) : find_dof(p, star, replaced, simplex);
    if (dof.dof == VertexDof::fixed) return;
    star.restrict_apex(dof, p.surface.reference);
    x = star.relax_and_grow(star.relax(x, p.team), p.team);
    if (!p.place_new_vertex(star, x)) return;
    if (p.surface.bends) {
      dof.surface_point = star.surface_point();
      replaced.deviation =
          p.deviation_after([&](const SurfaceBend& bend) { return bend.after_insertion(simplex, replaced, x); });
      if (!(replaced.deviation < kInfeasible)) return;
    }
    StarCandidate c = star.candidate(kNewVertex, kNoVertex, x);
    c.dof = dof;
    c.replaced = replaced;
    p.add(star, c);
  }

 private:
  /// The radius of the displacement bound of a new vertex, in lengths of its edge.
  static constexpr double kRadius = 0.25;

  /// Moves x to the reference surface, in the same sheet or on the same feature line. Degrees of freedom: fixed where
  /// there is none.
  TETUNE_HD static NewVertexDof place_on_reference(const StarContext& p, const ReplacedTriangles& replaced,
                                                   const SurfaceSimplex& simplex, Vec3& x) {
    const BoundaryTriangle& t = p.surface.triangles[replaced.triangle[0]];
    const double radius = kRadius * norm(vec(p.mesh.points[simplex.v[1]]) - vec(p.mesh.points[simplex.v[0]]));
    NewVertexDof dof{VertexDof::surface, {0, 0, 0}, radius, {SurfacePointKind::triangle, t.reference}};
    Vec3 from = p.surface.reference.centroid(t.reference);
    if (simplex.size == 2 && is_feature_edge(t, simplex.v[0], simplex.v[1])) {
      const Index v = is_on_curve(p, simplex.v[0]) ? simplex.v[0] : simplex.v[1];
      if (!is_on_curve(p, v)) return place_between_corners(p, simplex, radius);
      dof.dof = VertexDof::curve;
      dof.surface_point = p.surface.surface_point[v];
      from = vec(p.mesh.points[v]);
    }
    x = project_on_reference(p.surface.reference, dof.dof, from, x, dof.surface_point);
    return dof;
  }
  /// Whether a vertex is on a line that vertices slide along, even if this one is fixed, as at the end of a
  /// neighborhood.
  TETUNE_HD static bool is_on_curve(const StarContext& p, Index v) {
    const SurfacePoint& on = p.surface.surface_point[v];
    return p.dof[v] == VertexDof::curve || on.kind == SurfacePointKind::segment ||
           (on.kind == SurfacePointKind::vertex && p.surface.reference.dof[on.item] == VertexDof::curve);
  }
  /// On a feature edge without a vertex on such a line: the edge itself where it is a part of the reference
  /// surface. Otherwise vertices of the line were removed, and the line between its ends is not known. With a bound on
  /// the deviation none: DeviationBound is for vertices that slide.
  TETUNE_HD static NewVertexDof place_between_corners(const StarContext& p, const SurfaceSimplex& edge, double radius) {
    if (p.surface.limit.is_bounded()) return {VertexDof::fixed};
    const Vec3 a = vec(p.mesh.points[edge.v[0]]);
    const Vec3 along = vec(p.mesh.points[edge.v[1]]) - a;
    const NewVertexDof on_line{VertexDof::line, (1 / norm(along)) * along, radius, {SurfacePointKind::none, -1}};
    const bool is_part = p.dof[edge.v[0]] == VertexDof::line || p.dof[edge.v[1]] == VertexDof::line ||
                         has_edge(p.surface.reference, edge.v[0], edge.v[1]);
    return is_part ? on_line : NewVertexDof{VertexDof::fixed};
  }
  /// Whether the reference surface has an edge between two vertices. Inserted ones are none of its vertices.
  TETUNE_HD static bool has_edge(const ReferenceView& reference, Index a, Index b) {
    if (a >= reference.points.size() || b >= reference.points.size()) return false;
    const Index from = reference.vertex2corner.shorter(a, b);
    const Index to = a ^ b ^ from;
    for (Size c = reference.vertex2corner.begin(from); c < reference.vertex2corner.end(from); ++c) {
      const SurfaceTriangle& t = reference.triangles[reference.vertex2corner.items[c] / 3];
      if (t.v[0] == to || t.v[1] == to || t.v[2] == to) return true;
    }
    return false;
  }
  TETUNE_HD static NewVertexDof find_dof(const StarContext& p, const StarCavity& star,
                                         const ReplacedTriangles& replaced, const SurfaceSimplex& simplex) {
    const Vec3 origin = vec(p.mesh.points[simplex.v[0]]);
    const Vec3 edge = vec(p.mesh.points[simplex.v[1]]) - origin;
    const double length = norm(edge);
    const double radius = kRadius * length;
    const Vec3 n = area_normal(p.mesh, star.base(0));
    if (simplex.size == 3) return {VertexDof::plane, (1 / norm(n)) * n, radius};
    if (star.base_count() == 2 &&
        in_one_patch(p.surface.triangles[replaced.triangle[0]], p.surface.triangles[replaced.triangle[1]])) {
      const Vec3 to_first = apex(p, star.base(0), simplex) - origin;
      const Vec3 to_second = apex(p, star.base(1), simplex) - origin;
      const Vec3 n1 = cross(edge, to_first);
      const Vec3 n2 = cross(to_second, edge);
      const double flat = kFlat * length;
      const bool is_flat = std::fabs(dot(n1, to_second)) <= flat * norm(n1) &&
                           std::fabs(dot(n2, to_first)) <= flat * norm(n2) && dot(n1, n2) > 0;
      const Vec3 sum = n1 + n2;
      if (is_flat) return {VertexDof::plane, (1 / norm(sum)) * sum, radius};
    }
    return {VertexDof::line, (1 / length) * edge, radius};
  }
  /// The vertex of a triangle at an edge that is not on the edge.
  TETUNE_HD static Vec3 apex(const StarContext& p, const LinkFace& f, const SurfaceSimplex& edge) {
    const int k = !edge.has(f.v[0]) ? 0 : !edge.has(f.v[1]) ? 1 : 2;
    return vec(p.mesh.points[f.v[k]]);
  }
};

}  // namespace tetune
