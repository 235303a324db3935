// SPDX-License-Identifier: Apache-2.0
#include "phases/untangle/surface_folds.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/box_tree.hpp"
#include "math/orient.hpp"
#include "mesh/vertex_layers.hpp"

namespace tetune {
namespace {

Point3 to_array(const Point& p) { return {p.x, p.y, p.z}; }

/// A face on one tetrahedron alone. All are oriented consistently: the normal points out of a tetrahedron of positive
/// volume.
struct BoundaryFace {
  Index slot;
  std::array<Index, 3> v;
};

/// Calls f(face) for each boundary face.
template <class F>
void for_boundary_faces(const HostMesh& mesh, const F& f) {
  const auto tet2tet = span_of(mesh.tet2tet);
  Index slot = -1;
  for (const Tet& tet : mesh.tet2vertex) {
    ++slot;
    if (tet[0] == kFreeSlot) continue;
    for (int face = 0; face < 4; ++face) {
      if (tet2tet[slot][face] != kNoHalfFace) continue;
      f(BoundaryFace{slot, {tet[face_vertex(face, 0)], tet[face_vertex(face, 1)], tet[face_vertex(face, 2)]}});
    }
  }
}

/// Calls f(slot, v, normal) for each vertex v of each boundary face.
template <class F>
void for_boundary_corners(const HostMesh& mesh, const F& f) {
  const auto points = span_of(mesh.points);
  for_boundary_faces(mesh, [&](const BoundaryFace& face) {
    const Vec3 origin = vec(points[face.v[0]]);
    const Vec3 normal = cross(vec(points[face.v[1]]) - origin, vec(points[face.v[2]]) - origin);
    for (const Index v : face.v) f(face.slot, v, normal);
  });
}

/// Normals of boundary faces at a vertex, of one plane or of the two that meet in its line.
class PlaneNormals {
 public:
  /// Whether a face of a vertex that moves within a plane is turned over with respect to the first one.
  bool is_turned_in_plane(const Vec3& normal) {
    if (is_zero(first_)) first_ = normal;
    return dot(first_, normal) < 0;
  }
  /// Whether a face is turned over with respect to the first one in the same plane.
  bool is_turned_at_line(const Vec3& normal) {
    for (Vec3* known : {&first_, &second_}) {
      if (is_zero(*known)) *known = normal;
      const double cosine = dot(*known, normal) / (norm(*known) * norm(normal));
      if (std::fabs(cosine) > 1 - kParallel) return cosine < 0;
    }
    return false;
  }

 private:
  static constexpr double kParallel = 1e-6;  // 1 - cos of the angle
  static bool is_zero(const Vec3& x) { return dot(x, x) == 0; }

  Vec3 first_{}, second_{};
};

/// Flags the vertices within a number of rings around the slots.
std::vector<std::uint8_t> vertices_near(const HostMesh& mesh, const std::vector<Index>& slots, int rings) {
  std::vector<std::uint8_t> flags(mesh.points.size(), 0);
  for (const Index slot : slots) {
    for (const Index v : span_of(mesh.tet2vertex)[slot].v) span_of(flags)[v] = 1;
  }
  for (int ring = 0; ring < rings; ++ring) add_layer(mesh.tet2vertex, flags);
  return flags;
}

/// Tests pairs of boundary faces.
class FacePairs {
 public:
  explicit FacePairs(const HostMesh& mesh) : points_(mesh.points) {}

  Box box(const BoundaryFace& face) const {
    Box box{position(face.v[0]), position(face.v[0])};
    for (const Index v : face.v) box.include(position(v));
    return box;
  }
  bool are_at_fault(const BoundaryFace& a, const BoundaryFace& b) const {
    return has_crossing_edge(a, b) || has_crossing_edge(b, a) || are_folded(a, b);
  }

 private:
  Vec3 position(Index v) const { return vec(span_of(points_)[v]); }
  int sign(Index a, Index b, Index c, Index d) const {
    const auto at = [this](Index v) { return to_array(span_of(points_)[v]); };
    return orient_sign(at(a), at(b), at(c), at(d));
  }
  static bool has(const BoundaryFace& face, Index v) {
    return std::find(face.v.begin(), face.v.end(), v) != face.v.end();
  }
  /// Whether an edge of `a` passes through the inside of `b`.
  bool has_crossing_edge(const BoundaryFace& a, const BoundaryFace& b) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index p = a.v[k];
      const Index q = a.v[(k + 1) % 3];
      if (has(b, p) || has(b, q)) continue;
      if (sign(b.v[0], b.v[1], b.v[2], p) * sign(b.v[0], b.v[1], b.v[2], q) >= 0) continue;
      const int first = sign(p, q, b.v[0], b.v[1]);
      if (first != 0 && first == sign(p, q, b.v[1], b.v[2]) && first == sign(p, q, b.v[2], b.v[0])) return true;
    }
    return false;
  }
  /// Whether two faces with a common edge are on one side of it, in one plane.
  bool are_folded(const BoundaryFace& a, const BoundaryFace& b) const {
    constexpr double kFold = 1e-12;  // 1 - cos of the angle
    if (std::count_if(a.v.begin(), a.v.end(), [&](Index v) { return has(b, v); }) != 2) return false;
    const Vec3 m = normal(a);
    const Vec3 n = normal(b);
    return dot(m, n) < -(1 - kFold) * norm(m) * norm(n);
  }
  Vec3 normal(const BoundaryFace& f) const {
    return cross(position(f.v[1]) - position(f.v[0]), position(f.v[2]) - position(f.v[0]));
  }

  const std::vector<Point>& points_;
};

}  // namespace

std::vector<Index> exactly_tangled(const HostMesh& mesh, std::vector<Index> slots) {
  const auto points = span_of(mesh.points);
  const auto tets = span_of(mesh.tet2vertex);
  std::erase_if(slots, [&](Index slot) {
    const Tet& t = tets[slot];
    return orient_sign(to_array(points[t[0]]), to_array(points[t[1]]), to_array(points[t[2]]), to_array(points[t[3]])) >
           0;
  });
  return slots;
}

bool SlidingVertices::is_turned_from(Index triangle, const Vec3& normal) const {
  // A face over an edge of the surface may be steep.
  constexpr double kMaxCosine = -0.5;
  const SurfaceTriangle& t = span_of(triangles_)[triangle];
  const auto at = [&](int k) { return vec(span_of(points_)[t.v[k]]); };
  const Vec3 own = cross(at(1) - at(0), at(2) - at(0));
  return dot(own, normal) < kMaxCosine * norm(own) * norm(normal);
}

bool SlidingVertices::is_turned(Index v, const Vec3& normal) const {
  const SurfacePoint on = span_of(surface_points_)[v];
  switch (on.kind) {
    case SurfacePointKind::triangle:
      return is_turned_from(on.item, normal);
    case SurfacePointKind::edge: {
      const Index across = span_of(across_)[on.item];
      return is_turned_from(on.item / 3, normal) && (across < 0 || is_turned_from(across / 3, normal));
    }
    case SurfacePointKind::vertex:
    case SurfacePointKind::segment: {
      const bool is_vertex = on.kind == SurfacePointKind::vertex;
      const Index from = is_vertex ? on.item : on.item / 2;
      const Index to = is_vertex ? from : span_of(line_)[from].next[on.item % 2];
      for (Size i = span_of(offsets_)[from]; i < Size(span_of(offsets_)[from + 1]); ++i) {
        const Index triangle = Index(span_of(corners_)[i]) / 3;
        const Index(&t)[3] = span_of(triangles_)[triangle].v;
        if (std::find(t, t + 3, to) != t + 3 && !is_turned_from(triangle, normal)) return false;
      }
      return true;
    }
    default:
      return false;
  }
}

std::vector<std::uint8_t> folded_vertices(const HostMesh& mesh, const std::vector<VertexDof>& dofs,
                                          const SlidingVertices& sliding) {
  std::vector<PlaneNormals> normals(dofs.size());
  std::vector<std::uint8_t> folded(dofs.size(), 0);
  for_boundary_corners(mesh, [&, dofs = span_of(dofs), known = span_of(normals), flags = span_of(folded)](
                                 Index, Index v, const Vec3& normal) {
    const bool is_turned = (dofs[v] == VertexDof::plane && known[v].is_turned_in_plane(normal)) ||
                           (dofs[v] == VertexDof::line && known[v].is_turned_at_line(normal)) ||
                           (slides(dofs[v]) && sliding.is_turned(v, normal));
    if (is_turned) flags[v] = 1;
  });
  return folded;
}

std::vector<Index> newly_folded(const HostMesh& mesh, const std::vector<VertexDof>& dofs,
                                const std::vector<std::uint8_t>& before, const SlidingVertices& sliding) {
  const std::vector<std::uint8_t> folded = folded_vertices(mesh, dofs, sliding);
  std::vector<Index> slots;
  if (std::find(folded.begin(), folded.end(), 1) == folded.end()) return slots;
  for_boundary_corners(mesh, [&slots, now = span_of(folded), then = span_of(before)](Index slot, Index v, const Vec3&) {
    if (now[v] != 0 && then[v] == 0) slots.push_back(slot);
  });
  return slots;
}

std::vector<Index> surface_faults(const HostMesh& mesh, const std::vector<Index>& slots) {
  constexpr int kRings = 3;
  const std::vector<std::uint8_t> near = vertices_near(mesh, slots, kRings);
  const FacePairs pairs(mesh);
  std::vector<BoundaryFace> faces;
  std::vector<Box> boxes;
  for_boundary_faces(mesh, [&](const BoundaryFace& face) {
    faces.push_back(face);
    boxes.push_back(pairs.box(face));
  });
  const BoxTree tree(boxes);
  std::vector<Index> found;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const BoundaryFace& face = faces[i];
    if (std::none_of(face.v.begin(), face.v.end(), [&](Index v) { return span_of(near)[v] != 0; })) continue;
    bool is_at_fault = false;
    tree.for_meeting(
        boxes[i], [&](Index other) { is_at_fault = is_at_fault || pairs.are_at_fault(face, span_of(faces)[other]); });
    if (is_at_fault) found.push_back(face.slot);
  }
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace tetune
