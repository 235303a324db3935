// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "backend/macros.hpp"

namespace tetune {

using Size = std::int64_t;
using Index32 = std::int32_t;

/// A view of an array in the memory of one backend; kernels hold these.
template <class T>
class Span {
 public:
  Span() = default;
  TETUNE_HD Span(T* data, Size size) : data_(data), size_(size) {}
  /// From a view of mutable elements to one of constant elements.
  template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
  TETUNE_HD Span(const Span<U>& other) : data_(other.data()), size_(other.size()) {}

  TETUNE_HD T& operator[](Size i) const {
    TETUNE_ASSERT(i >= 0 && i < size_);
    return data_[i];
  }
  TETUNE_HD T* data() const { return data_; }
  TETUNE_HD Size size() const { return size_; }

 private:
  T* data_ = nullptr;
  Size size_ = 0;
};

/// A view of a std::vector with signed indices.
template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), static_cast<Size>(v.size())};
}
template <class T>
Span<const T> span_of(const std::vector<T>& v) {
  return {v.data(), static_cast<Size>(v.size())};
}

/// The position of the first element of an increasing sequence that is not below a value; the length if none is.
template <class T, class Value>
TETUNE_HD Size lower_bound(const Span<const T>& increasing, Value value) {
  Size begin = 0;
  for (Size end = increasing.size(); begin < end;) {
    const Size middle = begin + (end - begin) / 2;
    if (increasing[middle] < value) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}
/// Whether an increasing sequence contains a value.
template <class T>
TETUNE_HD bool contains(const Span<const T>& increasing, T value) {
  const Size i = lower_bound(increasing, value);
  return i < increasing.size() && increasing[i] == value;
}

/// The result of a reduction that adds.
template <class T>
struct Sum {
  T value{};
  TETUNE_HD void merge(const Sum& other) { value += other.value; }
};

/// Converts a count or a position to a 32-bit index; a value that does not fit is a bug.
template <class T>
TETUNE_HD constexpr Index32 to_index(T value) {
  TETUNE_ASSERT(static_cast<std::uint64_t>(value) <= 0x7fffffffU);  // a negative value becomes larger
  return static_cast<Index32>(value);
}

/// Converts to the type of the sizes of the standard library's containers.
template <class T>
constexpr std::size_t to_size_t(T value) {
  TETUNE_ASSERT(static_cast<std::int64_t>(value) >= 0);
  return static_cast<std::size_t>(value);
}

namespace backend {
using tetune::Size, tetune::Span, tetune::Sum, tetune::span_of, tetune::to_size_t;
}  // namespace backend
}  // namespace tetune
