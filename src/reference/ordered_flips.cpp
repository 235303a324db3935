// SPDX-License-Identifier: Apache-2.0
#include "reference/ordered_flips.hpp"

#include <algorithm>

#include "core/connect.hpp"
#include "core/upload.hpp"
#include "energy/harmonic.hpp"
#include "par/cpu.hpp"

namespace tetune::reference {
namespace {

constexpr double kMinRelativeGain = 1e-9;

bool even(const Index* p) {
  int inversions = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) inversions += p[i] > p[j] ? 1 : 0;
  }
  return inversions % 2 == 0;
}

/// The face of a tetrahedron opposite a vertex.
int opposite(const Tet& t, Index vertex) { return local_index(t, vertex); }

}  // namespace

OrderedFlips::OrderedFlips(const std::vector<Vec3>& points, const TetMesh& mesh)
    : points_(points), tags_(mesh.tet_tags), stamps_(mesh.tets.size(), 0) {
  const par::Cpu cpu(1);
  WorkMesh<par::Cpu> work = upload_mesh<par::Cpu>(mesh);
  build_adjacency(cpu, work);
  lock_interfaces(cpu, work, par::Cpu::Loan<int>(mesh.tet_tags).span());
  tets_ = work.tet2vertex.download();
  links_ = work.tet2tet.download();
  eta_.resize(tets_.size());
}

double OrderedFlips::eta(const Tet& t) const {
  const auto p = [&](int k) -> const Vec3& { return points_[static_cast<std::size_t>(t[k])]; };
  const TetEnergy e = tet_energy(kHarmonicLaw, p(0), p(1), p(2), p(3));
  return e.certified ? e.energy : -1;
}

void OrderedFlips::offer(Candidate c, const Tet* after, int count_after) {
  double before = 0;
  for (int k = 0; k < c.count; ++k) {
    before += eta_[static_cast<std::size_t>(c.tets[k])];
    c.stamps[k] = stamps_[static_cast<std::size_t>(c.tets[k])];
  }
  double sum = 0;
  for (int k = 0; k < count_after; ++k) {
    const double e = eta(after[k]);
    if (e < 0 || !(sum + e < before)) return;
    sum += e;
  }
  c.gain = before - sum;
  if (c.gain > kMinRelativeGain * before) queue_.push(c);
}

void OrderedFlips::look_at_face(Index t, int face) {
  const Link link = links_[static_cast<std::size_t>(t)][face];
  if (is_locked(link)) return;
  const Tet& tet = tets_[static_cast<std::size_t>(t)];
  Candidate c{};
  c.count = 2;
  c.tets[0] = t;
  c.tets[1] = link_tet(link);
  c.ends[0] = tet[face];
  c.ends[1] = tets_[static_cast<std::size_t>(c.tets[1])][link_face(link)];
  for (int k = 0; k < 3; ++k) c.ring[k] = tet[face_vertex(face, k)];
  const Tet after[3] = {{{c.ends[0], c.ring[0], c.ring[1], c.ends[1]}},
                        {{c.ends[0], c.ring[1], c.ring[2], c.ends[1]}},
                        {{c.ends[0], c.ring[2], c.ring[0], c.ends[1]}}};
  offer(c, after, 3);
}

void OrderedFlips::look_at_edge(Index t, int i, int j, Index lowest) {
  const Tet& tet = tets_[static_cast<std::size_t>(t)];
  int k = 0;
  while (k == i || k == j) ++k;
  int l = k + 1;
  while (l == i || l == j) ++l;
  const Index order[4] = {i, k, l, j};
  if (!even(order)) std::swap(k, l);
  // Turn around the edge: across the face opposite k lies the tetrahedron with l, and so on, back to t after three.
  const Link first = links_[static_cast<std::size_t>(t)][k];
  if (is_locked(first)) return;
  const Index second_tet = link_tet(first);
  const Tet& second = tets_[static_cast<std::size_t>(second_tet)];
  const Link next = links_[static_cast<std::size_t>(second_tet)][opposite(second, tet[l])];
  if (is_locked(next)) return;
  const Index third_tet = link_tet(next);
  const Index r = second[link_face(first)];
  const Tet& third = tets_[static_cast<std::size_t>(third_tet)];
  const Link last = links_[static_cast<std::size_t>(third_tet)][opposite(third, r)];
  if (is_locked(last) || link_tet(last) != t || second_tet < lowest || third_tet < lowest) return;
  Candidate c{};
  c.count = 3;
  c.tets[0] = t;
  c.tets[1] = second_tet;
  c.tets[2] = third_tet;
  c.ends[0] = tet[i];
  c.ends[1] = tet[j];
  c.ring[0] = tet[k];
  c.ring[1] = tet[l];
  c.ring[2] = r;
  const Tet after[2] = {{{c.ends[0], c.ring[0], c.ring[1], c.ring[2]}}, {{c.ends[1], c.ring[0], c.ring[2], c.ring[1]}}};
  offer(c, after, 2);
}

void OrderedFlips::look_around(Index t) {
  for (int f = 0; f < 4; ++f) look_at_face(t, f);
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) look_at_edge(t, i, j, 0);
  }
}

bool OrderedFlips::current(const Candidate& c) const {
  for (int k = 0; k < c.count; ++k) {
    if (stamps_[static_cast<std::size_t>(c.tets[k])] != c.stamps[k]) return false;
  }
  return true;
}

void OrderedFlips::connect(Index t, int face, Link other) {
  links_[static_cast<std::size_t>(t)][face] = other;
  if (other != kNoLink) {
    links_[static_cast<std::size_t>(link_tet(other))][link_face(other)] = make_link(t, face) | (other & kLocked);
  }
}

void OrderedFlips::apply(const Candidate& c, FlipResult& result) {
  // What lies across the outer faces: one on the side of each end for each edge of the ring.
  Link outer[3][2];
  for (int m = 0; m < 3; ++m) {
    for (int side = 0; side < 2; ++side) {
      const Index t = c.count == 2 ? c.tets[side] : c.tets[m];
      const Index away = c.count == 2 ? c.ring[(m + 2) % 3] : c.ends[1 - side];
      outer[m][side] = links_[static_cast<std::size_t>(t)][opposite(tets_[static_cast<std::size_t>(t)], away)];
    }
  }
  Index slots[3] = {c.tets[0], c.tets[1], c.tets[2]};
  if (c.count == 2) {
    if (free_.empty()) {
      free_.push_back(static_cast<Index>(tets_.size()));
      tets_.emplace_back();
      links_.emplace_back();
      tags_.push_back(0);
      eta_.push_back(0);
      stamps_.push_back(0);
    }
    slots[2] = free_.back();
    free_.pop_back();
  }
  const int made = c.count == 2 ? 3 : 2;
  for (int m = 0; m < made; ++m) {
    const auto s = static_cast<std::size_t>(slots[m]);
    if (c.count == 2) {
      tets_[s] = {{c.ends[0], c.ring[m], c.ring[(m + 1) % 3], c.ends[1]}};
    } else {
      tets_[s] = m == 0 ? Tet{{c.ends[0], c.ring[0], c.ring[1], c.ring[2]}}
                        : Tet{{c.ends[1], c.ring[0], c.ring[2], c.ring[1]}};
    }
    tags_[s] = tags_[static_cast<std::size_t>(c.tets[0])];
    eta_[s] = eta(tets_[s]);
    ++stamps_[s];
  }
  for (int m = 0; m < 3; ++m) {
    for (int side = 0; side < 2; ++side) {
      const Index s = c.count == 2 ? slots[m] : slots[side];
      const Index away = c.count == 2 ? c.ends[1 - side] : c.ring[(m + 2) % 3];
      connect(s, opposite(tets_[static_cast<std::size_t>(s)], away), outer[m][side]);
    }
  }
  if (c.count == 2) {
    // In (a, p, q, b) the face opposite p, vertex 1, is that opposite r in the next one, (a, q, r, b): vertex 2.
    for (int m = 0; m < 3; ++m) connect(slots[m], 1, make_link(slots[(m + 1) % 3], 2));
    ++result.flips23;
  } else {
    connect(slots[0], 0, make_link(slots[1], 0));
    const auto freed = static_cast<std::size_t>(slots[2]);
    tets_[freed] = {{-1, -1, -1, -1}};
    ++stamps_[freed];
    free_.push_back(slots[2]);
    ++result.flips32;
  }
  result.decrease += c.gain;
  for (int m = 0; m < made; ++m) look_around(slots[m]);
}

FlipResult OrderedFlips::run() {
  for (std::size_t t = 0; t < tets_.size(); ++t) eta_[t] = alive(t) ? std::max(eta(tets_[t]), 0.0) : 0;
  // A volume that rounding cannot tell from zero counts with the finite bound that tet_energy gives it.
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    if (!alive(t) || eta_[t] > 0) continue;
    const auto p = [&](int k) -> const Vec3& { return points_[static_cast<std::size_t>(tets_[t][k])]; };
    eta_[t] = tet_energy(kHarmonicLaw, p(0), p(1), p(2), p(3)).energy;
  }
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    if (!alive(t)) continue;
    const auto id = static_cast<Index>(t);
    for (int f = 0; f < 4; ++f) {
      const Link link = links_[t][f];
      if (!is_locked(link) && id < link_tet(link)) look_at_face(id, f);
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) look_at_edge(id, i, j, id);
    }
  }
  FlipResult result;
  while (!queue_.empty()) {
    const Candidate c = queue_.top();
    queue_.pop();
    if (current(c)) apply(c, result);
  }
  return result;
}

}  // namespace tetune::reference
