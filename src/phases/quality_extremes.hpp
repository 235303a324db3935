// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "energy/criterion.hpp"
#include "energy/dihedral_cots.hpp"
#include "energy/quality_floor.hpp"
#include "mesh/work_mesh.hpp"
#include "phases/element_selection.hpp"

/// The largest energy, the extreme dihedral angles and the smallest mean ratio of a mesh (docs/method.md, "Quality
/// floor").
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

/// The cotangents of the extreme dihedral angles, and edge_term() of the smallest mean ratio.
struct WorstMeasures {
  DihedralCots cots;
  double max_edge_term = 0;
  TETUNE_HD void merge(const WorstMeasures& other) {
    cots.merge(other.cots);
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
    return {QualityFloor::dihedral_cots(p, w), edge_term(p, w)};
  }
};

struct MaxCot {
  MeshView mesh;
  TETUNE_HD Maximum operator()(Size t) const { return {mesh.alive(t) ? dihedral_cots(mesh, t).max : -1}; }
};

struct ComputeCost {
  MeshView mesh;
  Span<const double> shapes;
  double min_cost;
  double min_shape;
  double obtuse_weight;
  Span<double> costs;
  TETUNE_HD Maximum operator()(Size t) const {
    const double cost = shapes[t] > min_shape ? dihedral_cots(mesh, t).cost(obtuse_weight) : 0;
    costs[t] = cost > min_cost ? cost : 0;
    return {costs[t]};
  }
};

struct ComputeListedCost {
  ComputeCost compute;
  Span<const Index> tets;
  TETUNE_HD void operator()(Size i) const { compute(tets[i]); }
};

/// The largest cost; clears those of free slots.
struct LargestCost {
  Span<const double> shapes;
  Span<double> costs;
  TETUNE_HD Maximum operator()(Size t) const {
    if (shapes[t] == 0) costs[t] = 0;
    return {costs[t]};
  }
};

}  // namespace quality_extremes_detail

/// Per slot, the cost of its dihedral angles (DihedralCots::cost()) if that is above `min_cost`, else 0. `shapes` are
/// the shape energies of all slots, 0 in free ones.
template <class Backend>
class AngleExtremes {
 public:
  AngleExtremes(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes, double min_cost,
                double obtuse_weight)
      : costs_(backend, mesh.slots()),
        min_cost_(min_cost),
        min_shape_(QualityFloor::min_shape(min_cost)),
        obtuse_weight_(obtuse_weight) {
    if (obtuse_weight > 0) min_shape_ = std::min(min_shape_, QualityFloor::min_shape(-min_cost / obtuse_weight));
    set_largest(backend.template reduce<Maximum>(mesh.slots(), compute(mesh, shapes)));
  }
  /// Computes the costs of the listed tetrahedra again; among them are all that have changed.
  void update(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes, Span<const Index> tets) {
    using namespace quality_extremes_detail;
    costs_.grow(backend, mesh.slots());
    backend.for_each(tets.size(), ComputeListedCost{compute(mesh, shapes), tets});
    set_largest(backend.template reduce<Maximum>(mesh.slots(), LargestCost{shapes, costs_.span()}));
  }
  /// Clears the costs of the tetrahedra that have no flagged vertex; the largest cost stays.
  void clear_outside(const Backend& backend, WorkMesh<Backend>& mesh, Span<const std::uint8_t> flags) {
    tetune::clear_outside(backend, mesh, flags, costs_.span());
  }

  Span<const double> costs() const { return costs_.span(); }
  /// The largest cost, at least `min_cost`.
  double largest() const { return largest_; }
  /// A cost that about `max_above` tetrahedra exceed, at least `min_cost`. The bisection is of sqrt(1 + cost^2), which
  /// is 1 / sin of a small angle, at values that do not depend on the mesh.
  double quantile(const Backend& backend, double max_above, double resolution) const {
    const auto cost_of = [](double x) { return std::sqrt(x * x - 1); };
    return std::max(min_cost_, cost_of(upper_quantile(backend, costs(), max_above, resolution, cost_of)));
  }
  /// The number of tetrahedra above a cost, which is at least `min_cost`.
  Size count_above(const Backend& backend, double cost) const {
    using namespace element_selection_detail;
    return backend.template reduce<Counts<1>>(costs().size(), CountAbove<1>{costs(), {cost}}).above[0];
  }

 private:
  using Maximum = quality_extremes_detail::Maximum;
  auto compute(WorkMesh<Backend>& mesh, Span<const double> shapes) {
    return quality_extremes_detail::ComputeCost{mesh.view(), shapes,         min_cost_,
                                                min_shape_,  obtuse_weight_, costs_.span()};
  }
  void set_largest(const Maximum& found) { largest_ = std::max(min_cost_, found.value); }

  BufferOf<Backend, double> costs_;
  double min_cost_, min_shape_, obtuse_weight_;
  double largest_ = 0;
};

/// The worst shape energy, dihedral angles and mean ratio, as bounds that no tetrahedron may exceed, but for angles up
/// to that of the cotangent `allowed_cot`, which are allowed in every mesh. `shapes` are the shape energies of all
/// slots: only tetrahedra of a large energy can have extreme angles or a small mean ratio.
template <class Backend>
QualityFloor find_floor(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes,
                        double allowed_cot = QualityFloor::kAllowedCot) {
  using namespace quality_extremes_detail;
  const auto measure_above = [&](double bound) {
    return backend.template reduce<WorstMeasures>(mesh.slots(), MeasureAbove{mesh.view(), shapes, bound});
  };
  QualityFloor floor;
  floor.worst_shape = backend.template reduce<Maximum>(mesh.slots(), ValueOf{shapes}).value;
  WorstMeasures worst = measure_above(0.5 * floor.worst_shape);
  worst.cots.min = std::min(worst.cots.min, allowed_cot);
  worst.merge(measure_above(std::min({QualityFloor::min_shape(worst.cots.max), QualityFloor::min_shape(worst.cots.min),
                                      QualityFloor::min_shape_of_mean_ratio(worst.max_edge_term)})));
  floor.max_cot = worst.cots.max;
  floor.min_cot = worst.cots.min;
  floor.max_edge_term = worst.max_edge_term;
  floor.add_tolerance();
  return floor;
}

/// Returns the cotangent of the smallest dihedral angle.
template <class Backend>
double find_max_cot(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace quality_extremes_detail;
  return backend.template reduce<Maximum>(mesh.slots(), MaxCot{mesh.view()}).value;
}

}  // namespace tetune
