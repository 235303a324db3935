// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/objective.hpp"
#include "energy/quality_floor.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// The objective that an operation minimizes, the quality floor that no tetrahedron may violate, and the weight of
/// large angles where the extreme angles are improved (DihedralCots::cost()).
struct Criterion {
  Objective objective = kHarmonicObjective;
  QualityFloor floor = QualityFloor::none();
  double obtuse_weight = 0;
};

/// A mesh and the criterion by which a kernel rates its tetrahedra, passed to kernels by value.
struct RatedMesh : MeshView {
  Objective objective;
  QualityFloor floor;
  double obtuse_weight;
};

template <class Backend>
RatedMesh rated(WorkMesh<Backend>& mesh, const Criterion& criterion) {
  return {mesh.view(), criterion.objective, criterion.floor, criterion.obtuse_weight};
}

}  // namespace tetune
