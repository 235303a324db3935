// SPDX-License-Identifier: Apache-2.0
// An operator that is defined in this file alone: the cavity engine selects and applies its candidates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>

#include "operators/engine/application.hpp"
#include "operators/flips/flip_energy.hpp"
#include "operators/flips/flip_proposals.hpp"
#include "support/flip_fixture.hpp"
#include "support/meshes.hpp"

namespace tetune {
namespace {

/// 3-2 and 4-4 flips alone, each edge evaluated by the tetrahedron in the lowest slot around it.
struct SmallEdgeFlips {
  using Candidate = FlipCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 32;
  static constexpr Size kBatch = 64;
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const Index> active;
  Span<const double> energies;

  struct IsLower {
    Index t;
    TETUNE_HD bool operator()(Index other) const { return other < t; }
  };

  TETUNE_HD Size operator()(Size i, const Proposals<FlipCandidate>& proposals) const {
    const Index t = active[i];
    Size evaluated = 0;
    for (int edge = 0; edge < 6; ++edge) {
      FlipCandidate c = find(t, edge);
      if (c.kind == FlipKind::none) continue;
      ++evaluated;
      const double gain = find_gain(c);
      if (gain > 0) proposals.add(i, c, gain, candidate_id(t, 4 + edge));
    }
    return evaluated;
  }
  TETUNE_HD FlipCandidate find(Index t, int edge) const {
    const FaceAdjacency links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face) {
      const bool at_edge = (edge_faces(edge) & 1U << face) != 0;
      if (at_edge && (is_locked(links[face]) || tet_of(links[face]) < t)) return {};
    }
    return edge_cavity(edge_star(mesh, 4, t, edge, IsLower{t}), constrained);
  }
  TETUNE_HD double find_gain(FlipCandidate& c) const {
    const double before = energy_before(c, energies);
    const double gain = before - best_energy<double>(mesh, c, before, before);
    return gain > kMinRelativeGain * before ? gain : 0;
  }
};

struct WithOperator : test::FlipFixture {
  using test::FlipFixture::FlipFixture;
  SmallEdgeFlips small_edge_flips() {
    return {rated(work, criterion), state.constrained(), state.active.span(), state.energies.span()};
  }
  PassResult small_edge_flip_pass() { return flip_active(cpu, work, criterion, state, small_edge_flips(), flags()); }
};

TEST(AddOperator, ThreeTetsAroundALongEdgeBecomeTwo) {
  WithOperator f(test::three_tets(1));
  const PassResult r = f.small_edge_flip_pass();
  EXPECT_EQ(r.active, 3);
  EXPECT_EQ(r.evaluated, 1);
  EXPECT_EQ(r.counts.flips32, 1);
  EXPECT_EQ(r.counts.flips(), 1);
  EXPECT_NEAR(r.decrease, 40.2701812759764 - 20.784609690826525, 1e-10);
  std::vector<std::array<Index, 4>> tets = f.result().tets;
  for (auto& t : tets) t = ascending(t);
  EXPECT_EQ(tets, (std::vector<std::array<Index, 4>>{{0, 2, 3, 4}, {1, 2, 3, 4}}));
  EXPECT_EQ(f.flipped, std::vector<std::uint8_t>(5, 1));
  EXPECT_EQ(f.state.active.download(), (std::vector<Index>{0, 1}));
  f.expect_consistent();
  EXPECT_EQ(f.small_edge_flip_pass().counts.flips(), 0);
}

TEST(AddOperator, TheHighestBidOnAllTetrahedraOfItsCavityIsSelected) {
  WithOperator f(test::sheared(test::scrambled(test::cube(6, 0.2, 2), 3, 2), 2.5));
  const SmallEdgeFlips operation = f.small_edge_flips();
  std::vector<std::pair<std::uint64_t, FlipCandidate>> bids;
  std::map<Index, std::uint64_t> highest;
  for (const Index t : f.state.active.download()) {
    for (int edge = 0; edge < 6; ++edge) {
      FlipCandidate c = operation.find(t, edge);
      const double gain = c.kind == FlipKind::none ? 0 : operation.find_gain(c);
      if (!(gain > 0)) continue;
      bids.push_back({make_bid(gain, candidate_id(t, 4 + edge)), c});
      for (int k = 0; k < c.old_count(); ++k) highest[c.tets[k]] = std::max(highest[c.tets[k]], bids.back().first);
    }
  }
  const Size expected = std::count_if(bids.begin(), bids.end(), [&](const auto& bid) {
    const auto holds = [&](Index t) { return highest[t] == bid.first; };
    return std::all_of(bid.second.tets, bid.second.tets + bid.second.old_count(), holds);
  });
  EXPECT_GT(expected, 20);
  EXPECT_LT(expected, std::ssize(bids));
  const PassResult r = f.small_edge_flip_pass();
  EXPECT_EQ(r.counts.flips32 + r.counts.edge_removals, expected);
  EXPECT_EQ(r.counts.flips(), expected);
  EXPECT_EQ(f.work.tets(), std::ssize(f.original.tets) - r.counts.flips32);
  f.expect_consistent();
  EXPECT_NEAR(refresh_energy(f.cpu, f.work, f.criterion, f.state.energies), f.energy - r.decrease, 1e-9 * f.energy);
}

TEST(AddOperator, PassesEndWhereNoCandidateGains) {
  WithOperator f(test::sheared(test::scrambled(test::cube(5, 0.2, 4), 3, 4), 2.5));
  int passes = 0;
  for (Size flips = 1; flips > 0; ++passes) flips = f.small_edge_flip_pass().counts.flips();
  EXPECT_GT(passes, 2);
  f.expect_consistent();
}

}  // namespace
}  // namespace tetune
