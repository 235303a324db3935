// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <typeinfo>

#include "backend/pool.hpp"

namespace tetune::backend {

/// The memory of an emulated device: separate from the host's, filled with invalid values at each allocation and
/// release, with counts of the transfers.
class DeviceMemory {
 public:
  struct Traffic {
    std::size_t uploads = 0, downloads = 0;
    std::size_t bytes_up = 0, bytes_down = 0;
    std::size_t largest_download = 0;
  };

  DeviceMemory(std::size_t bytes, bool guard);
  ~DeviceMemory();
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  /// Smaller words in a kernel are no addresses of the host.
  static constexpr std::uint64_t kLowestHostAddress = 0x500000000000U;

  const Pool& pool() const { return pool_; }
  const Traffic& traffic() const { return traffic_; }

  void* allocate(std::size_t bytes);
  void release(void* memory, std::size_t bytes) noexcept;
  void copy(void* to, const void* from, std::size_t bytes) const;
  void upload(void* to, const void* from, std::size_t bytes);
  void download(void* to, const void* from, std::size_t bytes);

  /// Gives the process access to the memory while a kernel runs.
  class Access {
   public:
    explicit Access(const DeviceMemory& memory) : memory_(memory) { memory_.protect(false); }
    ~Access() { memory_.protect(true); }
    Access(const Access&) = delete;
    Access& operator=(const Access&) = delete;

   private:
    const DeviceMemory& memory_;
  };

  /// Throws std::logic_error where a kernel seems to hold a host address. The kernel is copied, to clear its padding.
  template <class F>
  void check_arguments([[maybe_unused]] F kernel) const {
#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
    __builtin_clear_padding(&kernel);
    if (holds_host_address(&kernel, sizeof kernel)) {
      throw std::logic_error(std::string(typeid(F).name()) + " holds a host address");
    }
#endif
#endif
  }

 private:
  void protect(bool on) const;
  bool holds(const void* begin, std::size_t bytes) const;
  bool holds_host_address(const void* object, std::size_t bytes) const;

  std::size_t bytes_;
  bool guard_;
  char* block_;
  Pool pool_;
  Traffic traffic_;
};

}  // namespace tetune::backend
