// SPDX-License-Identifier: Apache-2.0
#include "rounds.hpp"

#include <array>
#include <chrono>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "driver/constraints.hpp"
#include "driver/slide_on.hpp"
#include "input_surface.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune::mpi {
namespace {

using Time = std::chrono::steady_clock;
double seconds_since(Time::time_point start) { return std::chrono::duration<double>(Time::now() - start).count(); }

/// How far the parts are shifted, in layers of tetrahedra, and how far from an old cut vertices move again.
constexpr int kLayers = 4;
/// Cuts are surfaces, what lies on two of them are lines, on three points: more rounds than that find nothing to do.
constexpr int kMostRounds = 6;
/// The last rounds work around the tetrahedra with the smallest angles: this part of all, below this many degrees.
constexpr int kWorstRounds = 2;
constexpr double kWorstPart = 3e-4;
constexpr double kGoodAngle = 40;
/// Of the triangles between what is worked on and the rest: no patch of the mesh is to continue on them.
constexpr int kSeamTag = std::numeric_limits<int>::min();

/// What runs on parts count, and where the sum of all is.
struct Count {
  std::int64_t Report::*part;
  std::int64_t DistributedReport::*all;
};
constexpr std::array kCounts{Count{&Report::flips23, &DistributedReport::flips23},
                             Count{&Report::flips32, &DistributedReport::flips32},
                             Count{&Report::edge_removals, &DistributedReport::edge_removals},
                             Count{&Report::face_removals, &DistributedReport::face_removals},
                             Count{&Report::boundary_flips, &DistributedReport::boundary_flips},
                             Count{&Report::compound_flips, &DistributedReport::compound_flips},
                             Count{&Report::vertices_inserted, &DistributedReport::vertices_inserted},
                             Count{&Report::vertices_removed, &DistributedReport::vertices_removed}};

/// Lists the faces that only one tetrahedron has and whose vertices must not move, as required triangles of a tag of
/// their own, so that nothing slides onto a cut; returns their number.
std::size_t list_seam(TetMesh& mesh, const std::vector<std::uint8_t>& frozen) {
  std::map<std::array<Index, 3>, int> faces;
  for (const auto& tet : mesh.tets) {
    for (std::size_t f = 0; f < 4; ++f) {
      std::array<Index, 3> face{tet[(f + 1) % 4], tet[(f + 2) % 4], tet[(f + 3) % 4]};
      bool all = true;
      for (const Index v : face) all = all && frozen[static_cast<std::size_t>(v)] != 0;
      if (!all) continue;
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  }
  const std::size_t before = mesh.triangles.size();
  for (const auto& [face, count] : faces) {
    if (count > 1) continue;
    mesh.required_triangles.push_back(static_cast<Index>(mesh.triangles.size()));
    mesh.triangles.push_back(face);
    mesh.triangle_tags.push_back(kSeamTag);
  }
  return mesh.triangles.size() - before;
}

/// They came last, and are kept.
void drop_seam(TetMesh& mesh, std::size_t count) {
  mesh.triangles.resize(mesh.triangles.size() - count);
  mesh.triangle_tags.resize(mesh.triangles.size());
  mesh.required_triangles.resize(mesh.required_triangles.size() - count);
}

/// Takes out what was appended to the vertices of a mesh before it was optimised: from `first` to `end`.
void drop_appended(TetMesh& mesh, std::vector<Index>& vertex2original, std::size_t first, std::size_t end) {
  if (first == end) return;
  if (vertex2original.empty()) {
    mesh.points.resize(first);
    mesh.point_tags.resize(first);
    return;
  }
  const auto appended = [&](Index v) { return v >= static_cast<Index>(first) && v < static_cast<Index>(end); };
  std::vector<std::uint8_t> keep;
  for (const Index v : vertex2original) keep.push_back(appended(v) ? 0 : 1);
  keep_vertices(mesh, positions_of_kept(keep));
  std::erase_if(vertex2original, appended);
}

template <class T, class Map>
std::vector<T> picked(const std::vector<T>& values, const Map& new2old, std::size_t count) {
  std::vector<T> result;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back(values[static_cast<std::size_t>(new2old[i])]);
  return result;
}

class Rounds {
 public:
  Rounds(MPI_Comm comm, Part& part, Totals& totals, Options options, const std::function<bool()>& stop)
      : comm_(comm), self_(rank_of(comm)), part_(part), totals_(totals), options_(std::move(options)) {
    context_.stop = stop;
    report_.ranks = size_of(comm);
    settle_threads();
  }

  DistributedReport run() {
    const auto start = Time::now();
    together(comm_, [&] { check_options(); });
    check_frozen(options_.frozen_regions, part_.mesh.tet_tags, "frozen_regions", "tetrahedron");
    check_frozen(options_.frozen_patches, part_.mesh.triangle_tags, "frozen_patches", "triangle");
    report_.tets_before = all_reduce(comm_, static_cast<Id>(part_.mesh.tets.size()), MPI_SUM);
    first_round();
    while (report_.left_frozen > 0 && !cancelled_ && static_cast<int>(report_.rounds.size()) < kMostRounds) {
      next_round();
    }
    for (int turn = 0; turn < kWorstRounds && !cancelled_ && works_on_worst(); ++turn) last_round();
    report_.tets_after = all_reduce(comm_, static_cast<Id>(part_.mesh.tets.size()), MPI_SUM);
    sum_up_counts();
    if (cancelled_) report_.stop = StopReason::cancelled;
    report_.seconds = seconds_since(start);
    return report_;
  }

 private:
  /// All threads of a node, shared among its ranks.
  void settle_threads() {
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(comm_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    const int ranks = size_of(node);
    MPI_Comm_free(&node);
    if (options_.threads > 0) return;
    options_.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / ranks);
  }

  void check_options() const {
    if (options_.untangle) {
      throw OptionError("untangle works on whole meshes; repair the mesh on one machine first");
    }
    if (!options_.targets.empty()) throw OptionError("targets are for meshes on one machine; measure the result");
    if (!options_.frozen_vertices.empty()) {
      throw OptionError("frozen_vertices is for meshes on one machine; list the vertices as required instead");
    }
  }

  /// A tag that no rank has is an error; one that only others have is none of this rank's.
  void check_frozen(std::vector<int>& wanted, const std::vector<int>& tags, const char* option, const char* what) {
    if (wanted.empty()) return;
    const std::set<int> present(tags.begin(), tags.end());
    std::vector<int> here;
    for (const int tag : wanted) here.push_back(present.count(tag) > 0 ? 1 : 0);
    const std::vector<int> anywhere = all_reduce(comm_, here, MPI_MAX);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (anywhere[i] != 0) continue;
      throw OptionError(std::string(option) + " names tag " + std::to_string(wanted[i]) + ", but no " + what +
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
    std::vector<std::uint8_t> frozen(part_.vertex_flags.size(), 0);
    for (std::size_t v = 0; v < frozen.size(); ++v) {
      if ((part_.vertex_flags[v] & kShared) == 0) continue;
      part_.vertex_flags[v] |= kPending | kFirstCut;
      frozen[v] = 1;
    }
    optimise(part_, std::move(frozen), round);
    finish(round, start);
  }

  /// Before any vertex moves.
  void find_surface() {
    const Part shell = shell_of(comm_, part_, totals_, options_.frozen_regions);
    surface_.emplace();
    together(comm_, [&] {
      if (shell.mesh.tets.empty()) return;
      Options options = options_for(shell.mesh);
      for (const std::uint8_t flags : shell.vertex_flags) {
        options.frozen_vertices.push_back((flags & kHeld) != 0 ? 1 : 0);
      }
      try {
        surface_.emplace(part_, shell, options_.frozen_regions, find_slide_surface(shell.mesh, options));
      } catch (const MeshError&) {
        throw MeshError(defects(shell));
      }
    });
  }

  /// As optimize() does.
  bool works_on_worst() const {
    return report_.ranks > 1 && options_.effort != Effort::fast && options_.energy == Energy::shape &&
           options_.termination == Termination::relative && options_.max_iterations > 0;
  }

  /// The smallest angles of a part were opened with its cuts frozen, and by what was the worst of the part: once more,
  /// around the worst of all parts.
  void last_round() {
    const auto start = Time::now();
    const std::int64_t left_frozen = report_.left_frozen;
    for (std::uint8_t& flags : part_.vertex_flags) flags &= static_cast<std::uint8_t>(~kPending);
    std::vector<int> pending(part_.vertex_id.size(), 1);
    together(comm_, [&] {
      angles_.clear();
      for (const Measures& m : measure_each(part_.mesh, options_.threads)) {
        angles_.push_back(static_cast<float>(m[static_cast<std::size_t>(Measure::min_dihedral)]));
      }
    });
    const float bound = smallest_angles();
    for (std::size_t t = 0; t < angles_.size(); ++t) {
      if (angles_[t] > bound) continue;
      for (const Index v : part_.mesh.tets[t]) pending[static_cast<std::size_t>(v)] = 0;
    }
    angles_ = {};
    shared_->least(pending);
    for (std::size_t v = 0; v < pending.size(); ++v) {
      if (pending[v] == 0) part_.vertex_flags[v] |= kPending;
    }
    next_round(start);
    report_.left_frozen = report_.rounds.back().left_frozen = left_frozen;
  }

  /// Below which the angles of the kWorstPart of all tetrahedra are.
  float smallest_angles() const {
    constexpr std::size_t kBins = 1000;
    std::vector<std::int64_t> counts(kBins, 0);
    const auto width = static_cast<float>(kGoodAngle / kBins);
    for (const float a : angles_) {
      if (a < static_cast<float>(kGoodAngle)) ++counts[static_cast<std::size_t>(a / width)];
    }
    counts = all_reduce(comm_, std::move(counts), MPI_SUM);
    const double wanted = std::max(1.0, kWorstPart * static_cast<double>(report_.tets_before));
    std::int64_t below = 0;
    std::size_t b = 0;
    while (b < kBins && static_cast<double>(below) < wanted) below += counts[b++];
    return static_cast<float>(b) * width;
  }

  void next_round(Time::time_point start = Time::now()) {
    RoundReport round;
    round.round = static_cast<int>(report_.rounds.size()) + 1;
    shift(round);
    Part band = take_band();
    std::vector<std::uint8_t> frozen;
    for (const std::uint8_t flags : band.vertex_flags) {
      frozen.push_back((flags & kShared) != 0 || (flags & kNear) == 0 ? 1 : 0);
    }
    optimise(band, std::move(frozen), round);
    together(comm_, [&] { absorb(part_, band); });
    band = {};
    // Pending vertices that no other part has were free to move.
    for (std::uint8_t& flags : part_.vertex_flags) {
      flags &= static_cast<std::uint8_t>((flags & kShared) != 0 ? ~kNear : ~(kNear | kPending));
    }
    finish(round, start);
  }

  /// Moves the tetrahedra around pending vertices to one of the ranks there: the one that has the fewest.
  void shift(RoundReport& round) {
    const std::vector<Id> sizes = all_gather(comm_, static_cast<Id>(part_.mesh.tets.size()));
    std::vector<int> place2rank(sizes.size());
    std::iota(place2rank.begin(), place2rank.end(), 0);
    std::stable_sort(place2rank.begin(), place2rank.end(), [&sizes](int a, int b) {
      return sizes[static_cast<std::size_t>(a)] < sizes[static_cast<std::size_t>(b)];
    });
    const auto own = static_cast<int>(std::find(place2rank.begin(), place2rank.end(), self_) - place2rank.begin());
    constexpr int kFar = std::numeric_limits<int>::max();
    const TetMesh& mesh = part_.mesh;
    std::vector<int> reached(mesh.points.size(), kFar);
    for (std::size_t v = 0; v < reached.size(); ++v) {
      if ((part_.vertex_flags[v] & kPending) != 0) reached[v] = own;
    }
    shared_->least(reached);
    std::vector<int> owner(mesh.tets.size(), own);
    for (int layer = 0; layer < kLayers; ++layer) {
      const std::vector<int> before = reached;
      for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
        int least = kFar;
        for (const Index v : mesh.tets[t]) least = std::min(least, before[static_cast<std::size_t>(v)]);
        if (least == kFar) continue;
        owner[t] = std::min(owner[t], least);
        for (const Index v : mesh.tets[t]) {
          int& there = reached[static_cast<std::size_t>(v)];
          there = std::min(there, owner[t]);
        }
      }
      shared_->least(reached);
    }
    std::vector<std::uint8_t> leaves(owner.size(), 0);
    std::vector<int> to;
    for (std::size_t t = 0; t < owner.size(); ++t) {
      if (owner[t] == own) continue;
      leaves[t] = 1;
      to.push_back(place2rank[static_cast<std::size_t>(owner[t])]);
      for (const Index v : mesh.tets[t]) part_.vertex_flags[static_cast<std::size_t>(v)] |= kShared;
    }
    round.tets_moved = all_reduce(comm_, static_cast<Id>(to.size()), MPI_SUM);
    Addressed leaving = address(extract(part_, leaves), to, self_);
    if (surface_) surface_->send(comm_, leaving);
    Pieces arrived = send(comm_, std::move(leaving));
    together(comm_, [&] {
      absorb(part_, assemble(std::move(arrived)));
      if (surface_) surface_->keep(part_);
    });
    Shared(comm_, part_, totals_).mark(part_);
  }

  /// Takes the surroundings of pending vertices out of the part.
  Part take_band() {
    const TetMesh& mesh = part_.mesh;
    std::vector<std::uint8_t> near(mesh.points.size(), 0);
    for (std::size_t v = 0; v < near.size(); ++v) near[v] = (part_.vertex_flags[v] & kPending) != 0 ? 1 : 0;
    for (int layer = 0; layer < kLayers; ++layer) {
      const std::vector<std::uint8_t> before = near;
      for (const auto& tet : mesh.tets) {
        bool touched = false;
        for (const Index v : tet) touched = touched || before[static_cast<std::size_t>(v)] != 0;
        if (!touched) continue;
        for (const Index v : tet) near[static_cast<std::size_t>(v)] = 1;
      }
    }
    for (std::size_t v = 0; v < near.size(); ++v) {
      if (near[v] != 0) part_.vertex_flags[v] |= kNear;
    }
    std::vector<std::uint8_t> in_band(mesh.tets.size(), 0);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) {
        if ((part_.vertex_flags[static_cast<std::size_t>(v)] & (kNear | kShared)) == kNear) in_band[t] = 1;
      }
    }
    return extract(part_, in_band);
  }

  /// Optimises a mesh whose flagged vertices must not move.
  void optimise(Part& part, std::vector<std::uint8_t> frozen, RoundReport& round) {
    const auto start = Time::now();
    Report report;
    together(comm_, [&] {
      if (part.mesh.tets.empty()) return;
      for (std::size_t v = 0; v < frozen.size(); ++v) {
        if ((part.vertex_flags[v] & kHeld) != 0) frozen[v] = 1;
      }
      report = optimise_here(part, std::move(frozen));
    });
    const double stopped = report.stop == StopReason::cancelled ? 1 : 0;
    const auto most = all_reduce(comm_, std::vector<double>{seconds_since(start), stopped}, MPI_MAX);
    round.optimizer_seconds = most[0];
    cancelled_ = most[1] > 0;
    round.tets = all_reduce(comm_, report.tets_before, MPI_SUM);
    const auto energies = all_reduce(comm_, std::vector<double>{report.energy_before, report.energy_after}, MPI_SUM);
    if (round.round == 1) report_.energy_before = report_.energy_after = energies[0];
    report_.energy_after += energies[1] - energies[0];
    number_inserted(part);
    for (const Count& c : kCounts) report_.*c.all += report.*c.part;
  }

  Report optimise_here(Part& part, std::vector<std::uint8_t> frozen) {
    TetMesh& mesh = part.mesh;
    Options options = options_for(mesh);
    const std::size_t vertices = mesh.points.size();
    const std::size_t seam = list_seam(mesh, frozen);
    InputSurface::Piece piece;
    if (surface_) piece = surface_->under(part, options.max_deviation > 0, frozen);
    options.frozen_vertices = std::move(frozen);
    Report report;
    try {
      report = surface_ ? tetune::optimize(mesh, options, context_, piece.surface)
                        : tetune::optimize(mesh, options, context_);
    } catch (const OverlapError& e) {
      std::vector<Index> tets;
      for (const Index t : e.tets) tets.push_back(static_cast<Index>(part.tet_id[static_cast<std::size_t>(t)]));
      std::sort(tets.begin(), tets.end());
      throw OverlapError(std::move(tets));
    } catch (const MeshError&) {
      drop_seam(mesh, seam);
      drop_appended(mesh, report.vertex2original, vertices, mesh.points.size());
      throw MeshError(defects(part));
    }
    drop_seam(mesh, seam);
    if (surface_) {
      surface_->settle(piece);
      drop_appended(mesh, report.vertex2original, vertices, piece.id.size());
    }
    if (!report.vertex2original.empty()) {
      std::vector<Id> ids;
      std::vector<std::uint8_t> flags;
      for (const Index v : report.vertex2original) {
        ids.push_back(v < 0 ? -1 : part.vertex_id[static_cast<std::size_t>(v)]);
        flags.push_back(v < 0 ? 0 : part.vertex_flags[static_cast<std::size_t>(v)]);
      }
      part.vertex_id = std::move(ids);
      part.vertex_flags = std::move(flags);
    }
    part.tet_id = picked(part.tet_id, report.tet2original, mesh.tets.size());
    if (!report.triangle2original.empty()) {
      part.triangle_id = picked(part.triangle_id, report.triangle2original, mesh.triangles.size());
    }
    if (!report.edge2original.empty()) {
      part.edge_id = picked(part.edge_id, report.edge2original, mesh.edges.size());
    }
    return report;
  }

  /// A part may lack a tag that the whole mesh has.
  Options options_for(const TetMesh& mesh) const {
    Options options = options_;
    options.frozen_regions = present(options_.frozen_regions, mesh.tet_tags);
    options.frozen_patches = present(options_.frozen_patches, mesh.triangle_tags);
    return options;
  }

  static std::vector<int> present(const std::vector<int>& wanted, const std::vector<int>& tags) {
    std::vector<int> here;
    for (const int tag : wanted) {
      if (std::find(tags.begin(), tags.end(), tag) != tags.end()) here.push_back(tag);
    }
    return here;
  }

  /// What is wrong with a part, in the numbers of the whole mesh.
  std::string defects(const Part& part) const {
    ValidationReport report = validate(part.mesh, options_.threads);
    for (Finding& f : report.findings) {
      const std::vector<Id>* ids = f.where == "tetrahedra" ? &part.tet_id
                                   : f.where == "vertices" ? &part.vertex_id
                                                           : nullptr;
      if (ids == nullptr) continue;
      for (Index& i : f.first) i = static_cast<Index>((*ids)[static_cast<std::size_t>(i)]);
    }
    return report.message(false);
  }

  void number_inserted(Part& part) {
    const auto inserted =
        all_gather(comm_, static_cast<Id>(std::count(part.vertex_id.begin(), part.vertex_id.end(), -1)));
    Id next = std::accumulate(inserted.begin(), inserted.begin() + self_, totals_.vertices);
    for (Id& id : part.vertex_id) {
      if (id < 0) id = next++;
    }
    totals_.vertices = std::accumulate(inserted.begin(), inserted.end(), totals_.vertices);
  }

  void finish(RoundReport& round, Time::time_point start) {
    shared_.emplace(comm_, part_, totals_);
    // Each counts once: where its part is the lowest that has it.
    std::vector<int> lowest(part_.vertex_id.size(), self_);
    shared_->least(lowest);
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
      const auto triangles = all_reduce(comm_, static_cast<Id>(surface_->triangles()), MPI_MAX);
      report_.surface_triangles = std::max(report_.surface_triangles, triangles);
    }
    round.seconds = all_reduce(comm_, seconds_since(start), MPI_MAX);
    report_.optimizer_seconds += round.optimizer_seconds;
    report_.rounds.push_back(round);
  }

  /// Until now these are counts of this rank alone.
  void sum_up_counts() {
    std::vector<Id> sums;
    for (const Count& c : kCounts) sums.push_back(report_.*c.all);
    sums = all_reduce(comm_, std::move(sums), MPI_SUM);
    for (std::size_t i = 0; i < sums.size(); ++i) report_.*kCounts[i].all = sums[i];
  }

  MPI_Comm comm_;
  int self_;
  Part& part_;
  Totals& totals_;
  Options options_;
  Context context_;
  bool cancelled_ = false;
  std::optional<Shared> shared_;  ///< of the part as the last round left it
  /// With Boundary::slide on several ranks: what the part slides on.
  std::optional<InputSurface> surface_;
  std::vector<float> angles_;  ///< smallest dihedral angle of each tetrahedron of the part, degrees
  DistributedReport report_;
};

}  // namespace

DistributedReport optimize_parts(MPI_Comm comm, Part& part, Totals& totals, Options options,
                                 const std::function<bool()>& stop) {
  return Rounds(comm, part, totals, std::move(options), stop).run();
}

}  // namespace tetune::mpi
