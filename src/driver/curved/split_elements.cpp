// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/split_elements.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "curved/held_bound.hpp"
#include "driver/curved/curved_skeleton.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

constexpr int kMaxInvalidRounds = 4;
constexpr int kMaxBoundedRounds = 8;

bool is_stopped(const RelaxationGoal& goal) { return goal.stop && goal.stop(); }

class BoundedSplitter {
 public:
  BoundedSplitter(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal, double max_tets)
      : mesh_(mesh), held_(held), origins_(origins), goal_(goal), max_tets_(max_tets) {}

  void run() {
    for (int round = 0; round < kMaxBoundedRounds && !is_stopped(goal_); ++round) {
      std::vector<Index> tets = find_bounded(mesh_, held_, kSmallBound);
      std::erase_if(tets, [this](Index t) { return excluded_.contains(span_of(origins_.tets)[t]); });
      if (tets.empty()) break;
      split(tets);
    }
  }

 private:
  void split(const std::vector<Index>& tets) {
    TetMesh trial = mesh_;
    HeldNodes held = held_;
    Origins step = own_origins(mesh_);
    const std::vector<Index> around = split_edges(trial, held, tets, max_tets_, step);
    held.vertices.resize(trial.points.size(), 0);
    relax_curved(trial, held, find_invalid(trial, goal_.threads), goal_);
    const std::vector<Index> invalid = find_invalid(trial, goal_.threads);
    if (!around.empty() && invalid.empty()) {
      mesh_ = std::move(trial);
      held_ = std::move(held);
      for (Index& t : step.tets) t = span_of(origins_.tets)[t];
      for (Index& v : step.vertices) v = v < 0 ? v : span_of(origins_.vertices)[v];
      origins_ = std::move(step);
      return;
    }
    exclude(tets, trial, invalid);
  }

  /// Excludes from further splits the tetrahedra that share a vertex with one that is not valid after the split; where
  /// none does, all of them.
  void exclude(const std::vector<Index>& tets, const TetMesh& trial, const std::vector<Index>& invalid) {
    std::set<Index> vertices;
    for (const Index t : invalid) vertices.insert(span_of(trial.tets)[t].begin(), span_of(trial.tets)[t].end());
    const auto is_near = [&](Index t) {
      const auto& tet = span_of(mesh_.tets)[t];
      return std::any_of(tet.begin(), tet.end(), [&vertices](Index v) { return vertices.contains(v); });
    };
    const bool has_near = std::any_of(tets.begin(), tets.end(), is_near);
    for (const Index t : tets) {
      if (!has_near || is_near(t)) excluded_.insert(span_of(origins_.tets)[t]);
    }
  }

  TetMesh& mesh_;
  HeldNodes& held_;
  Origins& origins_;
  const RelaxationGoal& goal_;
  double max_tets_;
  std::set<Index> excluded_;  ///< of the input
};

}  // namespace

void split_invalid(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal) {
  std::vector<Index> left = find_unfolded(mesh, goal.threads);
  for (int round = 0; round < kMaxInvalidRounds && !left.empty() && !is_stopped(goal); ++round) {
    TetMesh trial = mesh;
    HeldNodes trial_held = held;
    Origins trial_origins = origins;
    std::vector<Index> relaxed = split_edges(trial, trial_held, left, kUnlimitedSplits, trial_origins);
    if (relaxed.empty()) return;
    trial_held.vertices.resize(trial.points.size(), 0);
    relaxed.insert(relaxed.end(), left.begin(), left.end());
    sort_unique(relaxed);
    relax_curved(trial, trial_held, relaxed, goal);
    std::vector<Index> still_invalid = find_unfolded(trial, goal.threads);
    if (still_invalid.size() >= left.size()) return;
    left = std::move(still_invalid);
    mesh = std::move(trial);
    held = std::move(trial_held);
    origins = std::move(trial_origins);
  }
}

void split_bounded(TetMesh& mesh, HeldNodes& held, Origins& origins, const RelaxationGoal& goal, double max_tets) {
  BoundedSplitter(mesh, held, origins, goal, max_tets).run();
}

}  // namespace tetune
