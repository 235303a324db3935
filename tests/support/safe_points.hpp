// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/context.hpp"

/// Runs that are stopped at each of their safe points.
namespace tetune::test {

/// Returns how often run(context) calls Context::stop.
template <class Run>
int count_safe_points(const Run& run) {
  int points = 0;
  Context context;
  context.stop = [&points] {
    ++points;
    return false;
  };
  run(context);
  return points;
}

/// A context that requests the stop at one safe point, counted from 1, and does not repeat the request: like an event
/// that is taken from a queue. `asked` counts the calls.
inline Context stop_once_at(int point, int& asked) {
  asked = 0;
  Context context;
  context.stop = [&asked, point] { return ++asked == point; };
  return context;
}

}  // namespace tetune::test
