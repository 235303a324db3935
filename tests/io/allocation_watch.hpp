// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace tetune::test {

/// The largest single request to operator new while an instance lives: shows that a wild count in a file is refused
/// before memory is asked for. One instance at a time. 0 under the sanitizers of clang.
class AllocationWatch {
 public:
  AllocationWatch();
  ~AllocationWatch();
  AllocationWatch(const AllocationWatch&) = delete;
  AllocationWatch& operator=(const AllocationWatch&) = delete;
  std::size_t largest() const;
};

}  // namespace tetune::test
