// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>

namespace tetune::test {

/// Observes operator new during the lifetime of an instance. The largest single request shows that an invalid count is
/// rejected before an allocation; a limited number of granted requests simulates that memory runs out. At most one
/// instance at a time.
class AllocationWatch {
 public:
  /// False under the sanitizers of clang: nothing is observed then, and all requests are granted.
  static bool works();

  /// Requests beyond the first `granted` throw std::bad_alloc.
  explicit AllocationWatch(std::size_t granted = std::numeric_limits<std::size_t>::max());
  ~AllocationWatch();
  AllocationWatch(const AllocationWatch&) = delete;
  AllocationWatch& operator=(const AllocationWatch&) = delete;
  std::size_t largest() const;
};

}  // namespace tetune::test
