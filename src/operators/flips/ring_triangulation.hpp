// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "backend/pack.hpp"
#include "energy/criterion.hpp"
#include "energy/harmonic.hpp"
#include "operators/flips/flip_candidate.hpp"

/// The best triangulation of the ring around an edge that is removed, by dynamic programming (Klincsek, "Minimal
/// triangulations of polygonal domains", 1980): the energy is a sum over triangles.
namespace tetune {

/// Energy of the tetrahedron (0, u, v, w), over the factor of the objective; kInfeasible where its volume is not
/// certified positive.
template <class T>
TETUNE_HD TETUNE_INLINE T corner_energy(const Objective& objective, const Vec3T<T>& u, const Vec3T<T>& v,
                                        const Vec3T<T>& w) {
  const Vec3T<T> uv = cross(u, v);
  const Vec3T<T> vw = cross(v, w);
  const Vec3T<T> wu = cross(w, u);
  const Vec3T<T> face = uv + vw + wu;
  const T det = dot(uv, w);
  const T energy = objective.term(dot(uv, uv) + dot(vw, vw) + dot(wu, wu) + dot(face, face), 1.0 / det);
  const T margin = det * det - kVolumeMargin * (dot(u, u) * dot(v, v) * dot(w, w));
  return ((det > 0.0) & (margin > 0.0)) ? energy : T{} + kInfeasible;
}

/// The vertices of a ring relative to an end of its edge, repeated beyond the last one, so that packs of consecutive
/// vertices can be loaded.
template <class Pack>
class RingFan {
 public:
  TETUNE_HD TETUNE_INLINE Vec3 operator[](int m) const { return {x_[m], y_[m], z_[m]}; }
  /// Vertices m, m + 1, ...
  TETUNE_HD TETUNE_INLINE Vec3T<Pack> pack(int m) const {
    return {backend::load<Pack>(x_ + m), backend::load<Pack>(y_ + m), backend::load<Pack>(z_ + m)};
  }

  /// Sets the fans of both ends.
  TETUNE_HD static void set(const MeshView& mesh, const FlipCandidate& c, RingFan& from_a, RingFan& from_b) {
    const Vec3 a = vec(mesh.points[c.a]);
    const Vec3 b = vec(mesh.points[c.b]);
    const int n = c.ring_size;
    for (int m = 0; m < n; ++m) {
      const Vec3 r = vec(mesh.points[c.ring[m]]);
      from_a.set(m, r - a);
      from_b.set(m, r - b);
    }
    for (int m = n; m < (n > 4 ? 8 : 4) + 2; ++m) {
      from_a.set(m, from_a[m - n]);
      from_b.set(m, from_b[m - n]);
    }
  }

 private:
  TETUNE_HD void set(int m, const Vec3& v) {
    x_[m] = v.x;
    y_[m] = v.y;
    z_[m] = v.z;
  }
  /// The ring in whole packs of four, and two more: loops read the next two vertices of each.
  static constexpr int kSize = 8 + 2;
  static_assert(kMaxRing <= 8 && sizeof(Pack) <= 4 * sizeof(double));
  double x_[kSize], y_[kSize], z_[kSize];
};

/// Where packs are single numbers, as on a GPU, positions are read again: there the memory of a thread costs more.
template <>
class RingFan<double> {
 public:
  TETUNE_HD TETUNE_INLINE Vec3 operator[](int m) const {
    return vec(points_[c_->ring[m < c_->ring_size ? m : m - c_->ring_size]]) - origin_;
  }
  TETUNE_HD TETUNE_INLINE Vec3 pack(int m) const { return (*this)[m]; }

  TETUNE_HD static void set(const MeshView& mesh, const FlipCandidate& c, RingFan& from_a, RingFan& from_b) {
    from_a.points_ = from_b.points_ = mesh.points;
    from_a.c_ = from_b.c_ = &c;
    from_a.origin_ = vec(mesh.points[c.a]);
    from_b.origin_ = vec(mesh.points[c.b]);
  }

 private:
  Span<const Point> points_;
  const FlipCandidate* c_ = nullptr;
  Vec3 origin_;
};

/// A ring relative to each of the two ends of its edge. The ears of its triangulations, that is the triangles of three
/// consecutive vertices, are evaluated together; for most rings they show that no triangulation is good enough.
template <class Pack>
class RingFans {
 public:
  TETUNE_HD RingFans(const RatedMesh& mesh, const FlipCandidate& c) : objective_(mesh.objective), n_(c.ring_size) {
    RingFan<Pack>::set(mesh, c, from_a_, from_b_);
    for (int m = 0; m < n_; m += kLanes) {
      const Pack energies = corner_energy(objective_, from_a_.pack(m), from_a_.pack(m + 1), from_a_.pack(m + 2)) +
                            corner_energy(objective_, from_b_.pack(m), from_b_.pack(m + 2), from_b_.pack(m + 1));
      std::memcpy(ears_ + m, &energies, sizeof energies);
    }
  }

  /// Finds the triangulation of minimum energy, and returns that energy; `limit` when none is below it.
  TETUNE_HD double best(double limit, Triangulation& triangulation) const {
    if (!(objective_.factor * min_ears() < limit)) return limit;
    return objective_.factor * triangulate(limit / objective_.factor, triangulation);
  }

 private:
  static constexpr int kLanes = kLanesOf<Pack>;
  static constexpr int kPolygons = kMaxRing * (kMaxRing - 1) / 2;
  /// Increases by 1 with i, and by k with k.
  TETUNE_HD TETUNE_INLINE static int interval_index(int i, int k) { return k * (k - 1) / 2 + i; }

  /// Each triangulation of four or more vertices has two ears that do not overlap.
  TETUNE_HD double min_ears() const {
    double min_energy = kInfeasible;
    for (int i = 0; i + 2 < n_; ++i) {
      for (int j = i + 2; j < (i == 0 ? n_ - 1 : n_); ++j) {
        const double ears = ears_[i] + ears_[j];
        min_energy = ears < min_energy ? ears : min_energy;
      }
    }
    return min_energy;
  }

  TETUNE_HD double triangulate(double limit, Triangulation& triangulation) const {
    // Of the polygon from vertex i to vertex k, at interval_index(i, k).
    double min_energy[kPolygons];
    std::uint8_t apex[kPolygons];
    for (int i = 0; i + 1 < n_; ++i) min_energy[interval_index(i, i + 1)] = 0;
    for (int length = 2; length < n_; ++length) {
      for (int i = 0; i + length < n_; ++i) {
        const int k = i + length;
        const int polygon = interval_index(i, k);
        min_energy[polygon] = limit;
        for (int j = i + 1, to_j = interval_index(i, j); j < k; to_j += j, ++j) {
          const double sides = min_energy[to_j] + min_energy[polygon + j - i];
          if (!(sides < min_energy[polygon])) continue;
          const double sum = sides + triangle(i, j, k);
          if (!(sum < min_energy[polygon])) continue;
          min_energy[polygon] = sum;
          apex[polygon] = static_cast<std::uint8_t>(j);
        }
      }
    }
    const double energy = min_energy[interval_index(0, n_ - 1)];
    if (!(energy < limit)) return limit;
    // Each triangle leaves the polygons beyond two of its sides on a stack.
    int count = 0;
    int open = 1;
    std::uint8_t polygons[kMaxRing][2] = {{0, static_cast<std::uint8_t>(n_ - 1)}};
    while (open > 0) {
      --open;
      const std::uint8_t i = polygons[open][0];
      const std::uint8_t k = polygons[open][1];
      if (k - i < 2) continue;
      const std::uint8_t j = apex[interval_index(i, k)];
      triangulation.corner[count][0] = polygons[open][0] = i;
      triangulation.corner[count][1] = polygons[open][1] = polygons[open + 1][0] = j;
      triangulation.corner[count][2] = polygons[open + 1][1] = k;
      ++count;
      open += 2;
    }
    return energy;
  }

  /// Energy of the two tetrahedra on a triangle, over the factor of the objective.
  TETUNE_HD TETUNE_INLINE double pair(int i, int j, int k) const {
    return corner_energy(objective_, from_a_[i], from_a_[j], from_a_[k]) +
           corner_energy(objective_, from_b_[i], from_b_[k], from_b_[j]);
  }

  TETUNE_HD double triangle(int i, int j, int k) const {
    if (k == i + 2) return ears_[i];
    if (k == i + n_ - 1 && j == i + 1) return ears_[k];
    if (k == i + n_ - 1 && j == k - 1) return ears_[j];
    return pair(i, j, k);
  }

  Objective objective_;
  int n_;
  RingFan<Pack> from_a_, from_b_;
  double ears_[8];
};

}  // namespace tetune
