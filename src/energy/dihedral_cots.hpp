// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/quality_floor.hpp"
#include "math/orient.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// Six times the volume of a tetrahedron, or of one per lane; where it is not certified, the bound on its error.
template <class T>
TETUNE_HD TETUNE_INLINE T six_volume_or_bound(const Vec3T<T> (&p)[4]) {
  const OrientT<T> o = orient(p[0], p[1], p[2], p[3]);
  return o.certified() ? o.det : o.bound;
}

/// The extreme cotangents of the dihedral angles of a tetrahedron, or of one per lane. Where its volume is not
/// certified, the bound on its error takes its place.
template <class T>
TETUNE_HD TETUNE_INLINE DihedralCotsT<T> dihedral_cots(const Vec3T<T> (&p)[4]) {
  return QualityFloor::dihedral_cots(p, six_volume_or_bound(p));
}
TETUNE_HD inline DihedralCots dihedral_cots(const MeshView& mesh, Size t) {
  const Tet tet = mesh.tet2vertex[t];
  const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                     vec(mesh.points[tet[3]])};
  return dihedral_cots(p);
}

}  // namespace tetune
