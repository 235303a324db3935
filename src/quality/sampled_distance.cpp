// SPDX-License-Identifier: Apache-2.0
#include "quality/sampled_distance.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "math/box_tree.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

/// The first radius in lengths of an edge, of which most samples are within: a larger one finds more triangles for
/// each.
constexpr double kFirstRadius = 0.1;
constexpr double kRadiusGrowth = 4;
constexpr int kMaxRounds = 3;

Box box_of(const TrianglePoints& t) {
  Box box{t[0], t[0]};
  box.include(t[1]);
  box.include(t[2]);
  return box;
}

/// The squared length of the edge after corner k.
double length2(const TrianglePoints& t, std::size_t k) {
  const Vec3 edge = t[(k + 1) % 3] - t[k];
  return dot(edge, edge);
}

double max_length2(const TrianglePoints& t) { return std::max({length2(t, 0), length2(t, 1), length2(t, 2)}); }

double double_area(const TrianglePoints& t) { return norm(cross(t[1] - t[0], t[2] - t[0])); }

bool is_thin(const TrianglePoints& t) {
  constexpr double kMaxAspect = 4;
  return max_length2(t) > kMaxAspect * double_area(t);
}

/// Divides a triangle at its longest edge.
std::array<TrianglePoints, 2> halves(const TrianglePoints& t) {
  const double longest2 = max_length2(t);
  std::size_t k = 0;
  while (length2(t, k) < longest2) ++k;
  const Vec3 middle = 0.5 * (t[k] + t[(k + 1) % 3]);
  return {{{t[k], middle, t[(k + 2) % 3]}, {middle, t[(k + 1) % 3], t[(k + 2) % 3]}}};
}

/// The samples are in a tree, as they may be fewer than the triangles, and each triangle finds those near it. A
/// distance is exact once all triangles within the radius of the sample have been measured and one of them is within
/// it; the other samples are searched again with a larger radius, and the few that are far by a tree of the triangles.
class DistanceSearch {
 public:
  DistanceSearch(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                 const backend::Cpu& cpu)
      : samples_(samples), surface_(surface), cpu_(cpu), distance2_(samples.size()), pending_(samples.size()) {
    for (std::atomic<double>& d : distance2_) d.store(kInfinity, std::memory_order_relaxed);
    std::iota(pending_.begin(), pending_.end(), Index{0});
  }

  LargestDistances run() {
    search_within_radius();
    search_everywhere();
    return {std::sqrt(vertices2_), std::sqrt(all2_)};
  }

 private:
  /// Samples that are pending afterwards are far from the surface.
  void search_within_radius() {
    double scale = 1;
    for (int round = 0; round < kMaxRounds && !pending_.empty(); ++round, scale *= kRadiusGrowth) {
      search(scale);
      for (const Index i : pending_) {
        if (is_exact(i, scale)) include(i);
      }
      std::erase_if(pending_, [&](Index i) { return is_exact(i, scale) || is_within_largest(i); });
    }
  }

  void search_everywhere() {
    if (pending_.empty()) return;
    const ClosestTriangle closest(surface_);
    cpu_.for_each(std::ssize(pending_), [&](Size p) {
      const Index i = span_of(pending_)[p];
      distance2_[to_size_t(i)].store(closest.closest(sample(i).point, largest2(i)).distance2,
                                     std::memory_order_relaxed);
    });
    for (const Index i : pending_) include(i);
  }

  /// The largest distance that matters for a sample.
  double largest2(Index i) const { return sample(i).is_vertex ? vertices2_ : all2_; }
  /// Whether the distance found so far, an upper bound, cannot change the results.
  bool is_within_largest(Index i) const { return distance2_of(i) <= largest2(i); }
  void include(Index i) {
    if (sample(i).is_vertex) vertices2_ = std::max(vertices2_, distance2_of(i));
    all2_ = std::max(all2_, distance2_of(i));
  }

  const SurfaceSample& sample(Index i) const { return span_of(samples_)[i]; }
  double distance2_of(Index i) const { return distance2_[to_size_t(i)].load(std::memory_order_relaxed); }
  /// Every triangle within the radius has been measured.
  bool is_exact(Index i, double scale) const {
    const double radius = scale * sample(i).radius;
    return distance2_of(i) <= radius * radius;
  }

  /// Measures the distances of the pending samples from the triangles near them.
  void search(double scale) {
    constexpr int kMaxDivisions = 20;
    std::vector<Box> boxes;
    boxes.reserve(pending_.size());
    for (const Index i : pending_) {
      const double r = scale * sample(i).radius;
      const Vec3 radius{r, r, r};
      boxes.push_back({sample(i).point - radius, sample(i).point + radius});
    }
    const BoxTree tree(boxes);
    cpu_.for_each(std::ssize(surface_),
                  [&](Size t) { measure_near(tree, span_of(surface_)[t], kMaxDivisions, span_of(surface_)[t]); });
  }

  /// Measures the distances of the samples near a part of a triangle from the triangle. The box of a thin part may have
  /// many that are far from it: then it is divided.
  void measure_near(const BoxTree& tree, const TrianglePoints& part, int divisions, const TrianglePoints& triangle) {
    constexpr std::size_t kMany = 64;
    std::array<Index, kMany> near;
    std::size_t count = 0;
    const Box box = box_of(part);
    const bool is_all = tree.while_meeting(box, [&](Index item) {
      if (count == kMany) return false;
      near[count++] = item;
      return true;
    });
    if (is_all) {
      for (std::size_t i = 0; i < count; ++i) measure(span_of(pending_)[near[i]], triangle);
    } else if (divisions > 0 && is_thin(part)) {
      for (const TrianglePoints& half : halves(part)) measure_near(tree, half, divisions - 1, triangle);
    } else {
      tree.for_meeting(box, [&](Index item) { measure(span_of(pending_)[item], triangle); });
    }
  }

  void measure(Index i, const TrianglePoints& triangle) {
    std::atomic<double>& least = distance2_[to_size_t(i)];
    double so_far = least.load(std::memory_order_relaxed);
    const double d = distance2(sample(i).point, triangle);
    while (d < so_far && !least.compare_exchange_weak(so_far, d, std::memory_order_relaxed)) {
    }
  }

  const std::vector<SurfaceSample>& samples_;
  const std::vector<TrianglePoints>& surface_;
  const backend::Cpu& cpu_;
  std::vector<std::atomic<double>> distance2_;
  std::vector<Index> pending_;
  double vertices2_ = 0, all2_ = 0;  ///< the largest squared distances so far
};

}  // namespace

double search_radius(const TrianglePoints& triangle) {
  // A thin triangle has a small radius, but not one that grows for ever.
  return std::sqrt(std::max(kFirstRadius * kFirstRadius * double_area(triangle), 1e-6 * max_length2(triangle)));
}

LargestDistances max_distances(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                               const backend::Cpu& cpu) {
  return DistanceSearch(samples, surface, cpu).run();
}

}  // namespace tetune
