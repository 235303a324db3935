// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "tetune/data.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

using Data = std::vector<DataArray>;

/// What tags are called as data where they had no name.
constexpr const char* kNameless = "medit:ref";

Data::const_iterator find(const Data& data, const std::string& name) {
  return std::find_if(data.begin(), data.end(), [&](const DataArray& array) { return array.name == name; });
}

std::string names_of(const Data& data) {
  std::string names;
  for (const DataArray& array : data) names += (names.empty() ? "" : ", ") + array.name;
  return names.empty() ? "none" : names;
}

int to_tag(double value) {
  if (std::isnan(value)) return 0;
  using Limits = std::numeric_limits<int>;
  if (std::trunc(value) != value || value < Limits::min() || value > Limits::max()) {
    throw OptionError("it holds " + std::to_string(value));
  }
  return static_cast<int>(value);
}

std::vector<int> to_tags(const DataArray& array) {
  const std::string what = "the cell data \"" + array.name + "\" cannot be tags: ";
  if (array.components != 1) {
    throw OptionError(what + "it has " + std::to_string(array.components) + " numbers a cell, and tags have one");
  }
  try {
    return std::visit(
        [](const auto& values) {
          std::vector<int> tags;
          tags.reserve(values.size());
          for (const auto value : values) tags.push_back(to_tag(static_cast<double>(value)));
          return tags;
        },
        array.values);
  } catch (const OptionError& e) {
    throw OptionError(what + e.what() + ", and tags are whole numbers of 32 bits");
  }
}

/// Of one kind of elements: their new tags, and their data with the old ones under a name, unless that is empty.
std::pair<std::vector<int>, Data> retagged(const Data& data, const std::vector<int>& tags, const std::string& name,
                                           const std::string& old_name) {
  std::pair<std::vector<int>, Data> result{std::vector<int>(tags.size(), 0), data};
  auto& [now, all] = result;
  if (const auto at = find(data, name); at != data.end()) now = to_tags(*at);
  now.resize(tags.size(), 0);
  if (!old_name.empty() && !tags.empty()) {
    all.push_back({old_name, 1, std::vector<std::int32_t>(tags.begin(), tags.end())});
  }
  return result;
}

}  // namespace

void use_as_tags(TetMesh& mesh, const std::string& name) {
  if (find(mesh.tet_data, name) == mesh.tet_data.end()) {
    throw OptionError("the tetrahedra have no data \"" + name + "\"; theirs are: " + names_of(mesh.tet_data));
  }
  if (!mesh.groups.empty()) {
    throw OptionError("the tags of this mesh are those of its named groups; its data \"" + name +
                      "\" cannot replace them");
  }
  const auto any = [](const std::vector<int>& tags) {
    return std::any_of(tags.begin(), tags.end(), [](int tag) { return tag != 0; });
  };
  bool tagged = any(mesh.tet_tags) || any(mesh.triangle_tags) || any(mesh.edge_tags);
  for (const ElementBlock& block : mesh.others) tagged = tagged || any(block.tags);
  std::string old_name;
  if (tagged) {
    const auto taken = [&](const Data& data) { return find(data, old_name) != data.end(); };
    old_name = mesh.cell_tags_name.empty() ? kNameless : mesh.cell_tags_name;
    do {
      old_name += ":before";
    } while (taken(mesh.tet_data) || taken(mesh.triangle_data) || taken(mesh.edge_data));
  }

  // All that may throw comes first.
  auto tets = retagged(mesh.tet_data, mesh.tet_tags, name, old_name);
  auto triangles = retagged(mesh.triangle_data, mesh.triangle_tags, name, old_name);
  auto edges = retagged(mesh.edge_data, mesh.edge_tags, name, old_name);
  std::vector<ElementBlock> others = mesh.others;
  for (ElementBlock& block : others) {
    std::tie(block.tags, block.data) = retagged(block.data, block.tags, name, old_name);
  }
  std::tie(mesh.tet_tags, mesh.tet_data) = std::move(tets);
  std::tie(mesh.triangle_tags, mesh.triangle_data) = std::move(triangles);
  std::tie(mesh.edge_tags, mesh.edge_data) = std::move(edges);
  mesh.others = std::move(others);
}

}  // namespace tetune
