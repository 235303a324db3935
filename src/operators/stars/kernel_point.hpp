// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/team.hpp"
#include "energy/harmonic.hpp"
#include "energy/ring.hpp"
#include "operators/stars/star_candidate.hpp"

namespace tetune {

namespace kernel_point_detail {

inline constexpr int kRelaxations = 30;
inline constexpr double kOverRelaxation = 1.5;
/// The height required over a face, in parts of the square root of twice its area.
inline constexpr double kHeight = 0.1;

}  // namespace kernel_point_detail

/// Moves x into the kernel of a star-shaped cavity, that is to where all its faces are visible, by steps over the plane
/// of the most violated face (relaxation: Agmon, Motzkin and Schoenberg, 1954). Returns false where it finds no such
/// place.
template <class Team>
TETUNE_HD bool move_into_kernel(Span<const Point> points, const LinkFace* faces, int face_count, Vec3& x,
                                const Team& team) {
  using namespace kernel_point_detail;
  // Face i belongs to thread i % kSize of the team.
  constexpr int kOwn = (kMaxStarFaces + Team::kSize - 1) / Team::kSize;
  Vec3 normal[kOwn];
  double height[kOwn];  // of the plane that x is to be above
  for (int i = team.rank(); i < face_count; i += Team::kSize) {
    const Vec3 p = vec(points[faces[i].v[0]]);
    const Vec3 n = opposite_face(p, vec(points[faces[i].v[1]]), vec(points[faces[i].v[2]])).n;
    const double twice_area = norm(n);
    normal[i / Team::kSize] = (1 / twice_area) * n;
    height[i / Team::kSize] = dot(normal[i / Team::kSize], p) + kHeight * std::sqrt(twice_area);
  }
  for (int step = 0; step < kRelaxations; ++step) {
    backend::IndexedMax below{0, -1};
    for (int i = team.rank(); i < face_count; i += Team::kSize) {
      below.add(height[i / Team::kSize] - dot(normal[i / Team::kSize], x), i);
    }
    below = team.merge(below);
    if (below.index < 0) return true;
    x = x +
        (kOverRelaxation * below.value) * team.broadcast(normal[below.index / Team::kSize], below.index % Team::kSize);
  }
  return false;
}

}  // namespace tetune
