// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "mesh/id_maps.hpp"
#include "operators/flips/flip_pass.hpp"
#include "phases/element_selection.hpp"
#include "phases/optimizer.hpp"
#include "phases/untangle/surface_folds.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace untangle_detail {

/// Makes the vertices of tangled tetrahedra the active ones. Returns the number of these tetrahedra.
template <class Backend>
Size activate_tangled(const Backend& backend, WorkingSet<Backend>& work) {
  const auto tets = find_tets(backend, work.mesh, HasUncertifiedVolume{work.mesh.view()});
  const Span<std::uint8_t> active = work.dofs.active.span();
  backend.fill(active, std::uint8_t{0});
  flag_vertices(backend, work.mesh, tets.span(), active);
  return tets.size();
}

/// Flips around active vertices until there are no more flips.
template <class Backend>
void flip_around_tangles(const Backend& backend, WorkingSet<Backend>& work) {
  const Criterion criterion{kShapeObjective};
  refresh_energy(backend, work.mesh, criterion, work.flips.energies);
  reset_slack(backend, work.mesh, work.flips);
  activate_around(backend, work.mesh, work.flips, Span<const std::uint8_t>(work.dofs.active.span()));
  flip_until_none(backend, work.mesh, criterion, work.flips, {});
}

/// The positions of all vertices.
template <class Backend>
struct Positions {
  BufferOf<Backend, Point> points;
  BufferOf<Backend, SurfacePoint> surface_points;
  CheckedSurface<Backend> checked;

  Positions(const Backend& backend, const WorkingSet<Backend>& work) {
    points.assign(backend, work.mesh.points);
    surface_points.assign(backend, work.dofs.surface_point);
    checked.assign(backend, work.dofs.checked);
  }
  void restore(const Backend& backend, WorkingSet<Backend>& work) const {
    work.mesh.points.assign(backend, points);
    work.dofs.surface_point.assign(backend, surface_points);
    work.dofs.checked.assign(backend, checked);
  }
};

/// Replaces each flag other than 0 by 1; clears those of vertices that slide on the surface.
struct FlagWithOne {
  Span<const VertexDof> dof;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size v) const {
    if (flags[v] != 0) flags[v] = slides(dof[v]) ? 0 : 1;
  }
};

/// Regularized sweeps, from the given positions, over all vertices near a tetrahedron that is tangled there. The
/// elements around a tangle make room for it, which a sweep over the tangle alone cannot do. Requires the rings and
/// colors of all vertices. Returns the number of tangled tetrahedra; the positions are restored unless that is 0.
template <class Backend>
Size untangle_by_continuation(Optimizer<Backend>& optimizer, const Positions<Backend>& start) {
  const UntangleParameters& p = optimizer.tuning.untangle;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const Positions<Backend> before(backend, work);
  start.restore(backend, work);
  Size tangled = activate_tangled(backend, work);
  BufferOf<Backend, std::uint8_t> region;
  region.assign(backend, work.dofs.active);
  for (int ring = 0; ring < p.rings; ++ring) {
    flag_neighbors(backend, work.mesh, region.span());
    backend.for_each(region.size(), FlagWithOne{work.dofs.dof.span(), region.span()});
  }
  Criterion criterion{kShapeObjective};
  criterion.objective.regularization = p.start;
  for (int i = 0; i < p.max_continuation_sweeps && tangled > 0; ++i) {
    work.dofs.active.assign(backend, region);
    sweep<RegularizedRing>(backend, work.mesh, criterion, work.movable_vertices(),
                           NewtonStep{p.relaxation, optimizer.tuning.relocation.min_gain}, SweepScope::selection);
    criterion.objective.regularization *= p.decay;
    tangled = activate_tangled(backend, work);
    if (!optimizer.proceed(Phase::untangling, 0)) break;
  }
  if (tangled > 0) {
    before.restore(backend, work);
    tangled = activate_tangled(backend, work);
  }
  return tangled;
}

/// Rounds of regularized sweeps and flips. Stops when no tetrahedron is tangled or the caller cancels.
template <class Backend>
void run_rounds(Optimizer<Backend>& optimizer) {
  const UntangleParameters& p = optimizer.tuning.untangle;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  Size tangled = activate_tangled(backend, work);
  const Positions<Backend> start(backend, work);
  bool proceeds = true;
  for (int round = 0; round < p.max_rounds && tangled > 0 && proceeds; ++round) {
    if (round == p.first_flip_round) {
      tangled = untangle_by_continuation(optimizer, start);
      proceeds = optimizer.proceed(Phase::untangling, 0);
      if (tangled == 0 || !proceeds) break;
    }
    if (round >= p.first_flip_round && work.flips.max_ring > 0) {
      flip_around_tangles(backend, work);
      tangled = activate_tangled(backend, work);
    }
    build_rings(backend, work.mesh, work.rings);
    color_vertices(backend, work.rings.view(), work.dofs.dof.span(), work.coloring, work.dofs.stars());
    Criterion criterion{kShapeObjective};
    criterion.objective.regularization = p.regularizations[to_size_t(round) % p.regularizations.size()];
    for (int i = 0; i < p.max_sweeps && tangled > 0 && proceeds; ++i) {
      flag_neighbors(backend, work.mesh, work.dofs.active.span());
      sweep<RegularizedRing>(backend, work.mesh, criterion, work.movable_vertices(),
                             NewtonStep{1, optimizer.tuning.relocation.min_gain}, SweepScope::selection);
      tangled = activate_tangled(backend, work);
      criterion.objective.regularization *= p.regularization_decay;
      proceeds = optimizer.proceed(Phase::untangling, 0);
    }
  }
  backend.fill(work.dofs.active.span(), std::uint8_t{1});
}

/// The state that untangling changes, in the host's memory: few meshes need it again.
template <class Backend>
struct Snapshot {
  MeshSnapshot mesh;
  std::vector<SurfacePoint> surface_points;
  CheckedSurfaceOnHost checked;

  explicit Snapshot(const WorkingSet<Backend>& work)
      : mesh(work.mesh), surface_points(work.dofs.surface_point.download()), checked(work.dofs.checked.download()) {}
  void restore(const Backend& backend, WorkingSet<Backend>& work) const {
    mesh.upload(backend, work.mesh);
    work.dofs.surface_point.upload(backend, surface_points);
    work.dofs.checked.upload(backend, checked);
  }
};

/// The tetrahedra of the input from which those in some slots descend, in increasing order.
template <class Backend>
std::vector<Index> originals_of(const WorkMesh<Backend>& mesh, std::vector<Index> slots) {
  return translated_ids(std::move(slots), mesh.tet2original.download());
}

/// Returns the tetrahedra of the input from which those descend whose volume is still not positive, or where the
/// surface has become folded.
template <class Backend>
std::vector<Index> untangle_once(Optimizer<Backend>& optimizer) {
  WorkMesh<Backend>& mesh = optimizer.work.mesh;
  const std::vector<VertexDof> dofs = optimizer.work.dofs.dof.download();
  const std::vector<std::uint8_t> folded = folded_vertices(HostMesh(mesh), dofs, SlidingVertices(optimizer.work.dofs));
  run_rounds(optimizer);
  const HostMesh result(mesh);
  std::vector<Index> left =
      exactly_tangled(result, find_tets(optimizer.backend, mesh, HasUncertifiedVolume{mesh.view()}).download());
  if (left.empty()) left = newly_folded(result, dofs, folded, SlidingVertices(optimizer.work.dofs));
  return originals_of(mesh, std::move(left));
}

/// Untangles from the state before, with all vertices of the surface and of interfaces fixed: if they can move, the
/// surface may fold even though the inside has room.
template <class Backend>
std::vector<Index> untangle_inside(Optimizer<Backend>& optimizer, const Snapshot<Backend>& before) {
  WorkingSet<Backend>& work = optimizer.work;
  const std::vector<VertexDof> dofs = work.dofs.dof.download();
  std::vector<VertexDof> fixed = dofs;
  for (VertexDof& dof : fixed) dof = dof == VertexDof::free ? dof : VertexDof::fixed;
  before.restore(optimizer.backend, work);
  work.dofs.dof.upload(optimizer.backend, fixed);
  optimizer.invalidate_rings();
  // Other vertices have colors than before, and afterwards.
  work.coloring = {};
  std::vector<Index> left = untangle_once(optimizer);
  work.dofs.dof.upload(optimizer.backend, dofs);
  work.coloring = {};
  return left;
}

template <class Backend>
bool can_move_surface(const WorkingSet<Backend>& work) {
  const std::vector<VertexDof> dofs = work.dofs.dof.download();
  return std::any_of(dofs.begin(), dofs.end(),
                     [](VertexDof dof) { return dof != VertexDof::free && dof != VertexDof::fixed; });
}

/// The tetrahedra that could not be untangled, and the reason; none if all are positive.
struct UntangleResult {
  std::vector<Index> left;  ///< tetrahedra of the input, in increasing order
  UntangleError::Reason reason = UntangleError::Reason::no_room;
};

/// Restores the input, unless a stop was requested, and finds the reason why tetrahedra are left.
template <class Backend>
UntangleResult find_reason(Optimizer<Backend>& optimizer, const Snapshot<Backend>& before, std::vector<Index> left) {
  using Reason = UntangleError::Reason;
  if (optimizer.backend.stop_requested()) return {std::move(left), Reason::stopped};
  WorkMesh<Backend>& mesh = optimizer.work.mesh;
  before.restore(optimizer.backend, optimizer.work);
  std::vector<Index> slots;
  const std::vector<Index> tet2original = mesh.tet2original.download();
  for (Size slot = 0; slot < std::ssize(tet2original); ++slot) {
    const Index original = span_of(tet2original)[slot];
    if (std::binary_search(left.begin(), left.end(), original)) slots.push_back(to_index(slot));
  }
  const std::vector<Index> faults = surface_faults(HostMesh(mesh), slots);
  if (!faults.empty()) return {originals_of(mesh, faults), Reason::surface_at_fault};
  const bool slides = optimizer.options.boundary == Boundary::slide;
  return {std::move(left), slides ? Reason::no_room_though_sliding : Reason::no_room};
}

template <class Backend>
UntangleResult untangle_tets(Optimizer<Backend>& optimizer) {
  const Snapshot<Backend> before(optimizer.work);
  std::vector<Index> left = untangle_once(optimizer);
  if (left.empty()) return {};
  if (!optimizer.backend.stop_requested() && can_move_surface(optimizer.work) &&
      untangle_inside(optimizer, before).empty()) {
    return {};
  }
  return find_reason(optimizer, before, std::move(left));
}

}  // namespace untangle_detail

/// Makes all volumes positive: vertices move under an energy that stays finite where a volume vanishes (docs/method.md,
/// "Untangling"). Throws UntangleError if tetrahedra remain that are not positive, or if the surface would fold.
template <class Backend>
void untangle(Optimizer<Backend>& optimizer) {
  untangle_detail::UntangleResult result;
  optimizer.timer.measure(Phase::untangling, [&] { result = untangle_detail::untangle_tets(optimizer); });
  optimizer.report.tets_untangled = optimizer.work.tangled;
  if (!result.left.empty()) {
    throw UntangleError(optimizer.work.tangled, std::move(result.left), result.reason);
  }
}

}  // namespace tetune
