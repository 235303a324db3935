// SPDX-License-Identifier: Apache-2.0
#include "mesh/periodic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "backend/span.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

/// A pair of linked vertices, seen from one of them.
struct Neighbor {
  Index from, to;
  Vec3 shift;     ///< from -> to
  bool is_image;  ///< `from` is the image
};

bool is_near(const Vec3& a, const Vec3& b, double tolerance) {
  return std::fabs(a.x - b.x) <= tolerance && std::fabs(a.y - b.y) <= tolerance && std::fabs(a.z - b.z) <= tolerance;
}

/// translation_of() for one coordinate.
double best_shift(const PeriodicLink& link, const std::vector<Point3>& points, std::size_t k, double difference,
                  double tolerance) {
  std::vector<double> candidates;
  if (link.affine.size() == 16) candidates.push_back(link.affine[4 * k + 3]);
  candidates.insert(candidates.end(),
                    {0.0, difference, std::nextafter(difference, -kInfinity), std::nextafter(difference, kInfinity)});
  double best = difference;
  std::int64_t max_exact = -1;
  for (const double shift : candidates) {
    if (!(std::fabs(shift - difference) <= tolerance)) continue;
    const std::int64_t exact = std::count_if(link.pairs.begin(), link.pairs.end(), [&](const auto& pair) {
      return span_of(points)[pair[1]][k] + shift == span_of(points)[pair[0]][k];
    });
    if (exact > max_exact) {
      max_exact = exact;
      best = shift;
    }
  }
  return best;
}

/// The pairs of all links from both sides, by vertex; and 1 for each vertex with a link that is no translation.
std::vector<Neighbor> find_neighbors(const TetMesh& mesh, double tolerance, std::vector<std::uint8_t>& unmatched) {
  std::vector<Neighbor> neighbors;
  for (const PeriodicLink& link : mesh.periodic) {
    const std::optional<Vec3> shift = translation_of(link, mesh.points, tolerance);
    for (const auto& [vertex, master] : link.pairs) {
      if (!shift) {
        span_of(unmatched)[vertex] = span_of(unmatched)[master] = 1;
        continue;
      }
      neighbors.push_back({master, vertex, *shift, false});
      neighbors.push_back({vertex, master, -1.0 * *shift, true});
    }
  }
  // Stable: of several links of one pair the first one counts.
  std::stable_sort(neighbors.begin(), neighbors.end(),
                   [](const Neighbor& a, const Neighbor& b) { return a.from < b.from; });
  return neighbors;
}

/// Finds one class after the other.
class ClassFinder {
 public:
  ClassFinder(const TetMesh& mesh, double tolerance)
      : unmatched_(mesh.points.size(), 0),
        neighbors_(find_neighbors(mesh, tolerance, unmatched_)),
        shifts_(mesh.points.size()),
        seen_(mesh.points.size(), 0),
        tolerance_(tolerance) {}

  PeriodicClasses find() {
    // From vertices that are no image first.
    for (const bool from_images : {false, true}) {
      for (std::size_t i = 0; i < neighbors_.size(); ++i) {
        const Index v = neighbors_[i].from;
        if (i > 0 && neighbors_[i - 1].from == v) continue;
        if (span_of(seen_)[v] == 0 && (from_images || !is_image(v))) add_class(v);
      }
    }
    return std::move(classes_);
  }

 private:
  std::span<const Neighbor> neighbors_of(Index v) const {
    const auto begin = std::lower_bound(neighbors_.begin(), neighbors_.end(), v,
                                        [](const Neighbor& n, Index id) { return n.from < id; });
    const auto end = std::find_if(begin, neighbors_.end(), [v](const Neighbor& n) { return n.from != v; });
    return {neighbors_.data() + (begin - neighbors_.begin()), to_size_t(end - begin)};
  }
  bool is_image(Index v) const {
    const auto around = neighbors_of(v);
    return std::any_of(around.begin(), around.end(), [](const Neighbor& n) { return n.is_image; });
  }

  /// Adds the class of a root, unless its links contradict each other.
  void add_class(Index root) {
    std::vector<Index> members{root};
    bool matches = true;
    span_of(seen_)[root] = 1;
    span_of(shifts_)[root] = {0, 0, 0};
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Index v = members[i];
      if (span_of(unmatched_)[v] != 0) matches = false;
      for (const Neighbor& n : neighbors_of(v)) {
        const Vec3 shift = span_of(shifts_)[v] + n.shift;
        if (span_of(seen_)[n.to] != 0) {
          matches = matches && is_near(shift, span_of(shifts_)[n.to], tolerance_);
          continue;
        }
        span_of(seen_)[n.to] = 1;
        span_of(shifts_)[n.to] = shift;
        members.push_back(n.to);
      }
    }
    if (!matches || members.size() < 2) return;
    for (const Index v : members) {
      classes_.members.push_back(v);
      classes_.shifts.push_back(span_of(shifts_)[v]);
    }
    classes_.first.push_back(std::uint32_t(classes_.members.size()));
  }

  std::vector<std::uint8_t> unmatched_;
  std::vector<Neighbor> neighbors_;
  std::vector<Vec3> shifts_;
  std::vector<std::uint8_t> seen_;
  double tolerance_;
  PeriodicClasses classes_;
};

}  // namespace

double extent_of(const TetMesh& mesh) {
  double extent = 0;
  for (std::size_t k = 0; k < 3 && !mesh.points.empty(); ++k) {
    const auto [low, high] = std::minmax_element(mesh.points.begin(), mesh.points.end(),
                                                 [k](const Point3& a, const Point3& b) { return a[k] < b[k]; });
    extent = std::max(extent, (*high)[k] - (*low)[k]);
  }
  return extent;
}

std::optional<Vec3> translation_of(const PeriodicLink& link, const std::vector<Point3>& points, double tolerance) {
  if (link.pairs.empty()) return std::nullopt;
  const auto difference = [&points](const std::array<Index, 2>& pair) {
    return vec(span_of(points)[pair[0]]) - vec(span_of(points)[pair[1]]);
  };
  const Vec3 first = difference(link.pairs[0]);
  for (const auto& pair : link.pairs) {
    if (!is_near(difference(pair), first, tolerance)) return std::nullopt;
  }
  return Vec3{best_shift(link, points, 0, first.x, tolerance), best_shift(link, points, 1, first.y, tolerance),
              best_shift(link, points, 2, first.z, tolerance)};
}

PeriodicClasses find_periodic_classes(const TetMesh& mesh) {
  if (mesh.periodic.empty()) return {};
  return ClassFinder(mesh, kMatchTolerance * extent_of(mesh)).find();
}

}  // namespace tetune
