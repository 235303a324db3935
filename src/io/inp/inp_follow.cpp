// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_follow.hpp"
#include "io/inp/inp_format.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "io/inp/inp_conditions.hpp"
#include "io/inp/inp_faces.hpp"
#include "io/inp/inp_inserted.hpp"

namespace tetune {
namespace {

bool has(const std::vector<Index>& items, Index item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

/// A keyword line without GENERATE, and before it the comments between the lines that continue it.
std::string without_generate(std::string_view written, const char* newline) {
  std::string head, comments, text;
  for (std::size_t start = 0; start < written.size();) {
    const std::size_t end = std::min(written.find('\n', start), written.size() - 1) + 1;
    const std::string_view line = written.substr(start, end - start);
    const std::size_t first = line.find_first_not_of(" \t");
    const bool is_comment = first != std::string_view::npos && line.substr(first).starts_with("**");
    (is_comment ? comments : head) += line;
    start = end;
  }
  for (std::size_t start = 0; start <= head.size();) {
    const std::size_t comma = std::min(head.find(',', start), head.size());
    const std::string_view part = std::string_view(head).substr(start, comma - start);
    if (inp_name(part) != "GENERATE") text.append(text.empty() ? "" : ",").append(part);
    start = comma + 1;
  }
  while (text.ends_with('\n') || text.ends_with('\r')) text.pop_back();
  return comments + text + newline;
}

class InpFollower {
 public:
  InpFollower(const InpModel& model, const TetMesh& mesh, const InpMatch& match, const Middles* middles)
      : model_(model), mesh_(mesh), match_(match), middles_(middles), additions_(model.sets.size()) {}

  InpChanges follow(const IoContext& context) {
    inserted_ = find_inp_inserted(model_, mesh_, match_, middles_);
    faces_ = find_inp_faces(model_, mesh_, match_);
    follow_faces();
    add_elements();
    add_nodes();
    changes_.conditions = extend_inp_conditions(model_, match_, inserted_, sets_of_, context);
    for (std::size_t c = 0; c < model_.set_cards.size(); ++c) changes_.set_cards.push_back(set_card(c));
    return std::move(changes_);
  }

 private:
  void follow_faces() {
    for (const InpFaceCard& card : model_.face_cards) {
      std::string text = std::string(card.head) + card.other_lines;
      bool is_same = true;
      for (const Index g : card.groups) {
        const InpFaceGroup& group = span_of(model_.face_groups)[g];
        const std::vector<InpLabeledFace> before = labeled(group.direct);
        const std::vector<InpLabeledFace> after = direct_faces(group, before, span_of(faces_)[g]);
        is_same = is_same && before == after;
        collect_members(group, after, span_of(faces_)[g]);
        for (const InpFaceSet& use : group.sets) {
          // Without elements the cards of the set are left out.
          const bool has_members = auxiliary_members_.count(use.set) != 0;
          if (has_members) text += use.line;
          is_same = is_same && has_members;
        }
        for (const InpLabeledFace& f : after) {
          text += model_.reference(f.element, card.in_assembly) + group.before + std::to_string(f.face) + group.after +
                  model_.newline;
        }
      }
      changes_.face_cards.emplace_back();
      if (!is_same) changes_.face_cards.back() = std::move(text);
    }
  }
  std::vector<InpLabeledFace> labeled(const std::vector<InpFace>& faces) const {
    std::vector<InpLabeledFace> list;
    for (const InpFace& f : faces) list.push_back({span_of(model_.element_labels)[f.element], f.face});
    std::sort(list.begin(), list.end());
    return list;
  }
  /// The faces of a group that are listed one by one: those of no set, and those that were before.
  static std::vector<InpLabeledFace> direct_faces(const InpFaceGroup& group, const std::vector<InpLabeledFace>& before,
                                                  const std::vector<InpLabeledFace>& faces) {
    std::vector<InpLabeledFace> direct;
    for (const InpLabeledFace& f : faces) {
      const bool has_set =
          std::any_of(group.sets.begin(), group.sets.end(), [&f](const InpFaceSet& use) { return use.face == f.face; });
      if (!has_set || std::binary_search(before.begin(), before.end(), f)) direct.push_back(f);
    }
    return direct;
  }
  /// Finds the members of the auxiliary sets of a group: an element stays in its set, a new one joins the first.
  void collect_members(const InpFaceGroup& group, const std::vector<InpLabeledFace>& direct,
                       const std::vector<InpLabeledFace>& faces) {
    for (const InpLabeledFace& f : faces) {
      const Index element = model_.element(f.element);  // -1 for a new number
      Index first = -1;
      Index own = -1;
      for (const InpFaceSet& use : group.sets) {
        const std::vector<Index>& old = span_of(model_.sets)[use.set].members;
        if (use.face != f.face) continue;
        if (first < 0) first = use.set;
        if (std::binary_search(old.begin(), old.end(), element)) own = use.set;
      }
      if (own < 0 && !std::binary_search(direct.begin(), direct.end(), f)) own = first;
      if (own >= 0) auxiliary_members_[own].insert(f.element);
    }
  }

  /// Whether a card of the set lists one of these sets by name.
  bool nests_one_of(const InpSet& set, const std::vector<Index>& sets) const {
    return std::any_of(set.cards.begin(), set.cards.end(), [&](Index c) {
      const std::vector<Index>& nested = span_of(model_.set_cards)[c].nested;
      return std::any_of(nested.begin(), nested.end(), [&sets](Index s) { return has(sets, s); });
    });
  }
  /// Adds an entity to those of the sets that do not have it by their name in its own card or in other sets.
  void add(std::int64_t label, const std::vector<Index>& sets, Index set_of_card) {
    for (const Index s : sets) {
      if (s == set_of_card || nests_one_of(span_of(model_.sets)[s], sets)) continue;
      span_of(additions_)[s].push_back(label);
    }
  }
  /// The last card of the set that lists something, so that more can be added to it; -1 where there is none.
  Index last_card(const InpSet& set) const {
    for (auto c = set.cards.rbegin(); c != set.cards.rend(); ++c) {
      if (!span_of(model_.set_cards)[*c].follows_elements) return *c;
    }
    return -1;
  }
  /// The cards of sets that have none of their own.
  std::string further_cards(const std::vector<Index>& sets) {
    std::string text;
    for (const Index s : sets) {
      std::vector<std::int64_t>& labels = span_of(additions_)[s];
      const InpSet& set = span_of(model_.sets)[s];
      if (labels.empty() || last_card(set) >= 0) continue;
      text += set.parameters + model_.newline;
      append_inp_labels(text, labels, model_.newline);
      labels.clear();
    }
    return text;
  }

  /// Adds elements with new numbers to the sets of the regions or patches of their tags. Returns the further cards
  /// after each of the cards.
  template <class Regions>
  std::vector<std::string> add_elements(const std::vector<std::vector<Index>>& added,
                                        const std::vector<InpEntityCard>& cards,
                                        const std::vector<std::int64_t>& labels, const std::vector<int>& tags,
                                        const Regions& regions) {
    std::vector<std::string> texts;
    for (std::size_t c = 0; c < added.size(); ++c) {
      std::set<Index> sets;
      for (const Index i : added[c]) {
        const auto& region = span_of(regions)[find_inp_tag(regions, span_of(tags)[i])];
        add(span_of(labels)[i], region.sets, cards[c].set);
        sets.insert(region.sets.begin(), region.sets.end());
      }
      texts.push_back(further_cards({sets.begin(), sets.end()}));
    }
    return texts;
  }
  void add_elements() {
    changes_.cards_after_tets =
        add_elements(match_.added, model_.tet_cards, match_.tet_labels, mesh_.tet_tags, model_.regions);
    changes_.cards_after_triangles = add_elements(match_.added_triangles, model_.triangle_cards, match_.triangle_labels,
                                                  mesh_.triangle_tags, model_.patches);
  }

  void add_nodes() {
    std::vector<Index> vertex2inserted(mesh_.points.size(), -1);
    for (std::size_t i = 0; i < match_.inserted.size(); ++i) span_of(vertex2inserted)[match_.inserted[i]] = to_index(i);
    std::vector<std::set<int>> regions(match_.inserted.size()), patches(match_.inserted.size());
    const auto collect = [&](const auto& elements, const std::vector<int>& tags, std::vector<std::set<int>>& of,
                             const auto& edges) {
      for (std::size_t i = 0; i < elements.size(); ++i) {
        for (const Index v : elements[i]) {
          if (const Index n = span_of(vertex2inserted)[v]; n >= 0) span_of(of)[n].insert(tags[i]);
        }
        if (middles_ == nullptr || !middles_->has(elements[i])) continue;
        for (const auto& [a, b] : edges) {
          const Index v = middles_->of(elements[i][to_size_t(a)], elements[i][to_size_t(b)]);
          if (const Index n = span_of(vertex2inserted)[v]; n >= 0) span_of(of)[n].insert(tags[i]);
        }
      }
    };
    if (match_.inserted.empty()) return;
    collect(mesh_.tets, mesh_.tet_tags, regions, kTetEdges);
    collect(mesh_.triangles, mesh_.triangle_tags, patches, kTriangleEdges);
    const Index set_of_card = model_.node_cards.back().set;
    sets_of_.resize(match_.inserted.size());
    for (Index s = 0; s < std::ssize(model_.sets); ++s) {
      const InpSet& set = span_of(model_.sets)[s];
      for (const Index node : set.rest) sets_of_rest_.emplace_back(node, s);
      if (set.of_nodes && !(set.regions.empty() && set.patches.empty())) sets_of_tags_.push_back(s);
    }
    sort_unique(sets_of_rest_);
    changes_.appends_nodes = true;
    for (std::size_t i = 0; i < sets_of_.size(); ++i) {
      sets_of_[i] = sets_with(regions[i], patches[i], middles_ != nullptr && middles_->is_middle(match_.inserted[i]));
      join_sets(i, vertex2inserted);
      if (set_of_card >= 0 && !has(sets_of_[i], set_of_card)) changes_.appends_nodes = false;
    }
    std::set<Index> all;
    for (std::size_t i = 0; i < sets_of_.size(); ++i) {
      const std::int64_t label = span_of(match_.vertex_labels)[match_.inserted[i]];
      add(label, sets_of_[i], changes_.appends_nodes ? set_of_card : -1);
      all.insert(sets_of_[i].begin(), sets_of_[i].end());
    }
    changes_.cards_after_nodes = further_cards({all.begin(), all.end()});
  }
  /// The sets that can have an inserted node by its place, ascending: decks have thousands of sets of a node.
  std::vector<Index> candidates(const InpInserted& node, const std::vector<Index>& vertex2inserted) const {
    std::vector<Index> sets;
    for (const Index v : node.support) {
      auto at = std::lower_bound(sets_of_rest_.begin(), sets_of_rest_.end(), std::pair(v, Index{-1}));
      for (; at != sets_of_rest_.end() && at->first == v; ++at) sets.push_back(at->second);
    }
    for (const Index v : node.ends) {
      const Index n = v < 0 ? -1 : span_of(vertex2inserted)[v];
      if (n >= 0) sets.insert(sets.end(), span_of(sets_of_)[n].begin(), span_of(sets_of_)[n].end());
    }
    sort_unique(sets);
    return sets;
  }
  /// Adds the sets that have nodes beside their regions and patches and that an inserted node joins by its place.
  void join_sets(std::size_t i, const std::vector<Index>& vertex2inserted) {
    if (inserted_.empty()) return;
    const InpInserted& node = inserted_[i];
    for (const Index s : candidates(node, vertex2inserted)) {
      const InpSet& set = span_of(model_.sets)[s];
      if (set.rest.empty() || has(sets_of_[i], s)) continue;
      const auto is_member = [&set](Index v) { return is_listed(set.members, v); };
      const auto is_of_rest = [&set](Index v) { return is_listed(set.rest, v); };
      const auto has_end = [&](Index v) {
        const Index n = span_of(vertex2inserted)[v];
        return n >= 0 ? has(span_of(sets_of_)[n], s) : is_member(span_of(match_.vertex2node)[v]);
      };
      const bool joins = node.is_middle() ? !set.middles.empty() && node.has_inserted_end && !node.is_across &&
                                                std::all_of(node.ends.begin(), node.ends.end(), has_end)
                                          : std::all_of(node.support.begin(), node.support.end(), is_member) &&
                                                std::any_of(node.support.begin(), node.support.end(), is_of_rest);
      if (joins) sets_of_[i].push_back(s);
    }
  }
  /// The sets of nodes that have all vertices of one of these regions or patches.
  std::vector<Index> sets_with(const std::set<int>& regions, const std::set<int>& patches, bool is_middle) const {
    std::vector<Index> sets;
    for (const Index s : sets_of_tags_) {
      const InpSet& set = span_of(model_.sets)[s];
      const auto any_of = [](const std::vector<int>& tags, const std::set<int>& found) {
        return std::any_of(tags.begin(), tags.end(), [&found](int tag) { return found.count(tag) != 0; });
      };
      if (is_middle && !set.adds_middles) continue;
      if (any_of(set.regions, regions) || any_of(set.patches, patches)) sets.push_back(s);
    }
    return sets;
  }

  /// Whether the mesh has an element with the number of this one.
  bool has_element(Index element) const {
    if (const Index t = span_of(model_.element2tet)[element]; t >= 0) return span_of(match_.old2tet)[t] >= 0;
    const Index triangle = model_.triangle(element);
    return triangle < 0 || !span_of(model_.triangles)[triangle].is_face || span_of(match_.old2triangle)[triangle] >= 0;
  }

  std::optional<std::string> set_card(std::size_t c) {
    const InpSetCard& card = model_.set_cards[c];
    const InpSet& set = span_of(model_.sets)[card.set];
    if (card.follows_elements) return {};
    std::vector<std::int64_t> labels;
    for (const Index member : card.members) {
      const std::int64_t label =
          set.of_nodes ? span_of(model_.node_labels)[member] : span_of(model_.element_labels)[member];
      const bool stays = set.of_nodes       ? span_of(match_.node2vertex)[member] >= 0
                         : set.is_auxiliary ? auxiliary_members_[card.set].count(label) != 0
                                            : has_element(member);
      if (stays) labels.push_back(label);
    }
    bool is_same = labels.size() == card.members.size();
    if (to_index(c) == last_card(set)) {
      std::vector<std::int64_t>& more = span_of(additions_)[card.set];
      if (set.is_auxiliary) {
        std::set<std::int64_t> joining = auxiliary_members_[card.set];
        for (const Index member : set.members) joining.erase(span_of(model_.element_labels)[member]);
        more.assign(joining.begin(), joining.end());
      }
      is_same = is_same && more.empty();
      labels.insert(labels.end(), more.begin(), more.end());
    }
    if (is_same) return {};
    if (labels.empty() && card.names.empty()) return "";
    std::string text = without_generate(card.head, model_.newline);
    for (const std::string& name : card.names) text += name + "," + model_.newline;
    append_inp_labels(text, labels, model_.newline);
    return text;
  }

  const InpModel& model_;
  const TetMesh& mesh_;
  const InpMatch& match_;
  const Middles* middles_;
  std::map<Index, std::set<std::int64_t>> auxiliary_members_;  ///< numbers of elements, by set
  std::vector<std::vector<InpLabeledFace>> faces_;             ///< per face group
  std::vector<InpInserted> inserted_;                          ///< per inserted node
  std::vector<std::vector<Index>> sets_of_;                    ///< per inserted node
  std::vector<std::vector<std::int64_t>> additions_;           ///< per set
  std::vector<std::pair<Index, Index>> sets_of_rest_;          ///< by their InpSet::rest: a node, a set
  std::vector<Index> sets_of_tags_;                            ///< those of nodes with regions or patches, ascending
  InpChanges changes_;
};

}  // namespace

InpChanges follow_inp(const InpModel& model, const TetMesh& mesh, const InpMatch& match, const Middles* middles,
                      const IoContext& context) {
  return InpFollower(model, mesh, match, middles).follow(context);
}

}  // namespace tetune
