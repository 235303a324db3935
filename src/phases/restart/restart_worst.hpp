// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "energy/quality_floor.hpp"
#include "mesh/csr.hpp"
#include "phases/optimizer.hpp"
#include "phases/restart/neighborhood_finder.hpp"

namespace tetune {

namespace backend {
class Cpu;
}

/// The state of a mesh that restarts begin with.
struct RestartInput {
  const Options& options;
  Context context;
  QualityFloor input_floor;  ///< no tetrahedron may become worse
  double mean_energy;        ///< per tetrahedron, of the shape energy
  Size tets_before;          ///< of the caller's mesh
  Size removable;            ///< WorkingSet::removable
};

/// Iterated local search on the host: see restart_worst().
class RestartSearch {
 public:
  RestartSearch(HostWork& whole, RestartInput input);
  ~RestartSearch();

  /// Restarts at several spots. Returns false if none is left.
  bool run_round(WorstReport& r);
  /// From now on restarts lower the largest angle, and are kept where the smallest one of the mesh stays.
  void aim_at_largest_angle();
  bool has_changed() const { return restarts_kept_ > 0; }
  /// The extreme cotangents in the mesh, at least those of AngleParameters::min_cost.
  DihedralCots extremes() const;
  /// The smallest dihedral angle in degrees with Options::trace_angles, else 0.
  double traced_angle() const;
  void add_to(Report& report) const;
  /// The number of vertices that may be removed in further work (WorkingSet::removable).
  Size removable() const { return input_.removable + counts_.vertices_inserted - counts_.vertices_removed; }

 private:
  struct Restart;
  struct RestartSpot;
  double cost(Index slot) const { return span_of(cots_)[slot].cost(weight_); }
  /// Sets the weight of large angles for the next round, so that the largest costs somewhat more than the smallest.
  /// Returns false if it is small enough, or if several rounds have not lowered it.
  bool weigh_largest_angle();
  /// The slots within RestartParameters::worst_fraction of the largest cost of those whose restarts have not all
  /// failed, the largest cost first.
  std::vector<Index> find_worst() const;
  /// Whether a slot has about the cost of another one, or a larger one.
  bool is_tied(Index slot, Index other) const;
  /// The spots of a round, whose neighborhoods have no tetrahedron and no face in common.
  std::vector<std::unique_ptr<RestartSpot>> choose();
  void run(Restart& restart, const Csr<backend::Cpu>& triangles, const Context& context) const;
  /// Keeps the first try that has succeeded, if there is one, and counts the failures of those before it.
  void finish(RestartSpot& spot, WorstReport& r);
  void keep(Restart& restart);
  void count_failure(const Restart& restart);

  HostWork& whole_;
  RestartInput input_;
  Options options_;  ///< of one neighborhood
  const AngleParameters& angles_;
  const RestartParameters& p_;
  NeighborhoodFinder finder_;
  std::unique_ptr<backend::Cpu> host_;
  std::vector<DihedralCots> cots_;  ///< per slot; 0 where the cost is at most AngleParameters::min_cost
  double weight_;                   ///< of large angles in the cost
  double max_cot_ = HUGE_VAL;       ///< a result with a smaller angle is not kept
  bool aims_at_largest_ = false;
  int rounds_without_ = 0;  ///< in succession, in which no restart was kept
  /// Per slot: the number of restarts around it that have failed since its neighborhood changed last.
  std::vector<std::uint8_t> failures_;
  OperationCounts counts_;
  int restarts_ = 0, restarts_kept_ = 0;
};

/// Improves the worst elements where improve_angles() is stuck, by iterated local search (Lourenço, Martin and Stützle,
/// 2003): neighborhoods of the worst, as meshes of their own on the host, are optimized again, where angles may be as
/// in the input (`input_floor`), and a result is kept if the largest cost in it has fallen, or other large ones.
/// Further rounds lower the largest angle. Then `floor` is tightened. Reports Report::worst_rounds. Returns false when
/// the caller cancels.
template <class Backend>
bool restart_worst(Optimizer<Backend>& optimizer, const QualityFloor& input_floor, QualityFloor& floor) {
  const int rounds = restart_rounds(optimizer.options, double(optimizer.work.mesh.tets()));
  if (rounds == 0) return true;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  HostWork whole;
  std::unique_ptr<RestartSearch> search;
  optimizer.timer.measure(Phase::restarts, [&] {
    optimizer.sum_energy(kShapeObjective);
    whole = HostWork(work);
    search = std::make_unique<RestartSearch>(whole, RestartInput{optimizer.options,
                                                                 {{}, [&backend] { return backend.stop_requested(); }},
                                                                 input_floor,
                                                                 optimizer.energy() / double(work.mesh.tets()),
                                                                 Size{optimizer.report.tets_before},
                                                                 work.removable});
  });
  const int rounds_in_all = rounds + largest_angle_rounds(optimizer.options);
  int round = 0;
  const auto run_until = [&](int last) {
    while (round < last) {
      WorstReport r;
      r.work = "restarts";
      bool has_worst = false;
      r.seconds = optimizer.timer.measure(Phase::restarts, [&] { has_worst = search->run_round(r); });
      if (!has_worst) return true;
      r.round = ++round;
      optimizer.timer.measure(Phase::trace, [&] { r.dihedral_min = search->traced_angle(); });
      optimizer.report.worst_rounds.push_back(r);
      optimizer.progress.estimate.finish_restart_round(round, rounds_in_all);
      if (!optimizer.proceed(Phase::restarts, optimizer.iteration())) return false;
    }
    return true;
  };
  bool proceeds = run_until(rounds);
  if (proceeds) {
    search->aim_at_largest_angle();
    proceeds = run_until(round + largest_angle_rounds(optimizer.options));
  }
  search->add_to(optimizer.report);
  work.removable = search->removable();
  if (!search->has_changed()) return proceeds;
  optimizer.timer.measure(Phase::restarts, [&] {
    upload_work(backend, whole, work);
    optimizer.invalidate_rings();
    optimizer.sum_energy(kShapeObjective);
    const DihedralCots reached = search->extremes();
    constexpr double kRelaxed = 1 + QualityFloor::kTolerance;
    floor.limit_angles({kRelaxed * reached.max, kRelaxed * reached.min});
  });
  return proceeds;
}

}  // namespace tetune
