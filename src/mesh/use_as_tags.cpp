// SPDX-License-Identifier: Apache-2.0
// Tags from the data of elements.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mesh/whole_number.hpp"
#include "system/real_text.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

using Data = std::vector<DataArray>;

/// The name that unnamed tags get as data.
constexpr const char* kDefaultName = "medit:ref";

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
  if (const std::optional<int> tag = whole_number(value)) return *tag;
  throw OptionError("it contains " + number_text(value));
}

std::vector<int> to_tags(const DataArray& array) {
  const std::string refusal = "the cell data \"" + array.name + "\" cannot be used as tags: ";
  if (array.components != 1) {
    throw OptionError(refusal + "it has " + std::to_string(array.components) +
                      " numbers per cell; a tag is one number");
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
    throw OptionError(refusal + e.what() + "; a tag is a 32-bit integer");
  }
}

/// The data and the tags of one kind of elements.
struct ElementData {
  Data* data;
  std::vector<int>* tags;
};

}  // namespace

void use_as_tags(TetMesh& mesh, const std::string& name) {
  if (find(mesh.tet_data, name) == mesh.tet_data.end()) {
    if (name == (mesh.cell_tags_name.empty() ? kDefaultName : mesh.cell_tags_name))
      return;  // the tags have this name already
    throw OptionError("the tetrahedra have no data \"" + name + "\"; their data are: " + names_of(mesh.tet_data));
  }
  if (!mesh.groups.empty()) {
    throw OptionError("the tags of this mesh are those of its named groups; its data \"" + name +
                      "\" cannot replace them");
  }
  std::vector<ElementData> kinds{
      {&mesh.tet_data, &mesh.tet_tags}, {&mesh.triangle_data, &mesh.triangle_tags}, {&mesh.edge_data, &mesh.edge_tags}};
  for (ElementBlock& block : mesh.others) kinds.push_back({&block.data, &block.tags});
  const bool tagged = std::any_of(kinds.begin(), kinds.end(), [](const ElementData& kind) {
    return std::any_of(kind.tags->begin(), kind.tags->end(), [](int tag) { return tag != 0; });
  });
  std::string old_name = mesh.cell_tags_name.empty() ? kDefaultName : mesh.cell_tags_name;
  const auto is_taken = [&](const ElementData& kind) { return find(*kind.data, old_name) != kind.data->end(); };
  do {
    old_name += ":before";
  } while (std::any_of(kinds.begin(), kinds.end(), is_taken));

  // Everything that may throw comes first, so that the mesh changes completely or not at all.
  std::vector<std::vector<int>> tags;
  Data before;
  for (const ElementData& kind : kinds) {
    const auto at = find(*kind.data, name);
    tags.push_back(at != kind.data->end() ? to_tags(*at) : std::vector<int>());
    tags.back().resize(kind.tags->size(), 0);
    before.push_back({old_name, 1, std::vector<std::int32_t>(kind.tags->begin(), kind.tags->end())});
    kind.data->reserve(kind.data->size() + 1);
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    kinds[k].tags->swap(tags[k]);
    if (tagged && !tags[k].empty()) kinds[k].data->push_back(std::move(before[k]));
  }
}

}  // namespace tetune
