// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

/// Memory of the CPU backend's arrays. The system hands out fresh pages, which it must clear: that costs more than many
/// a pass over them. So large blocks that are given back are kept, while a session is open, for the next array of about
/// their size.
namespace tetune::par::block_cache {

/// Throws std::bad_alloc. From any thread; null for no bytes.
void* allocate(std::size_t bytes);
/// `bytes` as asked for.
void release(void* memory, std::size_t bytes) noexcept;

/// Sessions may overlap; when the last one ends, what was kept goes back to the system.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

}  // namespace tetune::par::block_cache
