// SPDX-License-Identifier: Apache-2.0
#include "reference/ordered_flips.hpp"

#include <algorithm>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune::reference {
namespace {

constexpr double kMinRelativeGain = 1e-9;

bool is_even(const Index (&p)[4]) {
  int inversions = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) inversions += p[i] > p[j] ? 1 : 0;
  }
  return inversions % 2 == 0;
}

}  // namespace

OrderedFlips::OrderedFlips(const std::vector<Vec3>& points, const TetMesh& mesh)
    : points_(points), tags_(mesh.tet_tags), stamps_(mesh.tets.size(), 0) {
  const backend::Cpu cpu(1);
  WorkMesh<backend::Cpu> work = upload_mesh(cpu, mesh);
  build_adjacency(cpu, work);
  lock_interfaces(cpu, work, backend::Cpu::DeviceView<int>(cpu, mesh.tet_tags).span());
  tets_ = work.tet2vertex.download();
  adjacency_ = work.tet2tet.download();
  eta_.resize(tets_.size());
}

TetEnergy OrderedFlips::energy_of(const Tet& t) const {
  const Span<const Vec3> p = span_of(points_);
  return tet_energy(kHarmonicObjective, p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
}

double OrderedFlips::eta(const Tet& t) const {
  const TetEnergy e = energy_of(t);
  return e.certified ? e.energy : -1;
}

OrderedFlips::NewTets OrderedFlips::tets_after(const Candidate& c) {
  const auto& [a, b] = c.ends;
  const auto& [p, q, r] = c.ring;
  if (c.count == 2) return {{{{a, p, q, b}}, {{a, q, r, b}}, {{a, r, p, b}}}, 3};
  return {{{{a, p, q, r}}, {{b, p, r, q}}, {}}, 2};
}

void OrderedFlips::push_if_better(Candidate c) {
  double before = 0;
  for (int k = 0; k < c.count; ++k) {
    before += span_of(eta_)[c.tets[k]];
    c.stamps[k] = span_of(stamps_)[c.tets[k]];
  }
  const NewTets made = tets_after(c);
  double after = 0;
  for (int k = 0; k < made.count; ++k) {
    const double e = eta(made.tets[k]);
    if (e < 0 || !(after + e < before)) return;
    after += e;
  }
  c.gain = before - after;
  if (c.gain > kMinRelativeGain * before) queue_.push(c);
}

void OrderedFlips::evaluate_face(Index t, int face) {
  const HalfFace other = across(t, face);
  if (is_locked(other)) return;
  Candidate c{};
  c.count = 2;
  c.tets[0] = t;
  c.tets[1] = tet_of(other);
  c.ends[0] = tet(t)[face];
  c.ends[1] = tet(tet_of(other))[face_of(other)];
  for (int k = 0; k < 3; ++k) c.ring[k] = tet(t)[face_vertex(face, k)];
  push_if_better(c);
}

void OrderedFlips::evaluate_edge(Index t, int i, int j, Index min_tet) {
  int k = 0;
  while (k == i || k == j) ++k;
  int l = k + 1;
  while (l == i || l == j) ++l;
  if (!is_even({i, k, l, j})) std::swap(k, l);
  // Around the edge: across the face opposite k lies the second tetrahedron, across its face opposite l the third, and
  // across the last face t again if the edge has three tetrahedra.
  const Tet& first = tet(t);
  const HalfFace to_second = across(t, k);
  if (is_locked(to_second)) return;
  const Index second = tet_of(to_second);
  const HalfFace to_third = across(second, local_index(tet(second), first[l]));
  if (is_locked(to_third)) return;
  const Index third = tet_of(to_third);
  const Index r = tet(second)[face_of(to_second)];
  const HalfFace to_first = across(third, local_index(tet(third), r));
  if (is_locked(to_first) || tet_of(to_first) != t || second < min_tet || third < min_tet) return;
  push_if_better({0, {t, second, third}, {}, {first[i], first[j]}, {first[k], first[l], r}, 3});
}

void OrderedFlips::evaluate_tet(Index t) {
  for (int f = 0; f < 4; ++f) evaluate_face(t, f);
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) evaluate_edge(t, i, j, 0);
  }
}

bool OrderedFlips::is_current(const Candidate& c) const {
  for (int k = 0; k < c.count; ++k) {
    if (span_of(stamps_)[c.tets[k]] != c.stamps[k]) return false;
  }
  return true;
}

Index OrderedFlips::allocate_slot() {
  if (free_.empty()) {
    free_.push_back(to_index(tets_.size()));
    tets_.emplace_back();
    adjacency_.emplace_back();
    tags_.push_back(0);
    eta_.push_back(0);
    stamps_.push_back(0);
  }
  const Index slot = free_.back();
  free_.pop_back();
  return slot;
}

void OrderedFlips::free_slot(Index t) {
  span_of(tets_)[t] = {{-1, -1, -1, -1}};
  ++span_of(stamps_)[t];
  free_.push_back(t);
}

void OrderedFlips::store(Index slot, const Tet& tet, int tag) {
  span_of(tets_)[slot] = tet;
  span_of(tags_)[slot] = tag;
  span_of(eta_)[slot] = eta(tet);
  ++span_of(stamps_)[slot];
}

void OrderedFlips::connect(Index t, int face, HalfFace other) {
  const Span<FaceAdjacency> adjacency = span_of(adjacency_);
  adjacency[t][face] = other;
  if (other != kNoHalfFace) adjacency[tet_of(other)][face_of(other)] = make_half_face(t, face) | (other & kLocked);
}

void OrderedFlips::find_outer_faces(const Candidate& c, HalfFace (&outer)[3][2]) const {
  for (int m = 0; m < 3; ++m) {
    for (int side = 0; side < 2; ++side) {
      const Index t = c.count == 2 ? c.tets[side] : c.tets[m];
      const Index opposite = c.count == 2 ? c.ring[(m + 2) % 3] : c.ends[1 - side];
      outer[m][side] = across(t, local_index(tet(t), opposite));
    }
  }
}

void OrderedFlips::connect_outer_faces(const Candidate& c, const Index (&slots)[3], const HalfFace (&outer)[3][2]) {
  for (int m = 0; m < 3; ++m) {
    for (int side = 0; side < 2; ++side) {
      const Index slot = c.count == 2 ? slots[m] : slots[side];
      const Index opposite = c.count == 2 ? c.ends[1 - side] : c.ring[(m + 2) % 3];
      connect(slot, local_index(tet(slot), opposite), outer[m][side]);
    }
  }
}

void OrderedFlips::apply(const Candidate& c, FlipResult& result) {
  HalfFace outer[3][2];
  find_outer_faces(c, outer);
  const NewTets made = tets_after(c);
  const Index slots[3] = {c.tets[0], c.tets[1], c.count == 2 ? allocate_slot() : c.tets[2]};
  const int region = tag(c.tets[0]);
  for (int m = 0; m < made.count; ++m) store(slots[m], made.tets[m], region);
  connect_outer_faces(c, slots, outer);
  if (c.count == 2) {
    // The face of (a, p, q, b) opposite p, local vertex 1, is the face of (a, q, r, b) opposite r, local vertex 2.
    for (int m = 0; m < 3; ++m) connect(slots[m], 1, make_half_face(slots[(m + 1) % 3], 2));
    ++result.flips23;
  } else {
    connect(slots[0], 0, make_half_face(slots[1], 0));
    free_slot(slots[2]);
    ++result.flips32;
  }
  result.decrease += c.gain;
  for (int m = 0; m < made.count; ++m) evaluate_tet(slots[m]);
}

FlipResult OrderedFlips::run() {
  const Index count = to_index(tets_.size());
  // An uncertified volume counts with the large, finite energy that tet_energy() returns for it.
  for (Index t = 0; t < count; ++t) span_of(eta_)[t] = alive(t) ? energy_of(tet(t)).energy : 0;
  for (Index t = 0; t < count; ++t) {
    if (!alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      const HalfFace other = across(t, f);
      if (!is_locked(other) && t < tet_of(other)) evaluate_face(t, f);
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) evaluate_edge(t, i, j, t);
    }
  }
  FlipResult result;
  while (!queue_.empty()) {
    const Candidate c = queue_.top();
    queue_.pop();
    if (is_current(c)) apply(c, result);
  }
  return result;
}

}  // namespace tetune::reference
