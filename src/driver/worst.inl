// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/quality_floor.hpp"
#include "core/work_mesh.hpp"
#include "par/atomic.hpp"
#include "vertices/angle_ring.hpp"

/// Which tetrahedra are the worst, for work on them alone (docs/method.md, "Worst first").
namespace tetune {
namespace worst_detail {

struct WorstCount {
  Size count = 0;
  TETUNE_HD void merge(const WorstCount& other) { count += other.count; }
};

struct IsAbove {
  Span<const double> values;
  double bound;
  TETUNE_HD bool operator()(Size t) const { return values[t] > bound; }
};

struct HasFlag {
  MeshView mesh;
  Span<const std::uint8_t> flags;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    return (flags[tet[0]] | flags[tet[1]] | flags[tet[2]] | flags[tet[3]]) != 0;
  }
};

struct FlagCorners {
  Span<const Tet> tets;
  Span<const Index> slots;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size i) const {
    for (int k = 0; k < 4; ++k) par::store_shared(flags[tets[slots[i]][k]], std::uint8_t{1});
  }
};

/// The same of those with an angle whose cotangent is above `cot`.
struct FlagSharp {
  MeshView mesh;
  FlagCorners flag;
  double cot;
  TETUNE_HD void operator()(Size i) const {
    if (largest_cot(mesh, flag.slots[i]) > cot) flag(i);
  }
};

struct Most {
  double value = -1;
  TETUNE_HD void merge(const Most& other) { value = other.value > value ? other.value : value; }
};

struct ValueOf {
  Span<const double> values;
  TETUNE_HD Most operator()(Size t) const { return {values[t]}; }
};

struct CotAbove {
  MeshView mesh;
  IsAbove above;
  TETUNE_HD Most operator()(Size t) const { return {above(t) ? largest_cot(mesh, t) : -1}; }
};

struct CotOf {
  MeshView mesh;
  TETUNE_HD Most operator()(Size t) const { return {mesh.alive(t) ? largest_cot(mesh, t) : -1}; }
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

/// One over the sine of the smallest dihedral angle, where the shape energy leaves room for a cotangent above `least`;
/// 0 elsewhere.
struct FindSharpness {
  MeshView mesh;
  Span<const double> shapes;
  double least;
  double least_shape;
  Span<double> values;
  TETUNE_HD Most operator()(Size t) const {
    const double cot = shapes[t] > least_shape ? largest_cot(mesh, t) : 0;
    values[t] = cot > least ? std::sqrt(1 + cot * cot) : 0;
    return {cot};
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

/// The tetrahedra for which a predicate over the slots holds.
template <class Backend, class Is>
typename Backend::template Buffer<Index> find_tets(const Backend& par, WorkMesh<Backend>& mesh, const Is& is) {
  typename Backend::template Buffer<Index> tets(mesh.slots());
  tets.resize(par.compact(mesh.slots(), is, tets.span()));
  return tets;
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

/// About the cotangent of the dihedral angle that is larger than the smallest of a part of `count` tetrahedra, of whose
/// smallest angles one over the sine is given.
template <class Backend>
double sharp_cot(const Backend& par, Span<const double> sharpness, double part, Size count) {
  const double above = quantile_above(par, sharpness, part, count);
  return std::sqrt(above * above - 1);
}

/// One over the sine of the smallest dihedral angle of each slot, where its cotangent is above `least`, and 0
/// elsewhere; and the largest cotangent, or `least`. `shapes` are the shape energies of all slots.
template <class Backend>
struct Sharpness {
  typename Backend::template Buffer<double> values;
  double most_cot;

  Sharpness(const Backend& par, WorkMesh<Backend>& mesh, Span<const double> shapes, double least)
      : values(mesh.slots()) {
    using namespace worst_detail;
    const FindSharpness find{mesh.view(), shapes, least, QualityFloor::least_shape(least), values.span()};
    most_cot = std::max(least, par.template reduce<Most>(mesh.slots(), find).value);
  }
};

/// The worst shape energy and dihedral angle of a mesh, as what nothing may go below. `shapes` are the shape energies
/// of all slots: only where they are large the angles may be small.
template <class Backend>
QualityFloor find_floor(const Backend& par, WorkMesh<Backend>& mesh, Span<const double> shapes) {
  using namespace worst_detail;
  const auto most_cot = [&](double above) {
    return par.template reduce<Most>(mesh.slots(), CotAbove{mesh.view(), {shapes, above}}).value;
  };
  QualityFloor floor;
  floor.worst_shape = par.template reduce<Most>(mesh.slots(), ValueOf{shapes}).value;
  const double among_worst = most_cot(0.5 * floor.worst_shape);
  floor.most_cot = std::max(among_worst, most_cot(QualityFloor::least_shape(among_worst)));
  floor.settle();
  return floor;
}

/// Cotangent of the smallest dihedral angle.
template <class Backend>
double find_most_cot(const Backend& par, WorkMesh<Backend>& mesh) {
  return par.template reduce<worst_detail::Most>(mesh.slots(), worst_detail::CotOf{mesh.view()}).value;
}

/// The tetrahedra whose value, of those given for all slots, is above `bound`.
template <class Backend>
typename Backend::template Buffer<Index> tets_above(const Backend& par, WorkMesh<Backend>& mesh,
                                                    Span<const double> values, double bound) {
  return find_tets(par, mesh, worst_detail::IsAbove{values, bound});
}

/// Those that have a flagged vertex.
template <class Backend>
typename Backend::template Buffer<Index> flagged_tets(const Backend& par, WorkMesh<Backend>& mesh,
                                                      Span<const std::uint8_t> flags) {
  return find_tets(par, mesh, worst_detail::HasFlag{mesh.view(), flags});
}

/// Flags the vertices of some tetrahedra.
template <class Backend>
void flag_corners(const Backend& par, WorkMesh<Backend>& mesh, Span<const Index> tets, Span<std::uint8_t> flags) {
  par.for_each(tets.size(), worst_detail::FlagCorners{mesh.tet2vertex.span(), tets, flags});
}

/// The same of those of them that have an angle whose cotangent is above `cot`.
template <class Backend>
void flag_sharp(const Backend& par, WorkMesh<Backend>& mesh, Span<const Index> tets, double cot,
                Span<std::uint8_t> flags) {
  par.for_each(tets.size(), worst_detail::FlagSharp{mesh.view(), {mesh.tet2vertex.span(), tets, flags}, cot});
}

}  // namespace tetune
