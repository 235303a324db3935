// SPDX-License-Identifier: Apache-2.0
#include "quality/sampled_distance.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "math/box_tree.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

/// The first radius relative to the length of an edge. Most samples are within it; a larger one finds more triangles
/// for each.
constexpr double kFirstRadius = 0.1;
constexpr double kRadiusGrowth = 4;
constexpr double kMaxScale = 16;

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
/// it. The search of the other samples is repeated with a larger radius; that of the few that are far is in a tree of
/// the triangles.
class DistanceSearch {
 public:
  DistanceSearch(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                 const backend::Cpu& cpu)
      : samples_(samples), surface_(surface), cpu_(cpu), distance2_(samples.size()) {
    for (std::atomic<double>& d : distance2_) d.store(kInfinity, std::memory_order_relaxed);
  }

  /// With a descent samples have upper bounds. Those with the largest bounds are searched for first, as their distances
  /// exceed the bounds of almost all others, which then need no search. A sixteenth of the samples comes before all, so
  /// that the descents of the others can end early.
  LargestDistances run(const SurfaceDescent* descent) {
    constexpr Size kFirstStride = 16;
    if (descent != nullptr) {
      search_farthest(*descent, kFirstStride);
      search_farthest(*descent, 1);
    }
    pending_.resize(samples_.size());
    std::iota(pending_.begin(), pending_.end(), Index{0});
    std::erase_if(pending_, [this](Index i) { return is_within_largest(i); });
    search_within_radius(1);
    search_everywhere();
    return {std::sqrt(vertices2_), std::sqrt(all2_)};
  }

 private:
  void search_farthest(const SurfaceDescent& descent, Size stride) {
    bound_by(descent, stride);
    pending_ = farthest();
    search_within_radius(kMaxScale);
    search_everywhere();
  }
  void bound_by(const SurfaceDescent& descent, Size stride) {
    cpu_.for_each(std::ssize(samples_) / stride, [&](Size k) {
      const Index i = to_index(k * stride);
      const SurfaceSample& s = sample(i);
      if (s.start < 0 || distance2_of(i) < kInfinity) return;
      distance2_[to_size_t(i)].store(descent.distance2(s.point, s.start, largest2(i)), std::memory_order_relaxed);
    });
  }
  /// A few samples with the largest finite bounds, of the vertices and of all.
  std::vector<Index> farthest() const {
    constexpr Size kCount = 32;
    std::vector<Index> result;
    for (const bool vertices_only : {true, false}) {
      std::vector<Index> bounded;
      for (Index i = 0; i < std::ssize(samples_); ++i) {
        const bool is_candidate = distance2_of(i) < kInfinity && !is_within_largest(i);
        if (is_candidate && (!vertices_only || sample(i).is_vertex)) bounded.push_back(i);
      }
      const Size count = std::min(kCount, std::ssize(bounded));
      std::partial_sort(bounded.begin(), bounded.begin() + count, bounded.end(),
                        [this](Index a, Index b) { return distance2_of(a) > distance2_of(b); });
      result.insert(result.end(), bounded.begin(), bounded.begin() + count);
    }
    return result;
  }

  /// Samples that are pending afterwards are far from the surface.
  void search_within_radius(double scale) {
    for (; scale <= kMaxScale && !pending_.empty(); scale *= kRadiusGrowth) {
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
    constexpr double kRounding = 1 + 1e-12;
    std::vector<Box> boxes;
    boxes.reserve(pending_.size());
    for (const Index i : pending_) {
      const double r = std::min(scale * sample(i).radius, kRounding * std::sqrt(distance2_of(i)));
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
    std::atomic<double>& smallest2 = distance2_[to_size_t(i)];
    double so_far = smallest2.load(std::memory_order_relaxed);
    const double d = distance2(sample(i).point, triangle);
    while (d < so_far && !smallest2.compare_exchange_weak(so_far, d, std::memory_order_relaxed)) {
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
  // The radius of a thin triangle is small, but at least a thousandth of its longest edge, as the search enlarges it in
  // steps.
  constexpr double kMinRadius2 = 1e-6;
  return std::sqrt(std::max(kFirstRadius * kFirstRadius * double_area(triangle), kMinRadius2 * max_length2(triangle)));
}

SurfaceDescent::SurfaceDescent(const std::vector<TrianglePoints>& triangles,
                               const std::vector<std::array<Index, 3>>& ids, Size vertices, const backend::Cpu& cpu)
    : triangles_(triangles), ids_(ids) {
  const Size corners = 3 * std::ssize(ids);
  const auto vertex_of = [&ids](Size corner) { return Size{span_of(ids)[corner / 3][to_size_t(corner % 3)]}; };
  build_csr(cpu, vertices, corners, vertex_of, vertex2corner_, corners);
}

double SurfaceDescent::distance2(const Vec3& p, Index start, double sufficient) const {
  constexpr int kMaxSteps = 16;
  constexpr Size kMaxTriangles = 64;  // a bound suffices at vertices of many
  const CsrView rows{vertex2corner_.offsets.span(), vertex2corner_.items.span()};
  double least = kInfinity;
  Index next = start;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Index vertex = next;
    Size closest = -1;
    const Size end = std::min(rows.end(vertex), rows.begin(vertex) + kMaxTriangles);
    for (Size c = rows.begin(vertex); c < end; ++c) {
      const Size t = rows.items[c] / 3;
      const double d2 = tetune::distance2(p, span_of(triangles_)[t]);
      if (!(d2 < least)) continue;
      if (d2 <= sufficient) return d2;
      least = d2;
      closest = t;
    }
    if (closest < 0) break;
    double from_corner2 = kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 away = span_of(triangles_)[closest][k] - p;
      if (!(dot(away, away) < from_corner2)) continue;
      from_corner2 = dot(away, away);
      next = span_of(ids_)[closest][k];
    }
    if (next == vertex) break;
  }
  return least;
}

LargestDistances max_distances(const std::vector<SurfaceSample>& samples, const std::vector<TrianglePoints>& surface,
                               const backend::Cpu& cpu, const SurfaceDescent* descent) {
  return DistanceSearch(samples, surface, cpu).run(descent);
}

}  // namespace tetune
