// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "tetune/types.hpp"

/// Lists in increasing order.
namespace tetune {

/// Sorts items, and keeps one of equal ones.
template <class T>
void sort_unique(std::vector<T>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

/// Whether an increasing list contains an item.
template <class T>
bool is_listed(const std::vector<T>& increasing, const std::type_identity_t<T>& item) {
  return std::binary_search(increasing.begin(), increasing.end(), item);
}

/// Removes the items that an increasing list contains.
template <class T>
void erase_listed(std::vector<T>& items, const std::vector<T>& increasing) {
  std::erase_if(items, [&](const T& item) { return is_listed(increasing, item); });
}

/// The position of a value in an increasing list, or -1.
template <class T>
Index position_in(const std::vector<T>& increasing, const std::type_identity_t<T>& value) {
  const auto found = std::lower_bound(increasing.begin(), increasing.end(), value);
  return found != increasing.end() && *found == value ? to_index(found - increasing.begin()) : -1;
}

/// The pairs with this first item, of a list of pairs in increasing order.
template <class T>
std::span<const std::pair<T, T>> pairs_from(const std::vector<std::pair<T, T>>& increasing,
                                            const std::type_identity_t<T>& first) {
  const auto begin = std::lower_bound(increasing.begin(), increasing.end(), first,
                                      [](const auto& pair, const T& value) { return pair.first < value; });
  const auto end = std::upper_bound(begin, increasing.end(), first,
                                    [](const T& value, const auto& pair) { return value < pair.first; });
  return {begin, end};
}

}  // namespace tetune
