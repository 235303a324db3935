// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/pool.hpp"
#include "tetune/error.hpp"

/// Memory of a CUDA device, and results that reach the host from it.
namespace tetune::backend {

inline void check_cuda(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // clears the error, which is reported here
  throw DeviceError(std::string("CUDA: ") + what + " failed: " + cudaGetErrorString(status));
}

/// A handle of the pool of a Cuda backend.
///
/// Memory may be released, and allocated again for another buffer, while kernels that use it have yet to run: whatever
/// uses it next, transfers included, is enqueued in the same stream and so runs after them.
class CudaMemory {
 public:
  static constexpr bool kIsPool = true;
  CudaMemory() = default;
  explicit CudaMemory(GrowingPool& pool) : pool_(&pool) {}

  void* allocate(std::size_t bytes) const { return pool_->allocate(bytes); }
  void release(void* memory, std::size_t) const noexcept {
    if (memory != nullptr) pool_->release(memory);
  }
  static void copy(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, nullptr), "copy");
  }
  static void upload(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "upload");
  }
  static void download(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "download");
  }

 private:
  GrowingPool* pool_ = nullptr;
};

/// Results that kernels write to pinned memory of the host: after one wait all of them are there.
class Readback {
 public:
  /// A result on the host.
  class Slot {
   public:
    virtual ~Slot() = default;
    virtual void receive(const unsigned char* from) = 0;
  };

  static constexpr std::size_t kCapacity = 4096;
  static constexpr std::size_t kAlignment = 16;

  Readback() : memory_(allocate(), release) {}

  /// Returns where a kernel is to write a result that `slot` is to receive.
  unsigned char* add(std::shared_ptr<Slot> slot, std::size_t bytes) {
    if (end_ + bytes > kCapacity) fetch();
    slots_.push_back({end_, std::move(slot)});
    end_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    return memory_.get() + slots_.back().first;
  }
  void fetch() {
    check_cuda(cudaStreamSynchronize(nullptr), "wait");
    for (const auto& [offset, slot] : slots_) slot->receive(memory_.get() + offset);
    slots_.clear();
    end_ = 0;
  }

 private:
  static unsigned char* allocate() {
    void* memory = nullptr;
    check_cuda(cudaMallocHost(&memory, kCapacity), "allocation");
    return static_cast<unsigned char*>(memory);
  }
  static void release(unsigned char* memory) {
    cudaStreamSynchronize(nullptr);  // kernels may have results to write
    cudaFreeHost(memory);
  }

  std::unique_ptr<unsigned char, void (*)(unsigned char*)> memory_;
  std::size_t end_ = 0;
  std::vector<std::pair<std::size_t, std::shared_ptr<Slot>>> slots_;
};

/// A result for which get() waits, unless an earlier wait has brought it.
template <class R>
class Pending {
  static_assert(std::is_trivially_copyable_v<R> && sizeof(R) <= Readback::kCapacity &&
                alignof(R) <= Readback::kAlignment);

 public:
  /// R{}
  Pending() = default;
  /// Sets `target` to where a kernel is to write the result.
  Pending(Readback& readback, R*& target) : readback_(&readback), slot_(std::make_shared<Slot>()) {
    target = reinterpret_cast<R*>(readback.add(slot_, sizeof(R)));
  }

  R get() const {
    if (slot_ == nullptr) return R{};
    if (!slot_->is_here) readback_->fetch();
    return slot_->value;
  }

 private:
  struct Slot final : Readback::Slot {
    R value{};
    bool is_here = false;
    void receive(const unsigned char* from) override {
      std::memcpy(&value, from, sizeof(R));
      is_here = true;
    }
  };
  Readback* readback_ = nullptr;
  std::shared_ptr<Slot> slot_;
};

}  // namespace tetune::backend
