// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "energy/harmonic.hpp"
#include "flips/flip.hpp"
#include "par/pack.hpp"

/// What a flip is worth: the best way to fill its cavity. For an edge removal that is the best of all triangulations
/// of the ring, found by dynamic programming (Klincsek, "Minimal triangulations of polygonal domains", 1980): the
/// energy is a sum over triangles.
namespace tetune {

/// Energy of the tetrahedron (0, u, v, w), over the law's factor; kNever where its volume is not certified positive.
template <class T>
TETUNE_HD TETUNE_INLINE T corner_energy(const EnergyLaw& law, const Vec3T<T>& u, const Vec3T<T>& v, const Vec3T<T>& w) {
  const Vec3T<T> uv = cross(u, v);
  const Vec3T<T> vw = cross(v, w);
  const Vec3T<T> wu = cross(w, u);
  const Vec3T<T> face = uv + vw + wu;
  const T det = dot(uv, w);
  const T energy = law.term(dot(uv, uv) + dot(vw, vw) + dot(wu, wu) + dot(face, face), 1.0 / det);
  const T margin = det * det - kVolumeMargin * (dot(u, u) * dot(v, v) * dot(w, w));
  return ((det > 0.0) & (margin > 0.0)) ? energy : T{} + kNever;
}

/// A ring seen from the two ends of its edge. The ears of its triangulations, that is the triangles of three vertices
/// in a row, are evaluated together; for most rings they show that no triangulation is good enough.
template <class Pack>
class RingFans {
 public:
  TETUNE_HD RingFans(const MeshView& mesh, const Cavity& c) : law_(mesh.law), n_(c.ring_size) {
    const Vec3 a = vec(mesh.points[c.a]);
    const Vec3 b = vec(mesh.points[c.b]);
    for (int m = 0; m < n_; ++m) {
      const Vec3 r = vec(mesh.points[c.ring[m]]);
      from_a_.set(m, r - a);
      from_b_.set(m, r - b);
    }
    for (int m = n_; m < (n_ > 4 ? 8 : 4) + 2; ++m) {
      from_a_.set(m, from_a_[m - n_]);
      from_b_.set(m, from_b_[m - n_]);
    }
    for (int m = 0; m < n_; m += kLanes) {
      const Pack energies = corner_energy(law_, from_a_.pack(m), from_a_.pack(m + 1), from_a_.pack(m + 2)) +
                            corner_energy(law_, from_b_.pack(m), from_b_.pack(m + 2), from_b_.pack(m + 1));
      std::memcpy(ears_ + m, &energies, sizeof energies);
    }
  }

  /// Finds the triangulation of least energy, and returns that; `limit` when none is below it.
  TETUNE_HD double best(double limit, Triangulation& triangulation) const {
    if (!(law_.factor * least_ears() < limit)) return limit;
    return law_.factor * triangulate(limit / law_.factor, triangulation);
  }

 private:
  static constexpr int kLanes = sizeof(Pack) / sizeof(double);

  /// Each triangulation of four or more vertices has two ears that do not overlap.
  TETUNE_HD double least_ears() const {
    double least = kNever;
    for (int i = 0; i + 2 < n_; ++i) {
      for (int j = i + 2; j < (i == 0 ? n_ - 1 : n_); ++j) {
        const double ears = ears_[i] + ears_[j];
        least = ears < least ? ears : least;
      }
    }
    return least;
  }

  TETUNE_HD double triangulate(double limit, Triangulation& triangulation) const {
    double least[kMaxRing][kMaxRing];
    std::uint8_t apex[kMaxRing][kMaxRing];
    for (int i = 0; i + 1 < n_; ++i) least[i][i + 1] = 0;
    for (int length = 2; length < n_; ++length) {
      for (int i = 0; i + length < n_; ++i) {
        const int k = i + length;
        least[i][k] = limit;
        for (int j = i + 1; j < k; ++j) {
          const double sides = least[i][j] + least[j][k];
          if (!(sides < least[i][k])) continue;
          const double sum = sides + triangle(i, j, k);
          if (!(sum < least[i][k])) continue;
          least[i][k] = sum;
          apex[i][k] = static_cast<std::uint8_t>(j);
        }
      }
    }
    if (!(least[0][n_ - 1] < limit)) return limit;
    // Each triangle leaves the polygons beyond two of its sides for later.
    int count = 0;
    int open = 1;
    std::uint8_t polygons[kMaxRing][2] = {{0, static_cast<std::uint8_t>(n_ - 1)}};
    while (open > 0) {
      --open;
      const std::uint8_t i = polygons[open][0];
      const std::uint8_t k = polygons[open][1];
      if (k - i < 2) continue;
      const std::uint8_t j = apex[i][k];
      triangulation.corner[count][0] = polygons[open][0] = i;
      triangulation.corner[count][1] = polygons[open][1] = polygons[open + 1][0] = j;
      triangulation.corner[count][2] = polygons[open + 1][1] = k;
      ++count;
      open += 2;
    }
    return least[0][n_ - 1];
  }

  struct Fan {
    double x[10], y[10], z[10];
    TETUNE_HD void set(int m, const Vec3& v) {
      x[m] = v.x;
      y[m] = v.y;
      z[m] = v.z;
    }
    TETUNE_HD TETUNE_INLINE Vec3 operator[](int m) const { return {x[m], y[m], z[m]}; }
    /// Vertices m, m + 1, ...
    TETUNE_HD TETUNE_INLINE Vec3T<Pack> pack(int m) const {
      Vec3T<Pack> v;
      std::memcpy(&v.x, x + m, sizeof(Pack));
      std::memcpy(&v.y, y + m, sizeof(Pack));
      std::memcpy(&v.z, z + m, sizeof(Pack));
      return v;
    }
  };

  /// Energy of the two tetrahedra on a triangle, over the law's factor.
  TETUNE_HD TETUNE_INLINE double pair(int i, int j, int k) const {
    return corner_energy(law_, from_a_[i], from_a_[j], from_a_[k]) +
           corner_energy(law_, from_b_[i], from_b_[k], from_b_[j]);
  }

  TETUNE_HD double triangle(int i, int j, int k) const {
    if (k == i + 2) return ears_[i];
    if (k == i + n_ - 1 && j == i + 1) return ears_[k];
    if (k == i + n_ - 1 && j == k - 1) return ears_[j];
    return pair(i, j, k);
  }

  EnergyLaw law_;
  int n_;
  Fan from_a_, from_b_;
  double ears_[8];
};

/// Energy of the tetrahedra a flip would make; `limit` where one of them is not certified positive or is worse than the
/// floor, or the sum is not below `limit`.
TETUNE_HD inline double energy_after(const MeshView& mesh, const Cavity& c, const Triangulation& triangulation,
                                     double limit) {
  double sum = 0;
  for (int x = 0; x < c.made(); ++x) {
    const Tet t = new_tet(c, triangulation, x);
    const Vec3 p[4] = {vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]), vec(mesh.points[t[3]])};
    const TetEnergy e = tet_energy(mesh.law, p[0], p[1], p[2], p[3]);
    sum += e.energy;
    if (!e.certified || !(sum < limit)) return limit;
    if (e.shape > mesh.floor.safe_shape && !mesh.floor.allows(e.shape, p, e.w)) return limit;
  }
  return sum;
}

/// Whether the volumes that a flip of three ring vertices makes look positive: the cheapest test.
TETUNE_HD inline bool may_be_valid(const MeshView& mesh, const Cavity& c) {
  const Vec3 a = vec(mesh.points[c.a]);
  const Vec3 ab = vec(mesh.points[c.b]) - a;
  const Vec3 ap = vec(mesh.points[c.ring[0]]) - a;
  const Vec3 aq = vec(mesh.points[c.ring[1]]) - a;
  const Vec3 ar = vec(mesh.points[c.ring[2]]) - a;
  const Vec3 apq = cross(ap, aq);
  if (c.kind == FlipKind::face_removal) {
    return dot(apq, ab) > 0 && dot(cross(aq, ar), ab) > 0 && dot(cross(ar, ap), ab) > 0;
  }
  return dot(apq, ar) > 0 && dot(cross(aq - ap, ar - ap), ab - ap) > 0;
}

/// The least energy that a flip can leave in its cavity instead of `before`, and the triangulation that does; `limit`
/// when it is not below that. Exact where it is below `before`: as the new tetrahedra will have it. A function of its
/// own in the machine code, so that its bits are the same wherever it is called.
template <class Pack = par::Pack>
TETUNE_HD __attribute__((noinline)) double best_energy(const MeshView& mesh, const Cavity& c, double before,
                                                       double limit, Triangulation& triangulation) {
  if (c.ring_size == 3) {
    if (!may_be_valid(mesh, c)) return limit;
    for (std::uint8_t k = 0; k < 3; ++k) triangulation.corner[0][k] = k;
  } else {
    const double estimate = RingFans<Pack>(mesh, c).best(limit, triangulation);
    if (!(estimate < before)) return estimate;
  }
  return energy_after(mesh, c, triangulation, limit);
}

}  // namespace tetune
