// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/flips/ring_triangulation.hpp"

/// The energy that a flip leaves behind.
namespace tetune {

/// Energy of the tetrahedra that a flip makes; `limit` where one of them is not certified positive or is worse than the
/// floor, or the sum is not below `limit`.
TETUNE_HD inline double energy_after(const RatedMesh& mesh, const FlipCandidate& c, double limit) {
  double sum = 0;
  for (int x = 0; x < c.new_count(); ++x) {
    const Tet t = c.new_tet(x);
    const Vec3 p[4] = {vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]), vec(mesh.points[t[3]])};
    const TetEnergy e = tet_energy(mesh.objective, p[0], p[1], p[2], p[3]);
    sum += e.energy;
    if (!e.certified || !(sum < limit)) return limit;
    if (e.shape > mesh.floor.safe_shape && !mesh.floor.allows(e.shape, p, e.w)) return limit;
  }
  return sum;
}

/// Whether the volumes that a flip of three ring vertices makes are positive but for round-off: the cheapest test.
TETUNE_HD inline bool may_be_valid(const RatedMesh& mesh, const FlipCandidate& c) {
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

/// The minimum energy that a flip can leave in its cavity instead of `before`, and the triangulation that does; `limit`
/// when it is not below that. Exact where it is below `before`: equal to the sum for the new tetrahedra.
template <class Pack>
TETUNE_HD double best_energy(const RatedMesh& mesh, FlipCandidate& c, double before, double limit) {
  if (c.ring_size == 3) {
    if (!may_be_valid(mesh, c)) return limit;
  } else {
    const double estimate = RingFans<Pack>(mesh, c).best(limit, c.triangulation);
    if (!(estimate < before)) return estimate;
  }
  return energy_after(mesh, c, limit);
}

}  // namespace tetune
