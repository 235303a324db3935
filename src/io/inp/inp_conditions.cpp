// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "io/inp/inp_format.hpp"
#include "io/real_field.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

using ConditionKind = InpCardKind::Condition;
using ValueFields = std::vector<std::string>;

/// The fields of a node for one component or degree of freedom.
struct NodeValue {
  ValueFields values;
  Index line = -1;  ///< of the condition; -1: one that is appended
};
/// The values of a node by component or degree of freedom, or by a text in the place of these, as "ENCASTRE".
using NodeValues = std::map<std::string, NodeValue>;

/// The last degree of freedom that a line can name; larger numbers are kept as text.
constexpr std::int64_t kMaxFreedom = 99;

/// Keys that are numbers are sorted by these.
std::string freedom_key(std::int64_t number) {
  std::string key(number < 10 ? 1 : 0, '0');
  return key += std::to_string(number);
}

/// The fields from one on, as text.
ValueFields fields_from(const std::vector<std::string_view>& fields, std::size_t first) {
  ValueFields values;
  for (std::size_t k = first; k < fields.size(); ++k) values.emplace_back(fields[k]);
  return values;
}

class InpConditionReader {
 public:
  explicit InpConditionReader(ConditionKind kind) : kind_(kind) {}
  /// Calls take(key, values) for the values that a line gives.
  template <class Take>
  void read(std::string_view line, const Take& take) const {
    const std::vector<std::string_view> fields = inp_fields(line);
    // The area of a node of a surface is its own: with one more the total would grow.
    if (kind_ == ConditionKind::members && fields.size() > 1) return;
    if (kind_ == ConditionKind::field || kind_ == ConditionKind::members)
      return take(std::string(), fields_from(fields, 1));
    if (fields.size() < 2) return;
    const std::size_t first_value = kind_ == ConditionKind::range ? 3 : 2;
    std::int64_t first = 0;
    if (!parse_inp_integer(fields[1], first) || first < 0 || first > kMaxFreedom) {
      return take(inp_name(fields[1]), fields_from(fields, first_value));
    }
    std::int64_t last = first;
    if (kind_ == ConditionKind::range && fields.size() > 2) parse_inp_integer(fields[2], last);
    for (std::int64_t key = first; key <= std::min(std::max(first, last), kMaxFreedom); ++key) {
      take(freedom_key(key), fields_from(fields, first_value));
    }
  }
  /// Appends the lines of a node, which is named by `reference`.
  void append(std::string& out, const std::string& reference, const NodeValues& entries, const char* newline) const {
    for (auto at = entries.begin(); at != entries.end();) {
      auto last = at;
      while (kind_ == ConditionKind::range && std::next(last) != entries.end() && is_next(*last, *std::next(last)))
        ++last;
      out += reference;
      std::int64_t number = 0;
      const bool is_number = parse_inp_integer(at->first, number);
      if (!at->first.empty()) out += ", " + (is_number ? std::to_string(number) : at->first);
      if (kind_ == ConditionKind::range && is_number) {
        parse_inp_integer(last->first, number);
        out += ", " + std::to_string(number);
      } else if (kind_ == ConditionKind::range && !at->second.values.empty()) {
        out += ",";
      }
      for (const std::string& value : at->second.values) out += ", " + value;
      out += newline;
      at = std::next(last);
    }
  }

 private:
  static bool is_next(const NodeValues::value_type& a, const NodeValues::value_type& b) {
    std::int64_t first = 0;
    std::int64_t second = 0;
    return parse_inp_integer(a.first, first) && parse_inp_integer(b.first, second) && second == first + 1 &&
           a.second.values == b.second.values;
  }
  ConditionKind kind_;
};

/// The values between nodes: where they differ, numbers by their weights. Nothing where a text differs.
std::optional<ValueFields> value_between(const std::vector<const ValueFields*>& of, const std::vector<double>& weights,
                                         bool may_differ) {
  std::size_t n = 0;
  for (const ValueFields* fields : of) n = std::max(n, fields->size());
  ValueFields result;
  double sum = 0;
  for (std::size_t i = 0; i < of.size(); ++i) sum += weights[i];
  for (std::size_t k = 0; k < n; ++k) {
    const auto text = [k](const ValueFields& fields) { return k < fields.size() ? fields[k] : std::string(); };
    result.push_back(text(*of.front()));
    const auto differs = [&](const ValueFields* fields) { return text(*fields) != result.back(); };
    if (std::none_of(of.begin(), of.end(), differs)) continue;
    double value = 0;
    for (std::size_t i = 0; i < of.size(); ++i) {
      const std::string written = text(*of[i]);
      const std::optional<double> number = written.empty() ? 0 : parse_real_field(written);
      if (!number || !may_differ) return {};
      value += weights[i] / sum * *number;
    }
    if (!std::isfinite(value)) return {};
    result.back().clear();
    append_inp_real(result.back(), value);
  }
  return result;
}

using IndexPairs = std::vector<std::pair<Index, Index>>;

/// The inserted nodes of a mesh, and which of them depend on which nodes; inserted nodes by their position in
/// InpMatch::inserted.
struct InpDependents {
  const InpModel& model;
  const InpMatch& match;
  const std::vector<InpInserted>& inserted;
  const std::vector<std::vector<Index>>& sets_of;  ///< per inserted node

  IndexPairs of_node;              ///< a node of the deck, an inserted node
  IndexPairs of_inserted;          ///< an inserted vertex, a mid-side node at an edge of it
  std::vector<Index> nodes;        ///< the first of `of_node`
  std::vector<Index> outside;      ///< inserted vertices that no tetrahedron of the deck contains
  std::vector<Index> old_middles;  ///< of the deck, ascending

  InpDependents(const InpModel& deck, const InpMatch& deck_match, const std::vector<InpInserted>& nodes_of_mesh,
                const std::vector<std::vector<Index>>& sets)
      : model(deck), match(deck_match), inserted(nodes_of_mesh), sets_of(sets) {
    for (Index i = 0; i < std::ssize(inserted); ++i) {
      const InpInserted& node = span_of(inserted)[i];
      for (const Index v : node.nodes) of_node.emplace_back(v, i);
      for (const Index v : node.support) of_node.emplace_back(v, i);
      if (!node.is_middle() && node.nodes.empty()) outside.push_back(i);
      for (const Index v : node.ends) {
        if (v < 0) continue;
        const Index old = span_of(match.vertex2node)[v];
        if (old >= 0) {
          of_node.emplace_back(old, i);
        } else {
          of_inserted.emplace_back(position(v), i);
        }
      }
    }
    sort_unique(of_node);
    sort_unique(of_inserted);
    for (const auto& [node, i] : of_node) {
      if (nodes.empty() || nodes.back() != node) nodes.push_back(node);
    }
    for (const auto& [ends, node] : model.middles) old_middles.push_back(node);
    sort_unique(old_middles);
  }
  /// The position of a vertex among the inserted ones.
  Index position(Index v) const {
    return to_index(std::lower_bound(match.inserted.begin(), match.inserted.end(), v) - match.inserted.begin());
  }
};

/// The values of inserted nodes in one condition.
class InpExtension {
 public:
  InpExtension(const InpDependents& dependents, const InpCondition& condition)
      : dependents_(dependents), condition_(condition), reader_(condition.kind) {}

  std::string extend() {
    read_lines();
    std::string text;
    for (const Index i : concerned()) {
      if (span_of(dependents_.inserted)[i].is_middle()) {
        add_middle(i);
      } else {
        add_vertex(i);
      }
      NodeValues written;
      for (const auto& [key, value] : entries_of_inserted(i)) {
        if (value.line < 0) written.emplace(key, value);
      }
      const InpModel& model = dependents_.model;
      const Index v = span_of(dependents_.match.inserted)[i];
      reader_.append(text, model.reference(span_of(dependents_.match.vertex_labels)[v], condition_.in_assembly),
                     written, model.newline);
    }
    return text;
  }
  /// The number of inserted nodes without a value beside nodes with one.
  std::size_t missing() const { return missing_; }
  /// The number of inserted vertices between nodes that different sets support, and that are in none of these.
  std::size_t between_sets() const { return between_sets_; }

 private:
  bool is_field() const { return InpCardKind::is_field(condition_.kind); }
  bool has_own_line(const NodeValue& value) const {
    return value.line < 0 || span_of(condition_.lines)[value.line].node >= 0;
  }

  /// Reads the values of the nodes that are needed; later lines replace earlier ones.
  void read_lines() {
    for (Index l = 0; l < std::ssize(condition_.lines); ++l) {
      const InpConditionLine& line = span_of(condition_.lines)[l];
      const auto give = [&](Index node) {
        reader_.read(line.text, [&](std::string key, ValueFields values) {
          entries_[node][std::move(key)] = {std::move(values), l};
        });
      };
      if (line.node >= 0) {
        has_own_lines_ = true;
        names_middles_ = names_middles_ || is_listed(dependents_.old_middles, line.node);
        if (is_listed(dependents_.nodes, line.node)) give(line.node);
      }
      if (line.set < 0) continue;
      const InpSet& set = span_of(dependents_.model.sets)[line.set];
      names_middles_ = names_middles_ || !set.middles.empty();
      lines_of_set_[line.set].push_back(l);
      const bool is_small = set.members.size() < dependents_.nodes.size();
      for (const Index node : is_small ? set.members : dependents_.nodes) {
        if (is_listed(is_small ? dependents_.nodes : set.members, node)) give(node);
      }
    }
  }
  /// The inserted nodes that can get a value, ascending: vertices precede mid-side nodes.
  std::vector<Index> concerned() const {
    std::vector<Index> rows;
    if (has_own_lines_) rows = dependents_.outside;
    const auto take_partners = [&rows](const IndexPairs& pairs, Index first) {
      for (const auto& pair : pairs_from(pairs, first)) rows.push_back(pair.second);
    };
    for (const auto& [node, entries] : entries_) take_partners(dependents_.of_node, node);
    sort_unique(rows);
    const std::vector<Index> found = rows;
    for (const Index i : found) take_partners(dependents_.of_inserted, i);
    sort_unique(rows);
    return rows;
  }

  const NodeValues& entries_of_node(Index node) const {
    static const NodeValues none;
    const auto at = entries_.find(node);
    return at == entries_.end() ? none : at->second;
  }
  /// The values of an inserted node, at first those by the sets that it is in.
  NodeValues& entries_of_inserted(Index i) {
    const auto known = added_.find(i);
    if (known != added_.end()) return known->second;
    NodeValues& entries = added_[i];
    std::vector<Index> lines;
    for (const Index s : span_of(dependents_.sets_of)[i]) {
      const auto found = lines_of_set_.find(s);
      if (found != lines_of_set_.end()) lines.insert(lines.end(), found->second.begin(), found->second.end());
    }
    sort_unique(lines);
    for (const Index l : lines) {
      reader_.read(span_of(condition_.lines)[l].text, [&](std::string key, ValueFields values) {
        entries[std::move(key)] = {std::move(values), l};
      });
    }
    return entries;
  }

  void add_vertex(Index i) {
    const InpInserted& node = span_of(dependents_.inserted)[i];
    const std::vector<Index>& needed = is_field() ? node.nodes : node.support;
    std::vector<const NodeValues*> of;
    for (const Index v : needed) of.push_back(&entries_of_node(v));
    std::vector<double> weights(of.size(), 1);
    std::copy_n(node.weights.begin(), std::min(weights.size(), node.weights.size()), weights.begin());
    // Inner vertices around the vertex decide whether it joins, and have no part in its value.
    add(i, of, weights, node.nodes.size());
  }
  void add_middle(Index i) {
    const InpInserted& node = span_of(dependents_.inserted)[i];
    if (!names_middles_ || (!is_field() && (!node.has_inserted_end || node.is_across))) return;
    std::vector<const NodeValues*> of;
    for (const Index v : node.ends) {
      const Index old = span_of(dependents_.match.vertex2node)[v];
      of.push_back(old >= 0 ? &entries_of_node(old) : &entries_of_inserted(dependents_.position(v)));
    }
    add(i, of, {0.5, 0.5}, 2);
  }

  /// Whether a node whose neighbors have a value by sets alone has it by a set too, or must not have it.
  bool is_left_to_sets(Index i, const std::string& key, const std::vector<const NodeValue*>& of) {
    const NodeValues& own = entries_of_inserted(i);
    const auto at = own.find(key);
    const auto has_line = [](Index line) { return [line](const NodeValue* value) { return value->line == line; }; };
    if (at != own.end() && std::any_of(of.begin(), of.end(), has_line(at->second.line))) return true;
    if (is_field()) return false;
    const bool is_of_one = std::all_of(of.begin(), of.end(), has_line(of.front()->line));
    if (at == own.end() && !is_of_one && !span_of(dependents_.inserted)[i].is_middle()) is_between_sets_ = true;
    return true;
  }

  /// Adds the values that all of these entries have.
  void add(Index i, const std::vector<const NodeValues*>& of, const std::vector<double>& weights,
           std::size_t with_value) {
    NodeValues& own = entries_of_inserted(i);
    bool is_complete = !of.empty() || !own.empty();
    std::set<std::string> keys;
    for (const NodeValues* entries : of) {
      for (const auto& [key, value] : *entries) keys.insert(key);
    }
    is_between_sets_ = false;
    for (const std::string& key : keys) {
      std::vector<const NodeValue*> found;
      for (const NodeValues* entries : of) {
        const auto at = entries->find(key);
        if (at != entries->end()) found.push_back(&at->second);
      }
      const bool is_by_line =
          std::any_of(found.begin(), found.end(), [this](const NodeValue* value) { return has_own_line(*value); });
      if (!is_by_line && (found.size() < of.size() || is_left_to_sets(i, key, found))) continue;
      std::vector<const ValueFields*> values;
      for (const NodeValue* value : found) values.push_back(&value->values);
      std::optional<ValueFields> between;
      if (found.size() == of.size()) {
        values.resize(std::min(values.size(), with_value));
        between = value_between(values, weights, condition_.kind != ConditionKind::members);
      }
      if (between) own[key] = {std::move(*between), -1};
      is_complete = is_complete && own.count(key) != 0;
    }
    missing_ += is_field() && !is_complete ? 1 : 0;
    between_sets_ += is_between_sets_ ? 1 : 0;
  }

  const InpDependents& dependents_;
  const InpCondition& condition_;
  InpConditionReader reader_;
  std::map<Index, NodeValues> entries_;  ///< of nodes of the deck
  std::map<Index, NodeValues> added_;    ///< of inserted nodes
  std::map<Index, std::vector<Index>> lines_of_set_;
  bool names_middles_ = false, has_own_lines_ = false, is_between_sets_ = false;
  std::size_t missing_ = 0, between_sets_ = 0;
};

std::string count_of_inserted(std::size_t n) {
  return std::to_string(n) + (n == 1 ? " inserted node has" : " inserted nodes have");
}

}  // namespace

std::vector<std::string> extend_inp_conditions(const InpModel& model, const InpMatch& match,
                                               const std::vector<InpInserted>& inserted,
                                               const std::vector<std::vector<Index>>& sets_of,
                                               const IoContext& context) {
  std::vector<std::string> texts(model.conditions.size());
  if (inserted.empty()) return texts;
  const InpDependents dependents(model, match, inserted, sets_of);
  for (std::size_t c = 0; c < texts.size(); ++c) {
    const InpCondition& condition = model.conditions[c];
    if (condition.last_piece < 0) continue;
    if (condition.may_continue) {
      context.warn("inserted nodes have no value in *" + condition.name +
                   ", as its lines of more than seven values can be continued; name a set of all nodes");
      continue;
    }
    InpExtension extension(dependents, condition);
    texts[c] = extension.extend();
    if (extension.between_sets() != 0) {
      context.warn(count_of_inserted(extension.between_sets()) + " no value in *" + condition.name +
                   ", as they are between nodes of different sets and in none of these");
    }
    if (extension.missing() == 0) continue;
    context.warn(
        count_of_inserted(extension.missing()) + " no value in *" + condition.name +
        ", as they are not between nodes of the deck that all have one; name a set of all nodes before these lines");
  }
  return texts;
}

}  // namespace tetune
