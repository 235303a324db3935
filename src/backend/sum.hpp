// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/macros.hpp"

namespace tetune::backend {

/// The result of a reduction that adds.
template <class T>
struct Sum {
  T value{};
  TETUNE_HD void merge(const Sum& other) { value += other.value; }
};

}  // namespace tetune::backend
