// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "io/inp/inp_format.hpp"
#include "io/real_field.hpp"

namespace tetune {
namespace {

using ConditionKind = InpCardKind::Condition;
using ValueFields = std::vector<std::string>;

/// The fields of a node for one component or degree of freedom.
struct NodeValue {
  ValueFields values;
  bool has_own_line = false;  ///< not by a set
};
/// By a component, a degree of freedom, or a text in the place of these, as "ENCASTRE".
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
  /// Calls take(key, values) for what a line gives.
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
  /// Appends the lines of a node.
  void append(std::string& out, std::int64_t label, const NodeValues& entries, const char* newline) const {
    for (auto at = entries.begin(); at != entries.end();) {
      auto last = at;
      while (kind_ == ConditionKind::range && std::next(last) != entries.end() && is_next(*last, *std::next(last)))
        ++last;
      out += std::to_string(label);
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

/// The values of inserted nodes in one condition.
class InpExtension {
 public:
  InpExtension(const InpModel& model, const InpMatch& match, const std::vector<InpInserted>& inserted,
               const InpCondition& condition)
      : model_(model),
        match_(match),
        inserted_(inserted),
        condition_(condition),
        reader_(condition.kind),
        added_(inserted.size()) {}

  std::string extend() {
    read_lines();
    std::string text;
    for (std::size_t i = 0; i < inserted_.size(); ++i) {
      if (inserted_[i].is_middle()) {
        add_middle(i);
      } else {
        add_vertex(i);
      }
      reader_.append(text, span_of(match_.vertex_labels)[match_.inserted[i]], added_[i], model_.newline);
    }
    return text;
  }
  /// The number of inserted nodes without a value beside nodes with one.
  std::size_t missing() const { return missing_; }

 private:
  bool is_field() const {
    return condition_.kind == ConditionKind::field || condition_.kind == ConditionKind::components;
  }

  /// Reads the values of the nodes that are needed; later lines replace earlier ones.
  void read_lines() {
    for (const InpInserted& node : inserted_) {
      for (const Index v : node.nodes) entries_[v];
      for (const Index v : node.support) entries_[v];
      for (const Index v : node.ends) {
        if (v >= 0 && span_of(match_.vertex2node)[v] >= 0) entries_[span_of(match_.vertex2node)[v]];
      }
    }
    std::vector<std::uint8_t> is_middle(model_.points.size(), 0);
    for (const auto& [ends, node] : model_.middles) span_of(is_middle)[node] = 1;
    for (const InpConditionLine& line : condition_.lines) {
      const bool has_own_line = line.node >= 0;
      const auto give = [&](Index node) {
        const auto at = entries_.find(node);
        if (at == entries_.end()) return;
        reader_.read(line.text, [&](std::string key, ValueFields values) {
          at->second[std::move(key)] = {std::move(values), has_own_line};
        });
      };
      if (has_own_line) {
        names_middles_ = names_middles_ || span_of(is_middle)[line.node] != 0;
        give(line.node);
      }
      if (line.set < 0) continue;
      const InpSet& set = span_of(model_.sets)[line.set];
      names_middles_ = names_middles_ || !set.middles.empty();
      for (const auto& [node, known] : entries_) {
        if (std::binary_search(set.members.begin(), set.members.end(), node)) give(node);
      }
    }
  }

  void add_vertex(std::size_t i) {
    const InpInserted& node = inserted_[i];
    const std::vector<Index>& needed = is_field() ? node.nodes : node.support;
    std::vector<const NodeValues*> of;
    for (const Index v : needed) of.push_back(&entries_.at(v));
    std::vector<double> weights(of.size(), 1);
    std::copy_n(node.weights.begin(), std::min(weights.size(), node.weights.size()), weights.begin());
    // Inner vertices around the vertex decide whether it joins, and have no part in its value.
    add(i, of, weights, node.nodes.size());
  }
  void add_middle(std::size_t i) {
    const InpInserted& node = inserted_[i];
    if (!names_middles_ || (!is_field() && (!node.has_inserted_end || node.is_across))) return;
    std::vector<const NodeValues*> of;
    for (const Index v : node.ends) {
      const Index old = span_of(match_.vertex2node)[v];
      const auto at = std::lower_bound(match_.inserted.begin(), match_.inserted.end(), v) - match_.inserted.begin();
      of.push_back(old >= 0 ? &entries_.at(old) : &added_[to_size_t(at)]);
    }
    add(i, of, {0.5, 0.5}, 2);
  }

  /// Adds what all of these entries have.
  void add(std::size_t i, const std::vector<const NodeValues*>& of, const std::vector<double>& weights,
           std::size_t with_value) {
    if (of.empty()) {
      missing_ += is_field() ? 1 : 0;
      return;
    }
    bool is_complete = true;
    for (const auto& [key, entry] : *of.front()) {
      std::vector<const ValueFields*> values;
      bool has_own_line = false;
      for (const NodeValues* entries : of) {
        const auto at = entries->find(key);
        if (at == entries->end()) break;
        values.push_back(&at->second.values);
        has_own_line = has_own_line || at->second.has_own_line;
      }
      if (values.size() < of.size()) is_complete = false;
      if (values.size() < of.size() || !has_own_line) continue;
      values.resize(std::min(values.size(), with_value));
      std::optional<ValueFields> found = value_between(values, weights, condition_.kind != ConditionKind::members);
      if (found) {
        added_[i][key] = {std::move(*found), true};
      } else {
        is_complete = false;
      }
    }
    const auto has_more = [&of](const NodeValues* entries) { return entries->size() > of.front()->size(); };
    if (is_field() && (!is_complete || std::any_of(of.begin(), of.end(), has_more))) ++missing_;
  }

  const InpModel& model_;
  const InpMatch& match_;
  const std::vector<InpInserted>& inserted_;
  const InpCondition& condition_;
  InpConditionReader reader_;
  std::map<Index, NodeValues> entries_;  ///< of nodes of the deck
  std::vector<NodeValues> added_;        ///< per inserted node
  bool names_middles_ = false;
  std::size_t missing_ = 0;
};

}  // namespace

std::vector<std::string> extend_inp_conditions(const InpModel& model, const InpMatch& match,
                                               const std::vector<InpInserted>& inserted, const IoContext& context) {
  std::vector<std::string> texts(model.conditions.size());
  if (inserted.empty()) return texts;
  for (std::size_t c = 0; c < texts.size(); ++c) {
    const InpCondition& condition = model.conditions[c];
    if (condition.last_piece < 0) continue;
    InpExtension extension(model, match, inserted, condition);
    texts[c] = extension.extend();
    if (extension.missing() == 0) continue;
    context.warn(
        std::to_string(extension.missing()) + " inserted nodes have no value in *" + condition.name +
        ", as they are not between nodes of the deck that all have one; name a set of all nodes before these lines");
  }
  return texts;
}

}  // namespace tetune
