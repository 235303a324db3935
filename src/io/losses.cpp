// SPDX-License-Identifier: Apache-2.0
#include "io/losses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <type_traits>
#include <variant>

#include "backend/span.hpp"
#include "io/plain_text.hpp"
#include "io/tag_numbers.hpp"
#include "mesh/node_sets.hpp"
#include "tetune/error.hpp"

namespace tetune {

bool has_tag(const std::vector<int>& tags) {
  return std::any_of(tags.begin(), tags.end(), [](int tag) { return tag != 0; });
}

void warn_of_lists(const TetMesh& mesh, const IoContext& context) {
  bool is_listed = std::any_of(mesh.others.begin(), mesh.others.end(),
                               [](const ElementBlock& block) { return !block.required.empty(); });
  for (const auto* list : {&mesh.corners, &mesh.required_vertices, &mesh.ridges, &mesh.required_edges,
                           &mesh.required_triangles, &mesh.required_tets}) {
    is_listed = is_listed || !list->empty();
  }
  if (is_listed) context.warn("the format cannot hold lists of corners, ridges and required entities");
}

void warn_of_point_tags(const TetMesh& mesh, const IoContext& context) {
  if (has_tag(mesh.point_tags)) context.warn("the format cannot hold tags of vertices");
}

namespace {

/// Calls f(array) for the data of any entity.
template <class F>
void for_each_data(const TetMesh& mesh, const F& f) {
  const auto visit = [&f](const std::vector<DataArray>& data) { std::for_each(data.begin(), data.end(), f); };
  for (const auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) visit(*data);
  for (const ElementBlock& block : mesh.others) visit(block.data);
}

/// Warns of the data of any entity that are_kept(array) does not accept.
template <class AreKept>
void warn_of_data_unless(const TetMesh& mesh, const IoContext& context, const AreKept& are_kept) {
  std::set<std::string> names;
  for_each_data(mesh, [&](const DataArray& array) {
    if (!are_kept(array)) names.insert("\"" + array.name + "\"");
  });
  if (!names.empty()) context.warn("the format cannot hold the data " + listed_texts(names));
}

template <class T>
bool has_beyond_doubles(const std::vector<T>& values) {
  if constexpr (!std::is_integral_v<T> || sizeof(T) < sizeof(std::int64_t)) {
    return false;
  } else {
    constexpr T kMost = T{1} << 53;  // the next integer is rounded to it
    return std::any_of(values.begin(), values.end(), [](T value) {
      if constexpr (std::is_signed_v<T>) return value < -kMost || value > kMost;
      return value > kMost;
    });
  }
}

}  // namespace

void warn_of_data(const TetMesh& mesh, const IoContext& context, const char* kept) {
  warn_of_data_unless(mesh, context, [kept](const DataArray& array) { return kept != nullptr && array.name == kept; });
}

void warn_of_data_but_node_sets(const TetMesh& mesh, const IoContext& context) {
  warn_of_data_unless(mesh, context, is_node_set);
}

std::string rounded_integers(const std::vector<const std::vector<DataArray>*>& lists, const char* format) {
  std::set<std::string> names;
  for (const std::vector<DataArray>* data : lists) {
    for (const DataArray& array : *data) {
      const auto is_rounded = [](const auto& values) { return has_beyond_doubles(values); };
      if (std::visit(is_rounded, array.values)) names.insert("\"" + array.name + "\"");
    }
  }
  if (names.empty()) return {};
  return "integers beyond 2^53 are rounded, as " + std::string(format) + " stores doubles: data " + listed_texts(names);
}

void warn_of_names(const TetMesh& mesh, const IoContext& context) {
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), [](const Group& group) { return !group.name.empty(); })) {
    context.warn("the format cannot hold the names of groups");
  }
}

void warn_of_point_elements(const IoContext& context) { context.warn("the format cannot hold elements of one vertex"); }

void warn_of_shared_names(const IoContext& context) {
  context.warn("an element can have one name only: it has that of its group with the fewest tags");
}

void RenamedGroups::add(const std::string& name, const std::string& written) {
  if (written == name) return;
  texts_.push_back("the group \"" + without_control_characters(name) + "\" is written as " + written);
}

void RenamedGroups::warn(const IoContext& context) const {
  if (!texts_.empty()) context.warn(listed_texts(texts_));
}

void warn_of_empty_group(const Group& group, const IoContext& context) {
  context.warn("the group \"" + group.name + "\" has no elements; it is not written");
}

void warn_of_empty_groups(const TetMesh& mesh, const IoContext& context) {
  for (const Group* const group : empty_groups(mesh)) {
    if (!group->name.empty()) warn_of_empty_group(*group, context);
  }
}

void warn_of_merged_tags(const Group& group, std::size_t tags, const IoContext& context) {
  context.warn("the " + std::to_string(tags) + " tags of the group \"" + group.name +
               "\" become one: the number of their group");
}

void refuse_infinite_points(const TetMesh& mesh) {
  const auto is_infinite = [](const Point3& p) {
    return !std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); });
  };
  const auto point = std::find_if(mesh.points.begin(), mesh.points.end(), is_infinite);
  if (point == mesh.points.end()) return;
  throw FileError("node " + std::to_string(point - mesh.points.begin() + 1) +
                  ", counted from 1: a coordinate is not finite; the format has no notation for it: repair the mesh");
}

std::vector<const Group*> empty_groups(const TetMesh& mesh) {
  const std::array<std::set<int>, 4> in_use = tags_by_dimension(mesh);
  std::vector<const Group*> empty;
  for (const Group& group : mesh.groups) {
    const bool is_known = group.dimension >= 0 && group.dimension < std::ssize(in_use);
    const auto has_element = [&](int tag) { return is_known && in_use[to_size_t(group.dimension)].contains(tag); };
    if (std::none_of(group.tags.begin(), group.tags.end(), has_element)) empty.push_back(&group);
  }
  return empty;
}

}  // namespace tetune
