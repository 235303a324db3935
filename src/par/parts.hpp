// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>

namespace tetune::par {

/// Which parts of a large block are in use. Best fit; neighbours are joined when they are given back. What lies beyond
/// all that was ever in use comes last, so that where a part lies depends on the calls alone, and not on the size of
/// the block.
class Parts {
 public:
  static constexpr std::size_t kNowhere = ~std::size_t{0};

  explicit Parts(std::size_t block_bytes) : block_bytes_(block_bytes) {}

  /// Where the part begins, or kNowhere.
  std::size_t take(std::size_t bytes);
  void give_back(std::size_t begin) noexcept;

  std::size_t block_bytes() const { return block_bytes_; }
  std::size_t in_use() const { return in_use_; }
  /// The size of a block that would have done.
  std::size_t peak() const { return end_; }

 private:
  struct Part {
    std::size_t bytes;
    bool is_free;
  };
  using ByBegin = std::map<std::size_t, Part>;
  ByBegin::iterator find_room(std::size_t bytes);

  std::size_t block_bytes_;
  /// They fill the block from its start to `end_`. There are never many.
  ByBegin parts_;
  std::size_t end_ = 0;
  std::size_t in_use_ = 0;
};

}  // namespace tetune::par
