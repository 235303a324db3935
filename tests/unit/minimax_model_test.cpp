// SPDX-License-Identifier: Apache-2.0
// Steps that decrease the maximum of several linear functions, against exact solutions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "relocation/minimax_model.hpp"

namespace tetune {
namespace {

/// A model of functions with given gradients.
class Model {
 public:
  void add(double value, const Vec3& gradient) {
    const int number = static_cast<int>(gradients_.size());
    model_.add_in_order([&](const auto& add_one) { add_one(value, number); }, backend::SingleThread());
    gradients_.push_back(gradient);
  }
  int added() const { return model_.added(); }
  void clear() { model_.clear(backend::SingleThread()); }
  template <class Team = backend::SingleThread>
  MinimaxStep step(double radius, const Team& team = {}) {
    model_.set_gradients([this](const int(&i)[1]) { return gradients_[to_size_t(i[0])]; },
                         [](const Vec3& gradient) { return gradient; });
    return model_.step(radius, team);
  }

 private:
  MinimaxModel model_;
  std::vector<Vec3> gradients_;
};

TEST(MinimaxModel, WithoutFunctionsThereIsNoStep) {
  const Vec3 d = MinimaxModel().step(1).d;
  EXPECT_EQ(norm(d), 0);
}

TEST(MinimaxModel, OneFunctionDecreasesAlongItsGradientByTheRadius) {
  Model model;
  model.add(5, {0, 3, 4});
  const Vec3 d = model.step(2).d;
  EXPECT_NEAR(d.x, 0, 1e-15);
  EXPECT_NEAR(d.y, -1.2, 1e-15);
  EXPECT_NEAR(d.z, -1.6, 1e-15);
}

TEST(MinimaxModel, OpposedGradientsLeaveTheDirectionThatDecreasesBoth) {
  Model model;
  model.add(1, {1, 0, 0.5});
  model.add(1, {-1, 0, 0.5});
  const Vec3 d = model.step(0.1).d;
  EXPECT_NEAR(d.x, 0, 1e-12);
  EXPECT_LT(d.z, 0);
}

TEST(MinimaxModel, GradientsThatOverflowAreLeftOut) {
  Model model;
  model.add(1, {1e300, 0, 0});
  model.add(2, {std::nan(""), 0, 0});
  EXPECT_EQ(norm(model.step(1).d), 0);
  model.add(1, {0, 2, 0});
  EXPECT_NEAR(model.step(1).d.y, -1, 1e-15);
}

TEST(MinimaxModel, AnOptimumHasNoStep) {
  Model model;
  model.add(1, {1, 0, 0});
  model.add(1, {-0.5, 1, 0});
  model.add(1, {-0.5, -1, 0});
  EXPECT_LT(norm(model.step(1).d), 0.02);
}

TEST(MinimaxModel, FunctionsBeyondItsRoomAreCountedAndDoNotTakePart) {
  constexpr int kMany = 100;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Model model;
  Model expected;
  for (int i = 0; i < kMany; ++i) {
    const double value = uniform(random);
    const Vec3 gradient{uniform(random), uniform(random), uniform(random)};
    model.add(value, gradient);
    if (i < MinimaxModel::kMaxFunctions) expected.add(value, gradient);
  }
  EXPECT_EQ(model.added(), kMany);
  EXPECT_EQ(norm(model.step(0.5).d - expected.step(0.5).d), 0);
  model.clear();
  EXPECT_EQ(model.added(), 0);
  EXPECT_EQ(norm(model.step(0.5).d), 0);
}

TEST(MinimaxModel, FunctionsFarBelowTheLargestDoNotCount) {
  Model model;
  model.add(1, {1, 0, 0});
  model.add(-10, {-1, 0, 0});
  EXPECT_NEAR(model.step(0.5).d.x, -0.5, 1e-15);
}

using Functions = std::vector<std::pair<double, Vec3>>;

double longest_gradient(const Functions& functions) {
  double longest = 0;
  for (const auto& function : functions) longest = std::max(longest, norm(function.second));
  return longest;
}

double largest_value(const Functions& functions, const Vec3& d) {
  double largest = -1e300;
  for (const auto& [value, gradient] : functions) largest = std::max(largest, value + dot(gradient, d));
  return largest;
}

/// The function that a step minimizes: the maximum of the functions, with the quadratic term.
double model_value(const Functions& functions, double radius, const Vec3& d) {
  return largest_value(functions, d) + 0.5 * longest_gradient(functions) / radius * dot(d, d);
}

/// The step at which the functions of a subset have the same value, which is minimal: -tau sum l_i g_i with weights
/// of sum 1, by elimination with pivoting. Zero where their gradients are dependent.
Vec3 step_of_subset(const Functions& functions, const std::vector<int>& subset, double tau) {
  const int n = static_cast<int>(subset.size());
  // Unknowns: the weights, and the value. Rows: tau sum l_j g_i . g_j + value = c_i, and sum l_j = 1.
  double a[5][6] = {};
  for (int i = 0; i < n; ++i) {
    const auto& [value, gradient] = functions[to_size_t(subset[to_size_t(i)])];
    for (int j = 0; j < n; ++j) a[i][j] = tau * dot(gradient, functions[to_size_t(subset[to_size_t(j)])].second);
    a[i][n] = a[n][i] = 1;
    a[i][n + 1] = value;
  }
  a[n][n + 1] = 1;
  for (int k = 0; k <= n; ++k) {
    int pivot = k;
    for (int i = k; i <= n; ++i) pivot = std::abs(a[i][k]) > std::abs(a[pivot][k]) ? i : pivot;
    if (std::abs(a[pivot][k]) < 1e-13) return {0, 0, 0};
    std::swap(a[k], a[pivot]);
    for (int i = 0; i <= n; ++i) {
      const double factor = i == k ? 0 : a[i][k] / a[k][k];
      for (int j = k; j <= n + 1; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  Vec3 d{0, 0, 0};
  for (int i = 0; i < n; ++i) {
    d = d - (tau * a[i][n + 1] / a[i][i]) * functions[to_size_t(subset[to_size_t(i)])].second;
  }
  return d;
}

/// The minimum, by all subsets of at most four functions: one of them determines it.
double minimum_of_subsets(const Functions& functions, double radius) {
  const double tau = radius / longest_gradient(functions);
  double least = model_value(functions, radius, {0, 0, 0});
  std::vector<int> subset;
  const auto extend = [&](const auto& self, int from) -> void {
    for (int i = from; i < static_cast<int>(functions.size()); ++i) {
      subset.push_back(i);
      least = std::min(least, model_value(functions, radius, step_of_subset(functions, subset, tau)));
      if (subset.size() < 4) self(self, i + 1);
      subset.pop_back();
    }
  };
  extend(extend, 0);
  return least;
}

/// Random functions; `kind` chooses those in space, on a plane, on a line, on a lattice with ties and duplicates, near
/// a plane, and in a narrow bundle.
Functions random_functions(int kind, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> whole(-1, 1);
  Functions functions(to_size_t(1 + static_cast<int>(random() % 12)));
  for (auto& [value, g] : functions) {
    value = kind == 3 ? 0.1 * whole(random) : 0.1 * uniform(random);
    g = {uniform(random), uniform(random), uniform(random)};
    if (kind == 1) g = {g.x, g.y, g.x + 2 * g.y};
    if (kind == 2) g = g.x * Vec3{1, 2, 3};
    if (kind == 3) g = {1.0 * whole(random), 1.0 * whole(random), 1.0 * whole(random)};
    if (kind == 4) g.z = 1e-9 * g.z;
    if (kind == 5) g = Vec3{1, 1, 1} + 1e-5 * g;
  }
  functions[0].second.x += 1;  // one gradient is not zero
  return functions;
}

TEST(MinimaxModel, AStepIsOptimalAmongAllSubsets) {
  std::mt19937 random(1);
  for (int test = 0; test < 600; ++test) {
    const Functions functions = random_functions(test % 6, random);
    const double radius = test % 5 == 0 ? 1 : 0.05;
    Model model;
    for (const auto& [value, gradient] : functions) model.add(value, gradient);
    const auto [d, value] = model.step(radius);
    const Vec3 by_packs = model.step(radius, backend::PackThread<backend::Pack4>()).d;
    EXPECT_TRUE(by_packs.x == d.x && by_packs.y == d.y && by_packs.z == d.z);
    EXPECT_LE(norm(d), radius * (1 + 1e-12));
    EXPECT_NEAR(value, largest_value(functions, d), 1e-14);
    EXPECT_LE(model_value(functions, radius, d),
              minimum_of_subsets(functions, radius) + 1e-6 * radius * longest_gradient(functions))
        << "functions of kind " << test % 6 << ", test " << test;
  }
}

}  // namespace
}  // namespace tetune
