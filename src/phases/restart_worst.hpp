// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "energy/quality_floor.hpp"
#include "phases/neighborhood_finder.hpp"
#include "phases/optimizer.hpp"

namespace tetune {

namespace backend {
class Cpu;
}

/// The state of a mesh that restarts begin with.
struct RestartInput {
  const Options& options;
  Context context;
  QualityFloor of_input;            ///< no tetrahedron may become worse
  std::vector<double> extremeness;  ///< per slot: AngleExtremes::values
  double mean_energy;               ///< per tetrahedron, of the shape energy
  Size tets_before;                 ///< of the caller's mesh
};

/// Iterated local search on the host: see restart_worst().
class RestartSearch {
 public:
  RestartSearch(HostWork& whole, RestartInput input);
  ~RestartSearch();

  /// Restarts at several places. Returns false if none is left.
  bool run_round(WorstReport& r);
  bool has_changed() const { return restarts_kept_ > 0; }
  /// The largest cost of the dihedral angles.
  double max_cost() const;
  /// The smallest dihedral angle in degrees with Options::trace_angles, else 0.
  double traced_angle() const;
  void add_to(Report& report) const;

 private:
  struct Restart;
  /// The slots within RestartParameters::worst_part of the largest cost of those whose restarts have not all failed,
  /// the largest cost first.
  std::vector<Index> find_worst() const;
  /// Whether a slot has about the cost of another one, or a larger one.
  bool is_tied(Index slot, Index other) const;
  /// The restarts of a round, in neighborhoods that have no tetrahedron and no face in common.
  std::vector<std::unique_ptr<Restart>> choose();
  void run(Restart& restart, const Context& context) const;
  void keep(Restart& restart);
  void count_failure(const Restart& restart);

  HostWork& whole_;
  RestartInput input_;
  Options options_;  ///< of one neighborhood
  const RestartParameters& p_;
  NeighborhoodFinder finder_;
  std::unique_ptr<backend::Cpu> host_;
  /// The number of restarts around a slot that have failed since its neighborhood changed last.
  std::map<Index, int> failures_;
  OperationCounts counts_;
  int restarts_ = 0, restarts_kept_ = 0;
};

/// Improves the worst elements where improve_angles() is stuck, by iterated local search (Lourenço, Martin and Stützle,
/// 2003): neighborhoods of the worst, as meshes of their own on the host, are optimized again, where angles may be as
/// in the input (`of_input`), and a result is kept if the largest cost in it has fallen, or other large ones; then
/// `floor` is tightened. Reports Report::worst_rounds. Returns false when the caller cancels.
template <class Backend>
bool restart_worst(Optimizer<Backend>& optimizer, const QualityFloor& of_input, QualityFloor& floor) {
  const int rounds = restart_rounds(optimizer.options, double(optimizer.work.mesh.tets()));
  if (rounds == 0) return true;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const AngleParameters& angles = optimizer.tuning.angles;
  HostWork whole;
  std::unique_ptr<RestartSearch> search;
  optimizer.timer.measure(Phase::restarts, [&] {
    optimizer.sum_energy(kShapeObjective);
    const AngleExtremes<Backend> extremes(backend, work.mesh, optimizer.slot_energies(), angles.min_cost,
                                          angles.obtuse_weight);
    whole = download_work(work);
    search = std::make_unique<RestartSearch>(whole, RestartInput{optimizer.options,
                                                                 {{}, [&backend] { return backend.stop_requested(); }},
                                                                 of_input,
                                                                 extremes.values.download(),
                                                                 optimizer.energy() / double(work.mesh.tets()),
                                                                 Size{optimizer.report.tets_before}});
  });
  bool proceeds = true;
  for (int i = 1; i <= rounds && proceeds; ++i) {
    WorstReport r;
    bool has_worst = false;
    r.seconds = optimizer.timer.measure(Phase::restarts, [&] { has_worst = search->run_round(r); });
    if (!has_worst) break;
    r.round = i;
    optimizer.timer.measure(Phase::trace, [&] { r.dihedral_min = search->traced_angle(); });
    optimizer.report.worst_rounds.push_back(r);
    optimizer.progress.estimate.finish_restart(i, rounds);
    proceeds = optimizer.proceed(Phase::restarts, optimizer.iteration());
  }
  search->add_to(optimizer.report);
  if (!search->has_changed()) return proceeds;
  optimizer.timer.measure(Phase::restarts, [&] {
    upload_work(backend, whole, work);
    optimizer.invalidate_rings();
    optimizer.sum_energy(kShapeObjective);
    floor.limit_cost((1 + QualityFloor::kTolerance) * search->max_cost(), angles.obtuse_weight);
  });
  return proceeds;
}

}  // namespace tetune
