// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "boundary/sliding/reference_surface.hpp"
#include "boundary/surface.hpp"
#include "energy/objective.hpp"
#include "mesh/half_face.hpp"
#include "mesh/tet_mesh_view.hpp"

/// Curved sheets, and sheets with curved rims, that are thin for their triangles. Where vertices slide, the new
/// triangles are off the old ones by up to a part of the heights of neighbors over the planes of each other, which can
/// be more than the sheet is thick.
namespace tetune {

/// A sheet is thin for a triangle where its thickness is below kThinPart of the mean edge of the triangle, and below
/// kThinBend of the height by which the surface bends there; at a feature line, below kThinRim of the height by which
/// the line bends.
inline constexpr double kThinPart = 0.25;
inline constexpr double kThinBend = 0.5;
inline constexpr double kThinRim = 0.25;

namespace thin_sheets_detail {

/// The cosine of the largest angle between the two sides of a sheet. Larger angles are those of a wedge, which is thin
/// at its tip whatever its shape.
inline constexpr double kMinSheetCos = 0.95;

/// At most this number of tetrahedra are crossed.
inline constexpr int kMaxSteps = 64;

/// Finds the thickness of the mesh at each surface triangle, on either side: the distance from the centroid to the
/// opposite side along the normal. kInfeasible where it is above kThinPart of the edges, or there is no sheet.
struct FindThickness {
  MeshView mesh;
  ReferenceView reference;  ///< the surface of the mesh
  Span<double> thickness;   ///< per triangle
  TETUNE_HD void operator()(Size t) const {
    if (!mesh.alive(t)) return;
    for (int f = 0; f < 4; ++f) {
      const HalfFace across = mesh.tet2tet[t][f];
      if (!lists_locked_face(to_index(t), across)) continue;
      const Tet tet = mesh.tet2vertex[t];
      const Index v[3] = {tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]};
      const Index triangle = find_triangle(reference.triangles, reference.vertex2corner, v);
      if (triangle < 0) continue;
      const double inside = from(to_index(t), f);
      const double beyond = across == kNoHalfFace ? kInfeasible : from(tet_of(across), face_of(across));
      thickness[triangle] = inside < beyond ? inside : beyond;
    }
  }

 private:
  struct Face {
    Vec3 a, b, c;
    /// Points out of the tetrahedron; its length is twice the area.
    TETUNE_HD Vec3 normal() const { return cross(b - a, c - a); }
  };
  TETUNE_HD Face face(Index t, int f) const {
    const Tet tet = mesh.tet2vertex[t];
    return {vec(mesh.points[tet[face_vertex(f, 0)]]), vec(mesh.points[tet[face_vertex(f, 1)]]),
            vec(mesh.points[tet[face_vertex(f, 2)]])};
  }

  /// The thickness of the region of a tetrahedron at a face of it.
  TETUNE_HD double from(Index t, int f) const {
    const Face start = face(t, f);
    const Vec3 normal = start.normal();
    const double area = norm(normal);
    if (!(area > 0)) return kInfeasible;
    const Vec3 inward = (-1 / area) * normal;
    const Vec3 center = (1.0 / 3) * (start.a + start.b + start.c);
    const double limit = kThinPart / 3 * (norm(start.b - start.a) + norm(start.c - start.b) + norm(start.a - start.c));
    for (int step = 0; step < kMaxSteps; ++step) {
      double distance = limit;
      int exit = -1;
      for (int g = 0; g < 4; ++g) {
        if (g == f) continue;
        const Face side = face(t, g);
        const Vec3 out = side.normal();
        const double slope = dot(out, inward);
        if (!(slope > 0) || !(dot(out, side.a - center) < distance * slope)) continue;
        distance = dot(out, side.a - center) / slope;
        exit = g;
      }
      if (exit < 0) return kInfeasible;
      const HalfFace across = mesh.tet2tet[t][exit];
      if (is_locked(across)) {
        const Vec3 out = face(t, exit).normal();
        return dot(out, inward) >= kMinSheetCos * norm(out) ? distance : kInfeasible;
      }
      t = tet_of(across);
      f = face_of(across);
    }
    return kInfeasible;
  }
};

/// Whether a triangle and its neighbors that are not across feature edges are of sheets.
TETUNE_HD inline bool is_among_sheets(const ReferenceView& reference, Span<const double> thickness, Index triangle) {
  if (!(thickness[triangle] < kInfeasible)) return false;
  for (Size k = 0; k < 3; ++k) {
    const Index opposite = reference.across[3 * Size{triangle} + k];
    if (opposite != kFeatureEdge && !(thickness[opposite / 3] < kInfeasible)) return false;
  }
  return true;
}

/// Marks triangles of thin sheets, whose neighbors and their neighbors are triangles of sheets too: fewer are noise, as
/// beside caps of scanned surfaces.
struct IsThin {
  ReferenceView reference;
  Span<const double> thickness;
  Span<std::uint8_t> is_thin;  ///< per triangle
  TETUNE_HD void operator()(Size triangle) const {
    is_thin[triangle] = thickness[triangle] < kThinBend * height(to_index(triangle)) ? 1 : 0;
  }

 private:
  /// The largest height of a neighbor over the plane of a triangle, not across feature edges; 0 beside triangles that
  /// are not of a sheet.
  TETUNE_HD double height(Index triangle) const {
    const SurfaceTriangle& t = reference.triangles[triangle];
    const Vec3 x = reference.point(t.v[0]);
    const Vec3 normal = cross(reference.point(t.v[1]) - x, reference.point(t.v[2]) - x);
    double largest = 0;
    for (Size k = 0; k < 3; ++k) {
      const Index opposite = reference.across[3 * Size{triangle} + k];
      if (opposite == kFeatureEdge) continue;
      if (!is_among_sheets(reference, thickness, opposite / 3)) return 0;
      const Index apex = reference.triangles[opposite / 3].v[opposite % 3];
      const double height = std::fabs(dot(normal, reference.point(apex) - x));
      largest = height > largest ? height : largest;
    }
    return largest > 0 ? largest / norm(normal) : 0;
  }
};

/// Marks vertices of feature lines at the rims of thin sheets, of which they have at least two triangles.
struct IsAtThinRim {
  ReferenceView reference;
  Span<const double> thickness;
  Span<std::uint8_t> is_thin;  ///< per vertex
  TETUNE_HD void operator()(Size v) const {
    is_thin[v] = reference.dof[v] == VertexDof::curve && is_thin_at(to_index(v)) ? 1 : 0;
  }

 private:
  TETUNE_HD bool is_thin_at(Index v) const {
    const Vec3 a = reference.point(reference.line[v].next[0]);
    const Vec3 chord = reference.point(reference.line[v].next[1]) - a;
    const double limit = kThinRim * norm(cross(chord, reference.point(v) - a)) / norm(chord);
    int thin = 0;
    for (Size c = reference.vertex2corner.begin(v); c < reference.vertex2corner.end(v); ++c) {
      const Index triangle = to_index(reference.vertex2corner.items[c] / 3);
      thin += thickness[triangle] < limit && is_among_sheets(reference, thickness, triangle) ? 1 : 0;
    }
    return thin >= 2;
  }
};

}  // namespace thin_sheets_detail

/// The thin sheets of a mesh.
struct ThinSheets {
  std::vector<std::uint8_t> triangles;  ///< 1 per triangle of the surface that bends by more than the thickness allows
  std::vector<std::uint8_t> rims;       ///< 1 per vertex on a feature line that does
};

/// Finds the thin sheets of a mesh whose surface is the reference surface.
template <class Backend>
ThinSheets find_thin_sheets(const Backend& backend, WorkMesh<Backend>& mesh,
                            const ReferenceSurface<Backend>& reference) {
  using namespace thin_sheets_detail;
  const ReferenceView surface = reference.view();
  BufferOf<Backend, double> thickness(backend, surface.triangles.size());
  backend.fill(thickness.span(), kInfeasible);
  backend.for_each(mesh.slots(), FindThickness{mesh.view(), surface, thickness.span()});
  BufferOf<Backend, std::uint8_t> triangles(backend, surface.triangles.size());
  backend.for_each(triangles.size(), IsThin{surface, thickness.span(), triangles.span()});
  BufferOf<Backend, std::uint8_t> rims(backend, mesh.vertices());
  backend.for_each(rims.size(), IsAtThinRim{surface, thickness.span(), rims.span()});
  return {triangles.download(), rims.download()};
}

}  // namespace tetune
