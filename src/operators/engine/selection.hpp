// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>

#include "backend/team.hpp"
#include "operators/engine/bid.hpp"
#include "operators/engine/candidate.hpp"
#include "operators/engine/evaluate_proposals.hpp"

/// The first half of the cavity engine: from proposals to a set of candidates whose cavities do not overlap.
namespace tetune {

/// A selected candidate, with the slots and half-faces that its application needs.
template <CavityPatch P>
struct Record {
  P patch;
  std::uint64_t bid;
  Index proposal;
  Index twin;  ///< the record of the other part; -1: there is none
  Index extra_slots[P::kMaxExtraTets];
  HalfFace across[P::kMaxCavityFaces];  ///< what lies across the boundary faces: before, then afterwards

  /// The slot of new tetrahedron x.
  TETUNE_HD Index slot(int x) const {
    return x < patch.old_count() ? patch.tets[x] : extra_slots[x - patch.old_count()];
  }
  /// Where boundary face k is afterwards.
  TETUNE_HD HalfFace new_half_face(int k) const {
    const NewFace f = patch.new_face(k);
    return make_half_face(slot(f.tet), f.face);
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
  bool is_stopped = false;  ///< a stop was requested: nothing is selected

  Size size() const { return selected.size(); }
};

namespace selection_detail {

template <class C>
inline constexpr bool kIsOwnPatch = std::is_same_v<C, typename C::Patch>;

/// Whether a stored candidate holds all of its tetrahedra so far. One that does not cannot be selected, as bids only
/// rise.
template <class C>
struct HoldsSoFar {
  Proposals<C> proposals;
  TETUNE_HD bool operator()(Size i) const {
    const Size last = i - i % proposals.parts + proposals.parts;
    if (proposals.bids[i] == 0) return false;
    for (Size j = last - proposals.parts; j < last; ++j) {
      if (proposals.bids[j] != 0 && !holds_all(proposals.candidates[j], proposals.bids[j], proposals.tet2bid))
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

/// Makes records of stored candidates, with what lies around their cavities. Selects all of them for now.
template <class C>
struct FillRecord {
  static constexpr Size kGrain = 32;
  MeshView mesh;
  Proposals<C> proposals;
  Span<const Index> entries;
  Span<Record<typename C::Patch>> records;
  Span<Index> selected;
  Size first;  ///< record of the batch

  TETUNE_HD void operator()(Size i) const {
    Record<typename C::Patch>& r = records[first + i];
    selected[first + i] = to_index(first + i);
    const Size entry = entries[i];
    r.patch = proposals.candidates[entry].expand(mesh);
    r.bid = proposals.bids[entry];
    r.proposal = to_index(proposals.first + entry / proposals.parts);
    r.twin = find_twin(first + i, entry);
    const int faces = r.patch.face_count();
    for (int k = 0; k < faces; ++k) {
      r.across[k] = mesh.across(r.patch.old_face(mesh, k));
    }
    for (int k = 0; k < r.patch.new_surface_faces(); ++k) r.across[faces + k] = kNoHalfFace;
  }

 private:
  /// The parts of a candidate are neighbors, as all of them hold their tetrahedra or none does.
  TETUNE_HD Index find_twin(Size record, Size entry) const {
    if (proposals.parts == 1 || proposals.bids[entry ^ 1] == 0) return -1;
    return to_index(entry % 2 == 0 ? record + 1 : record - 1);
  }
};

template <class P>
struct IsSelected {
  Span<const Record<P>> records;
  Span<const std::uint64_t> tet2bid;
  TETUNE_HD bool operator()(Size i) const { return holds(records[i]) && holds_twin(records[i]); }

 private:
  TETUNE_HD bool holds(const Record<P>& r) const { return holds_all(r.patch, r.bid, tet2bid); }
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

/// Lists the stored candidates of `size` proposals that hold all of their tetrahedra so far; returns their number.
/// Where these are all proposals (`is_final`), also sums up what the candidates change.
template <class Backend, class C>
Size list_holding(const Backend& backend, const Proposals<C>& proposals, Size size, bool is_final, Span<Index> entries,
                  Selection<Backend, typename C::Patch>& s) {
  const HoldsSoFar<C> holds{proposals};
  if constexpr (kIsOwnPatch<C>) {
    if (is_final) {
      s.before.resize(backend, size);
      const auto found = backend.compact_and_sum(size, holds, entries, CountChangesOfCandidate<C>{proposals.candidates},
                                                 s.before.span());
      s.total = found.sum;
      return found.count;
    }
  }
  return backend.compact(size, holds, entries);
}

}  // namespace selection_detail

/// Runs a generator over `count` proposals, and selects candidates whose cavities do not overlap. It polls for a stop
/// before each batch. `tet2bid` is scratch for all slots.
template <class Backend, class Generator>
auto select_candidates(const Backend& backend, WorkMesh<Backend>& mesh, Size count, const Generator& generator,
                       BufferOf<Backend, std::uint64_t>& tet2bid) {
  using namespace selection_detail;
  using C = typename Generator::Candidate;
  using P = typename C::Patch;
  Selection<Backend, P> s;
  tet2bid.resize(backend, mesh.slots(), mesh.room());
  backend.fill(tet2bid.span(), std::uint64_t{0});
  const Size choices = choices_apart<Backend>(generator);
  const Size batch = batch_size<Backend, Generator>(count, choices);
  // After a single batch the bids are final.
  const bool is_final = kIsOwnPatch<C> && batch == count;
  {
    BufferOf<Backend, C> candidates(backend, Generator::kParts * batch);
    BufferOf<Backend, std::uint64_t> bids(backend, Generator::kParts * batch);
    BufferOf<Backend, Index> entries(backend, Generator::kParts * batch);
    Size room = 0;
    for (Size first = 0; first < count; first += batch) {
      if (backend.stop_requested()) {
        s.is_stopped = true;
        s.selected.resize(backend, 0);
        return s;
      }
      const Size size = std::min(batch, count - first);
      const Proposals<C> proposals{tet2bid.span(), candidates.span(), bids.span(), first, Generator::kParts};
      const auto evaluated = evaluate_proposals(backend, generator, proposals, size, choices);
      const Size found = list_holding(backend, proposals, Generator::kParts * size, is_final, entries.span(), s);
      s.evaluated += evaluated.get().value;
      const Size before = s.records.size();
      reserve_records(backend, s.records, before + found,
                      static_cast<double>(first + size) / static_cast<double>(count), room);
      s.records.resize(backend, before + found);
      s.selected.resize(backend, before + found);
      backend.for_each(
          found, FillRecord<C>{mesh.view(), proposals, entries.span(), s.records.span(), s.selected.span(), before});
    }
  }
  if (is_final) return s;
  s.before.resize(backend, s.records.size());
  const auto selected = backend.compact_and_sum(s.records.size(), IsSelected<P>{s.records.span(), tet2bid.span()},
                                                s.selected.span(), CountChanges<P>{s.records.span()}, s.before.span());
  s.selected.resize(backend, selected.count);
  s.total = selected.sum;
  return s;
}

}  // namespace tetune
