// SPDX-License-Identifier: Apache-2.0
// The tags of tetrahedra by the sets of elements of a deck: each combination of sets that occurs has a tag of its own.
#include <algorithm>
#include <map>
#include <set>

#include "io/combinations.hpp"
#include "io/inp/inp_scan.hpp"
#include "io/inp/inp_tags.hpp"
#include "io/tag_numbers.hpp"

namespace tetune {
namespace {

/// Finds the sets of tetrahedra that one line of faces lists and no other card: those make no regions.
void find_auxiliary_sets(const InpScan& scan, InpModel& model) {
  std::vector<int> uses(model.sets.size(), 0);
  for (const Index s : scan.element2set) {
    if (s >= 0) uses[to_size_t(s)] = 2;
  }
  for (const InpFaceGroup& group : model.face_groups) {
    for (const InpFaceSet& use : group.sets) ++uses[to_size_t(use.set)];
  }
  const auto is_other = [&model](Index e) { return span_of(model.element2tet)[e] < 0; };
  for (const InpSetCard& card : model.set_cards) {
    if (!card.nested.empty()) uses[to_size_t(card.set)] = 2;
  }
  for (std::size_t s = 0; s < model.sets.size(); ++s) {
    InpSet& set = model.sets[s];
    set.is_auxiliary = !set.of_nodes && uses[s] == 1 && scan.mentioned.count(set.key) == 0 &&
                       std::none_of(set.members.begin(), set.members.end(), is_other);
  }
  for (InpFaceGroup& group : model.face_groups) {
    std::erase_if(group.sets, [&](const InpFaceSet& use) {
      const InpSet& set = span_of(model.sets)[use.set];
      if (set.is_auxiliary) return false;
      for (const Index e : set.members) {
        if (!is_other(e)) group.direct.push_back({e, use.face});
      }
      return true;
    });
    sort_unique(group.direct);
  }
}

class InpRegions {
 public:
  InpRegions(const InpScan& scan, InpModel& model, TetMesh& mesh) : scan_(scan), model_(model), mesh_(mesh) {}

  void make() {
    Combinations<Index> combinations;
    std::map<std::string, Index> type2member;
    std::vector<Index> combination(model_.element_labels.size(), 0);
    for (std::size_t t = 0; t < model_.tets.size(); ++t) {
      // Elements of different types are in different regions; the first type needs no tag.
      const std::string& type = span_of(model_.tet_cards)[model_.tet2card[t]].type;
      const Index member = -type2member.try_emplace(type, to_index(type2member.size())).first->second;
      if (member < 0) span_of(combination)[model_.tet2element[t]] = combinations.with(0, member);
    }
    for (std::size_t s = 0; s < model_.sets.size(); ++s) {
      const InpSet& set = model_.sets[s];
      if (set.of_nodes || set.is_auxiliary) continue;
      for (const Index e : set.members) {
        Index& c = span_of(combination)[e];
        c = combinations.with(c, to_index(s));
      }
    }
    set_tags(combinations, combination);
  }

 private:
  static bool is_solid(const InpElementType& type) { return find_element_kind(type.kind)->dimension == 3; }

  void set_tags(const Combinations<Index>& combinations, const std::vector<Index>& combination) {
    std::vector<std::vector<std::string>> names(combinations.size());
    for (std::size_t c = 0; c < names.size(); ++c) {
      for (const Index s : combinations.of(to_index(c))) {
        if (s >= 0) names[c].push_back(span_of(model_.sets)[s].name);
      }
    }
    std::vector<bool> occurs(combinations.size(), false), of_quads(occurs), of_lines(occurs);
    for (const Index e : model_.tet2element) occurs[to_size_t(span_of(combination)[e])] = true;
    for (const InpOther& other : scan_.others) {
      if (other.type.role != InpElementType::Role::block) continue;
      (is_solid(other.type) ? occurs : of_quads)[to_size_t(span_of(combination)[other.element])] = true;
    }
    for (const auto& [element, edge] : model_.lines) of_lines[to_size_t(span_of(combination)[element])] = true;
    const std::vector<int> tags = number_inp_tags(names, occurs, "Volume");
    const std::vector<int> quad_tags = number_inp_tags(names, of_quads, "Surface");
    const std::vector<int> line_tags = number_inp_tags(names, of_lines, "Line");
    for (const auto& [element, edge] : model_.lines) {
      span_of(mesh_.edge_tags)[edge] = span_of(line_tags)[span_of(combination)[element]];
    }
    mesh_.tet_tags.reserve(model_.tets.size());
    for (const Index e : model_.tet2element) mesh_.tet_tags.push_back(span_of(tags)[span_of(combination)[e]]);
    std::map<const ElementBlock*, std::size_t> next;  // element of each block
    for (const InpOther& other : scan_.others) {
      if (other.type.role != InpElementType::Role::block) continue;
      ElementBlock& block = inp_block(mesh_, other.type);
      block.tags[next[&block]++] =
          span_of(is_solid(other.type) ? tags : quad_tags)[span_of(combination)[other.element]];
    }
    add_regions(combinations, occurs, tags);
    for (std::size_t c = 1; c < names.size(); ++c) {
      for (const Index s : combinations.of(to_index(c))) {
        if (s >= 0 && of_quads[c]) span_of(model_.sets)[s].quads.push_back(quad_tags[c]);
        if (s >= 0 && of_lines[c]) span_of(model_.sets)[s].lines.push_back(line_tags[c]);
      }
    }
  }

  void add_regions(const Combinations<Index>& combinations, const std::vector<bool>& occurs,
                   const std::vector<int>& tags) {
    model_.tet_tags = mesh_.tet_tags;
    for (std::size_t c = 0; c < tags.size(); ++c) {
      if (!occurs[c]) continue;
      InpRegion region{tags[c], {}};
      for (const Index s : combinations.of(to_index(c))) {
        if (s < 0) continue;
        region.sets.push_back(s);
        span_of(model_.sets)[s].regions.push_back(region.tag);
      }
      model_.regions.push_back(std::move(region));
    }
    std::sort(model_.regions.begin(), model_.regions.end(), [](const auto& a, const auto& b) { return a.tag < b.tag; });
  }

  const InpScan& scan_;
  InpModel& model_;
  TetMesh& mesh_;
};

/// The groups of one dimension that the sets and surfaces of a deck become.
class InpGroups {
 public:
  /// Names of sets that stand for a tag begin with `start`.
  InpGroups(TetMesh& mesh, int dimension, const char* start) : mesh_(mesh), dimension_(dimension), start_(start) {}

  /// Adds the group of a set or a surface, or tags to the one of its name, unless the name says no more than the tag.
  template <class Named>
  void add(const Named& named, const std::vector<int>& tags) {
    if (tags.empty() || (tags.size() == 1 && is_inp_tag_name(named.name, start_, tags[0]))) return;
    const auto [at, is_new] = key2group_.try_emplace(named.key, mesh_.groups.size());
    if (is_new) {
      mesh_.groups.push_back({dimension_, free_number(tags), named.name, tags});
      return;
    }
    std::vector<int>& all = mesh_.groups[at->second].tags;
    all.insert(all.end(), tags.begin(), tags.end());
    sort_unique(all);
  }

 private:
  /// A number that no other group has: of one tag this tag, or the next one.
  int free_number(const std::vector<int>& tags) {
    if (tags.size() != 1 || tags[0] < 1) return numbers_.take_lowest();
    int number = tags[0];
    while (!numbers_.take(number)) ++number;
    return number;
  }

  TetMesh& mesh_;
  int dimension_;
  const char* start_;
  std::map<std::string, std::size_t> key2group_;
  FreeNumbers numbers_{{}};
};

/// The tags of the quadrilaterals in a set, but for those that a patch has too, unless a set is named for the tag: then
/// both are in one group.
std::vector<int> tags_of_quads(const InpSet& set, const InpModel& model) {
  std::vector<int> tags = set.quads;
  std::erase_if(tags, [&model](int tag) {
    const auto has_tag = [tag](const InpPatch& patch) { return patch.tag == tag; };
    const auto is_named = [tag](const InpSet& s) { return !s.of_nodes && is_inp_tag_name(s.name, "Surface", tag); };
    return std::any_of(model.patches.begin(), model.patches.end(), has_tag) &&
           std::none_of(model.sets.begin(), model.sets.end(), is_named);
  });
  return tags;
}

void add_groups(const InpModel& model, TetMesh& mesh) {
  InpGroups volumes(mesh, 3, "Volume"), patches(mesh, 2, "Surface"), lines(mesh, 1, "Line");
  for (const InpSet& set : model.sets) {
    if (!set.of_nodes) volumes.add(set, set.regions);
  }
  const std::vector<std::vector<int>> group2tags = tags_of_face_groups(model);
  std::set<std::string> taken;
  for (const InpFaceCard& card : model.face_cards) {
    if (card.name.empty()) continue;
    taken.insert(card.key);
    std::vector<int> tags;
    for (const Index g : card.groups) {
      tags.insert(tags.end(), span_of(group2tags)[g].begin(), span_of(group2tags)[g].end());
    }
    sort_unique(tags);
    patches.add(card, tags);
  }
  for (const InpSet& set : model.sets) {
    if (!set.of_nodes && !set.patches.empty() && taken.insert(set.key).second) patches.add(set, set.patches);
  }
  for (const InpSet& set : model.sets) {
    if (!set.of_nodes || !set.regions.empty() || taken.count(set.key) != 0) continue;
    patches.add(set, set.patches);
  }
  for (const InpSet& set : model.sets) {
    patches.add(set, tags_of_quads(set, model));
    lines.add(set, set.lines);
  }
}

/// Holds the sets whose nodes other cards pair or load one by one, and those nested in them. Throws FileError where
/// one of these has the nodes of elements, which change.
void hold_sets(const InpScan& scan, InpModel& model) {
  for (InpSet& set : model.sets) {
    set.is_held |= set.of_nodes && (scan.paired.count(set.key) != 0 || scan.loaded.count(set.key) != 0);
  }
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const InpSetCard& card : model.set_cards) {
      if (!span_of(model.sets)[card.set].is_held) continue;
      for (const Index s : card.nested) {
        InpSet& nested = span_of(model.sets)[s];
        is_changed |= !nested.is_held;
        nested.is_held = true;
      }
    }
  }
  for (std::size_t c = 0; c < model.set_cards.size(); ++c) {
    const InpSet& set = span_of(model.sets)[model.set_cards[c].set];
    if (!set.is_held || !model.set_cards[c].follows_elements) continue;
    const bool is_loaded = scan.loaded.count(set.key) != 0;
    scan.set_places[c].fail((is_loaded ? "a load acts on each node of the set " + set.name + ", and these nodes"
                                       : "the order of the set " + set.name + " matters, and its nodes") +
                            " would change with the elements; list them by number");
  }
}

std::vector<Index> nodes_of(const std::vector<std::int64_t>& labels, const InpModel& model) {
  std::vector<Index> nodes;
  for (const std::int64_t label : labels) {
    if (const Index node = model.node(label); node >= 0) nodes.push_back(node);
  }
  sort_unique(nodes);
  return nodes;
}

/// The nodes that other cards name by number. Not those mid-side nodes that have values of fields alone, as both ends
/// of their edge have: those of new edges get the mean of their ends, and the lines of those that are gone are left
/// out.
std::vector<Index> find_held_nodes(const InpScan& scan, const InpModel& model) {
  const std::vector<Index> by_others = nodes_of(scan.held_nodes, model);
  const std::vector<Index> with_fields = nodes_of(scan.nodes_with_fields, model);
  std::vector<Index> all;
  std::set_union(by_others.begin(), by_others.end(), with_fields.begin(), with_fields.end(), std::back_inserter(all));
  // Lines that may be continued are not interpreted.
  if (std::ranges::any_of(model.conditions, &InpCondition::may_continue)) return all;
  std::vector<Index> free;
  for (const auto& [ends, node] : model.middles) {
    const bool have_ends = is_listed(with_fields, ends[0]) && is_listed(with_fields, ends[1]);
    if (have_ends && !is_listed(by_others, node)) free.push_back(node);
  }
  sort_unique(free);
  erase_listed(all, free);
  return all;
}

/// Holds the nodes and elements that other cards name by number; warns where these are more than a quarter of all
/// nodes, as little of the mesh may change then.
void hold_labels(const InpScan& scan, const InpModel& model, TetMesh& mesh, const IoContext& context) {
  const std::vector<Index> nodes = find_held_nodes(scan, model);
  mesh.required_vertices.insert(mesh.required_vertices.end(), nodes.begin(), nodes.end());
  if (nodes.size() > mesh.points.size() / 4) {
    context.warn(std::to_string(nodes.size()) + " of " + std::to_string(mesh.points.size()) +
                 " nodes keep their place, as cards name them by number");
  }
  for (const Index element : scan.find_held_elements()) {
    const Index tet = span_of(model.element2tet)[element];
    if (tet >= 0) mesh.required_tets.push_back(tet);
  }
  sort_unique(mesh.required_vertices);
  sort_unique(mesh.required_tets);
}

}  // namespace

void partition_inp(const InpScan& scan, InpModel& model, TetMesh& mesh, const IoContext& context) {
  find_auxiliary_sets(scan, model);
  find_inp_lines(scan, model, mesh);
  InpRegions(scan, model, mesh).make();
  find_inp_triangles(scan, model, mesh);
  hold_sets(scan, model);
  find_inp_patches(scan, model, mesh, context);
  add_groups(model, mesh);
  hold_labels(scan, model, mesh, context);
}

}  // namespace tetune
