// SPDX-License-Identifier: Apache-2.0
// From the surfaces of a deck, elements on faces, and sets of nodes on its boundary, to triangles with tags.
#include <algorithm>
#include <map>
#include <optional>

#include "backend/cpu.hpp"
#include "io/combinations.hpp"
#include "io/inp/inp_match.hpp"
#include "io/inp/inp_scan.hpp"
#include "io/inp/inp_tags.hpp"
#include "io/plain_text.hpp"
#include "mesh/tet.hpp"
#include "mesh/vertex_tets.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// A face of a tetrahedron by its vertices in ascending order.
struct FaceOfTet {
  std::array<Index, 3> vertices;
  Index tet;
  int opposite;
  bool operator<(const FaceOfTet& other) const { return vertices < other.vertices; }
};

/// At most this number of held nodes, or one node of this number of the mesh, is no cause for a warning.
constexpr std::size_t kFewHeld = 100;

class InpPatches {
 public:
  InpPatches(const InpScan& scan, InpModel& model, TetMesh& mesh, const IoContext& context)
      : scan_(scan), model_(model), mesh_(mesh), context_(context) {}

  void find() {
    find_reversed();
    add_elements();
    for (std::size_t g = 0; g < model_.face_groups.size(); ++g) {
      const std::vector<InpFace>& faces = model_.face_groups[g].faces;
      for (const InpFace& f : faces) {
        add(span_of(model_.element2tet)[f.element], kInpOppositeFace[to_size_t(f.face)], to_index(g));
      }
      if (!faces.empty()) vertex2groups_.emplace_back(face_of(faces[0])[0], to_index(g));
    }
    std::sort(vertex2groups_.begin(), vertex2groups_.end());
    for (std::size_t s = 0; s < model_.sets.size(); ++s) {
      if (model_.sets[s].of_nodes) cover(to_index(s));
    }
    list_triangles();
    sort_unique(held_);
    mesh_.required_vertices.insert(mesh_.required_vertices.end(), held_.begin(), held_.end());
    if (held_.size() <= std::max(kFewHeld, mesh_.points.size() / kFewHeld)) return;
    const char* const reason = !is_any_single_ ? "no region and no part of the boundary has these sets as its nodes"
                               : is_any_rest_
                                   ? "no region and no part of the boundary has these sets as its nodes, or as "
                                     "other cards take their nodes one by one"
                                   : "other cards take their nodes one by one";
    context_.warn(std::to_string(held_.size()) + " nodes of the sets " + listed_texts(names_of_held_) +
                  " keep their place, as " + reason);
  }

 private:
  /// Finds the tetrahedra that read_mesh() reverses, so that their faces have the same sides in the mesh that it
  /// returns.
  void find_reversed() {
    TetMesh oriented;
    oriented.points.swap(mesh_.points);
    oriented.point_tags.assign(oriented.points.size(), 0);
    oriented.tets = mesh_.tets;
    oriented.tet_tags.assign(oriented.tets.size(), 0);
    orient_uniformly(oriented, 1);
    oriented.points.swap(mesh_.points);
    is_reversed_.resize(oriented.tets.size());
    for (std::size_t t = 0; t < is_reversed_.size(); ++t) is_reversed_[t] = oriented.tets[t] != mesh_.tets[t];
  }

  /// A face with its vertices counter-clockwise as seen from outside a tetrahedron.
  std::array<Index, 3> outward_face(Index t, int opposite) const {
    const auto& v = span_of(mesh_.tets)[t];
    const Tet tet{{v[0], v[1], v[2], v[3]}};
    std::array<Index, 3> face{tet[face_vertex(opposite, 0)], tet[face_vertex(opposite, 1)],
                              tet[face_vertex(opposite, 2)]};
    if (is_reversed_[to_size_t(t)]) std::swap(face[1], face[2]);
    return face;
  }

  /// The numbers of sets and of *ELEMENT cards of triangles as members of combinations; those of face groups are from
  /// 0.
  static Index member_of_set(Index s) { return -1 - s; }
  Index member_of_card(Index c) const { return -1 - to_index(model_.sets.size()) - c; }
  static bool is_group(Index member) { return member >= 0; }
  bool is_set(Index member) const { return !is_group(member) && set_of(member) < std::ssize(model_.sets); }
  static Index set_of(Index member) { return -1 - member; }
  Index card_of(Index member) const { return set_of(member) - to_index(model_.sets.size()); }

  /// Adds the elements that are faces of tetrahedra, to patches by their card, the side that their normal points to,
  /// and their sets.
  void add_elements() {
    std::vector<Index> position(model_.triangles.size(), -1);
    for (std::size_t i = 0; i < position.size(); ++i) {
      const InpTriangle& t = model_.triangles[i];
      if (!t.is_face) continue;
      position[i] = to_index(triangles_.size());
      positions_.emplace(ascending(t.vertices), position[i]);
      triangles_.push_back(t.vertices);
      const std::array<Index, 3> outward = outward_face(t.tet, t.opposite);
      const auto first = to_size_t(std::find(outward.begin(), outward.end(), t.vertices[0]) - outward.begin());
      const int side = outward[(first + 1) % 3] == t.vertices[1] ? 0 : 1;
      combination_.push_back(combinations_.with(0, {member_of_card(t.card), side}));
      elements_.push_back(to_index(i));
    }
    for (Index s = 0; s < std::ssize(model_.sets) && !elements_.empty(); ++s) {
      if (span_of(model_.sets)[s].of_nodes) continue;
      for (const Index e : span_of(model_.sets)[s].members) {
        const Index i = model_.triangle(e);
        if (i < 0 || span_of(position)[i] < 0) continue;
        Index& combination = span_of(combination_)[span_of(position)[i]];
        combination = combinations_.with(combination, {member_of_set(s), 0});
      }
    }
  }

  /// Adds a face to a patch: of a face group or of a set of nodes. The faces of a group have a side, those of a set
  /// have none.
  void add(Index tet, int opposite, Index member) {
    const std::array<Index, 3> face = outward_face(tet, opposite);
    std::array<Index, 3> key = face;
    std::sort(key.begin(), key.end());
    const auto [at, is_new] = positions_.try_emplace(key, to_index(triangles_.size()));
    if (is_new) {
      triangles_.push_back(face);
      combination_.push_back(0);
    }
    const auto& listed = span_of(triangles_)[at->second];
    const auto first = to_size_t(std::find(listed.begin(), listed.end(), face[0]) - listed.begin());
    const bool has_side = is_group(member);
    const bool same_sense = listed[(first + 1) % 3] == face[1];
    Index& combination = span_of(combination_)[at->second];
    combination = combinations_.with(combination, {member, has_side && !same_sense ? 1 : 0});
  }

  // Sets of nodes.

  /// The tetrahedra at each vertex, found for the first set that needs them.
  const VertexTets& vertex2tets() {
    if (!vertex2tets_) vertex2tets_.emplace(cpu_, mesh_);
    return *vertex2tets_;
  }

  /// Finds the regions and the parts of the boundary whose vertices a set has; other vertices of tetrahedra are held.
  void cover(Index s) {
    InpSet& set = span_of(model_.sets)[s];
    const auto follows = [this](Index card) { return span_of(model_.set_cards)[card].follows_elements; };
    const bool has_cards = !set.cards.empty();
    if (has_cards && std::all_of(set.cards.begin(), set.cards.end(), follows)) return;
    mark_.resize(mesh_.points.size(), kOutside);
    for (const Index v : set.members) span_of(mark_)[v] = kInSet;
    if (!set.is_held) {
      find_regions(set);
      take_groups(set);
      add_faces(faces_in(set), s);
    }
    hold_rest(set);
    for (const Index v : set.members) span_of(mark_)[v] = kOutside;
  }
  bool is_outside(Index v) const { return span_of(mark_)[v] == kOutside; }
  bool is_uncovered(Index v) const { return span_of(mark_)[v] == kInSet; }

  /// Sets the regions with all vertices in a set, and marks these as covered.
  void find_regions(InpSet& set) {
    find_region_of_tets();
    std::map<Index, std::size_t> tets_inside;  // by region
    for_each_tet_inside(set, [&](Index t) { ++tets_inside[span_of(tet2region_)[t]]; });
    std::erase_if(tets_inside,
                  [this](const auto& entry) { return entry.second < span_of(tets_of_region_)[entry.first]; });
    if (tets_inside.empty()) return;
    for (const auto& [region, tets] : tets_inside) set.regions.push_back(span_of(model_.regions)[region].tag);
    for_each_tet_inside(set, [&](Index t) {
      if (!tets_inside.contains(span_of(tet2region_)[t])) return;
      for (const Index v : span_of(mesh_.tets)[t]) span_of(mark_)[v] = kCovered;
    });
  }
  /// Calls f(tetrahedron) for those with all vertices in a set.
  template <class F>
  void for_each_tet_inside(const InpSet& set, const F& f) {
    const auto is_inside = [this](const std::array<Index, 4>& tet) {
      return std::none_of(tet.begin(), tet.end(), [this](Index v) { return is_outside(v); });
    };
    if (set.members.size() > mesh_.tets.size() / kTetsPerMember) {
      for (Index t = 0; t < std::ssize(mesh_.tets); ++t) {
        if (is_inside(span_of(mesh_.tets)[t])) f(t);
      }
      return;
    }
    for (const Index v : set.members) {
      for (const Index t : vertex2tets().of(v)) {
        const auto& tet = span_of(mesh_.tets)[t];
        const bool is_first = v == *std::min_element(tet.begin(), tet.end());
        if (is_first && is_inside(tet)) f(t);
      }
    }
  }
  void find_region_of_tets() {
    if (!tet2region_.empty()) return;
    tets_of_region_.assign(model_.regions.size(), 0);
    tet2region_.reserve(mesh_.tets.size());
    Index region = -1;
    for (const int tag : mesh_.tet_tags) {
      if (region < 0 || span_of(model_.regions)[region].tag != tag) region = find_inp_tag(model_.regions, tag);
      tet2region_.push_back(region);
      ++span_of(tets_of_region_)[region];
    }
  }

  /// Takes the face groups with all vertices in a set.
  void take_groups(InpSet& set) {
    std::vector<Index> candidates;
    for (const Index v : set.members) {
      auto at = std::lower_bound(vertex2groups_.begin(), vertex2groups_.end(), std::pair{v, Index{-1}});
      for (; at != vertex2groups_.end() && at->first == v; ++at) candidates.push_back(at->second);
    }
    std::sort(candidates.begin(), candidates.end());
    for (const Index g : candidates) {
      const std::vector<InpFace>& faces = span_of(model_.face_groups)[g].faces;
      const auto is_in_set = [this](const InpFace& f) {
        const auto face = face_of(f);
        return std::none_of(face.begin(), face.end(), [this](Index v) { return is_outside(v); });
      };
      if (!std::all_of(faces.begin(), faces.end(), is_in_set)) continue;
      set.groups.push_back(g);
      for (const InpFace& f : faces) {
        for (const Index v : face_of(f)) span_of(mark_)[v] = kCovered;
      }
    }
  }
  std::array<Index, 3> face_of(const InpFace& f) const {
    return outward_face(span_of(model_.element2tet)[f.element], kInpOppositeFace[to_size_t(f.face)]);
  }

  /// The faces with all vertices in a set and one of them not covered yet, sorted.
  std::vector<FaceOfTet> faces_in(const InpSet& set) {
    std::vector<FaceOfTet> faces;
    for (const Index v : set.members) {
      if (!is_uncovered(v)) continue;
      for (const Index t : vertex2tets().of(v)) add_faces_of(t, v, faces);
    }
    std::sort(faces.begin(), faces.end());
    return faces;
  }
  /// Adds the faces of a tetrahedron that are in the set and have v as their first vertex that is not covered.
  void add_faces_of(Index t, Index v, std::vector<FaceOfTet>& faces) const {
    const auto& tet = span_of(mesh_.tets)[t];
    for (std::size_t k = 0; k < 4; ++k) {
      const std::array<Index, 3> face = ascending_face(tet, k);
      if (std::any_of(face.begin(), face.end(), [this](Index u) { return is_outside(u); })) continue;
      const auto first = std::find_if(face.begin(), face.end(), [this](Index u) { return is_uncovered(u); });
      if (first == face.end() || *first != v) continue;
      faces.push_back({face, t, int(k)});
    }
  }
  /// Adds those of the faces that are on the boundary or between regions.
  void add_faces(const std::vector<FaceOfTet>& faces, Index set) {
    std::vector<Index> reached;
    for (auto face = faces.begin(); face != faces.end();) {
      const auto next = std::find_if(face, faces.end(), [face](const FaceOfTet& f) { return *face < f; });
      const auto tag_of = [this](const FaceOfTet& f) { return span_of(mesh_.tet_tags)[f.tet]; };
      if (next - face != 2 || tag_of(face[0]) != tag_of(face[1])) {
        add(face->tet, face->opposite, member_of_set(set));
        reached.insert(reached.end(), face->vertices.begin(), face->vertices.end());
      }
      face = next;
    }
    for (const Index v : reached) span_of(mark_)[v] = kCovered;
  }
  void hold_rest(InpSet& set) {
    const std::size_t before = held_.size();
    for (const Index v : set.members) {
      if (is_uncovered(v) && !vertex2tets().of(v).empty()) held_.push_back(v);
    }
    if (!set.is_held) set.rest.assign(held_.begin() + std::ptrdiff_t(before), held_.end());
    if (held_.size() == before) return;
    (set.is_held ? is_any_single_ : is_any_rest_) = true;
    names_of_held_.push_back(set.name);
  }

  // Tags and triangles of the mesh.

  void list_triangles() {
    std::vector<std::string> group_names(model_.face_groups.size());
    for (const InpFaceCard& card : model_.face_cards) {
      for (const Index g : card.groups) span_of(group_names)[g] = card.name;
    }
    std::vector<std::vector<std::string>> names(combinations_.size());
    std::vector<bool> occurs(combinations_.size(), false);
    for (const Index c : combination_) occurs[to_size_t(c)] = true;
    for (std::size_t c = 0; c < names.size(); ++c) {
      for (const InpPatchMember& m : combinations_.of(to_index(c))) {
        if (is_group(m.group)) names[c].push_back(span_of(group_names)[m.group]);
        if (is_set(m.group)) names[c].push_back(span_of(model_.sets)[set_of(m.group)].name);
      }
    }
    const std::vector<int> tags = number_inp_tags(names, occurs, "Surface");
    for (std::size_t c = 1; c < tags.size(); ++c) {
      if (occurs[c]) add_patch(to_index(c), tags[c]);
    }
    std::sort(model_.patches.begin(), model_.patches.end(), [](const auto& a, const auto& b) { return a.tag < b.tag; });
    take_patches_of_groups();
    mesh_.triangles.insert(mesh_.triangles.end(), triangles_.begin(), triangles_.end());
    for (const Index c : combination_) mesh_.triangle_tags.push_back(span_of(tags)[c]);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      span_of(model_.triangles)[elements_[i]].tag = span_of(tags)[combination_[i]];
    }
  }
  void add_patch(Index combination, int tag) {
    InpPatch patch{tag};
    for (const InpPatchMember& m : combinations_.of(combination)) {
      if (is_group(m.group)) {
        patch.members.push_back(m);
      } else if (is_set(m.group)) {
        InpSet& set = span_of(model_.sets)[set_of(m.group)];
        set.patches.push_back(tag);
        if (!set.of_nodes) patch.sets.push_back(set_of(m.group));
      } else {
        patch.card = card_of(m.group);
      }
    }
    model_.patches.push_back(std::move(patch));
  }

  /// A set with the vertices of a face group has those of its patches.
  void take_patches_of_groups() {
    const std::vector<std::vector<int>> group2tags = tags_of_face_groups(model_);
    for (InpSet& set : model_.sets) {
      for (const Index g : set.groups) {
        const std::vector<int>& tags = span_of(group2tags)[g];
        set.patches.insert(set.patches.end(), tags.begin(), tags.end());
      }
      sort_unique(set.patches);
    }
  }

  /// A set of more than one vertex per this number of tetrahedra is searched by a pass over all of them.
  static constexpr std::size_t kTetsPerMember = 16;
  static constexpr std::uint8_t kOutside = 0, kInSet = 1, kCovered = 2;

  const InpScan& scan_;
  InpModel& model_;
  TetMesh& mesh_;
  const IoContext& context_;

  Combinations<InpPatchMember> combinations_;
  std::vector<bool> is_reversed_;                    ///< per tetrahedron
  std::map<std::array<Index, 3>, Index> positions_;  ///< of triangles, by their vertices in ascending order
  std::vector<std::array<Index, 3>> triangles_;
  std::vector<Index> combination_;  ///< per triangle
  std::vector<Index> elements_;     ///< of the first triangles: positions in InpModel::triangles

  /// Face groups by a vertex of their first face, ascending.
  std::vector<std::pair<Index, Index>> vertex2groups_;
  backend::Cpu cpu_{1};
  std::optional<VertexTets> vertex2tets_;
  std::vector<Index> tet2region_;            ///< positions in InpModel::regions
  std::vector<std::size_t> tets_of_region_;  ///< numbers of tetrahedra
  std::vector<std::uint8_t> mark_;
  std::vector<Index> held_;
  std::vector<std::string> names_of_held_;
  /// Whether some of these sets are held as a whole; and whether some have nodes beside those of regions and patches.
  bool is_any_single_ = false, is_any_rest_ = false;
};

}  // namespace

std::vector<std::vector<int>> tags_of_face_groups(const InpModel& model) {
  std::vector<std::vector<int>> group2tags(model.face_groups.size());
  for (const InpPatch& patch : model.patches) {
    for (const InpPatchMember& m : patch.members) span_of(group2tags)[m.group].push_back(patch.tag);
  }
  return group2tags;
}

void find_inp_patches(const InpScan& scan, InpModel& model, TetMesh& mesh, const IoContext& context) {
  InpPatches(scan, model, mesh, context).find();
}

}  // namespace tetune
