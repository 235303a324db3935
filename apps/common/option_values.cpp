// SPDX-License-Identifier: Apache-2.0
#include "option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <string_view>

#include "system/real_text.hpp"
#include "tetune/error.hpp"
#include "tetune/periodic.hpp"

namespace tetune::cli {
namespace {

/// Lists the tags of regions or patches, with the names of their groups: 10 "steel", 20.
std::string list_tags(const TetMesh& mesh, TagOrName::Of of) {
  const bool regions = of == TagOrName::Of::region;
  constexpr std::size_t kShown = 20;
  const std::vector<int>& all = regions ? mesh.tet_tags : mesh.triangle_tags;
  const std::set<int> tags(all.begin(), all.end());
  std::string text;
  std::size_t shown = 0;
  for (const int tag : tags) {
    if (shown++ == kShown) return text + fmt::format(", ... ({} tags)", tags.size());
    text += fmt::format("{}{}", text.empty() ? "" : ", ", tag);
    for (const Group& group : mesh.groups) {
      const bool has = std::find(group.tags.begin(), group.tags.end(), tag) != group.tags.end();
      if (has && group.dimension == (regions ? 3 : 2) && !group.name.empty())
        text += fmt::format(" \"{}\"", group.name);
    }
  }
  return text.empty() ? "none" : text;
}

/// Parses the name of a measure, for example "mean_ratio".
Measure parse_measure(const std::string& option, const std::string& name) {
  std::string known;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto measure = static_cast<Measure>(k);
    if (name == to_string(measure)) return measure;
    known += fmt::format("{}{}", k == 0 ? "" : ", ", to_string(measure));
  }
  throw OptionError(fmt::format("{}: '{}' is not a measure; the measures are {}", option, name, known));
}

/// A tag if the text is an integer, otherwise the name of a group.
TagOrName parse_tag(TagOrName::Of of, const std::string& text) {
  int tag = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), tag);
  const bool is_tag = error == std::errc() && at == text.data() + text.size();
  return {of, is_tag ? tag : 0, is_tag ? "" : text};
}

/// The tags of a region or patch that elements of the mesh have. Throws OptionError if there is none; the message lists
/// all tags.
std::vector<int> find_tags(const std::string& option, const TagOrName& wanted, const std::string& mesh_name,
                           const TetMesh& mesh) {
  const std::vector<int>& tags = wanted.is_region() ? mesh.tet_tags : mesh.triangle_tags;
  std::vector<int> found{wanted.tag};
  if (!wanted.name.empty()) {
    found.clear();
    for (const Group& g : mesh.groups) {
      if (g.name != wanted.name || g.dimension != (wanted.is_region() ? 3 : 2)) continue;
      found.insert(found.end(), g.tags.begin(), g.tags.end());
    }
  }
  std::erase_if(found, [&tags](int tag) { return std::find(tags.begin(), tags.end(), tag) == tags.end(); });
  if (!found.empty()) return found;
  throw OptionError(fmt::format(
      "{}: {} has no {} {}; it has {}", option, mesh_name, wanted.is_region() ? "region" : "patch",
      wanted.name.empty() ? std::to_string(wanted.tag) : "\"" + wanted.name + "\"", list_tags(mesh, wanted.of)));
}

}  // namespace

double Box::diagonal() const { return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]); }

Box bounding_box(const TetMesh& mesh) {
  if (mesh.points.empty()) return {};
  Box box{mesh.points[0], mesh.points[0]};
  for (const Point3& p : mesh.points) {
    for (std::size_t k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], p[k]);
      box.high[k] = std::max(box.high[k], p[k]);
    }
  }
  return box;
}

double Length::in(const Box& box) const { return is_percentage ? value / 100 * box.diagonal() : value; }

Length parse_length(const std::string& option, const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = parse_real(text.data(), end, value);
  const bool percent = error == std::errc() && at + 1 == end && *at == '%';
  if (error != std::errc() || (at != end && !percent) || !(value >= 0) || !std::isfinite(value)) {
    throw OptionError(
        fmt::format("{}: '{}' is not a length; give 0 or more in the mesh's unit, or a number with % for a part of the "
                    "bounding box's diagonal",
                    option, text));
  }
  return {value, percent};
}

Target parse_bound(const std::string& option, const std::string& text, std::optional<Measure> by_default) {
  const std::size_t equals = text.find('=');
  const std::string number = equals == std::string::npos ? text : text.substr(equals + 1);
  if (equals != std::string::npos) {
    by_default = parse_measure(option, text.substr(0, equals));
  } else if (!by_default) {
    throw OptionError(fmt::format("{}: '{}' is not a measure and a number, as mean_ratio=0.2", option, text));
  }
  Target target{*by_default, 0};
  const char* end = number.data() + number.size();
  const auto [at, error] = parse_real(number.data(), end, target.value);
  if (error != std::errc() || at != end || !std::isfinite(target.value)) {
    throw OptionError(fmt::format(
        "{}: invalid value '{}'; give a number, or a measure and a number as min_dihedral_deg=10", option, text));
  }
  return target;
}

void parse_freeze(const std::string& text, std::vector<TagOrName>& frozen) {
  std::optional<TagOrName::Of> of;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string item = text.substr(begin, end - begin);
    begin = end + 1;
    if (item.starts_with("tag=")) {
      of = TagOrName::Of::region;
      item.erase(0, std::strlen("tag="));
    } else if (item.starts_with("patch=")) {
      of = TagOrName::Of::patch;
      item.erase(0, std::strlen("patch="));
    }
    if (!of || item.empty()) {
      throw OptionError(
          fmt::format("--freeze: invalid value '{}'; give the tags or names of regions as tag=1,2,steel and "
                      "those of patches as patch=3,inlet",
                      text));
    }
    frozen.push_back(parse_tag(*of, item));
  }
}

void freeze(const std::vector<TagOrName>& frozen, const std::string& mesh_name, const TetMesh& mesh, Options& options) {
  for (const TagOrName& f : frozen) {
    const std::vector<int> tags = find_tags("--freeze", f, mesh_name, mesh);
    auto& to = f.is_region() ? options.frozen_regions : options.frozen_patches;
    to.insert(to.end(), tags.begin(), tags.end());
  }
}

std::vector<int> find_patches(const std::string& option, const std::vector<std::string>& patches,
                              const std::string& mesh_name, const TetMesh& mesh) {
  std::vector<int> all;
  for (const std::string& patch : patches) {
    const std::vector<int> tags = find_tags(option, parse_tag(TagOrName::Of::patch, patch), mesh_name, mesh);
    all.insert(all.end(), tags.begin(), tags.end());
  }
  return all;
}

void add_links(const std::vector<std::string>& axes, const std::string& map, const std::string& mesh_name,
               TetMesh& mesh) {
  std::array<bool, 3> linked{};
  for (const std::string& axis : axes) linked.at(std::string_view("xyz").find(axis)) = true;
  try {
    if (!axes.empty()) link_box_faces(mesh, linked);
  } catch (const MeshError& e) {
    throw MeshError(mesh_name + ": " + e.what());
  }
  if (!map.empty()) read_periodic_map(map, mesh);
}

}  // namespace tetune::cli
