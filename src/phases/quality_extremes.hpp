// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "energy/criterion.hpp"
#include "energy/dihedral_cots.hpp"
#include "energy/quality_floor.hpp"
#include "mesh/work_mesh.hpp"

/// The largest energy, the smallest dihedral angle and the smallest mean ratio of a mesh (docs/method.md, "The worst
/// elements").
namespace tetune {
namespace quality_extremes_detail {

struct Maximum {
  double value = -1;
  TETUNE_HD void merge(const Maximum& other) { value = other.value > value ? other.value : value; }
};

struct ValueOf {
  Span<const double> values;
  TETUNE_HD Maximum operator()(Size t) const { return {values[t]}; }
};

/// The cotangent of the smallest dihedral angle, and edge_term() of the smallest mean ratio.
struct WorstMeasures {
  double max_cot = -1, max_edge_term = 0;
  TETUNE_HD void merge(const WorstMeasures& other) {
    max_cot = other.max_cot > max_cot ? other.max_cot : max_cot;
    max_edge_term = other.max_edge_term > max_edge_term ? other.max_edge_term : max_edge_term;
  }
};

/// The worst measures of the tetrahedra whose shape energy is above a bound.
struct MeasureAbove {
  MeshView mesh;
  Span<const double> shapes;
  double bound;
  TETUNE_HD WorstMeasures operator()(Size t) const {
    if (!(shapes[t] > bound)) return {};
    const Tet tet = mesh.tet2vertex[t];
    const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                       vec(mesh.points[tet[3]])};
    const double w = six_volume_or_bound(p);
    return {QualityFloor::dihedral_cots(p, w).max, edge_term(p, w)};
  }
};

/// The cotangent of the largest angle of a tetrahedron whose energy is above a bound, with the sign changed.
struct MaxNegatedCotAbove {
  MeshView mesh;
  Span<const double> energies;
  double bound;
  TETUNE_HD Maximum operator()(Size t) const { return {energies[t] > bound ? -dihedral_cots(mesh, t).min : -1}; }
};

struct MaxCot {
  MeshView mesh;
  TETUNE_HD Maximum operator()(Size t) const { return {mesh.alive(t) ? dihedral_cots(mesh, t).max : -1}; }
};

struct ComputeExtremeness {
  MeshView mesh;
  Span<const double> shapes;
  double min_cost;
  double min_shape;
  double obtuse_weight;
  Span<double> values;
  TETUNE_HD Maximum operator()(Size t) const {
    const double cost = shapes[t] > min_shape ? dihedral_cots(mesh, t).cost(obtuse_weight) : 0;
    values[t] = cost > min_cost ? std::sqrt(1 + cost * cost) : 0;
    return {cost};
  }
};

}  // namespace quality_extremes_detail

/// Per slot, the square root of 1 + cost^2 if the cost of its dihedral angles (DihedralCots::cost()) is above
/// `min_cost`, else 0; for a small angle this is 1 / sin. `max_cost` is the largest cost, at least `min_cost`. `shapes`
/// are the shape energies of all slots.
template <class Backend>
struct AngleExtremes {
  BufferOf<Backend, double> values;
  double max_cost;

  AngleExtremes(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes, double min_cost,
                double obtuse_weight)
      : values(backend, mesh.slots()) {
    using namespace quality_extremes_detail;
    double min_shape = QualityFloor::min_shape(min_cost);
    if (obtuse_weight > 0) min_shape = std::min(min_shape, QualityFloor::min_shape(-min_cost / obtuse_weight));
    const ComputeExtremeness compute{mesh.view(), shapes, min_cost, min_shape, obtuse_weight, values.span()};
    max_cost = std::max(min_cost, backend.template reduce<Maximum>(mesh.slots(), compute).value);
  }
};

/// The largest shape energy, the smallest dihedral angle and the smallest mean ratio, as bounds that no tetrahedron may
/// exceed. `shapes` are the shape energies of all slots: only tetrahedra of a large energy can have small angles or a
/// small mean ratio.
template <class Backend>
QualityFloor find_floor(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes) {
  using namespace quality_extremes_detail;
  const auto measure_above = [&](double bound) {
    return backend.template reduce<WorstMeasures>(mesh.slots(), MeasureAbove{mesh.view(), shapes, bound});
  };
  QualityFloor floor;
  floor.worst_shape = backend.template reduce<Maximum>(mesh.slots(), ValueOf{shapes}).value;
  WorstMeasures worst = measure_above(0.5 * floor.worst_shape);
  worst.merge(measure_above(
      std::min(QualityFloor::min_shape(worst.max_cot), QualityFloor::min_shape_of_mean_ratio(worst.max_edge_term))));
  floor.max_cot = worst.max_cot;
  floor.max_edge_term = worst.max_edge_term;
  floor.add_tolerance();
  return floor;
}

/// Allows no dihedral angle that is larger than both the largest one of the mesh and that of the cotangent `cot`.
/// `shapes` are the shape energies of all slots.
template <class Backend>
void limit_largest_angle(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes, double cot,
                         QualityFloor& floor) {
  using namespace quality_extremes_detail;
  const MaxNegatedCotAbove largest{mesh.view(), shapes, QualityFloor::min_shape(cot)};
  const double negated = backend.template reduce<Maximum>(mesh.slots(), largest).value;
  floor.limit_angles({kInfeasible, -(1 + QualityFloor::kTolerance) * std::max(-cot, negated)});
}

/// Returns the cotangent of the smallest dihedral angle.
template <class Backend>
double find_max_cot(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace quality_extremes_detail;
  return backend.template reduce<Maximum>(mesh.slots(), MaxCot{mesh.view()}).value;
}

}  // namespace tetune
