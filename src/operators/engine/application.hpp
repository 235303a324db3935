// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/atomic.hpp"
#include "backend/team.hpp"
#include "energy/mesh_energy.hpp"
#include "operators/engine/active_set.hpp"
#include "operators/engine/prefetch_tets.hpp"
#include "operators/engine/selection.hpp"
#include "operators/engine/vertex_arrays.hpp"

/// The second half of the cavity engine: selected candidates are applied to the mesh, in place.
namespace tetune {

/// Totals over the candidates of a selection that were applied.
struct FlipSum {
  double decrease = 0;
  FlipCounts counts;
  TETUNE_HD void merge(const FlipSum& other) {
    static_assert(sizeof(FlipCounts) == 5 * sizeof(counts.flips23), "merge() adds up all counters");
    decrease += other.decrease;
    counts.flips23 += other.counts.flips23;
    counts.flips32 += other.counts.flips32;
    counts.edge_removals += other.counts.edge_removals;
    counts.face_removals += other.counts.face_removals;
    counts.boundary_flips += other.counts.boundary_flips;
  }
};

namespace application_detail {

/// The prefetch distance in records; cavities are scattered in memory.
inline constexpr Size kRecordsAhead = 6;

template <class P>
struct SelectedRecords {
  Span<const Record<P>> records;
  Span<const Index> selected;
  TETUNE_HD Size size() const { return selected.size(); }
  TETUNE_HD const Record<P>& operator[](Size i) const { return records[selected[i]]; }
};

/// AssignSlots for the selected records.
template <class P>
struct AssignSelected {
  static constexpr Size kGrain = 32;
  selection_detail::AssignSlots<P> assign;
  Span<const Index> selected;
  Span<const ChangeCounts> before;
  TETUNE_HD void operator()(Size i) const { assign(selected[i], before[i]); }
};

/// Writes the new tetrahedra, connects them with what lies across the boundary of the cavity, and frees the slots that
/// are left over. Marks the new tetrahedra and their neighbors for evaluation where `changed_tets` are given: nearly
/// all candidates whose cavity changed belong to one of these. The threads of a team divide the tetrahedra among them.
/// Other calls write the mesh at the same time: what becomes of a neighbor that is replaced as well is found in its
/// record.
template <class P>
struct WriteTets {
  static constexpr Size kGrain = 32;
  /// About the number of new tetrahedra of a patch.
  static constexpr int kTeamSize = P::kMaxExtraTets < 16 ? 4 : 32;
  struct Shared {};
  RatedMesh mesh;
  SelectedRecords<P> records;
  Span<const std::uint64_t> tet2bid;
  Span<const ChangeCounts> before;
  Span<Index> free_slots;
  Size free_kept;
  Span<double> energies;
  ActiveMarks changed_tets;
  Span<std::uint8_t> changed;
  VertexArrays vertices;

  TETUNE_INLINE void prefetch(Size i, Size end) const {
    if (i + kRecordsAhead >= end) return;
    const Record<P>& r = records[i + kRecordsAhead];
    const P& patch = r.patch;
    for (int k = 0; k < patch.face_count(); ++k) {
      const Index t = r.across[k] == kNoHalfFace ? 0 : tet_of(r.across[k]);
      backend::prefetch(&tet2bid[t]);
      backend::prefetch(&mesh.tet2tet[t]);
    }
    for (int k = 0; k < patch.old_count(); ++k) prefetch_tet(mesh, energies, patch.tets[k]);
    backend::prefetch(&mesh.tet2original[patch.tets[0]]);
    for (int k = 0; k < patch.vertex_count(); ++k) backend::prefetch(&mesh.points[patch.vertex(k)]);
  }
  TETUNE_HD FlipSum operator()(Size i) const {
    Shared memory;
    return (*this)(backend::SingleThread(), memory, i);
  }
  template <class Team>
  TETUNE_HD FlipSum operator()(const Team& team, Shared&, Size i) const {
    const Record<P>& r = records[i];
    const P& patch = r.patch;
    if constexpr (requires { patch.write_vertex(mesh, vertices); }) {
      if (team.rank() == 0) patch.write_vertex(mesh, vertices);
      team.sync();
    }
    FlipSum sum;
    sum.decrease = sum_in_order(team, write_tets(team, r));
    for (int x = team.rank(); x < patch.old_count(); x += Team::kSize) {
      if (x < patch.new_count()) continue;
      mesh.tet2vertex[patch.tets[x]][0] = kFreeSlot;
      energies[patch.tets[x]] = 0;
      free_slots[free_kept + before[i].freed + x - patch.new_count()] = patch.tets[x];
    }
    for (int k = team.rank(); k < patch.vertex_count() && changed.size() > 0; k += Team::kSize) {
      backend::store_shared(changed[patch.vertex(k)], 1);
    }
    if (r.is_leader(records.selected[i])) patch.count(sum.counts);
    return sum;
  }

 private:
  /// Returns what lies across boundary face k afterwards. A neighbor that stays gets `own`, the new half-face.
  TETUNE_HD HalfFace connect_face(const Record<P>& r, int k, HalfFace own) const {
    if (k >= r.patch.face_count()) return across_new_face(r, k - r.patch.face_count());
    const HalfFace old = r.across[k];
    if (old == kNoHalfFace) return old;
    const std::uint64_t bid = tet2bid[tet_of(old)];
    if (is_replaced(bid)) {
      return records.records[replacing_record(bid)].new_half_face_of(old & ~kLocked) | (old & kLocked);
    }
    mesh.across(old) = own | (old & kLocked);
    return old;
  }
  /// The faces that both parts of a candidate make in an interface lie on each other.
  TETUNE_HD HalfFace across_new_face(const Record<P>& r, int k) const {
    if (r.twin < 0) return kNoHalfFace;
    const Record<P>& twin = records.records[r.twin];
    if constexpr (requires { r.patch.meets(twin.patch); }) {
      if (!r.patch.meets(twin.patch)) return kNoHalfFace;
    }
    return twin.new_half_face(twin.patch.face_count() + k) | kLocked;
  }
  /// The sum over the threads, in their order.
  template <class Team>
  TETUNE_HD static double sum_in_order(const Team& team, double own) {
    double sum = team.broadcast(own, 0);
    for (int k = 1; k < Team::kSize; ++k) sum += team.broadcast(own, k);
    return sum;
  }
  /// The half-faces across the faces of new tetrahedron x.
  TETUNE_HD FaceAdjacency connect_tet(const Record<P>& r, int x) const {
    const bool marks = changed_tets.marks.size() > 0;
    const Index s = r.slot(x);
    FaceAdjacency adjacency{};
    for (int f = 0; f < 4; ++f) {
      const NewNeighbor n = r.patch.new_neighbor(x, f);
      if (n.tet >= 0) {
        adjacency[f] = make_half_face(r.slot(n.tet), n.face) | n.lock;
        continue;
      }
      adjacency[f] = connect_face(r, n.face, make_half_face(s, f));
      if (marks && !is_locked(adjacency[f])) changed_tets.mark_changed(tet_of(adjacency[f]));
    }
    if (marks) changed_tets.mark_changed(s);
    return adjacency;
  }
  /// Writes the tetrahedra of a thread; returns by how much their energy falls. A thread reads the old energies of the
  /// slots that it writes.
  template <class Team>
  TETUNE_HD double write_tets(const Team& team, const Record<P>& r) const {
    const P& patch = r.patch;
    const Index original = mesh.tet2original[patch.tets[0]];
    double decrease = 0;
    for (int x = team.rank(); x < patch.old_count(); x += Team::kSize) decrease += energies[patch.tets[x]];
    if constexpr (requires { patch.parent(0); }) write_originals(team, r);
    for (int x = team.rank(); x < patch.new_count(); x += Team::kSize) {
      const Index s = r.slot(x);
      mesh.tet2vertex[s] = patch.new_tet(x);
      mesh.tet2tet[s] = connect_tet(r, x);
      if constexpr (!requires { patch.parent(0); }) {
        if (x >= patch.old_count()) mesh.tet2original[s] = original;
      }
      energies[s] = slot_energy(mesh, mesh.tet2vertex[s]).energy;
      decrease -= energies[s];
    }
    return decrease;
  }
  /// All are read before one is written: the parents are among the slots.
  template <class Team>
  TETUNE_HD void write_originals(const Team& team, const Record<P>& r) const {
    Index originals[(P::kMaxExtraTets + Team::kSize - 1) / Team::kSize];
    for (int x = team.rank(); x < r.patch.new_count(); x += Team::kSize) {
      originals[x / Team::kSize] = mesh.tet2original[r.patch.parent(x)];
    }
    team.sync();
    for (int x = team.rank(); x < r.patch.new_count(); x += Team::kSize) {
      mesh.tet2original[r.slot(x)] = originals[x / Team::kSize];
    }
  }
};

}  // namespace application_detail

/// What an application writes beside the mesh and its energies.
struct ApplicationOutput {
  Span<std::uint8_t> changed;  ///< set for the vertices whose ring changes; may be empty
  bool marks_tets = false;     ///< marks the tetrahedra that an activation is to evaluate
  VertexArrays vertices;       ///< for operators that write vertices
};

/// Applies a selection; the slots that it needs must not be too many (check_slots()). The energies in `state` stay up
/// to date; the active set does not. Returns the pending FlipSum: see reduce_async().
template <class Backend, CavityPatch P>
auto apply_selection(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                     FlipState<Backend>& state, Selection<Backend, P>& selection, const ApplicationOutput& output) {
  using namespace application_detail;
  const SelectedRecords<P> records{selection.records.span(), selection.selected.span()};
  const Span<const ChangeCounts> before = selection.before.span();
  if (!selection.is_assigned) {
    const Size old_vertices = mesh.vertices() - selection.total.inserted;
    backend.for_each(records.size(), AssignSelected<P>{{selection.records.span(), FreeSlots(mesh), old_vertices,
                                                        state.tet2bid.span(), state.marks.span()},
                                                       records.selected,
                                                       before});
  }
  const SlotChange change(mesh, selection.total);
  change.make_room(backend, mesh);
  state.make_room(backend, change.needed);
  ActiveMarks changed_tets;
  if (output.marks_tets) changed_tets = {state.marks.span(), state.slack.span()};
  const auto sum = backend.template reduce_async<FlipSum>(
      records.size(),
      WriteTets<P>{rated(mesh, criterion), records, state.tet2bid.span(), before, mesh.free_slots.span(),
                   change.free_kept, state.energies.span(), changed_tets, output.changed, output.vertices});
  change.finish(mesh);
  return sum;
}

/// Applies the selection of an operator that flips, and makes what changed active. Throws MeshError, before anything is
/// changed, when the mesh would need too many slots.
template <class Backend, CavityPatch P>
PassResult flip_selected(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                         FlipState<Backend>& state, Selection<Backend, P>& selection, Span<std::uint8_t> changed) {
  PassResult result;
  result.evaluated = selection.evaluated;
  if (selection.is_stopped) return result;
  check_slots(SlotChange(mesh, selection.total).needed);
  const auto pending = apply_selection(backend, mesh, criterion, state, selection,
                                       ApplicationOutput{.changed = changed, .marks_tets = true, .vertices = {}});
  activate_marked(backend, criterion, state);
  const FlipSum sum = pending.get();
  result.counts = sum.counts;
  result.decrease = sum.decrease;
  return result;
}

/// One pass of an operator whose proposals are those of the active tetrahedra.
template <class Backend, class Generator>
PassResult flip_active(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                       FlipState<Backend>& state, const Generator& generator, Span<std::uint8_t> changed) {
  const Size active = state.active.size();
  auto selection = select_candidates(backend, mesh, active, generator, state);
  PassResult result = flip_selected(backend, mesh, criterion, state, selection, changed);
  result.active = active;
  return result;
}

}  // namespace tetune
