// SPDX-License-Identifier: Apache-2.0
#include "boundary/sliding/flat_patches.hpp"

#include <algorithm>
#include <cmath>

namespace tetune {
namespace {

/// Planes that meet at a smaller angle, whose sine this is, define no line.
constexpr double kMinSine = 0.1;

/// A triangle of a patch. Those of an interface may have different orientations: `sign` is relative to the first one.
struct OrientedTriangle {
  Index triangle;
  double sign;
};

/// The vertex at a corner of the reference surface.
Index vertex_at(const ReferenceSurfaceOnHost& reference, Index corner) {
  return span_of(reference.triangles)[corner / 3].v[corner % 3];
}
/// The start of the edge opposite a corner, in the orientation of its triangle.
Index start_of_edge(const ReferenceSurfaceOnHost& reference, Index corner) {
  return vertex_at(reference, corner - corner % 3 + (corner + 1) % 3);
}
Vec3 position(const ReferenceSurfaceOnHost& reference, Index v) { return vec(span_of(reference.points)[v]); }

/// The normal of a triangle; its length is twice the area.
Vec3 area_normal(const ReferenceSurfaceOnHost& reference, const OrientedTriangle& t) {
  const Index* v = span_of(reference.triangles)[t.triangle].v;
  const Vec3 a = position(reference, v[0]);
  return t.sign * cross(position(reference, v[1]) - a, position(reference, v[2]) - a);
}

/// The triangles that are connected with one over edges that are no features; marks them as reached.
std::vector<OrientedTriangle> patch_around(const ReferenceSurfaceOnHost& reference, Index seed,
                                           std::vector<std::uint8_t>& is_reached) {
  std::vector<OrientedTriangle> patch{{seed, 1}};
  span_of(is_reached)[seed] = 1;
  for (std::size_t i = 0; i < patch.size(); ++i) {
    const OrientedTriangle t = patch[i];
    for (Index corner = 3 * t.triangle; corner < 3 * t.triangle + 3; ++corner) {
      const Index across = span_of(reference.across)[corner];
      if (across == kFeatureEdge || span_of(is_reached)[across / 3] != 0) continue;
      span_of(is_reached)[across / 3] = 1;
      const bool is_turned = start_of_edge(reference, corner) == start_of_edge(reference, across);
      patch.push_back({across / 3, is_turned ? -t.sign : t.sign});
    }
  }
  return patch;
}

/// The unit normal of the plane that a patch lies in; the zero vector where it lies in none, or folds back.
Vec3 normal_of_plane(const ReferenceSurfaceOnHost& reference, const std::vector<OrientedTriangle>& patch,
                     double tolerance) {
  Vec3 sum{0, 0, 0};
  for (const OrientedTriangle& t : patch) sum = sum + area_normal(reference, t);
  const double length = norm(sum);
  if (!(length > 0)) return {0, 0, 0};
  const Vec3 normal = (1 / length) * sum;
  const Vec3 origin = position(reference, vertex_at(reference, 3 * patch.front().triangle));
  for (const OrientedTriangle& t : patch) {
    if (!(dot(normal, area_normal(reference, t)) >= 0)) return {0, 0, 0};
    for (const Index v : span_of(reference.triangles)[t.triangle].v) {
      if (!(std::fabs(dot(normal, position(reference, v) - origin)) <= tolerance)) return {0, 0, 0};
    }
  }
  return normal;
}

}  // namespace

FlatPatches::FlatPatches(const ReferenceSurfaceOnHost& reference, double tolerance)
    : tolerance_(tolerance), triangle2patch_(reference.triangles.size(), -1) {
  std::vector<std::uint8_t> is_reached(reference.triangles.size(), 0);
  for (Index seed = 0; seed < std::ssize(reference.triangles); ++seed) {
    if (span_of(is_reached)[seed] != 0) continue;
    const std::vector<OrientedTriangle> patch = patch_around(reference, seed, is_reached);
    const Vec3 normal = normal_of_plane(reference, patch, tolerance);
    if (dot(normal, normal) == 0) continue;
    for (const OrientedTriangle& t : patch) span_of(triangle2patch_)[t.triangle] = to_index(normals_.size());
    normals_.push_back(normal);
  }
}

void FlatPatches::restrict_vertices(const ReferenceSurfaceOnHost& reference, std::vector<VertexDof>& dof,
                                    std::vector<Vec3>& axis) const {
  for (Index v = 0; v < std::ssize(dof); ++v) {
    if (!slides(span_of(dof)[v])) continue;
    const MotionSpace space = space_of(reference, v, span_of(dof)[v]);
    if (space.dof == VertexDof::fixed) continue;
    span_of(dof)[v] = space.dof;
    span_of(axis)[v] = space.axis;
  }
}

MotionSpace FlatPatches::space_of(const ReferenceSurfaceOnHost& reference, Index v, VertexDof dof) const {
  std::vector<Index> patches;
  for (const std::uint32_t corner : reference.corners_at(v)) {
    const Index patch = patch_of(to_index(corner / 3));
    if (patch < 0) return {VertexDof::fixed, {}};
    if (std::find(patches.begin(), patches.end(), patch) == patches.end()) patches.push_back(patch);
  }
  if (patches.empty()) return {VertexDof::fixed, {}};
  if (dof == VertexDof::curve) return line_of(reference, v, patches);
  return {VertexDof::plane, span_of(normals_)[patches.front()]};
}

MotionSpace FlatPatches::line_of(const ReferenceSurfaceOnHost& reference, Index v,
                                 const std::vector<Index>& patches) const {
  const Vec3 first = span_of(normals_)[patches.front()];
  Vec3 direction{0, 0, 0};
  for (const Index patch : patches) {
    const Vec3 meet = cross(first, span_of(normals_)[patch]);
    if (dot(meet, meet) > dot(direction, direction)) direction = meet;
  }
  const double sine = norm(direction);
  if (!(sine >= kMinSine)) return {VertexDof::fixed, {}};
  const Vec3 axis = (1 / sine) * direction;
  // The line of more than two patches, and of one that both sides of an edge belong to, need not be straight.
  for (const Index end : span_of(reference.line)[v].next) {
    const Vec3 edge = position(reference, end) - position(reference, v);
    if (!(norm(cross(axis, edge)) <= tolerance_)) return {VertexDof::fixed, {}};
    for (const Index patch : patches) {
      if (!(std::fabs(dot(axis, span_of(normals_)[patch])) * norm(edge) <= tolerance_)) return {VertexDof::fixed, {}};
    }
  }
  return {VertexDof::line, axis};
}

}  // namespace tetune
