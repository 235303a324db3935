// SPDX-License-Identifier: Apache-2.0
#include "phases/restart/neighborhood_finder.hpp"

#include <algorithm>

namespace tetune {

NeighborhoodFinder::NeighborhoodFinder(const HostWork& whole) : whole_(whole) {
  grow();
  for (Index t = 0; t < whole.slots(); ++t) count_tet(t, 1);
}

void NeighborhoodFinder::grow() {
  is_found_.resize(whole_.tet2vertex.size(), 0);
  ring_.resize(whole_.points.size(), FoundTets::kNoRing);
  tets_at_.resize(whole_.points.size(), 0);
  found_.resize(whole_.points.size(), 0);
}

void NeighborhoodFinder::count_tet(Index slot, int sign) {
  if (slot < 0 || !whole_.alive(slot)) return;
  for (int k = 0; k < 4; ++k) span_of(tets_at_)[span_of(whole_.tet2vertex)[slot][k]] += sign;
}

void NeighborhoodFinder::count_tets(const std::vector<Index>& slots, int sign) {
  grow();
  for (const Index t : slots) count_tet(t, sign);
}

void NeighborhoodFinder::clear() {
  for (const Index t : tets_) span_of(is_found_)[t] = 0;
  for (const Index v : vertices_) {
    span_of(ring_)[v] = FoundTets::kNoRing;
    span_of(found_)[v] = 0;
  }
  tets_.clear();
  vertices_.clear();
}

void NeighborhoodFinder::add(Index slot) {
  span_of(is_found_)[slot] = 1;
  tets_.push_back(slot);
  for (int k = 0; k < 4; ++k) {
    const Index v = span_of(whole_.tet2vertex)[slot][k];
    if (span_of(found_)[v]++ == 0) vertices_.push_back(v);
  }
}

bool NeighborhoodFinder::reaches(Index slot, int ring) const {
  const Tet& tet = span_of(whole_.tet2vertex)[slot];
  const Span<const std::uint8_t> rings = span_of(ring_);
  return rings[tet[0]] <= ring || rings[tet[1]] <= ring || rings[tet[2]] <= ring || rings[tet[3]] <= ring;
}

void NeighborhoodFinder::find(Index slot, int rings) {
  clear();
  add(slot);
  for (int ring = 0; ring <= rings; ++ring) {
    // The vertices without a number are those of this ring.
    for (const Index v : vertices_) {
      std::uint8_t& number = span_of(ring_)[v];
      if (number == FoundTets::kNoRing) number = std::uint8_t(ring);
    }
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const FaceAdjacency links = span_of(whole_.tet2tet)[tets_[i]];
      for (const HalfFace across : links.across) {
        if (across == kNoHalfFace) continue;
        const Index next = tet_of(across);
        if (span_of(is_found_)[next] == 0 && reaches(next, ring)) add(next);
      }
    }
  }
}

bool NeighborhoodFinder::touches(const std::vector<std::uint8_t>& flags) const {
  return std::any_of(tets_.begin(), tets_.end(), [&](Index t) {
    const FaceAdjacency links = span_of(whole_.tet2tet)[t];
    return span_of(flags)[t] != 0 || std::any_of(links.across, links.across + 4, [&](HalfFace across) {
             return across != kNoHalfFace && span_of(flags)[tet_of(across)] != 0;
           });
  });
}

bool NeighborhoodFinder::has_vertex_of(const std::vector<std::uint8_t>& flags) const {
  return std::any_of(vertices_.begin(), vertices_.end(), [&](Index v) { return span_of(flags)[v] != 0; });
}

void NeighborhoodFinder::flag_vertices(std::vector<std::uint8_t>& flags) const {
  for (const Index v : vertices_) span_of(flags)[v] = 1;
}

FoundTets NeighborhoodFinder::found() const {
  FoundTets found{tets_, {}};
  found.vertices.reserve(vertices_.size());
  for (const Index v : vertices_) {
    const bool has_all_tets = span_of(found_)[v] == span_of(tets_at_)[v];
    found.vertices.push_back({v, has_all_tets ? span_of(ring_)[v] : FoundTets::kNoRing});
  }
  return found;
}

}  // namespace tetune
