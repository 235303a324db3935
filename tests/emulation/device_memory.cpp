// SPDX-License-Identifier: Apache-2.0
#include "emulation/device_memory.hpp"

#include <algorithm>

#include "emulation/pages.hpp"

namespace tetune::backend {
namespace {

/// A NaN as a double and as a float; above all ids.
constexpr std::uint32_t kPoison = 0x7ff4deadU;

void poison(void* memory, std::size_t bytes) {
  std::memset(memory, 0xde, bytes);
  std::fill_n(static_cast<std::uint32_t*>(memory), bytes / sizeof kPoison, kPoison);
}

}  // namespace

DeviceMemory::DeviceMemory(std::size_t bytes, bool guard)
    : bytes_(bytes), guard_(guard), block_(reserve_pages(std::max(bytes, kPage))), pool_(block_, bytes) {
  protect(true);
}

DeviceMemory::~DeviceMemory() { release_pages(block_, std::max(bytes_, kPage)); }

void* DeviceMemory::allocate(std::size_t bytes) {
  void* memory = pool_.allocate(bytes);
  const Access access(*this);
  if (bytes > 0) poison(memory, bytes);
  return memory;
}

void DeviceMemory::release(void* memory, std::size_t bytes) noexcept {
  pool_.release(memory);
  const Access access(*this);
  poison(memory, bytes);
}

void DeviceMemory::copy(void* to, const void* from, std::size_t bytes) const {
  if (!holds(to, bytes) || !holds(from, bytes))
    throw std::logic_error("a copy on the device has a pointer of the host");
  const Access access(*this);
  std::memcpy(to, from, bytes);
}

void DeviceMemory::upload(void* to, const void* from, std::size_t bytes) {
  if (!holds(to, bytes) || holds(from, bytes)) throw std::logic_error("an upload is not from the host to the device");
  ++traffic_.uploads;
  traffic_.bytes_up += bytes;
  const Access access(*this);
  if (bytes > 0) std::memcpy(to, from, bytes);
}

void DeviceMemory::download(void* to, const void* from, std::size_t bytes) {
  if (holds(to, bytes) || !holds(from, bytes)) throw std::logic_error("a download is not from the device to the host");
  ++traffic_.downloads;
  traffic_.bytes_down += bytes;
  traffic_.largest_download = std::max(traffic_.largest_download, bytes);
  const Access access(*this);
  if (bytes > 0) std::memcpy(to, from, bytes);
}

void DeviceMemory::protect(bool on) const {
  // The rest was never allocated, and has many pages.
  const std::size_t used = std::min((pool_.peak() + kPage - 1) / kPage * kPage, bytes_);
  if (guard_ && used > 0) protect_pages(block_, used, on);
}

bool DeviceMemory::holds(const void* begin, std::size_t bytes) const {
  const char* at = static_cast<const char*>(begin);
  return bytes > 0 ? at >= block_ && at + bytes <= block_ + bytes_ : at >= block_ && at <= block_ + bytes_;
}

bool DeviceMemory::holds_host_address(const void* object, std::size_t bytes) const {
  // The addresses of programs, heaps and stacks on 64-bit systems. As doubles they are subnormal; as two ids the second
  // one is above all ids of the tests.
  constexpr std::uint64_t kHighest = 0x7fffffffffffU;
  for (std::size_t at = 0; at + sizeof(std::uint64_t) <= bytes; at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, static_cast<const char*>(object) + at, sizeof word);
    if (word >= kLowestHostAddress && word <= kHighest && !holds(reinterpret_cast<const void*>(word), 0)) return true;
  }
  return false;
}

}  // namespace tetune::backend
