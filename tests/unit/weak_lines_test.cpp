// SPDX-License-Identifier: Apache-2.0
// Feature lines that are noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "boundary/sliding/weak_lines.hpp"
#include "support/meshes.hpp"
#include "support/sliding_dofs.hpp"

namespace tetune {
namespace {

using test::classify_sliding, test::expect_dofs;

/// The edges between the vertices of a path; the corner of each is `first_corner` and up.
void add_path(const std::vector<Index>& vertices, bool is_weak, Index first_corner, std::vector<FeatureEdge>& edges) {
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
    edges.push_back({{vertices[i], vertices[i + 1]}, first_corner++, is_weak ? 1U : 0U});
  }
}
std::vector<Index> find_sorted(std::vector<FeatureEdge> edges) {
  std::vector<Index> corners = find_weak_lines(std::move(edges));
  std::sort(corners.begin(), corners.end());
  return corners;
}

TEST(WeakLines, HaveAnOpenEndAndNoEdgeThatIsNotWeak) {
  std::vector<FeatureEdge> edges;
  add_path({7, 3, 9}, true, 10, edges);
  EXPECT_EQ(find_sorted(edges), (std::vector<Index>{10, 11}));
  add_path({9, 4}, false, 20, edges);
  EXPECT_EQ(find_sorted(edges), std::vector<Index>{});
}

TEST(WeakLines, BetweenJunctionsAreKept) {
  // A closed line that is not weak, a weak line across it, and a closed weak line elsewhere.
  std::vector<FeatureEdge> edges;
  add_path({0, 1, 2, 3, 0}, false, 0, edges);
  add_path({1, 5, 3}, true, 10, edges);
  add_path({20, 21, 22, 20}, true, 20, edges);
  EXPECT_EQ(find_sorted(edges), std::vector<Index>{});
}

TEST(WeakLines, LeaveLinesThatHaveAnOpenEndThen) {
  // Two branches of a weak line that ends at a closed line which is not weak.
  std::vector<FeatureEdge> edges;
  add_path({0, 1, 2, 3, 0}, false, 0, edges);
  add_path({1, 5, 6}, true, 10, edges);
  add_path({6, 7}, true, 20, edges);
  add_path({6, 8, 9}, true, 30, edges);
  EXPECT_EQ(find_sorted(edges), (std::vector<Index>{10, 11, 20, 30, 31}));
  // With a branch that is kept, the one before it is kept as well.
  add_path({9, 2}, true, 40, edges);
  EXPECT_EQ(find_sorted(edges), std::vector<Index>{20});
}

TEST(WeakLines, SeveralEdgesWithTheSameEndsAreOneThatIsNotWeak) {
  std::vector<FeatureEdge> edges;
  add_path({4, 5}, true, 10, edges);
  add_path({5, 4}, false, 20, edges);
  add_path({5, 6}, true, 30, edges);
  EXPECT_EQ(find_sorted(edges), std::vector<Index>{});
}

/// A cube of 6^3 cells with a roof. Its ridge begins at the middle of an edge, where the surface turns by twice the
/// angle of this slope, and becomes flat before it reaches the opposite side. Its second vertex is raised by `peak`.
TetMesh with_roof(double slope, double peak = 0) {
  TetMesh m = test::cube(6);
  for (Point3& p : m.points) {
    const bool is_second = p[0] == 1.0 / 6 && p[1] == 0.5;
    p[2] *= 1 + slope * std::max(0.0, 1 - 1.2 * p[0]) * (0.5 - std::abs(p[1] - 0.5)) + (is_second ? peak : 0);
  }
  return m;
}

TEST(WeakLines, AreNoFeaturesOfASurface) {
  // The edge at which the ridge begins turns there, which is a corner beside the eight of the cube. The surface turns
  // by 53 degrees at most, below 4/3 of 45.
  expect_dofs(classify_sliding(with_roof(0.5)), 8 + 1, 60 - 1, 150, 125);
  // Above it: 84 degrees where the ridge begins. Two of its edges turn by more than 45.
  expect_dofs(classify_sliding(with_roof(0.9)), 8 + 2, 60 - 1 + 1, 150 - 2, 125);
  // With a smaller angle the first ridge is a line as well.
  EXPECT_GT(classify_sliding(with_roof(0.5), 30).curve_vertices, 60 - 1);
}

TEST(WeakLines, LeaveTheirTipsFixed) {
  expect_dofs(classify_sliding(with_roof(0.3, 0.05)), 8, 60, 150, 125);
  expect_dofs(classify_sliding(with_roof(0.3, 0.06)), 8 + 1, 60, 150 - 1, 125);
  // Without a line a tip is no corner.
  expect_dofs(classify_sliding(with_roof(0.3, 0.06), 60), 8, 60, 150, 125);
}

}  // namespace
}  // namespace tetune
