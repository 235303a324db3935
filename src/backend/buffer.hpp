// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/span.hpp"

namespace tetune::backend {

/// An array in the memory of a backend. New elements are not initialized. A buffer keeps a handle of the memory that it
/// was allocated from, and must not outlive the backend.
template <class T, class Backend>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Empty; the first call that allocates memory has the backend as an argument.
  Buffer() = default;
  explicit Buffer(const Backend& backend, Size size) { resize(backend, size); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { memory_.release(data_, bytes(capacity_)); }

  /// Changes the size. The content is lost if the capacity does not suffice.
  void resize(const Backend& backend, Size size) {
    if (size > capacity_) {
      memory_.release(data_, bytes(capacity_));
      data_ = nullptr;
      capacity_ = 0;
      memory_ = backend.memory();
      data_ = static_cast<T*>(memory_.allocate(bytes(size)));
      capacity_ = size;
    }
    size_ = size;
  }

  /// resize() with a capacity of at least `capacity`, up to which grow() does not copy.
  void resize(const Backend& backend, Size size, Size capacity) {
    resize(backend, std::max(size, capacity));
    size_ = size;
  }

  /// Changes the size and keeps the content. Reserves an eighth more than the old capacity when it allocates.
  void grow(const Backend& backend, Size size) {
    if (size > capacity_) {
      Buffer bigger(backend, std::max(size, capacity_ + capacity_ / 8));
      if (size_ > 0) backend.memory().copy(bigger.data_, data_, bytes(size_));
      swap(bigger);
    }
    size_ = size;
  }

  /// Copies the content of another buffer.
  void assign(const Backend& backend, const Buffer& other) {
    resize(backend, other.size_);
    if (size_ > 0) backend.memory().copy(data_, other.data_, bytes(size_));
  }

  Size size() const { return size_; }
  Span<T> span() { return {data_, size_}; }
  Span<const T> span() const { return {data_, size_}; }
  operator Span<T>() { return span(); }
  operator Span<const T>() const { return span(); }

  void upload(const Backend& backend, const std::vector<T>& host) {
    resize(backend, std::ssize(host));
    if (size_ > 0) backend.memory().upload(data_, host.data(), bytes(size_));
  }
  std::vector<T> download() const {
    std::vector<T> host(to_size_t(size_));
    if (size_ > 0) memory_.download(host.data(), data_, bytes(size_));
    return host;
  }

  void swap(Buffer& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  static std::size_t bytes(Size n) { return to_size_t(n) * sizeof(T); }

  [[no_unique_address]] typename Backend::Memory memory_;
  T* data_ = nullptr;
  Size size_ = 0;
  Size capacity_ = 0;
};

/// The DeviceView of a backend whose memory is separate from the host's: a copy.
template <class T, class Backend>
class UploadedView {
 public:
  UploadedView(const Backend& backend, const std::vector<T>& host) { copy_.upload(backend, host); }
  Span<const T> span() const { return copy_.span(); }

 private:
  Buffer<T, Backend> copy_;
};

}  // namespace tetune::backend

namespace tetune {

/// The types of a backend that is a template parameter.
template <class Backend, class T>
using BufferOf = typename Backend::template Buffer<T>;
template <class Backend, class T>
using DeviceViewOf = typename Backend::template DeviceView<T>;
template <class Backend, class R>
using ResultOf = typename Backend::template Result<R>;

/// Changes the size and keeps the content, as Buffer::grow(); sets the elements that are new.
template <class Backend, class T>
void grow_filled(const Backend& backend, backend::Buffer<T, Backend>& buffer, Size size,
                 const std::type_identity_t<T>& value) {
  const Size old_size = buffer.size();
  buffer.grow(backend, size);
  if (size > old_size) backend.fill(Span<T>(buffer.span().data() + old_size, size - old_size), value);
}

}  // namespace tetune
