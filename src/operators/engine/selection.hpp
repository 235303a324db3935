// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>

#include "backend/team.hpp"
#include "operators/engine/bid.hpp"
#include "operators/engine/candidate.hpp"
#include "operators/engine/evaluate_proposals.hpp"
#include "operators/engine/flip_state.hpp"

/// The first half of the cavity engine: from proposals to a set of candidates whose cavities do not overlap.
namespace tetune {

/// A selected candidate, with the slots and half-faces that its application needs.
template <CavityPatch P>
struct Record {
  P patch;
  std::uint64_t bid;
  std::uint32_t proposal;
  Index twin;  ///< the record of the other part; -1: there is none
  Index extra_slots[P::kMaxExtraTets];
  HalfFace across[P::kMaxCavityFaces];  ///< what lies across the boundary faces before

  /// The slot of new tetrahedron x.
  TETUNE_HD Index slot(int x) const {
    return x < patch.old_count() ? patch.tets[x] : extra_slots[x - patch.old_count()];
  }
  /// Where boundary face k is afterwards.
  TETUNE_HD HalfFace new_half_face(int k) const {
    const NewFace f = patch.new_face(k);
    return make_half_face(slot(f.tet), f.face);
  }
  /// The new half-face in place of one of the boundary faces.
  TETUNE_HD HalfFace new_half_face_of(HalfFace old) const {
    int k = 0;
    while (patch.old_face(k) != old) ++k;
    return new_half_face(k);
  }
  /// Whether this record stands for all parts of its candidate; `own` is its position.
  TETUNE_HD bool is_leader(Index own) const { return twin < 0 || own < twin; }
};

/// Records that hold all of their tetrahedra, and what they change.
template <class Backend, CavityPatch P>
struct Selection {
  BufferOf<Backend, Record<P>> records;    ///< the selected ones, and perhaps a few more
  BufferOf<Backend, Index> selected;       ///< positions of records
  BufferOf<Backend, ChangeCounts> before;  ///< sums over the selected records before each
  ChangeCounts total;
  Size evaluated = 0;
  bool is_assigned = false;  ///< AssignSlots was called for all selected records
  bool is_stopped = false;   ///< a stop was requested: nothing is selected

  Size size() const { return selected.size(); }
};

namespace selection_detail {

template <class C>
inline constexpr bool kIsOwnPatch = std::is_same_v<C, typename C::Patch>;

/// Whether all parts of a stored candidate hold all of their tetrahedra so far. One that does not cannot be selected,
/// as bids only rise.
template <class C>
struct HoldsSoFar {
  Proposals<C> proposals;
  TETUNE_HD bool operator()(Size i) const {
    const Size last = i - i % proposals.parts + proposals.parts;
    if (proposals.bids[i] == 0) return false;
    for (Size j = last - proposals.parts; j < last; ++j) {
      if (proposals.bids[j] != 0 && !holds_all(proposals.candidates[j], proposals.bids[j], proposals.highest))
        return false;
    }
    return true;
  }
};

/// The numbers of tetrahedra and vertices that a stored candidate changes, where it is its own patch.
template <class C>
struct CountChangesOfCandidate {
  Span<const C> candidates;
  TETUNE_HD ChangeCounts operator()(Size i) const {
    ChangeCounts counts;
    candidates[i].count(counts);
    return counts;
  }
};

/// Makes a record of a stored candidate, with what lies around its cavity.
template <class C>
struct FillRecord {
  MeshView mesh;
  Proposals<C> proposals;
  Span<Record<typename C::Patch>> records;

  TETUNE_HD void operator()(Size entry, Size record) const {
    Record<typename C::Patch>& r = records[record];
    r.patch = proposals.candidates[entry].expand(mesh);
    r.bid = proposals.bids[entry];
    r.proposal = std::uint32_t(proposals.first + entry / proposals.parts);
    r.twin = find_twin(record, entry);
    for (int k = 0; k < r.patch.face_count(); ++k) r.across[k] = mesh.across(r.patch.old_face(k));
  }

 private:
  /// The parts of a candidate are neighbors, as all of them hold their tetrahedra or none does.
  TETUNE_HD Index find_twin(Size record, Size entry) const {
    if (proposals.parts == 1 || proposals.bids[entry ^ 1] == 0) return -1;
    return to_index(entry % 2 == 0 ? record + 1 : record - 1);
  }
};

/// Makes records of listed candidates, from position `first` on.
template <class C>
struct FillRecords {
  static constexpr Size kGrain = 32;
  FillRecord<C> fill;
  Span<const Index> entries;
  Size first;
  TETUNE_HD void operator()(Size i) const { fill(entries[i], first + i); }
};

/// Assigns slots and the ids of vertices to a record. Marks its old tetrahedra as replaced, and as not active.
template <class P>
struct AssignSlots {
  Span<Record<P>> records;
  FreeSlots slots;
  Size vertices;  ///< before
  Span<std::uint64_t> tet2bid;
  Span<std::uint8_t> marks;

  TETUNE_HD void operator()(Size record, const ChangeCounts& before) const {
    Record<P>& r = records[record];
    for (int k = 0; k < r.patch.old_count(); ++k) {
      backend::store_shared(tet2bid[r.patch.tets[k]], replaced_by(to_index(record)));
      marks[r.patch.tets[k]] = 0;
    }
    for (int x = 0; x < r.patch.new_count() - r.patch.old_count(); ++x) {
      r.extra_slots[x] = slots.slot_of(Size{before.taken} + x);
    }
    if constexpr (requires { r.patch.assign_vertex(Index{}); }) {
      r.patch.assign_vertex(to_index(vertices + before.inserted));
    }
  }
};

/// Lists selected records, and what they change.
struct ListSelected {
  static constexpr Size kGrain = 32;
  Span<Index> selected;
  Span<ChangeCounts> before;
  TETUNE_HD void operator()(Size record, Size rank, const ChangeCounts& before_record) const {
    selected[rank] = to_index(record);
    before[rank] = before_record;
  }
};

/// Makes records of the selected candidates, and assigns their slots.
template <class C>
struct SelectCandidate {
  static constexpr Size kGrain = 32;
  FillRecord<C> fill;
  AssignSlots<typename C::Patch> assign;
  ListSelected list;
  TETUNE_HD void operator()(Size entry, Size rank, const ChangeCounts& before) const {
    fill(entry, rank);
    assign(rank, before);
    list(rank, rank, before);
  }
};

template <class P>
struct IsSelected {
  Span<const Record<P>> records;
  Bids highest;
  TETUNE_HD bool operator()(Size i) const { return holds(records[i]) && holds_twin(records[i]); }

 private:
  TETUNE_HD bool holds(const Record<P>& r) const { return holds_all(r.patch, r.bid, highest); }
  TETUNE_HD bool holds_twin(const Record<P>& r) const { return r.twin < 0 || holds(records[r.twin]); }
};

template <class P>
struct CountChanges {
  Span<const Record<P>> records;
  TETUNE_HD ChangeCounts operator()(Size i) const {
    ChangeCounts counts;
    records[i].patch.count(counts);
    return counts;
  }
};

/// Proposals per batch, a multiple of `choices`. The candidates of a batch are stored apart until it is known which
/// lead. On a device a batch is a quarter of all proposals, so that they take a quarter of the memory, but at least
/// kMinDeviceBatch; where teams evaluate proposals it is kTeamBatch, as fewer of them occupy a device.
template <class Backend, class Generator>
Size batch_size(Size count, Size choices) {
  constexpr Size kMinDeviceBatch = Size{1} << 15;
  constexpr Size kTeamBatch = Size{1} << 14;
  const Size on_device = backend::TeamKernel<Generator> ? kTeamBatch : std::max(kMinDeviceBatch, (count + 3) / 4);
  const Size batch = Backend::kIsAsynchronous ? on_device : Generator::kBatch;
  return std::min(count, (batch + choices - 1) / choices * choices);
}

/// Reserves memory for all records, estimated from `needed` after the fraction `done` of the proposals.
template <class Backend, class Buffer>
void reserve_records(const Backend& backend, Buffer& records, Size needed, double done, Size& room) {
  if (needed <= room) return;
  const Size kept = records.size();
  room = done < 1 ? std::max(needed, static_cast<Size>(1.1 * static_cast<double>(needed) / done)) : needed;
  records.grow(backend, room);
  records.resize(backend, kept);
}

/// The candidates of a batch of proposals.
template <class Backend, class Generator>
struct Batch {
  using C = typename Generator::Candidate;
  BufferOf<Backend, C> candidates;
  BufferOf<Backend, std::uint64_t> bids;

  Batch(const Backend& backend, Size size)
      : candidates(backend, Generator::kParts * size), bids(backend, Generator::kParts * size) {}
  Proposals<C> proposals(FlipState<Backend>& state, Size first) {
    return {state.highest(), candidates.span(), bids.span(), first, Generator::kParts};
  }
};

/// Makes records of the candidates that may be selected, batch by batch, and polls for a stop before each.
template <class Backend, class Generator, class P>
void fill_records(const Backend& backend, WorkMesh<Backend>& mesh, Size count, const Generator& generator,
                  FlipState<Backend>& state, Selection<Backend, P>& s) {
  using C = typename Generator::Candidate;
  const Size choices = choices_apart<Backend>(generator);
  const Size batch = batch_size<Backend, Generator>(count, choices);
  Batch<Backend, Generator> of(backend, batch);
  BufferOf<Backend, Index> entries(backend, Generator::kParts * batch);
  Size room = 0;
  for (Size first = 0; first < count; first += batch) {
    s.is_stopped = backend.stop_requested();
    if (s.is_stopped) return;
    const Size size = std::min(batch, count - first);
    const Proposals<C> proposals = of.proposals(state, first);
    const auto evaluated = evaluate_proposals(backend, generator, proposals, size, choices);
    const Size found = backend.compact(Generator::kParts * size, HoldsSoFar<C>{proposals}, entries.span());
    s.evaluated += evaluated.get().value;
    const Size before = s.records.size();
    reserve_records(backend, s.records, before + found, static_cast<double>(first + size) / static_cast<double>(count),
                    room);
    s.records.resize(backend, before + found);
    backend.for_each(found, FillRecords<C>{{mesh.view(), proposals, s.records.span()}, entries.span(), before});
  }
}

/// Selects among the records of all batches.
template <class Backend, class P>
void select_records(const Backend& backend, FlipState<Backend>& state, Selection<Backend, P>& s) {
  s.selected.resize(backend, s.records.size());
  s.before.resize(backend, s.records.size());
  const auto selected =
      backend.compact_and_sum(s.records.size(), IsSelected<P>{s.records.span(), state.highest()},
                              CountChanges<P>{s.records.span()}, ListSelected{s.selected.span(), s.before.span()});
  s.selected.resize(backend, selected.count);
  s.total = selected.sum;
}

/// After the bids of a single batch, which are final: selects, makes records and assigns slots at once.
template <class Backend, class Generator, class P>
void select_and_assign(const Backend& backend, WorkMesh<Backend>& mesh, Size count, const Generator& generator,
                       FlipState<Backend>& state, Selection<Backend, P>& s) {
  s.is_stopped = backend.stop_requested();
  if (s.is_stopped) return;
  Batch<Backend, Generator> batch(backend, count);
  const Proposals<P> proposals = batch.proposals(state, 0);
  const auto evaluated = evaluate_proposals(backend, generator, proposals, count, choices_apart<Backend>(generator));
  const Size entries = Generator::kParts * count;
  s.records.resize(backend, entries);
  s.selected.resize(backend, entries);
  s.before.resize(backend, entries);
  const AssignSlots<P> assign{s.records.span(), FreeSlots(mesh), mesh.vertices(), state.tet2bid.span(),
                              state.marks.span()};
  const auto selected = backend.compact_and_sum(
      entries, HoldsSoFar<P>{proposals}, CountChangesOfCandidate<P>{proposals.candidates},
      SelectCandidate<P>{{mesh.view(), proposals, s.records.span()}, assign, {s.selected.span(), s.before.span()}});
  s.records.resize(backend, selected.count);
  s.selected.resize(backend, selected.count);
  s.evaluated = evaluated.get().value;
  s.total = selected.sum;
  s.is_assigned = true;
}

}  // namespace selection_detail

/// Runs a generator over `count` proposals, and selects candidates whose cavities do not overlap.
template <class Backend, class Generator>
auto select_candidates(const Backend& backend, WorkMesh<Backend>& mesh, Size count, const Generator& generator,
                       FlipState<Backend>& state) {
  using namespace selection_detail;
  using C = typename Generator::Candidate;
  Selection<Backend, typename C::Patch> s;
  if (count == 0) return s;
  Size edge_slots = 0;
  if constexpr (requires { generator.edge_slots(); }) edge_slots = generator.edge_slots();
  state.start_pass(backend, mesh, edge_slots);
  if constexpr (kIsOwnPatch<C>) {
    const bool is_one_batch = batch_size<Backend, Generator>(count, choices_apart<Backend>(generator)) == count;
    // There is a record per proposal then: no more memory than batches of all tetrahedra take.
    if (is_one_batch && Generator::kParts * count <= mesh.slots() / 4) {
      select_and_assign(backend, mesh, count, generator, state, s);
      return s;
    }
  }
  fill_records(backend, mesh, count, generator, state, s);
  if (!s.is_stopped) select_records(backend, state, s);
  return s;
}

}  // namespace tetune
