// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <queue>
#include <vector>

#include "core/links.hpp"
#include "core/types.hpp"
#include "reference/alexa.hpp"

namespace tetune::reference {

/// A mesh with links in plain vectors, flipped from one ordered queue.
class OrderedFlips {
 public:
  /// `points` are read during flipping and may be moved between calls of run().
  OrderedFlips(const std::vector<Vec3>& points, const TetMesh& mesh);

  /// Flips until the queue is empty; looks at every face and edge.
  FlipResult run();

  const std::vector<Tet>& tets() const { return tets_; }
  bool alive(std::size_t t) const { return tets_[t].v[0] >= 0; }
  int tag(std::size_t t) const { return tags_[t]; }
  Link across(std::size_t t, int face) const { return links_[t][face]; }

 private:
  /// A flip that was good when it was found. Its tetrahedra's stamps tell whether it still is what it was.
  struct Candidate {
    double gain;
    Index tets[3];
    std::uint32_t stamps[3];
    Index ends[2], ring[3];
    int count;  ///< tetrahedra before: 2 or 3
    bool operator<(const Candidate& other) const {
      if (gain != other.gain) return gain < other.gain;
      return tets[0] != other.tets[0] ? tets[0] > other.tets[0] : tets[1] > other.tets[1];
    }
  };

  double eta(const Tet& t) const;
  void look_at_face(Index t, int face);
  /// Leaves the edge alone where one of its other tetrahedra has an id below `lowest`.
  void look_at_edge(Index t, int i, int j, Index lowest);
  void look_around(Index t);
  void offer(Candidate c, const Tet* after, int count_after);
  bool current(const Candidate& c) const;
  void apply(const Candidate& c, FlipResult& result);
  void connect(Index t, int face, Link other);

  const std::vector<Vec3>& points_;
  std::vector<Tet> tets_;
  std::vector<Links> links_;
  std::vector<int> tags_;
  std::vector<double> eta_;
  std::vector<std::uint32_t> stamps_;
  std::vector<Index> free_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace tetune::reference
