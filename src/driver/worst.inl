// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/quality_floor.hpp"
#include "core/work_mesh.hpp"
#include "energy/harmonic.hpp"
#include "par/atomic.hpp"
#include "vertices/angle_ring.hpp"

/// Which tetrahedra are the worst, for work on them alone (docs/method.md, "Worst first").
namespace tetune {
namespace worst_detail {

struct WorstCount {
  Size count = 0;
  TETUNE_HD void merge(const WorstCount& other) { count += other.count; }
};

/// Flags the vertices of the tetrahedra whose shape energy is above a bound.
struct FlagWorst {
  MeshView mesh;
  double bound;
  Span<std::uint8_t> flags;
  TETUNE_HD WorstCount operator()(Size t) const {
    if (!mesh.alive(t)) return {};
    const Tet tet = mesh.tet2vertex[t];
    const TetEnergy e = tet_energy(mesh.law, vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]),
                                   vec(mesh.points[tet[2]]), vec(mesh.points[tet[3]]));
    if (!(e.shape > bound)) return {};
    for (int k = 0; k < 4; ++k) par::store_shared(flags[tet[k]], std::uint8_t{1});
    return {1};
  }
};

struct FloorOf {
  MeshView mesh;
  TETUNE_HD QualityFloor operator()(Size t) const {
    if (!mesh.alive(t)) return {};
    const Tet tet = mesh.tet2vertex[t];
    const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                       vec(mesh.points[tet[3]])};
    const TetEnergy e = tet_energy(mesh.law, p[0], p[1], p[2], p[3]);
    return {e.shape, QualityFloor::largest_cot(p, e.w), 0};
  }
};

/// Flags with 2 the vertices that share a tetrahedron with one flagged with 1.
struct FlagNeighbours {
  MeshView mesh;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size t) const {
    if (!mesh.alive(t)) return;
    const Tet tet = mesh.tet2vertex[t];
    bool near = false;
    for (int k = 0; k < 4; ++k) near = near || par::load_shared(flags[tet[k]]) == 1;
    for (int k = 0; k < 4 && near; ++k) {
      if (par::load_shared(flags[tet[k]]) == 0) par::store_shared(flags[tet[k]], std::uint8_t{2});
    }
  }
};

/// One over the sine of the smallest dihedral angle; 0 for a free slot.
struct Sharpness {
  MeshView mesh;
  Span<double> values;
  TETUNE_HD void operator()(Size t) const {
    const double cot = mesh.alive(t) ? largest_cot(mesh, t) : 0;
    values[t] = mesh.alive(t) ? std::sqrt(1 + cot * cot) : 0;
  }
};

/// Flags the vertices of the tetrahedra with an angle below a bound.
struct FlagSharp {
  MeshView mesh;
  double cot;
  Span<std::uint8_t> flags;
  TETUNE_HD WorstCount operator()(Size t) const {
    if (!mesh.alive(t) || !(largest_cot(mesh, t) > cot)) return {};
    for (int k = 0; k < 4; ++k) par::store_shared(flags[mesh.tet2vertex[t][k]], std::uint8_t{1});
    return {1};
  }
};

struct CountAbove {
  Span<const double> values;
  double bound;
  TETUNE_HD WorstCount operator()(Size i) const { return {values[i] > bound ? 1 : 0}; }
};

}  // namespace worst_detail

/// Flags those too that share a tetrahedron with a flagged vertex: without room the worst cannot improve.
template <class Backend>
void flag_neighbours(const Backend& par, WorkMesh<Backend>& mesh, Span<std::uint8_t> flags) {
  par.for_each(mesh.slots(), worst_detail::FlagNeighbours{mesh.view(), flags});
}

/// About the value that a part of `count` values, all 1 or more, are above.
template <class Backend>
double quantile_above(const Backend& par, Span<const double> values, double part, Size count) {
  const auto most = static_cast<Size>(part * static_cast<double>(count));
  double low = 1;
  double high = 1e6;
  while (high > 1.01 * low) {
    const double middle = std::sqrt(low * high);
    const Size above =
        par.template reduce<worst_detail::WorstCount>(values.size(), worst_detail::CountAbove{values, middle}).count;
    (above > most ? low : high) = middle;
  }
  return low;
}

/// About the cotangent of the dihedral angle that is larger than the smallest of a part of all tetrahedra.
template <class Backend>
double sharp_cot(const Backend& par, WorkMesh<Backend>& mesh, double part) {
  typename Backend::template Buffer<double> sharpness(mesh.slots());
  par.for_each(mesh.slots(), worst_detail::Sharpness{mesh.view(), sharpness.span()});
  const double above = quantile_above(par, Span<const double>(sharpness.span()), part, mesh.tets());
  return std::sqrt(above * above - 1);
}

/// The worst shape energy and dihedral angle of a mesh, as what nothing may go below.
template <class Backend>
QualityFloor find_floor(const Backend& par, WorkMesh<Backend>& mesh) {
  QualityFloor floor = par.template reduce<QualityFloor>(mesh.slots(), worst_detail::FloorOf{mesh.view()});
  floor.settle();
  return floor;
}

/// Flags the vertices of the tetrahedra with an angle whose cotangent is above `cot`; returns the number of those.
template <class Backend>
Size flag_sharp(const Backend& par, WorkMesh<Backend>& mesh, double cot, Span<std::uint8_t> flags) {
  return par.template reduce<worst_detail::WorstCount>(mesh.slots(), worst_detail::FlagSharp{mesh.view(), cot, flags})
      .count;
}

/// Flags the vertices of the tetrahedra whose shape energy is above `bound`, clears the flags of all others, and
/// returns the number of those tetrahedra.
template <class Backend>
Size flag_worst(const Backend& par, WorkMesh<Backend>& mesh, double bound, Span<std::uint8_t> flags) {
  par.fill(flags, std::uint8_t{0});
  return par.template reduce<worst_detail::WorstCount>(mesh.slots(), worst_detail::FlagWorst{mesh.view(), bound, flags})
      .count;
}

}  // namespace tetune
