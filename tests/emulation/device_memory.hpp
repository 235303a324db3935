// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <typeinfo>

#include "par/pool.hpp"

namespace tetune::par {

/// Memory that stands for a device's: apart from the host's, filled with what must not be read when it is handed out
/// and given back, and a count of what crosses.
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

  /// As Pool's.
  static DeviceMemory& current() { return *current_; }

  const Pool& pool() const { return pool_; }
  const Traffic& traffic() const { return traffic_; }

  void* allocate(std::size_t bytes);
  void release(void* memory, std::size_t bytes) noexcept;
  void copy(void* to, const void* from, std::size_t bytes) const;
  void upload(void* to, const void* from, std::size_t bytes);
  void download(void* to, const void* from, std::size_t bytes);

  /// While a kernel runs.
  class Open {
   public:
    explicit Open(const DeviceMemory& memory) : memory_(memory) { memory_.protect(false); }
    ~Open() { memory_.protect(true); }
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;

   private:
    const DeviceMemory& memory_;
  };

  /// Throws where a kernel carries what looks like an address of the host's. Taken by value, to clear what lies between
  /// its members.
  template <class F>
  void check_arguments([[maybe_unused]] F kernel) const {
#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
    __builtin_clear_padding(&kernel);
    if (carries_host_address(&kernel, sizeof kernel)) {
      throw std::logic_error(std::string(typeid(F).name()) + " carries an address of the host's");
    }
#endif
#endif
  }

 private:
  void protect(bool on) const;
  bool holds(const void* begin, std::size_t bytes) const;
  bool carries_host_address(const void* object, std::size_t bytes) const;

  static thread_local DeviceMemory* current_;
  DeviceMemory* outer_;
  std::size_t bytes_;
  bool guard_;
  char* block_;
  Pool pool_;
  Traffic traffic_;
};

}  // namespace tetune::par
