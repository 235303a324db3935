// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <vector>

#include "backend/span.hpp"
#include "mesh/sorted.hpp"
#include "tetune/types.hpp"

/// Maps between two numberings of vertices, elements or entries of lists. Such a map is named from2to; -1 is an entity
/// that the other numbering lacks. In reports, an empty map from a result to its original is the identity, and so is
/// that of a result without entries, which may have lost them all.
namespace tetune {

inline std::vector<Index> identity_map(std::size_t size) {
  std::vector<Index> ids(size);
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

/// The map of a report with all entries; `size`: their number.
inline std::vector<Index> explicit_map(const std::vector<Index>& new2original, std::size_t size) {
  return new2original.empty() ? identity_map(size) : new2original;
}

/// The map for a report: empty where it is the identity on all `originals`, as explicit_map() reads it.
inline std::vector<Index> empty_if_identity(std::vector<Index> new2original, std::size_t originals) {
  Index next = 0;
  const bool in_order =
      std::all_of(new2original.begin(), new2original.end(), [&next](Index original) { return original == next++; });
  if (new2original.size() == originals && in_order) new2original.clear();
  return new2original;
}

/// An entry of the map of a report.
inline Index original_of(const std::vector<Index>& new2original, Index i) {
  return new2original.empty() ? i : span_of(new2original)[i];
}

/// The composition of two maps of reports: from a result to an intermediate mesh, and from that to the input.
inline std::vector<Index> compose(std::vector<Index> between2input, std::vector<Index> result2between) {
  if (between2input.empty()) return result2between;
  if (result2between.empty()) return between2input;
  for (Index& i : result2between) i = i < 0 ? i : span_of(between2input)[i];
  return result2between;
}

/// The map in the other direction; `size`: the number of entities of the numbering `to`.
inline std::vector<Index> inverse_map(const std::vector<Index>& from2to, std::size_t size) {
  std::vector<Index> to2from(size, -1);
  Index from = 0;
  for (const Index to : from2to) {
    if (to >= 0) span_of(to2from)[to] = from;
    ++from;
  }
  return to2from;
}

/// The entities that the other numbering has, in increasing order.
inline std::vector<Index> kept_of(const std::vector<Index>& from2to) {
  std::vector<Index> kept;
  for (Index i = 0; i < std::ssize(from2to); ++i) {
    if (span_of(from2to)[i] >= 0) kept.push_back(i);
  }
  return kept;
}

/// Ids in the other numbering, which has all of them: in increasing order, each once.
template <class Id>
std::vector<Index> translated_ids(std::vector<Index> ids, const std::vector<Id>& from2to) {
  for (Index& id : ids) id = Index(span_of(from2to)[id]);
  sort_unique(ids);
  return ids;
}

/// The values of the entities with these ids.
template <class T, class Ids>
std::vector<T> gather_entries(const std::vector<T>& values, const Ids& ids) {
  std::vector<T> gathered;
  gathered.reserve(ids.size());
  for (const auto i : ids) gathered.push_back(span_of(values)[Size(i)]);
  return gathered;
}

/// As gather_entries(), with the value `missing` for ids below 0.
template <class T>
std::vector<T> gather_entries_or(const std::vector<T>& values, const std::vector<Index>& ids, const T& missing) {
  std::vector<T> gathered;
  gathered.reserve(ids.size());
  for (const Index i : ids) gathered.push_back(i < 0 ? missing : span_of(values)[i]);
  return gathered;
}

}  // namespace tetune
