// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "io/io_context.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Positive numbers that are not in use.
class FreeNumbers {
 public:
  explicit FreeNumbers(std::set<int> taken) : taken_(std::move(taken)) {}
  /// Takes a number into use; returns whether it was free.
  bool take(int number) { return taken_.insert(number).second; }
  /// Takes the lowest free number into use.
  int take_lowest() {
    while (!take(lowest_)) ++lowest_;
    return lowest_;
  }

 private:
  std::set<int> taken_;
  int lowest_ = 1;
};

/// A positive number up to `max` for each tag: the tag, or minus it where no other tag is that, or else a free one.
/// `taken` are numbers that only the tag of that number may have.
std::map<int, int> numbers_of_tags(const std::set<int>& tags, std::set<int> taken, int max);

/// The tags of the elements of each dimension, those of TetMesh::others included.
std::array<std::set<int>, 4> tags_by_dimension(const TetMesh& mesh);

/// Warns where elements of a dimension get other numbers than their tags. `range` describes the format's numbers.
void warn_of_renumbered_tags(const std::map<int, int>& tag2number, int dimension, const std::string& range,
                             const IoContext& context);

}  // namespace tetune
