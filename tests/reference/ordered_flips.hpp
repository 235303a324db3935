// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <queue>
#include <vector>

#include "backend/span.hpp"
#include "energy/harmonic.hpp"
#include "mesh/half_face.hpp"
#include "reference/alexa.hpp"

namespace tetune::reference {

/// A mesh with face adjacency in plain vectors, on which 2-3 and 3-2 flips are applied from one ordered queue.
class OrderedFlips {
 public:
  /// `points` are read by run() and may be moved between calls.
  OrderedFlips(const std::vector<Vec3>& points, const TetMesh& mesh);

  /// Evaluates every face and edge, and flips until the queue is empty.
  FlipResult run();

  Span<const Tet> tets() const { return span_of(tets_); }
  bool alive(Index t) const { return tet(t)[0] >= 0; }
  int tag(Index t) const { return span_of(tags_)[t]; }
  HalfFace across(Index t, int face) const { return span_of(adjacency_)[t][face]; }

 private:
  /// A flip that lowered the energy when it was evaluated. It is still valid if its tetrahedra have the same stamps.
  struct Candidate {
    double gain;
    Index tets[3];
    std::uint32_t stamps[3];
    Index ends[2], ring[3];
    int count;  ///< number of tetrahedra before the flip: 2 or 3
    bool operator<(const Candidate& other) const {
      if (gain != other.gain) return gain < other.gain;
      return tets[0] != other.tets[0] ? tets[0] > other.tets[0] : tets[1] > other.tets[1];
    }
  };
  /// The tetrahedra after a flip.
  struct NewTets {
    Tet tets[3];
    int count;
  };
  static NewTets tets_after(const Candidate& c);

  const Tet& tet(Index t) const { return span_of(tets_)[t]; }
  TetEnergy energy_of(const Tet& t) const;
  /// Negative if the volume is not certified positive.
  double eta(const Tet& t) const;
  void evaluate_face(Index t, int face);
  /// Skips the edge if another one of its tetrahedra has an id below `min_tet`.
  void evaluate_edge(Index t, int i, int j, Index min_tet);
  void evaluate_tet(Index t);
  void push_if_better(Candidate c);
  bool is_current(const Candidate& c) const;
  void apply(const Candidate& c, FlipResult& result);
  /// The half-faces across the outer faces of the cavity: for each edge of the ring, one on the side of each end.
  void find_outer_faces(const Candidate& c, HalfFace (&outer)[3][2]) const;
  void connect_outer_faces(const Candidate& c, const Index (&slots)[3], const HalfFace (&outer)[3][2]);
  Index allocate_slot();
  void free_slot(Index t);
  void store(Index slot, const Tet& tet, int tag);
  void connect(Index t, int face, HalfFace other);

  const std::vector<Vec3>& points_;
  std::vector<Tet> tets_;
  std::vector<FaceAdjacency> adjacency_;
  std::vector<int> tags_;
  std::vector<double> eta_;
  std::vector<std::uint32_t> stamps_;  ///< counts the changes of each slot
  std::vector<Index> free_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace tetune::reference
