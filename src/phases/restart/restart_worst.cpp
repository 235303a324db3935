// SPDX-License-Identifier: Apache-2.0
#include "phases/restart/restart_worst.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "phases/improve_angles.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/restart/neighborhood.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// The vertices of a neighborhood within some rings, as flags. Vertices that are inserted later belong to them.
class Region {
 public:
  Region(const Cpu& backend, const std::vector<std::uint8_t>& flags) { flags_.upload(backend, flags); }
  Span<const std::uint8_t> flags(const Cpu& backend, const WorkMesh<Cpu>& mesh) {
    grow_filled(backend, flags_, mesh.vertices(), std::uint8_t{1});
    return std::as_const(flags_).span();
  }

 private:
  VertexMask<Cpu> flags_;
};

MeshView view_of(HostWork& work) {
  return {span_of(work.points), span_of(work.tet2vertex), span_of(work.tet2tet), span_of(work.tet2original)};
}

void add(const WorstReport& round, WorstReport& sum) {
  sum.inserted += round.inserted;
  sum.removed += round.removed;
  sum.flips += round.flips;
  sum.moved += round.moved;
}

/// The extreme cotangents of the tetrahedron in each slot; 0 where they cost at most AngleParameters::min_cost, and in
/// free slots.
std::vector<DihedralCots> extreme_cots(const Cpu& backend, const MeshView& mesh, Size slots,
                                       const AngleParameters& angles) {
  std::vector<DihedralCots> all(to_size_t(slots), {0, 0});
  const Span<DihedralCots> of_slot = span_of(all);
  backend.for_each(slots, [&](Size t) {
    if (!mesh.alive(t)) return;
    const DihedralCots cots = dihedral_cots(mesh, t);
    if (cots.cost(angles.obtuse_weight) > angles.min_cost) of_slot[t] = cots;
  });
  return all;
}

DihedralCots merge(DihedralCots extremes, const std::vector<DihedralCots>& all) {
  for (const DihedralCots& cots : all) extremes.merge(cots);
  return extremes;
}

/// The sum of the costs to the power of eight, to which the largest contribute most. Products have the same bits
/// everywhere; results of std::pow() depend on the library.
double sum_of_powers(const std::vector<DihedralCots>& all, double obtuse_weight) {
  double sum = 0;
  for (const DihedralCots& cots : all) {
    const double cost = cots.cost(obtuse_weight);
    const double fourth = cost * cost * cost * cost;
    sum += fourth * fourth;
  }
  return sum;
}

/// Optimizes one neighborhood.
class NeighborhoodOptimizer {
 public:
  NeighborhoodOptimizer(Optimizer<Cpu>& optimizer, const RestartInput& input, double obtuse_weight, WorstReport& r)
      : optimizer_(optimizer),
        p_(optimizer.tuning.restart),
        angles_(improve_angles_detail::last_parameters(optimizer.tuning.angles)),
        input_(input),
        r_(r) {
    angles_.min_count = angles_.min_vertex_count = p_.count;
    angles_.obtuse_weight = obtuse_weight;
  }

  /// Angles are worked on whose cost is above a part of the largest.
  void set_largest_cost(double cost) { angles_.min_cost = std::max(angles_.min_cost, p_.cost_fraction * cost); }

  /// Lowers the energy, and then the mean energy, as before any work on the worst elements.
  void lower_energy(Region region, const RestartParameters::Perturbation& perturbation) {
    const Cpu& backend = optimizer_.backend;
    WorkingSet<Cpu>& work = optimizer_.work;
    const Criterion criterion{kShapeObjective, input_.input_floor, angles_.obtuse_weight};
    const int rounds = perturbation.energy_rounds + (edits_vertices(optimizer_.options) ? perturbation.mean_rounds : 0);
    for (int i = 0; i < rounds && !backend.stop_requested(); ++i) {
      const bool lowers_mean = i >= perturbation.energy_rounds;
      RetriangulationLimits limits = retriangulation_limits(optimizer_, kInfeasible);
      if (lowers_mean) {
        limits.mean_energy = input_.mean_energy;
        limits.min_gain = optimizer_.tuning.mean.min_gain;
      }
      const auto flags = region.flags(backend, work.mesh);
      const auto tets = tets_with_flagged_vertex(backend, work.mesh, flags);
      BufferOf<Cpu, Index> extreme;
      if (!lowers_mean) extreme = tets_above(backend, work.mesh, extremes_in(region).costs(), 0);
      const Span<const Index> proposers = lowers_mean ? tets.span() : std::as_const(extreme).span();
      WorstReport round;
      round.moved = improve_around(optimizer_, criterion, tets.span(), proposers, limits, round).swept.get().moved;
      add(round, r_);
      optimizer_.set_energy(sum_energy(backend, work.flips.energies));
    }
  }

  void enlarge_angles(Region region) {
    QualityFloor floor = input_.input_floor;
    for (int i = 0, stalls = 0; i < p_.angle_rounds && stalls < p_.max_stalls; ++i) {
      if (optimizer_.backend.stop_requested()) return;
      const double before = floor.max_cot;
      WorstReport round;
      improve_angles_detail::improve_once(optimizer_, angles_, extremes_in(region), floor, round);
      add(round, r_);
      stalls = floor.max_cot > (1 - angles_.min_fall) * before ? stalls + 1 : 0;
    }
  }

 private:
  /// The costs of the tetrahedra with a flagged vertex.
  AngleExtremes<Cpu> extremes_in(Region& region) const {
    const Cpu& backend = optimizer_.backend;
    WorkMesh<Cpu>& mesh = optimizer_.work.mesh;
    AngleExtremes<Cpu> extremes(backend, mesh, optimizer_.slot_energies(), angles_.min_cost, angles_.obtuse_weight);
    extremes.clear_outside(backend, mesh, region.flags(backend, mesh));
    return extremes;
  }

  Optimizer<Cpu>& optimizer_;
  const RestartParameters& p_;
  AngleParameters angles_;
  const RestartInput& input_;
  WorstReport& r_;
};

}  // namespace

/// One try at a spot: its neighborhood, and the result.
struct RestartSearch::Restart {
  Index slot;  ///< of the element to improve, in the whole mesh
  const RestartParameters::Perturbation& perturbation;
  FoundTets found;
  std::optional<Neighborhood> neighborhood;
  Report report;
  WorstReport changes;
  std::vector<DihedralCots> cots;  ///< per slot, afterwards
  bool is_better = false;

  Size removed() const { return report.vertices_removed - report.vertices_inserted; }
  Size growth() const { return neighborhood->work.mesh.tets() - std::ssize(found.slots); }
};

/// The tries at one spot, of which the first that succeeds counts.
struct RestartSearch::RestartSpot {
  std::vector<std::unique_ptr<Restart>> tries;
  /// The first try known to have succeeded; the number of tries if there is none.
  std::atomic<Size> first_success{0};
};

RestartSearch::RestartSearch(HostWork& whole, RestartInput input)
    : whole_(whole),
      input_(std::move(input)),
      options_(input_.options),
      angles_(tuning_of(options_.effort).angles),
      p_(tuning_of(options_.effort).restart),
      finder_(whole),
      host_(std::make_unique<Cpu>(options_.threads)),
      cots_(extreme_cots(*host_, view_of(whole), whole.slots(), angles_)),
      weight_(angles_.obtuse_weight),
      failures_(cots_.size(), 0) {
  options_.threads = 1;
  options_.trace_angles = false;
}
RestartSearch::~RestartSearch() = default;

DihedralCots RestartSearch::extremes() const {
  return merge({angles_.min_cost, -angles_.min_cost / angles_.obtuse_weight}, cots_);
}

void RestartSearch::aim_at_largest_angle() {
  aims_at_largest_ = true;
  std::fill(failures_.begin(), failures_.end(), std::uint8_t{0});
  rounds_without_ = 0;
}

bool RestartSearch::weigh_largest_angle() {
  const DihedralCots present = extremes();
  const bool is_small = -present.min * angles_.obtuse_weight <= angles_.min_cost;
  if (is_small || rounds_without_ == p_.max_rounds_without) return false;
  weight_ = (1 + p_.obtuse_lead) * present.max / -present.min;
  max_cot_ = present.max;
  return true;
}

double RestartSearch::traced_angle() const {
  using namespace quality_extremes_detail;
  if (!input_.options.trace_angles) return 0;
  return ProgressReporter::degrees(host_->reduce<Maximum>(whole_.slots(), MaxCot{view_of(whole_)}).value);
}

void RestartSearch::add_to(Report& report) const {
  report += counts_;
  report.restarts += restarts_;
  report.restarts_kept += restarts_kept_;
}

std::vector<Index> RestartSearch::find_worst() const {
  using quality_extremes_detail::Maximum;
  const auto cost_if_left = [&](Size t) {
    return span_of(failures_)[t] < std::ssize(p_.perturbations) ? cost(to_index(t)) : 0;
  };
  const Size slots = std::ssize(cots_);
  const double largest = host_->reduce<Maximum>(slots, [&](Size t) { return Maximum{cost_if_left(t)}; }).value;
  std::vector<Index> worst;
  if (!(largest > 0)) return worst;
  worst.resize(cots_.size());
  const double least = (1 - p_.worst_fraction) * largest;
  worst.resize(to_size_t(host_->compact(
      slots, [&](Size t) { return cost_if_left(t) >= least; }, span_of(worst))));
  std::sort(worst.begin(), worst.end(),
            [&](Index a, Index b) { return cost(a) > cost(b) || (cost(a) == cost(b) && a < b); });
  return worst;
}

bool RestartSearch::is_tied(Index slot, Index other) const { return cost(slot) >= (1 - p_.tie) * cost(other); }

std::vector<std::unique_ptr<RestartSearch::RestartSpot>> RestartSearch::choose() {
  std::vector<std::unique_ptr<RestartSpot>> spots;
  const std::vector<Index> worst = find_worst();
  const auto is_tied_with_first = [&](Index t) { return is_tied(t, worst.front()); };
  if (std::count_if(worst.begin(), worst.end(), is_tied_with_first) > p_.max_worst) return spots;
  std::vector<std::uint8_t> is_taken(whole_.tet2vertex.size(), 0);
  // Where the surface may change shape they have no vertex in common either: with a bound on the deviation a test
  // beside a common edge of the surface would read what the other neighborhood changes, and two of them could make the
  // same edge. Otherwise no vertex is flagged.
  std::vector<std::uint8_t> is_of_taken(whole_.points.size(), 0);
  int tried = 0;
  for (const Index slot : worst) {
    if (span_of(is_taken)[slot] != 0) continue;
    if (std::ssize(spots) == p_.spots || tried++ == p_.max_worst) break;
    const auto first = p_.perturbations.begin() + span_of(failures_)[slot];
    const auto last = first + std::min<std::ptrdiff_t>(p_.tries, p_.perturbations.end() - first);
    const auto rings_of = [this](const RestartParameters::Perturbation& perturbation) {
      return perturbation.rings + p_.angle_rings + p_.margin;
    };
    const auto widest = std::max_element(first, last, [](const auto& a, const auto& b) { return a.rings < b.rings; });
    finder_.find(slot, rings_of(*widest));
    if (finder_.touches(is_taken) || finder_.has_vertex_of(is_of_taken)) continue;
    for (const Index t : finder_.tets()) span_of(is_taken)[t] = 1;
    if (whole_.max_deviation > 0 || whole_.bends) finder_.flag_vertices(is_of_taken);
    auto spot = std::make_unique<RestartSpot>();
    int rings_found = rings_of(*widest);
    for (auto perturbation = first; perturbation != last; ++perturbation) {
      const int rings = rings_of(*perturbation);
      if (rings != rings_found) finder_.find(slot, rings);
      rings_found = rings;
      spot->tries.push_back(
          std::unique_ptr<Restart>(new Restart{slot, *perturbation, finder_.found(), {}, {}, {}, {}}));
    }
    spot->first_success = std::ssize(spot->tries);
    spots.push_back(std::move(spot));
  }
  return spots;
}

void RestartSearch::run(Restart& restart, const CornersByVertex& corners, const Context& context) const {
  const Cpu backend(1, context.stop);
  Neighborhood& neighborhood = restart.neighborhood.emplace(whole_, restart.found, corners);
  neighborhood.work.is_neighborhood = true;
  neighborhood.work.outside = whole_.tets() - std::ssize(restart.found.slots);
  neighborhood.work.removable = removable();
  restart.report.tets_before = input_.tets_before;
  PhaseTimer timer(restart.report);
  Optimizer<Cpu> optimizer(backend, neighborhood.work, options_, context, timer);
  optimizer.sum_energy(kShapeObjective);
  NeighborhoodOptimizer local(optimizer, input_, weight_, restart.changes);
  WorkMesh<Cpu>& mesh = neighborhood.work.mesh;
  const auto largest_cost = [&](const std::vector<DihedralCots>& all) {
    double largest = angles_.min_cost;
    for (const DihedralCots& cots : all) largest = std::max(largest, cots.cost(weight_));
    return largest;
  };
  const std::vector<DihedralCots> before = extreme_cots(backend, mesh.view(), mesh.slots(), angles_);
  const double cost_before = largest_cost(before);
  local.set_largest_cost(cost_before);
  const int rings = restart.perturbation.rings;
  local.lower_energy(Region(backend, neighborhood.flags(rings)), restart.perturbation);
  local.enlarge_angles(Region(backend, neighborhood.flags(rings + p_.angle_rings)));
  restart.cots = extreme_cots(backend, mesh.view(), mesh.slots(), angles_);
  const double cost_after = largest_cost(restart.cots);
  const bool others_fall =
      sum_of_powers(restart.cots, weight_) < (1 - p_.min_fall_of_others) * sum_of_powers(before, weight_);
  restart.is_better = merge({0, 0}, restart.cots).max <= max_cot_ &&
                      (cost_after < (1 - p_.min_fall) * cost_before || (cost_after <= cost_before && others_fall)) &&
                      !neighborhood.doubles_surface(whole_, corners);
}

void RestartSearch::keep(Restart& restart) {
  finder_.count_tets(restart.found.slots, -1);
  restart.neighborhood->put_back(whole_);
  const std::vector<Index>& slots = restart.neighborhood->slots();
  finder_.count_tets(slots, 1);
  cots_.resize(whole_.tet2vertex.size(), {0, 0});
  failures_.resize(whole_.tet2vertex.size(), 0);
  for (Size i = 0; i < std::ssize(slots); ++i) {
    const Index slot = span_of(slots)[i];
    if (slot < 0) continue;
    span_of(cots_)[slot] = span_of(restart.cots)[i];
    span_of(failures_)[slot] = 0;
  }
  counts_ += restart.report;
  ++restarts_kept_;
}

void RestartSearch::count_failure(const Restart& restart) {
  for (const Index slot : restart.found.slots) {
    std::uint8_t& failures = span_of(failures_)[slot];
    if (is_tied(slot, restart.slot) && failures < std::ssize(p_.perturbations)) ++failures;
  }
}

bool RestartSearch::run_round(WorstReport& r) {
  if (aims_at_largest_ && !weigh_largest_angle()) return false;
  const auto spots = choose();
  if (spots.empty()) return false;
  const LatchedHooks hooks(input_.context);
  const CornersByVertex corners = list_corners(*host_, whole_);
  // First tries come first: a later one runs only if an earlier one has not succeeded yet.
  const Size count = std::ssize(spots);
  host_->for_parts(p_.tries * count, [&](Size i) {
    RestartSpot& spot = *span_of(spots)[i % count];
    const Size number = i / count;
    const auto is_needed = [&] { return number < spot.first_success.load(std::memory_order_relaxed); };
    if (!is_needed()) return;
    Restart& restart = *span_of(spot.tries)[number];
    const auto stop = [&] { return !is_needed() || hooks.context().stop(); };
    run(restart, corners, {{}, stop});
    if (!restart.is_better) return;
    Size first = spot.first_success.load();
    while (number < first && !spot.first_success.compare_exchange_weak(first, number)) continue;
  });
  if (hooks.is_stopped()) return true;
  r.worst = count;
  const int kept_before = restarts_kept_;
  for (const auto& spot : spots) finish(*spot, r);
  rounds_without_ = restarts_kept_ > kept_before ? 0 : rounds_without_ + 1;
  whole_.erase_removed_triangles();
  return true;
}

void RestartSearch::finish(RestartSpot& spot, WorstReport& r) {
  const double max_tets = options_.max_growth * double(input_.tets_before);
  const Size first_success = spot.first_success;
  for (Size i = 0; i < std::ssize(spot.tries) && i <= first_success; ++i) {
    Restart& restart = *span_of(spot.tries)[i];
    ++restarts_;
    const bool has_room = (restart.growth() <= 0 || double(whole_.tets() + restart.growth()) <= max_tets) &&
                          restart.removed() <= std::max(removable(), Size{0});
    if (i == first_success && has_room) {
      add(restart.changes, r);
      keep(restart);
    } else {
      count_failure(restart);
    }
  }
}

}  // namespace tetune
