// SPDX-License-Identifier: Apache-2.0
#include "driver/targets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "boundary/classify.hpp"
#include "core/tet_measures.hpp"
#include "flips/flip.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kRegularAngle = 70.528779365509308;
constexpr par::Size kParts = 64;

bool misses(const Target& target, double value) {
  return larger_is_better(target.measure) ? value < target.value : value > target.value;
}

/// The best value that an element with such a dihedral angle can have, as far as it is known (docs/quality.md).
double best_at(Measure measure, double degrees) {
  if (measure == Measure::min_dihedral) return std::min(degrees, kRegularAngle);
  const double angle = degrees / kDegrees;
  return degrees >= kRegularAngle ? 1 : std::cbrt(8 * std::pow(std::sin(angle), 2) / std::pow(3 - std::cos(angle), 2));
}
bool bounded_by_angle(Measure measure) {
  return measure == Measure::min_dihedral || measure == Measure::mean_ratio || measure == Measure::sicn ||
         measure == Measure::harmonic;
}

/// What holds the elements of one outcome.
class Pins {
 public:
  Pins(const Outcome& outcome, const Options& options)
      : o_(outcome),
        options_(options),
        on_surface_(outcome.points.size(), 0),
        on_interface_(outcome.points.size(), 0),
        required_(outcome.tets.size(), 0) {
    for (const Index t : o_.required_slots) required_[at(t)] = 1;
    for (std::size_t t = 0; t < o_.tets.size(); ++t) {
      if (o_.tets[t][0] == kFreeSlot) continue;
      for (int f = 0; f < 4; ++f) {
        const Link link = o_.links[t][f];
        if (!is_locked(link)) continue;
        const bool interface = link != kNoLink && o_.tet_tags[at(link_tet(link))] != o_.tet_tags[t];
        for (int k = 0; k < 3; ++k) {
          const std::size_t v = at(o_.tets[t][face_vertex(f, k)]);
          on_surface_[v] = 1;
          if (interface) on_interface_[v] = 1;
        }
      }
    }
  }

  /// Sets the pin of an element, and the edge and angle where it is the surface's.
  void find(Index t, const Target& target, MissedTet& missed) const {
    const auto& frozen = options_.frozen_regions;
    if (required_[at(t)] != 0 || std::find(frozen.begin(), frozen.end(), o_.tet_tags[at(t)]) != frozen.end()) {
      missed.pin = Pin::locked_element;
    } else if (surface_angle(t, missed);
               misses(target, best_at(target.measure, missed.surface_angle)) && bounded_by_angle(target.measure)) {
      missed.pin = Pin::surface_angle;
    } else {
      missed.pin = strongest(t);
      missed.edge = {-1, -1};
      missed.surface_angle = 0;
    }
  }

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  Vec3 place(Index v) const { return vec(o_.points[at(v)]); }

  Pin strongest(Index t) const {
    const Tet tet = o_.tets[at(t)];
    int fixed = 0;
    int surface = 0;
    Pin pin = Pin::none;
    for (int k = 0; k < 4; ++k) {
      fixed += o_.kind[at(tet[k])] == Mobility::fixed ? 1 : 0;
      surface += on_surface_[at(tet[k])];
      pin = std::min(pin, pin_of(tet[k]));
    }
    return fixed == 4 ? Pin::fixed_vertices : surface == 4 ? Pin::surface_element : pin;
  }

  Pin pin_of(Index v) const {
    const Mobility kind = o_.kind[at(v)];
    if (kind == Mobility::free) return Pin::none;
    if (o_.frozen[at(v)] == kFrozen) return Pin::frozen_vertex;
    if (kind == Mobility::fixed && options_.boundary != Boundary::fixed) return Pin::feature_corner;
    if (kind == Mobility::line || kind == Mobility::curve) return Pin::feature_line;
    return on_interface_[at(v)] != 0 ? Pin::interface : Pin::boundary;
  }

  /// The smallest angle that the surface has at an edge of an element, on the element's side; 360 for none.
  void surface_angle(Index t, MissedTet& missed) const {
    missed.surface_angle = 360;
    for (int edge = 0; edge < 6; ++edge) {
      const EdgeCorners e = edge_corners(edge);
      const Index a = o_.tets[at(t)][e.i];
      const Index b = o_.tets[at(t)][e.j];
      const double angle = angle_at(t, a, b);
      const double one_way = to_surface(t, e.k, a, b);
      const double other_way = one_way < 0 ? -1 : to_surface(t, e.l, a, b);
      if (other_way < 0 || !(angle + one_way + other_way < missed.surface_angle)) continue;
      missed.surface_angle = angle + one_way + other_way;
      missed.edge = {o_.vertex2original[at(a)], o_.vertex2original[at(b)]};
    }
  }

  /// The angle from a face of t at edge (a, b) on to the surface; -1 when there is none all around.
  double to_surface(Index t, int face, Index a, Index b) const {
    double sum = 0;
    Link link = o_.links[at(t)][face];
    Index behind = o_.tets[at(t)][6 - local_index(o_.tets[at(t)], a) - local_index(o_.tets[at(t)], b) - face];
    while (!is_locked(link)) {
      const Index next = link_tet(link);
      if (next == t) return -1;
      sum += angle_at(next, a, b);
      const Tet tet = o_.tets[at(next)];
      const int entry = link_face(link);
      link = o_.links[at(next)][local_index(tet, behind)];
      behind = tet[entry];
    }
    return sum;
  }

  /// Dihedral angle of an element at its edge (a, b), in degrees.
  double angle_at(Index t, Index a, Index b) const {
    const Tet tet = o_.tets[at(t)];
    Vec3 normals[2];
    int n = 0;
    const Vec3 edge = place(b) - place(a);
    for (int k = 0; k < 4; ++k) {
      if (tet[k] != a && tet[k] != b) normals[n++] = cross(edge, place(tet[k]) - place(a));
    }
    return kDegrees * std::atan2(norm(cross(normals[0], normals[1])), dot(normals[0], normals[1]));
  }

  const Outcome& o_;
  const Options& options_;
  std::vector<std::uint8_t> on_surface_, on_interface_, required_;
};

}  // namespace

const char* to_string(Pin pin) {
  switch (pin) {
    case Pin::locked_element:
      return "locked element";
    case Pin::surface_angle:
      return "angle of the surface";
    case Pin::fixed_vertices:
      return "no vertex may move";
    case Pin::surface_element:
      return "all four vertices on the surface";
    case Pin::frozen_vertex:
      return "frozen vertex";
    case Pin::feature_corner:
      return "feature corner";
    case Pin::feature_line:
      return "feature line";
    case Pin::interface:
      return "interface";
    case Pin::boundary:
      return "boundary";
    case Pin::none:
      return "no constraint";
  }
  return "";
}

void check_target(const Target& target) {
  double worst = 0;
  double regular = 1;
  if (target.measure == Measure::min_dihedral) regular = kRegularAngle;
  if (target.measure == Measure::max_dihedral) {
    worst = 180;
    regular = kRegularAngle;
  }
  if (target.measure == Measure::radius_ratio || target.measure == Measure::aspect_ratio) worst = kFlatRatio;
  const double low = std::min(worst, regular);
  const double high = std::max(worst, regular);
  if (target.value >= low && target.value <= high && target.value != worst) return;
  const std::string range =
      worst == kFlatRatio ? "1 or more"
      : worst < regular
          ? "above 0 and at most " + (regular == 1 ? std::string("1") : "70.528, the regular tetrahedron's")
          : std::string("at least 70.529, the regular tetrahedron's, and below 180");
  throw OptionError("the target for " + std::string(to_string(target.measure)) + " is " + std::to_string(target.value) +
                    "; it must be " + range);
}

std::vector<TargetReport> report_targets(const Outcome& outcome, const Options& options) {
  const auto slots = static_cast<par::Size>(outcome.tets.size());
  const par::Cpu cpu(options.threads);
  const auto part_begin = [slots](par::Size part) { return slots * part / kParts; };
  const auto alive = [&outcome](par::Size t) { return outcome.tets[static_cast<std::size_t>(t)][0] != kFreeSlot; };

  // Compaction keeps the order of the slots: the id is the number of tetrahedra before.
  std::vector<Index> slot2tet(outcome.tets.size());
  Index tets = 0;
  for (par::Size t = 0; t < slots; ++t) {
    slot2tet[static_cast<std::size_t>(t)] = tets;
    if (alive(t)) ++tets;
  }

  struct Missed {
    Index slot;
    double value;
    MissedTet tet;
  };
  const Pins pins(outcome, options);
  std::vector<TargetReport> reports;
  for (const Target& target : options.targets) {
    const bool low = larger_is_better(target.measure);
    const auto worse = [low](const Missed& x, const Missed& y) {
      return x.value != y.value ? (x.value < y.value) == low : x.slot < y.slot;
    };
    std::vector<std::vector<Missed>> found(static_cast<std::size_t>(kParts));
    std::vector<std::array<std::int64_t, kPins>> pinned(static_cast<std::size_t>(kParts));
    cpu.for_parts(kParts, [&](par::Size part) {
      std::vector<Missed>& mine = found[static_cast<std::size_t>(part)];
      for (par::Size t = part_begin(part); t < part_begin(part + 1); ++t) {
        if (!alive(t)) continue;
        const Tet tet = outcome.tets[static_cast<std::size_t>(t)];
        Vec3 p[4];
        for (int k = 0; k < 4; ++k) p[k] = vec(outcome.points[static_cast<std::size_t>(tet[k])]);
        const double value = all_measures(TetShape(p))[static_cast<std::size_t>(target.measure)];
        if (!misses(target, value)) continue;
        Missed m{static_cast<Index>(t), value, {}};
        const Vec3 centroid = (0.25 / outcome.scale) * (p[0] + p[1] + p[2] + p[3]);
        m.tet.value = value;
        m.tet.centroid = {centroid.x, centroid.y, centroid.z};
        pins.find(m.slot, target, m.tet);
        ++pinned[static_cast<std::size_t>(part)][static_cast<std::size_t>(m.tet.pin)];
        mine.push_back(m);
        if (mine.size() < 2 * kMostMissed) continue;
        std::nth_element(mine.begin(), mine.begin() + kMostMissed, mine.end(), worse);
        mine.resize(kMostMissed);
      }
    });

    TargetReport report;
    report.target = target;
    report.tets = tets;
    std::vector<Missed> all;
    for (std::size_t part = 0; part < found.size(); ++part) {
      all.insert(all.end(), found[part].begin(), found[part].end());
      for (std::size_t k = 0; k < kPins; ++k) {
        report.pinned[k] += pinned[part][k];
        report.missed += pinned[part][k];
      }
    }
    std::sort(all.begin(), all.end(), worse);
    if (all.size() > kMostMissed) all.resize(kMostMissed);
    for (Missed& m : all) {
      m.tet.tet = slot2tet[static_cast<std::size_t>(m.slot)];
      report.worst.push_back(m.tet);
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace tetune
