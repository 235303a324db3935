// SPDX-License-Identifier: Apache-2.0
#include "driver/report/extend_report.hpp"

#include <utility>

#include "mesh/id_maps.hpp"
#include "phases/progress/phase_timer.hpp"

namespace tetune {
namespace {

/// compose() for a list of which the result has some entries, or none: the map is empty then, too.
std::vector<Index> compose_of_list(std::size_t entries, std::vector<Index> between2input,
                                   std::vector<Index> result2between) {
  return entries == 0 ? std::vector<Index>() : compose(std::move(between2input), std::move(result2between));
}

template <class T>
void append(std::vector<T>& list, const std::vector<T>& further) {
  list.insert(list.end(), further.begin(), further.end());
}

/// Appends the sweeps, flip passes and rounds; the sweeps of the further run are counted from those before.
void append_steps(Report& report, Report& further) {
  const int sweeps = report.sweeps.empty() ? 0 : report.sweeps.back().iteration;
  for (SweepReport& s : further.sweeps) s.iteration += sweeps;
  for (FlipReport& f : further.flip_passes) f.iteration += sweeps;
  append(report.sweeps, further.sweeps);
  append(report.flip_passes, further.flip_passes);
  append(report.worst_rounds, further.worst_rounds);
}

}  // namespace

void add_seconds(Report& report, const std::string& phase, double seconds) {
  report.phases[PhaseTimer::entry_of(report, phase)].seconds += seconds;
}

double seconds_of_phases(const Report& report) {
  double sum = 0;
  for (const PhaseTime& time : report.phases) sum += time.seconds;
  return sum;
}

void extend_report(Report& report, Report&& further, const TetMesh& result) {
  for (const PhaseTime& time : further.phases) add_seconds(report, time.phase, time.seconds);
  report.OperationCounts::operator+=(further);
  append_steps(report, further);
  report.restarts += further.restarts;
  report.restarts_kept += further.restarts_kept;
  report.tets_after = further.tets_after;
  report.deviation += further.deviation;
  report.energy_after += further.energy_after - further.energy_before;
  report.triangles_dropped += further.triangles_dropped;
  report.edges_dropped += further.edges_dropped;
  report.vertex2original = compose(std::move(report.vertex2original), std::move(further.vertex2original));
  report.tet2original = compose(std::move(report.tet2original), std::move(further.tet2original));
  report.triangle2original = compose_of_list(result.triangles.size(), std::move(report.triangle2original),
                                             std::move(further.triangle2original));
  report.edge2original =
      compose_of_list(result.edges.size(), std::move(report.edge2original), std::move(further.edge2original));
}

}  // namespace tetune
