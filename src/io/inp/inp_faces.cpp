// SPDX-License-Identifier: Apache-2.0
// The faces of surfaces and loads of a deck in a mesh.
#include <algorithm>

#include "io/inp/inp_faces.hpp"
#include "mesh/listed_faces.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// A tetrahedron at a listed triangle.
struct Neighbor {
  Index triangle, tet;
  int face;  ///< as Abaqus counts
  int side;  ///< 0: the normal of the triangle points away from it
};

/// Whether (d, a, b, c) is an even permutation of a tetrahedron, so that the normal of the triangle (a, b, c) points
/// away from d.
bool points_away(const std::array<Index, 4>& tet, const std::array<Index, 3>& triangle) {
  const auto place = [&tet](Index v) { return std::find(tet.begin(), tet.end(), v) - tet.begin(); };
  const auto a = place(triangle[0]);
  const auto b = place(triangle[1]);
  const auto c = place(triangle[2]);
  const auto d = 6 - a - b - c;
  const int inversions = (d > a) + (d > b) + (d > c) + (a > b) + (a > c) + (b > c);
  return inversions % 2 == 0;
}

/// The surface or card of loads that a patch is of first, or else its elements or set of nodes.
std::string name_of(const InpModel& model, const InpPatch& patch) {
  for (const InpFaceCard& card : model.face_cards) {
    for (const InpPatchMember& member : patch.members) {
      if (std::find(card.groups.begin(), card.groups.end(), member.group) == card.groups.end()) continue;
      return card.name.empty() ? "a load on faces" : "the surface " + card.name;
    }
  }
  if (patch.card >= 0) return "*ELEMENT, TYPE=" + span_of(model.triangle_cards)[patch.card].type;
  return "a set of nodes";
}

ListedFaces<3> tagged_triangles(const InpModel& model, const TetMesh& mesh) {
  std::vector<std::pair<std::array<Index, 3>, Index>> triangles;
  std::vector<bool> occurs(model.patches.size(), false);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const int tag = mesh.triangle_tags[i];
    if (tag == 0) continue;
    const Index patch = find_inp_tag(model.patches, tag);
    if (patch < 0)
      throw FileError("a triangle has the tag " + std::to_string(tag) + ", which no surface of the deck has" +
                      kNotOfDeck);
    occurs[to_size_t(patch)] = true;
    triangles.emplace_back(mesh.triangles[i], to_index(i));
  }
  const auto missing = std::find(occurs.begin(), occurs.end(), false) - occurs.begin();
  if (missing < std::ssize(occurs)) {
    const InpPatch& patch = span_of(model.patches)[missing];
    throw FileError("the mesh has no more triangles with the tag " + std::to_string(patch.tag) + ", of which " +
                    name_of(model, patch) + " of the deck consists; optimize it with open boundaries");
  }
  return {std::move(triangles), mesh.points.size()};
}

std::vector<Neighbor> find_neighbors(const TetMesh& mesh, const InpMatch& match, const ListedFaces<3>& triangles) {
  std::vector<Neighbor> neighbors;
  for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
    triangles.find_in_tet(span_of(match.listed)[t], [&](std::size_t k, Index triangle) {
      const bool away = points_away(span_of(mesh.tets)[t], span_of(mesh.triangles)[triangle]);
      neighbors.push_back({triangle, t, kInpFaceOpposite[k], away ? 0 : 1});
    });
  }
  std::stable_sort(neighbors.begin(), neighbors.end(),
                   [](const Neighbor& a, const Neighbor& b) { return a.triangle < b.triangle; });
  return neighbors;
}

}  // namespace

std::vector<std::vector<InpLabeledFace>> find_inp_faces(const InpModel& model, const TetMesh& mesh,
                                                        const InpMatch& match) {
  std::vector<std::vector<InpLabeledFace>> faces(model.face_groups.size());
  const ListedFaces<3> triangles = tagged_triangles(model, mesh);
  const std::vector<Neighbor> neighbors = find_neighbors(mesh, match, triangles);
  std::size_t found = 0;
  for (auto at = neighbors.begin(); at != neighbors.end(); ++found) {
    const auto end = std::find_if(at, neighbors.end(), [at](const Neighbor& n) { return n.triangle != at->triangle; });
    const Index patch = find_inp_tag(model.patches, span_of(mesh.triangle_tags)[at->triangle]);
    const bool is_outer = end - at == 1;
    for (const InpPatchMember& member : span_of(model.patches)[patch].members) {
      const auto on_side = std::find_if(at, end, [&](const Neighbor& n) { return is_outer || n.side == member.side; });
      if (on_side == end)
        throw FileError(std::string("tetrahedra at a triangle of a surface of the deck are on the same side of it") +
                        kNotOfDeck);
      span_of(faces)[member.group].push_back({span_of(match.tet_labels)[on_side->tet], on_side->face});
    }
    at = end;
  }
  if (found != triangles.size()) {
    throw FileError(std::to_string(triangles.size() - found) +
                    " triangles of surfaces of the deck are no faces of tetrahedra" + kNotOfDeck);
  }
  for (std::vector<InpLabeledFace>& list : faces) sort_unique(list);
  return faces;
}

}  // namespace tetune
