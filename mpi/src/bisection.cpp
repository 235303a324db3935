// SPDX-License-Identifier: Apache-2.0
#include "bisection.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "communicate.hpp"
#include "ids.hpp"

namespace tetune::mpi {
namespace {

class Bisection {
 public:
  Bisection(MPI_Comm comm, const std::vector<Point3>& points)
      : comm_(comm), points_(points), group_(points.size(), 0), groups_{{0, size_of(comm)}} {}

  std::vector<int> run() {
    while (std::any_of(groups_.begin(), groups_.end(), [](const Ranks& r) { return r.end - r.begin > 1; })) split();
    for (int& g : group_) g = item(groups_, g).begin;
    return std::move(group_);
  }

 private:
  static constexpr int kBins = 256;
  static constexpr int kRefinements = 4;
  struct Ranks {
    int begin, end;
  };
  struct Cut {
    std::size_t axis = 0;
    double low = 0, high = 0;
    std::int64_t target = 0, below = 0;
  };

  void split() {
    find_cuts();
    for (int i = 0; i < kRefinements; ++i) refine();
    divide_groups();
  }

  /// Chooses the longest axis of each group's bounding box, and the number of points below the cut.
  void find_cuts() {
    const std::size_t n = groups_.size();
    std::vector<double> box(6 * n, std::numeric_limits<double>::infinity());
    std::vector<std::int64_t> sizes(n, 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const std::size_t g(group_[i]);
      ++sizes[g];
      for (std::size_t k = 0; k < 3; ++k) {
        box[6 * g + k] = std::min(box[6 * g + k], points_[i][k]);
        box[6 * g + 3 + k] = std::min(box[6 * g + 3 + k], -points_[i][k]);
      }
    }
    box = all_reduce(comm_, std::move(box), MPI_MIN);
    sizes = all_reduce(comm_, std::move(sizes), MPI_SUM);
    cuts_.assign(n, {});
    for (std::size_t g = 0; g < n; ++g) {
      if (sizes[g] == 0) continue;
      Cut& cut = cuts_[g];
      const auto length = [&](std::size_t k) { return -box[6 * g + 3 + k] - box[6 * g + k]; };
      for (std::size_t k = 1; k < 3; ++k) {
        if (length(k) > length(cut.axis)) cut.axis = k;
      }
      cut.low = box[6 * g + cut.axis];
      cut.high = -box[6 * g + 3 + cut.axis];
      const Ranks r = groups_[g];
      cut.target = sizes[g] * ((r.end - r.begin) / 2) / (r.end - r.begin);
    }
  }

  void divide_groups() {
    std::vector<Ranks> halves;
    std::vector<int> first;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      first.push_back(int_size(halves));
      const Ranks r = groups_[g];
      if (r.end - r.begin == 1) {
        halves.push_back(r);
        continue;
      }
      const int middle = r.begin + (r.end - r.begin) / 2;
      halves.push_back({r.begin, middle});
      halves.push_back({middle, r.end});
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const std::size_t g(group_[i]);
      const bool splits = groups_[g].end - groups_[g].begin > 1;
      group_[i] = first[g] + (splits && points_[i][cuts_[g].axis] >= cuts_[g].high ? 1 : 0);
    }
    groups_ = std::move(halves);
  }

  static int bin(const Cut& cut, double x) {
    return std::clamp(int((x - cut.low) / (cut.high - cut.low) * kBins), 0, kBins - 1);
  }

  /// Narrows each cut to the bin in which the target number of points is reached.
  void refine() {
    std::vector<std::int64_t> counts(cuts_.size() * kBins, 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const std::size_t g(group_[i]);
      const double x = points_[i][cuts_[g].axis];
      if (x < cuts_[g].low || x >= cuts_[g].high) continue;
      ++item(counts, Id(g) * kBins + bin(cuts_[g], x));
    }
    counts = all_reduce(comm_, std::move(counts), MPI_SUM);
    for (std::size_t g = 0; g < cuts_.size(); ++g) {
      Cut& cut = cuts_[g];
      if (!(cut.high > cut.low)) continue;
      const std::int64_t* count = counts.data() + g * kBins;
      int b = 0;
      for (; b < kBins - 1 && cut.below + count[b] < cut.target; ++b) cut.below += count[b];
      const double width = (cut.high - cut.low) / kBins;
      const double low = cut.low;
      cut.low = low + b * width;
      if (b < kBins - 1) cut.high = low + (b + 1) * width;
    }
  }

  MPI_Comm comm_;
  const std::vector<Point3>& points_;
  std::vector<int> group_;
  std::vector<Ranks> groups_;
  std::vector<Cut> cuts_;
};

}  // namespace

std::vector<int> bisect(MPI_Comm comm, const std::vector<Point3>& points) { return Bisection(comm, points).run(); }

}  // namespace tetune::mpi
