// SPDX-License-Identifier: Apache-2.0
// Steps that decrease the maximum of several linear functions, against exact solutions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "relocation/minimax_model.hpp"

namespace tetune {
namespace {

/// A model of functions with given gradients.
class Model {
 public:
  void add(double value, const Vec3& gradient) {
    model_.add(value, static_cast<int>(gradients_.size()));
    gradients_.push_back(gradient);
  }
  void clear() { model_.clear(backend::SingleThread()); }
  template <class Team = backend::SingleThread>
  Vec3 step(double radius, const Team& team = {}) {
    model_.set_gradients([this](int i) { return gradients_[to_size_t(i)]; });
    return model_.step(radius, team);
  }

 private:
  MinimaxModel model_;
  std::vector<Vec3> gradients_;
};

TEST(MinimaxModel, WithoutFunctionsThereIsNoStep) {
  const Vec3 d = MinimaxModel().step(1);
  EXPECT_EQ(norm(d), 0);
}

TEST(MinimaxModel, OneFunctionDecreasesAlongItsGradientByTheRadius) {
  Model model;
  model.add(5, {0, 3, 4});
  const Vec3 d = model.step(2);
  EXPECT_NEAR(d.x, 0, 1e-15);
  EXPECT_NEAR(d.y, -1.2, 1e-15);
  EXPECT_NEAR(d.z, -1.6, 1e-15);
}

TEST(MinimaxModel, OpposedGradientsLeaveTheDirectionThatDecreasesBoth) {
  Model model;
  model.add(1, {1, 0, 0.5});
  model.add(1, {-1, 0, 0.5});
  const Vec3 d = model.step(0.1);
  EXPECT_NEAR(d.x, 0, 1e-12);
  EXPECT_LT(d.z, 0);
}

TEST(MinimaxModel, GradientsThatOverflowAreLeftOut) {
  Model model;
  model.add(1, {1e300, 0, 0});
  model.add(2, {std::nan(""), 0, 0});
  EXPECT_EQ(norm(model.step(1)), 0);
  model.add(1, {0, 2, 0});
  EXPECT_NEAR(model.step(1).y, -1, 1e-15);
}

TEST(MinimaxModel, AnOptimumHasNoStep) {
  Model model;
  model.add(1, {1, 0, 0});
  model.add(1, {-0.5, 1, 0});
  model.add(1, {-0.5, -1, 0});
  EXPECT_LT(norm(model.step(1)), 0.02);
}

TEST(MinimaxModel, TheLargestFunctionsAreKept) {
  constexpr int kMany = 100;
  constexpr int kKept = 40;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<std::pair<double, Vec3>> functions;
  for (int i = 0; i < kMany; ++i) {
    functions.emplace_back(uniform(random), Vec3{uniform(random), uniform(random), uniform(random)});
  }
  Model model;
  for (const auto& [value, gradient] : functions) model.add(value, gradient);
  std::sort(functions.begin(), functions.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  Model expected;
  for (int i = 0; i < kKept; ++i) expected.add(functions[i].first, functions[i].second);
  // The order of the functions affects the step within the tolerance of the method.
  EXPECT_LT(norm(model.step(0.5) - expected.step(0.5)), 1e-8);
  model.clear();
  EXPECT_EQ(norm(model.step(0.5)), 0);
}

TEST(MinimaxModel, FunctionsFarBelowTheLargestDoNotCount) {
  Model model;
  model.add(1, {1, 0, 0});
  model.add(-10, {-1, 0, 0});
  EXPECT_NEAR(model.step(0.5).x, -0.5, 1e-15);
}

TEST(MinimaxModel, TheSmallestFunctionsGiveWayToLargerOnes) {
  Model model;
  for (int i = 0; i < 1000; ++i) model.add(0, {-1, 0, 0});
  model.add(10, {1, 0, 0});
  EXPECT_NEAR(model.step(0.5).x, -0.5, 1e-15);
}

/// The maximum of the functions of a model, with the quadratic term of its step.
TEST(MinimaxModel, NoOtherStepIsMuchBetter) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int test = 0; test < 200; ++test) {
    Model model;
    std::vector<std::pair<double, Vec3>> functions;
    double longest = 0;
    for (int i = 0; i < 12; ++i) {
      functions.emplace_back(0.1 * uniform(random), Vec3{uniform(random), uniform(random), uniform(random)});
      longest = std::max(longest, norm(functions.back().second));
      model.add(functions.back().first, functions.back().second);
    }
    const double radius = 0.2;
    const auto objective = [&](const Vec3& d) {
      double largest = -1e300;
      for (const auto& [value, gradient] : functions) largest = std::max(largest, value + dot(gradient, d));
      return largest + 0.5 * longest / radius * dot(d, d);
    };
    const Vec3 d = model.step(radius);
    const Vec3 by_packs = model.step(radius, backend::PackThread<backend::Pack4>());
    EXPECT_TRUE(by_packs.x == d.x && by_packs.y == d.y && by_packs.z == d.z);
    EXPECT_LE(norm(d), radius * (1 + 1e-12));
    const double reached = objective(d);
    EXPECT_LE(reached, objective({0, 0, 0}) + 1e-12);
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 other = d + 0.05 * Vec3{uniform(random), uniform(random), uniform(random)};
      EXPECT_GE(objective(other), reached - 0.02 * radius * longest);
    }
  }
}

}  // namespace
}  // namespace tetune
