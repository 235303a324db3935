// SPDX-License-Identifier: Apache-2.0
// The model that bench/scaling predicts times with.
#include "scaling/machine_model.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "backend/thread_pool.hpp"

namespace tetune::scaling {
namespace {

constexpr ThreadCosts kFree{0, 0, 0, 1, 0, 0};

TEST(MachineModel, EqualPartsAreDividedEvenly) {
  const std::vector<double> parts(16, 0.5);
  EXPECT_EQ(makespan(parts, 1, 0, kFree), 8);
  EXPECT_EQ(makespan(parts, 4, 0, kFree), 2);
  EXPECT_EQ(makespan(parts, 5, 0, kFree), 2);
  EXPECT_EQ(makespan(parts, 64, 0, kFree), 0.5);
}

TEST(MachineModel, AThreadTakesTheNextPartWhenItIsFree) {
  EXPECT_EQ(makespan({4, 1, 1, 1, 1}, 2, 0, kFree), 4);
  EXPECT_EQ(makespan({1, 1, 1, 1, 4}, 2, 0, kFree), 6);
}

TEST(MachineModel, AddsTheCostsOfThreads) {
  ThreadCosts costs = kFree;
  costs.take = 0.25;
  EXPECT_EQ(makespan({1, 1, 1, 1}, 2, 0, costs), 2.75) << "parts are taken one after the other";
  costs = kFree;
  costs.notify = 3;
  EXPECT_EQ(makespan({1, 1, 1, 1}, 2, 0.5, costs), 2) << "the worker spins";
  EXPECT_EQ(makespan({1, 1, 1, 1}, 2, 2, costs), 4) << "it comes when the parts are almost done";
  costs = kFree;
  costs.start = 1;
  costs.gate = 0.5;
  EXPECT_EQ(makespan({4, 4}, 2, 0, costs), 7);
}

struct Spin {
  Size* calls;
  void operator()(Size) const {
    ++*calls;
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(200);
    while (std::chrono::steady_clock::now() < end) continue;
  }
};

TEST(MachineModel, TheClockAdvancesByTheMakespan) {
  MachineModel machine(MachineModel::Loops::scheduled, {});
  Size calls = 0;
  const Spin spin{&calls};
  const auto real_start = std::chrono::steady_clock::now();
  const auto start = machine.now();
  machine.run(8, 64, spin);
  const auto modeled = machine.now() - start;
  const auto real = std::chrono::steady_clock::now() - real_start;
  EXPECT_EQ(calls, 64);
  EXPECT_GE(modeled, std::chrono::microseconds(8 * 200));
  EXPECT_LT(modeled, real);
}

TEST(MachineModel, LoopsCanTakeNoTime) {
  MachineModel machine(MachineModel::Loops::free, {});
  Size calls = 0;
  const Spin spin{&calls};
  const auto before = std::chrono::steady_clock::now();
  const auto start = machine.now();
  machine.run(8, 64, spin);
  const auto modeled = machine.now() - start;
  EXPECT_EQ(calls, 64);
  EXPECT_LE(modeled, std::chrono::steady_clock::now() - before - std::chrono::microseconds(64 * 200));
}

}  // namespace
}  // namespace tetune::scaling
