// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <utility>

namespace tetune {

/// Positive numbers that are not in use.
class FreeNumbers {
 public:
  explicit FreeNumbers(std::set<int> taken) : taken_(std::move(taken)) {}
  /// Takes a number into use; returns whether it was free.
  bool take(int number) { return taken_.insert(number).second; }
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
inline std::map<int, int> numbers_of_tags(const std::set<int>& tags, std::set<int> taken, int max) {
  taken.insert(tags.begin(), tags.end());
  FreeNumbers free_numbers(std::move(taken));
  std::map<int, int> tag2number;
  for (const int tag : tags) {
    int& number = tag2number[tag];
    if (tag > 0 && tag <= max) number = tag;
    if (tag < 0 && tag >= -max && free_numbers.take(-tag)) number = -tag;
  }
  for (auto& [tag, number] : tag2number) {
    if (number == 0) number = free_numbers.take_lowest();
  }
  return tag2number;
}

}  // namespace tetune
