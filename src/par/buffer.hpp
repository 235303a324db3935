// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "par/span.hpp"

namespace tetune::par {

/// Owns an array in a backend's memory. Elements are not initialised.
template <class T, class Backend>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(Size size) { resize(size); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { Backend::release(data_, bytes(capacity_)); }

  /// Changes the size; the content is lost when memory must be had anew.
  void resize(Size size) {
    if (size > capacity_) {
      Backend::release(data_, bytes(capacity_));
      data_ = nullptr;
      capacity_ = 0;
      data_ = static_cast<T*>(Backend::allocate(bytes(size)));
      capacity_ = size;
    }
    size_ = size;
  }

  /// The same, with memory for at least `room`, so that the array can grow to that without a copy.
  void resize(Size size, Size room) {
    resize(std::max(size, room));
    size_ = size;
  }

  /// Changes the size and keeps the content, with room to spare when memory must be had anew.
  void grow(Size size) {
    if (size > capacity_) {
      Buffer bigger(std::max(size, capacity_ + capacity_ / 8));
      if (size_ > 0) Backend::copy(bigger.data_, data_, bytes(size_));
      swap(bigger);
    }
    size_ = size;
  }

  /// The same content as another array.
  void assign(const Buffer& other) {
    resize(other.size_);
    if (size_ > 0) Backend::copy(data_, other.data_, bytes(size_));
  }

  Size size() const { return size_; }
  Span<T> span() { return {data_, size_}; }
  Span<const T> span() const { return {data_, size_}; }

  void upload(const std::vector<T>& host) {
    resize(static_cast<Size>(host.size()));
    if (size_ > 0) Backend::upload(data_, host.data(), bytes(size_));
  }
  std::vector<T> download() const {
    std::vector<T> host(static_cast<std::size_t>(size_));
    if (size_ > 0) Backend::download(host.data(), data_, bytes(size_));
    return host;
  }

  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  static std::size_t bytes(Size n) { return static_cast<std::size_t>(n) * sizeof(T); }

  T* data_ = nullptr;
  Size size_ = 0;
  Size capacity_ = 0;
};

/// The Loan of a backend whose memory is apart from the host's: a copy.
template <class T, class Backend>
class LoanedCopy {
 public:
  explicit LoanedCopy(const std::vector<T>& host) { copy_.upload(host); }
  Span<const T> span() const { return copy_.span(); }

 private:
  Buffer<T, Backend> copy_;
};

}  // namespace tetune::par
