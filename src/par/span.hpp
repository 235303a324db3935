// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "par/macros.hpp"

namespace tetune::par {

using Size = std::int64_t;
using Index32 = std::int32_t;

/// A view of an array in the memory of one backend; what kernels carry.
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

}  // namespace tetune::par
