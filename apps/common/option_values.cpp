// SPDX-License-Identifier: Apache-2.0
#include "option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>

#include "system/real_text.hpp"
#include "tetune/error.hpp"
#include "tetune/periodic.hpp"

namespace tetune::cli {
namespace {

/// Lists the tags of regions or patches, with the names of their groups: 10 "steel", 20.
std::string list_tags(const TetMesh& mesh, bool regions) {
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

double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh) {
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
  return percent ? value / 100 * bounding_box(mesh).diagonal() : value;
}

Measure parse_measure(const std::string& option, const std::string& name) {
  std::string known;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto measure = static_cast<Measure>(k);
    if (name == to_string(measure)) return measure;
    known += fmt::format("{}{}", k == 0 ? "" : ", ", to_string(measure));
  }
  throw OptionError(fmt::format("{}: '{}' is not a measure; the measures are {}", option, name, known));
}

Target parse_bound(const std::string& option, const std::string& text, Measure by_default) {
  const std::size_t equals = text.find('=');
  const std::string number = equals == std::string::npos ? text : text.substr(equals + 1);
  Target target{by_default, 0};
  if (equals != std::string::npos) target.measure = parse_measure(option, text.substr(0, equals));
  const char* end = number.data() + number.size();
  const auto [at, error] = parse_real(number.data(), end, target.value);
  if (error != std::errc() || at != end || !std::isfinite(target.value)) {
    throw OptionError(fmt::format(
        "{}: invalid value '{}'; give a number, or a measure and a number as min_dihedral_deg=10", option, text));
  }
  return target;
}

void parse_freeze(const std::string& text, std::vector<Frozen>& frozen) {
  std::optional<bool> region;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string item = text.substr(begin, end - begin);
    begin = end + 1;
    if (item.starts_with("tag=")) {
      region = true;
      item.erase(0, std::strlen("tag="));
    } else if (item.starts_with("patch=")) {
      region = false;
      item.erase(0, std::strlen("patch="));
    }
    if (!region || item.empty()) {
      throw OptionError(
          fmt::format("--freeze: invalid value '{}'; give the tags or names of regions as tag=1,2,steel and "
                      "those of patches as patch=3,inlet",
                      text));
    }
    int tag = 0;
    const auto [at, error] = std::from_chars(item.data(), item.data() + item.size(), tag);
    const bool number = error == std::errc() && at == item.data() + item.size();
    frozen.push_back({*region, number ? tag : 0, number ? "" : item});
  }
}

void freeze(const std::vector<Frozen>& frozen, const std::string& mesh_name, const TetMesh& mesh, Options& options) {
  for (const Frozen& f : frozen) {
    const std::vector<int>& tags = f.region ? mesh.tet_tags : mesh.triangle_tags;
    std::vector<int> wanted{f.tag};
    if (!f.name.empty()) {
      wanted.clear();
      for (const Group& g : mesh.groups) {
        if (g.name != f.name || g.dimension != (f.region ? 3 : 2)) continue;
        wanted.insert(wanted.end(), g.tags.begin(), g.tags.end());
      }
    }
    const auto is_there = [&tags](int tag) { return std::find(tags.begin(), tags.end(), tag) != tags.end(); };
    if (!std::any_of(wanted.begin(), wanted.end(), is_there)) {
      throw OptionError(fmt::format("--freeze: {} has no {} {}; it has {}", mesh_name, f.region ? "region" : "patch",
                                    f.name.empty() ? std::to_string(f.tag) : "\"" + f.name + "\"",
                                    list_tags(mesh, f.region)));
    }
    auto& to = f.region ? options.frozen_regions : options.frozen_patches;
    std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(to), is_there);
  }
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
