// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace tetune::mpi {

using Time = std::chrono::steady_clock;

inline double seconds_since(Time::time_point start) {
  return std::chrono::duration<double>(Time::now() - start).count();
}

}  // namespace tetune::mpi
