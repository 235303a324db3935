// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "energy/quality_floor.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/min_angle_ring.hpp"

/// The largest energy and the smallest dihedral angle of a mesh (docs/method.md, "The worst elements").
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

/// The cotangent of the smallest angle of a tetrahedron whose energy is above a bound.
struct MaxCotAbove {
  MeshView mesh;
  Span<const double> energies;
  double bound;
  TETUNE_HD Maximum operator()(Size t) const { return {energies[t] > bound ? max_dihedral_cot(mesh, t) : -1}; }
};

struct MaxCot {
  MeshView mesh;
  TETUNE_HD Maximum operator()(Size t) const { return {mesh.alive(t) ? max_dihedral_cot(mesh, t) : -1}; }
};

struct ComputeSharpness {
  MeshView mesh;
  Span<const double> shapes;
  double min_cot;
  double min_shape;
  Span<double> values;
  TETUNE_HD Maximum operator()(Size t) const {
    const double cot = shapes[t] > min_shape ? max_dihedral_cot(mesh, t) : 0;
    values[t] = cot > min_cot ? std::sqrt(1 + cot * cot) : 0;
    return {cot};
  }
};

}  // namespace quality_extremes_detail

/// The sharpness of each slot: 1 / sin of its smallest dihedral angle if the cotangent is above `min_cot`, else 0. And
/// the largest cotangent, at least `min_cot`. `shapes` are the shape energies of all slots.
template <class Backend>
struct Sharpness {
  typename Backend::template Buffer<double> values;
  double max_cot;

  Sharpness(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes, double min_cot)
      : values(backend, mesh.slots()) {
    using namespace quality_extremes_detail;
    const ComputeSharpness compute{mesh.view(), shapes, min_cot, QualityFloor::min_shape(min_cot), values.span()};
    max_cot = std::max(min_cot, backend.template reduce<Maximum>(mesh.slots(), compute).value);
  }
};

/// The largest shape energy and the smallest dihedral angle, as bounds that no tetrahedron may exceed. `shapes` are the
/// shape energies of all slots: only tetrahedra of a large energy can have small angles.
template <class Backend>
QualityFloor find_floor(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> shapes) {
  using namespace quality_extremes_detail;
  const auto max_cot_above = [&](double bound) {
    return backend.template reduce<Maximum>(mesh.slots(), MaxCotAbove{mesh.view(), shapes, bound}).value;
  };
  QualityFloor floor;
  floor.worst_shape = backend.template reduce<Maximum>(mesh.slots(), ValueOf{shapes}).value;
  const double cot_of_worst = max_cot_above(0.5 * floor.worst_shape);
  floor.max_cot = std::max(cot_of_worst, max_cot_above(QualityFloor::min_shape(cot_of_worst)));
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
