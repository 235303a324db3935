// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>

namespace tetune::test {

/// Watches operator new while an instance lives. The largest single request shows that a wild count is refused before
/// memory is asked for; granting only some requests shows what happens when memory runs out. One instance at a time.
class AllocationWatch {
 public:
  /// False under the sanitizers of clang: nothing is watched then, and all requests are granted.
  static bool works();

  /// Requests beyond the first `granted` throw std::bad_alloc.
  explicit AllocationWatch(std::size_t granted = std::numeric_limits<std::size_t>::max());
  ~AllocationWatch();
  AllocationWatch(const AllocationWatch&) = delete;
  AllocationWatch& operator=(const AllocationWatch&) = delete;
  std::size_t largest() const;
};

}  // namespace tetune::test
