// SPDX-License-Identifier: Apache-2.0
#include "rounds.hpp"

#include <array>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "clock.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/limit_growth.hpp"
#include "halo.hpp"
#include "one_part.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune::mpi {
namespace {

/// The number of layers of tetrahedra by which parts are shifted, and within which vertices near an old interface move
/// again.
constexpr int kLayers = 4;
/// Interfaces are surfaces, pairs of them meet in curves, triples in points, so that three shifts free every vertex; 6
/// is a safety limit.
constexpr int kMaxRounds = 6;
/// The last rounds work on the tetrahedra with the smallest angles: at most this fraction of all, below this angle in
/// degrees.
constexpr int kWorstRounds = 2;
constexpr double kWorstFraction = 3e-4;
constexpr float kMaxWorstAngle = 40;
class Rounds {
 public:
  Rounds(MPI_Comm comm, Part& part, Totals& totals, Options options, const std::function<bool()>& stop,
         const MessageForm& form)
      : comm_(comm), self_(rank_of(comm)), part_(part), totals_(totals), options_(std::move(options)), form_(form) {
    context_.stop = stop;
    report_.ranks = size_of(comm);
    choose_threads();
  }

  DistributedReport run() {
    const auto start = Time::now();
    collective_try(comm_, [&] { check_options(); });
    check_frozen(options_.frozen_regions, part_.mesh.tet_tags, "frozen_regions", "tetrahedron");
    check_frozen(options_.frozen_patches, part_.mesh.triangle_tags, "frozen_patches", "triangle");
    report_.tets_before = all_reduce(comm_, std::ssize(part_.mesh.tets), MPI_SUM);
    max_tets_ = options_.max_growth * double(report_.tets_before);
    try {
      first_round();
    } catch (const MeshError& e) {  // that of the lowest rank that has one
      throw MeshError(defects_of_all(comm_, part_, options_.threads, form_, e));
    }
    while (report_.left_frozen > 0 && !cancelled_ && int_size(report_.rounds) < kMaxRounds) {
      next_round();
    }
    for (int turn = 0; turn < kWorstRounds && !cancelled_ && works_on_worst(); ++turn) last_round();
    report_.tets_after = all_reduce(comm_, std::ssize(part_.mesh.tets), MPI_SUM);
    sum_counts();
    if (cancelled_) report_.stop = StopReason::cancelled;
    report_.seconds = seconds_since(start);
    return report_;
  }

 private:
  /// Divides the threads of a node among its ranks.
  void choose_threads() {
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(comm_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    const int ranks = size_of(node);
    MPI_Comm_free(&node);
    if (options_.threads > 0) return;
    options_.threads = std::max(1, int(std::thread::hardware_concurrency()) / ranks);
  }

  void check_options() const {
    if (options_.untangle) {
      throw OptionError("untangle works on whole meshes; repair the mesh on one machine first");
    }
    if (!options_.only_below.empty()) throw OptionError("only_below is for meshes on one machine");
    if (!options_.targets.empty()) throw OptionError("targets are for meshes on one machine; measure the result");
    if (!options_.frozen_vertices.empty()) {
      throw OptionError("frozen_vertices is for meshes on one machine; list the vertices as required instead");
    }
  }

  /// Throws OptionError for a tag that no rank has.
  void check_frozen(std::vector<int>& wanted, const std::vector<int>& tags, const char* option, const char* kind) {
    if (wanted.empty()) return;
    const std::set<int> present(tags.begin(), tags.end());
    std::vector<int> found;
    for (const int tag : wanted) found.push_back(present.count(tag) > 0 ? 1 : 0);
    const std::vector<int> anywhere = all_reduce(comm_, found, MPI_MAX);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (anywhere[i] != 0) continue;
      throw OptionError(std::string(option) + " names tag " + std::to_string(wanted[i]) + ", but no " + kind +
                        " has it");
    }
  }

  void first_round() {
    const auto start = Time::now();
    RoundReport round;
    round.round = 1;
    for (std::uint8_t& flags : part_.vertex_flags) flags |= kShared;
    Shared(comm_, part_, totals_).mark(part_);
    if (report_.ranks > 1 && options_.boundary == Boundary::slide) find_surface();
    Marks frozen(part_.vertex_flags.size(), 0);
    for (std::size_t v = 0; v < frozen.size(); ++v) {
      if ((part_.vertex_flags[v] & kShared) == 0) continue;
      part_.vertex_flags[v] |= kPending | kFirstCut;
      frozen[v] = 1;
    }
    optimize_all(part_, std::move(frozen), round);
    finish(round, start);
  }

  /// Takes the surface of the input, before any vertex moves.
  void find_surface() {
    const Part halo = halo_of(comm_, part_, totals_, options_.frozen_regions);
    surface_.emplace();
    collective_try(comm_, [&] {
      if (halo.mesh.tets.empty()) return;
      Options options = options_for(options_, halo.mesh);
      for (const std::uint8_t flags : halo.vertex_flags) {
        options.frozen_vertices.push_back((flags & kHeld) != 0 ? 1 : 0);
      }
      try {
        surface_.emplace(part_, halo, options_.frozen_regions, find_slide_surface(halo.mesh, options));
      } catch (const MeshError& e) {
        throw MeshError(defects_of(halo, options_.threads, form_, e));
      }
    });
  }

  /// Whether optimize() itself would work on the worst elements with these options.
  bool works_on_worst() const {
    return report_.ranks > 1 && options_.effort != Effort::fast && options_.energy == Energy::shape &&
           options_.termination == Termination::relative && options_.max_iterations > 0;
  }

  /// Works on the worst elements of the whole mesh: earlier rounds worked on those of each part, with the vertices of
  /// its interfaces frozen.
  void last_round() {
    const auto start = Time::now();
    const std::int64_t left_frozen = report_.left_frozen;
    for (std::uint8_t& flags : part_.vertex_flags) flags &= std::uint8_t(~kPending);
    std::vector<int> pending(part_.vertex_id.size(), 1);
    collective_try(comm_, [&] {
      angles_.clear();
      for (const Measures& m : measure_each(part_.mesh, options_.threads)) {
        angles_.push_back(float(item(m, Measure::min_dihedral)));
      }
    });
    const float bound = smallest_angles();
    for (std::size_t t = 0; t < angles_.size(); ++t) {
      if (angles_[t] > bound) continue;
      for (const Index v : part_.mesh.tets[t]) item(pending, v) = 0;
    }
    angles_ = {};
    shared_->minimize(pending);
    for (std::size_t v = 0; v < pending.size(); ++v) {
      if (pending[v] == 0) part_.vertex_flags[v] |= kPending;
    }
    next_round(start);
    report_.left_frozen = report_.rounds.back().left_frozen = left_frozen;
  }

  /// Returns the angle below which the smallest angles of the kWorstFraction of all tetrahedra are.
  float smallest_angles() const {
    constexpr std::size_t kBins = 1000;
    std::vector<std::int64_t> counts(kBins, 0);
    const float width = kMaxWorstAngle / kBins;
    for (const float a : angles_) {
      if (a < kMaxWorstAngle) ++item(counts, std::min(kBins - 1, std::size_t(a / width)));
    }
    counts = all_reduce(comm_, std::move(counts), MPI_SUM);
    const double wanted = std::max(1.0, kWorstFraction * double(report_.tets_before));
    std::int64_t below = 0;
    std::size_t b = 0;
    while (b < kBins && double(below) < wanted) below += counts[b++];
    return float(b) * width;
  }

  void next_round(Time::time_point start = Time::now()) {
    RoundReport round;
    round.round = int_size(report_.rounds) + 1;
    shift(round);
    Part overlap = take_overlap();
    Marks frozen;
    for (const std::uint8_t flags : overlap.vertex_flags) {
      frozen.push_back((flags & kShared) != 0 || (flags & kNearPending) == 0 ? 1 : 0);
    }
    optimize_all(overlap, std::move(frozen), round);
    collective_try(comm_, [&] { merge(part_, overlap); });
    overlap = {};
    // Pending vertices that no other part has were not frozen in this round.
    for (std::uint8_t& flags : part_.vertex_flags) {
      flags &= std::uint8_t((flags & kShared) != 0 ? ~kNearPending : ~(kNearPending | kPending));
    }
    finish(round, start);
  }

  /// Moves the tetrahedra near pending vertices to one of the ranks that have tetrahedra there: the one with the
  /// fewest.
  void shift(RoundReport& round) {
    const std::vector<Id> sizes = all_gather(comm_, std::ssize(part_.mesh.tets));
    std::vector<int> position2rank(sizes.size());
    std::iota(position2rank.begin(), position2rank.end(), 0);
    std::stable_sort(position2rank.begin(), position2rank.end(),
                     [&sizes](int a, int b) { return item(sizes, a) < item(sizes, b); });
    const int own = int(std::find(position2rank.begin(), position2rank.end(), self_) - position2rank.begin());
    constexpr int kFar = std::numeric_limits<int>::max();
    const TetMesh& mesh = part_.mesh;
    std::vector<int> reached(mesh.points.size(), kFar);
    for (std::size_t v = 0; v < reached.size(); ++v) {
      if ((part_.vertex_flags[v] & kPending) != 0) reached[v] = own;
    }
    shared_->minimize(reached);
    std::vector<int> owner(mesh.tets.size(), own);
    for (int layer = 0; layer < kLayers; ++layer) {
      const std::vector<int> before = reached;
      for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
        int min_owner = kFar;
        for (const Index v : mesh.tets[t]) min_owner = std::min(min_owner, item(before, v));
        if (min_owner == kFar) continue;
        owner[t] = std::min(owner[t], min_owner);
        for (const Index v : mesh.tets[t]) {
          int& nearest = item(reached, v);
          nearest = std::min(nearest, owner[t]);
        }
      }
      shared_->minimize(reached);
    }
    Marks leaves(owner.size(), 0);
    std::vector<int> to;
    for (std::size_t t = 0; t < owner.size(); ++t) {
      if (owner[t] == own) continue;
      leaves[t] = 1;
      to.push_back(item(position2rank, owner[t]));
      for (const Index v : mesh.tets[t]) item(part_.vertex_flags, v) |= kShared;
    }
    round.tets_moved = all_reduce(comm_, std::ssize(to), MPI_SUM);
    Addressed leaving = address(extract(part_, leaves), to, self_);
    if (surface_) surface_->send(comm_, leaving);
    Pieces arrived = send(comm_, std::move(leaving));
    collective_try(comm_, [&] {
      merge(part_, assemble(std::move(arrived)));
      if (surface_) surface_->keep(part_);
    });
    Shared(comm_, part_, totals_).mark(part_);
  }

  /// Moves the tetrahedra near pending vertices out of the part.
  Part take_overlap() {
    const TetMesh& mesh = part_.mesh;
    Marks near(mesh.points.size(), 0);
    for (std::size_t v = 0; v < near.size(); ++v) near[v] = (part_.vertex_flags[v] & kPending) != 0 ? 1 : 0;
    for (int layer = 0; layer < kLayers; ++layer) add_layer(mesh.tets, near);
    for (std::size_t v = 0; v < near.size(); ++v) {
      if (near[v] != 0) part_.vertex_flags[v] |= kNearPending;
    }
    Marks in_overlap(mesh.tets.size(), 0);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) {
        if ((item(part_.vertex_flags, v) & (kNearPending | kShared)) == kNearPending) in_overlap[t] = 1;
      }
    }
    return extract(part_, in_overlap);
  }

  /// The growth of a round's parts with which the whole mesh stays within Options::max_growth: each part may add
  /// tetrahedra in proportion to those that it has.
  double max_growth_of_round(const Part& part) const {
    const Id outside = &part == &part_ ? 0 : std::ssize(part_.mesh.tets);
    const auto sums = all_reduce(comm_, std::vector<Id>{std::ssize(part.mesh.tets), outside}, MPI_SUM);
    return sums[0] > 0 ? (max_tets_ - double(sums[1])) / double(sums[0]) : 1;
  }

  /// Optimizes one part per rank; the vertices with `frozen` 1 stay.
  void optimize_all(Part& part, Marks frozen, RoundReport& round) {
    const auto start = Time::now();
    const double growth = max_growth_of_round(part);
    Report report;
    collective_try(comm_, [&] {
      if (part.mesh.tets.empty()) return;
      Options options = options_;
      // The first round has all of it.
      if (round.round > 1) limit_growth(options, growth * double(part.mesh.tets.size()), part.mesh);
      for (std::size_t v = 0; v < frozen.size(); ++v) {
        if ((part.vertex_flags[v] & kHeld) != 0) frozen[v] = 1;
      }
      report = optimize_part(part, std::move(frozen), options, context_, surface_ ? &*surface_ : nullptr, form_);
    });
    const double stopped = report.stop == StopReason::cancelled ? 1 : 0;
    const auto maxima = all_reduce(comm_, std::vector<double>{seconds_since(start), stopped}, MPI_MAX);
    round.optimizer_seconds = maxima[0];
    cancelled_ = maxima[1] > 0;
    round.tets = all_reduce(comm_, report.tets_before, MPI_SUM);
    const auto energies = all_reduce(comm_, std::vector<double>{report.energy_before, report.energy_after}, MPI_SUM);
    if (round.round == 1) report_.energy_before = report_.energy_after = energies[0];
    report_.energy_after += energies[1] - energies[0];
    number_inserted(part);
    report_ += report;
  }

  void number_inserted(Part& part) {
    const auto inserted = all_gather(comm_, Id{std::count(part.vertex_id.begin(), part.vertex_id.end(), -1)});
    Id next = std::accumulate(inserted.begin(), inserted.begin() + self_, totals_.vertices);
    for (Id& id : part.vertex_id) {
      if (id < 0) id = next++;
    }
    totals_.vertices = std::accumulate(inserted.begin(), inserted.end(), totals_.vertices);
  }

  void finish(RoundReport& round, Time::time_point start) {
    shared_.emplace(comm_, part_, totals_);
    // Each vertex is counted once, by the lowest rank that has it.
    std::vector<int> lowest(part_.vertex_id.size(), self_);
    shared_->minimize(lowest);
    Id cut = 0;
    Id pending = 0;
    for (std::size_t v = 0; v < lowest.size(); ++v) {
      if (lowest[v] != self_ || (part_.vertex_flags[v] & kShared) == 0) continue;
      ++cut;
      pending += (part_.vertex_flags[v] & kPending) != 0 ? 1 : 0;
    }
    const auto sums = all_reduce(comm_, std::vector<Id>{cut, pending}, MPI_SUM);
    round.cut_vertices = sums[0];
    report_.left_frozen = round.left_frozen = sums[1];
    if (surface_) {
      const auto triangles = all_reduce(comm_, Id(surface_->triangles()), MPI_MAX);
      report_.surface_triangles = std::max(report_.surface_triangles, triangles);
    }
    round.seconds = all_reduce(comm_, seconds_since(start), MPI_MAX);
    report_.optimizer_seconds += round.optimizer_seconds;
    report_.rounds.push_back(round);
  }

  /// Sums the counts, which until now are those of this rank only, over all ranks.
  void sum_counts() {
    std::vector<Id> sums;
    for (const auto& kind : kOperationCounts) sums.push_back(report_.*kind.count);
    sums = all_reduce(comm_, std::move(sums), MPI_SUM);
    for (std::size_t i = 0; i < sums.size(); ++i) report_.*kOperationCounts[i].count = sums[i];
  }

  MPI_Comm comm_;
  int self_;
  Part& part_;
  Totals& totals_;
  Options options_;
  const MessageForm form_;
  Context context_;
  bool cancelled_ = false;
  std::optional<Shared> shared_;  ///< of the part as the last round left it
  /// With Boundary::slide on several ranks: what the part slides on.
  std::optional<InputSurface> surface_;
  std::vector<float> angles_;  ///< smallest dihedral angle of each tetrahedron of the part, degrees
  double max_tets_ = 0;        ///< the number of tetrahedra that insertion may lead to, of all ranks
  DistributedReport report_;
};

}  // namespace

DistributedReport optimize_parts(MPI_Comm comm, Part& part, Totals& totals, Options options,
                                 const std::function<bool()>& stop, const MessageForm& form) {
  return Rounds(comm, part, totals, std::move(options), stop, form).run();
}

}  // namespace tetune::mpi
