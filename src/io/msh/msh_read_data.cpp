// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <sstream>

#include "io/msh/msh_sections.hpp"

namespace tetune {
namespace {

/// Makes a section text while it exists: version 2.2 has some in binary files.
class AsText {
 public:
  AsText(MshSource& source, bool is_text) : source_(source), was_binary_(source.is_binary()) {
    if (is_text) source.set_binary(false);
  }
  ~AsText() { source_.set_binary(was_binary_); }
  AsText(const AsText&) = delete;
  AsText& operator=(const AsText&) = delete;

 private:
  MshSource& source_;
  bool was_binary_;
};

/// The name in the rest of the line: what is between quotation marks, or all of it where there are none.
std::string read_name(MshSource& source) {
  const TextCursor at_name = source.text();
  const std::string_view line = source.text().line();
  const std::size_t first = line.find('"');
  const std::size_t last = line.rfind('"');
  if (first != last) return std::string(line.substr(first + 1, last - first - 1));
  const std::string_view bare = trimmed(line);
  if (first != std::string_view::npos || bare.empty()) {
    at_name.fail("expected a name in quotation marks, found \"" + printable(line.substr(0, 40)) + "\"");
  }
  return std::string(bare);
}

/// Reads the first number of a name. Returns whether it is the only one, as in version 2.0: 1"steel" or 1 "steel".
bool reads_number_alone(TextCursor& text, std::int64_t& number) {
  while (text.line_done() && text.remaining() > 0) text.line();
  const std::string_view word = text.peek();
  const std::size_t quote = word.find('"');
  if (quote == std::string_view::npos) {
    number = text.integer("dimension of a group");
    return text.peek().starts_with('"');
  }
  const auto [end, error] = std::from_chars(word.data(), word.data() + quote, number);
  return error == std::errc() && end == word.data() + quote;
}

void read_affine(MshSource& source, PeriodicLink& link) {
  TextCursor& text = source.text();
  if (!source.is_old()) {
    link.affine.resize(source.count("size of a periodic map", 1, 8));
    for (double& value : link.affine) value = source.real("periodic map");
  } else if (text.peek() == "Affine") {
    text.word();
    while (!text.line_done()) link.affine.push_back(text.real("periodic map"));
  }
  if (link.affine.size() != 16) link.affine.clear();
}

/// Of several steps the first is kept; parts of one step are joined.
void add_view(MshView view, MshModel& model, const IoContext& context) {
  const auto same = std::find_if(model.views.begin(), model.views.end(), [&view](const MshView& v) {
    return v.name == view.name && v.on_nodes == view.on_nodes;
  });
  if (same == model.views.end()) return model.views.push_back(std::move(view));
  if (same->step != view.step || same->components != view.components) {
    if (!std::exchange(same->has_more_steps, true)) {
      context.warn("of the data \"" + printable(view.name) + "\" the first step is kept");
    }
    return;
  }
  same->numbers.insert(same->numbers.end(), view.numbers.begin(), view.numbers.end());
  same->values.insert(same->values.end(), view.values.begin(), view.values.end());
}

}  // namespace

void read_msh_names(MshSource& source, MshModel& model) {
  TextCursor& text = source.text();
  const std::int64_t n = text.integer("number of names");
  for (std::int64_t i = 0; i < n; ++i) {
    std::int64_t number = 0;
    const bool is_alone = reads_number_alone(text, number);
    const std::int64_t dimension = is_alone ? kMshAnyDimension : number;
    if (!is_alone) number = text.integer("number of a group");
    if ((dimension < 0 && !(is_alone && source.is_old())) || dimension > 3 || number < 1 ||
        number > std::numeric_limits<int>::max()) {
      source.fail("group " + std::to_string(number) + " of dimension " + std::to_string(dimension) +
                  " is none: numbers are from 1, dimensions from 0 to 3");
    }
    model.names.push_back({int(dimension), int(number), read_name(source)});
  }
}

void read_msh_comments(MshSource& source, MshModel& model) {
  TextCursor lines = source.text();
  source.skip_section("Comments");
  if (lines.line() != kMshLooseTags) return;
  while (lines.remaining() > source.text().remaining()) {
    std::istringstream numbers{std::string(lines.line())};
    int dimension = 0, entity = 0, tag = 0;
    if (numbers >> dimension >> entity >> tag) model.loose_tags[{dimension, entity}] = tag;
  }
}

void read_msh_periodic(MshSource& source, MshModel& model, const IoContext& context) {
  const AsText as_text(source, source.is_old());
  const std::size_t n = source.count("number of links", 4, 28);
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < n; ++i) {
    PeriodicLink link;
    link.dimension = source.integer("dimension of a link");
    link.entity = source.integer("entity of a link");
    link.master = source.integer("master of a link");
    if (link.dimension < 0 || link.dimension > 2) {
      source.fail("a periodic link has dimension " + std::to_string(link.dimension) + "; it must be 0, 1 or 2");
    }
    read_affine(source, link);
    const std::size_t pairs = source.count("number of pairs", 2, 16);
    for (std::size_t k = 0; k < pairs; ++k) {
      const Index vertex = model.nodes.rank(source.long_integer("node of a pair"));
      const Index master = model.nodes.rank(source.long_integer("node of a pair"));
      if (vertex < 0 || master < 0) {
        ++unknown;
      } else {
        link.pairs.push_back({vertex, master});
      }
    }
    model.periodic.push_back(std::move(link));
  }
  if (unknown > 0) {
    context.warn(std::to_string(unknown) + " periodic pairs have a node that does not exist; they are not kept");
  }
}

void read_msh_view(MshSource& source, bool on_nodes, MshModel& model, const IoContext& context) {
  TextCursor& text = source.text();
  MshView view;
  view.on_nodes = on_nodes;
  const std::int64_t strings = text.integer("number of strings");
  text.line();
  for (std::int64_t i = 0; i < strings; ++i) {
    std::string name = read_name(source);
    if (i == 0) view.name = std::move(name);
  }
  const std::int64_t reals = text.integer("number of reals");
  for (std::int64_t i = 0; i < reals; ++i) text.real("time");
  const std::int64_t integers = text.integer("number of integers");
  std::array<std::int64_t, 3> header{0, 1, 0};  // step, components, entries
  for (std::int64_t i = 0; i < integers; ++i) {
    const std::int64_t value = text.integer("integer of the data");
    if (i < 3) header[to_size_t(i)] = value;
  }
  if (source.is_binary()) text.line();
  const std::int64_t each = header[1];
  if (each != 1 && each != 3 && each != 9) {
    context.warn("the data \"" + printable(view.name) + "\" of " + std::to_string(each) +
                 " components are not kept: 1, 3 or 9 are possible");
    return source.skip_section(on_nodes ? "NodeData" : "ElementData");
  }
  view.components = int(each);
  view.step = int(header[0]);
  const std::size_t n = source.checked(header[2], "number of values", view.components + 1, 4 + 8 * view.components);
  view.numbers.reserve(n);
  view.values.reserve(n * to_size_t(each));
  for (std::size_t i = 0; i < n; ++i) {
    view.numbers.push_back(source.short_integer("node or element of a value"));
    for (int k = 0; k < view.components; ++k) view.values.push_back(source.real("value"));
  }
  add_view(std::move(view), model, context);
}

}  // namespace tetune
