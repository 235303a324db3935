// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

/// Memory of the CPU backend's arrays. The system hands out fresh pages, which it must clear: that costs more than many
/// a pass over them. So arrays lie in regions of address space, and while a session is open, what one gives back serves
/// the next ones, whatever their sizes.
namespace tetune::par::host_memory {

/// Throws std::bad_alloc. From any thread; null for no bytes.
void* allocate(std::size_t bytes);
/// `bytes` as asked for.
void release(void* memory, std::size_t bytes) noexcept;

/// Sessions may overlap; when the last one ends, what is not in use goes back to the system.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

}  // namespace tetune::par::host_memory
