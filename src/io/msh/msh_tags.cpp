// SPDX-License-Identifier: Apache-2.0
// From entities and physical groups of Gmsh to tags, groups and data of a mesh.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>

#include "backend/span.hpp"
#include "io/msh/msh_model.hpp"
#include "math/constants.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

bool has_groups(const std::vector<MshCell>& cells) {
  return std::any_of(cells.begin(), cells.end(), [](const MshCell& cell) { return !cell.groups.empty(); });
}

/// The tags of cells: the number of the group of an entity in exactly one, minus the number of the entity in others
/// (the next free one for a negative number), and the number of the entity in files without groups. The known tags of
/// entities in no group take precedence.
std::vector<int> tags_of(const MshModel& model) {
  const bool grouped = has_groups(model.cells);
  using EntityGroups = std::pair<std::array<int, 2>, std::vector<int>>;
  std::map<EntityGroups, int> known;
  std::set<std::pair<int, int>> taken;  // dimension and tag
  std::vector<int> tags;
  for (const MshCell& cell : model.cells) {
    const auto [at, is_new] = known.try_emplace(EntityGroups{{cell.dimension, cell.entity}, cell.groups}, cell.entity);
    if (!is_new) {
      tags.push_back(at->second);
      continue;
    }
    const auto loose = model.loose_tags.find({cell.dimension, cell.entity});
    if (cell.groups.size() == 1) {
      at->second = cell.groups[0];
    } else if (cell.groups.empty() && loose != model.loose_tags.end()) {
      at->second = loose->second;
    } else if (grouped) {
      // Elements of one entity may be in different groups; those in several need different tags.
      int tag = -std::abs(cell.entity);
      while (!taken.emplace(cell.dimension, tag).second && (!cell.groups.empty() || cell.entity < 0)) {
        tag = tag < 0 && tag > std::numeric_limits<int>::min() + 1 ? tag - 1 : -1;
      }
      at->second = tag;
    }
    tags.push_back(at->second);
  }
  return tags;
}

std::vector<Group> groups_of(const MshModel& model, const std::vector<int>& cell_tags) {
  std::map<std::pair<int, int>, Group> groups;
  for (std::size_t c = 0; c < cell_tags.size(); ++c) {
    const MshCell& cell = model.cells[c];
    if (cell.is_dropped) continue;
    for (const int number : cell.groups) {
      Group& group = groups.try_emplace({cell.dimension, number}, Group{cell.dimension, number, {}, {}}).first->second;
      group.tags.push_back(cell_tags[c]);
    }
  }
  for (const MshName& name : model.names) {
    groups.try_emplace({name.dimension, name.number}, Group{name.dimension, name.number, {}, {}}).first->second.name =
        name.name;
  }
  std::vector<Group> list;
  for (auto& [key, group] : groups) {
    sort_unique(group.tags);
    list.push_back(std::move(group));
  }
  return list;
}

std::vector<int> by_element(const MshElements& elements, const std::vector<int>& by_cell) {
  std::vector<int> values(elements.cell.size());
  std::transform(elements.cell.begin(), elements.cell.end(), values.begin(),
                 [&by_cell](Index cell) { return span_of(by_cell)[cell]; });
  return values;
}

template <std::size_t N>
void unpack(const std::vector<Index>& corners, std::vector<std::array<Index, N>>& elements) {
  elements.resize(corners.size() / N);
  if (!corners.empty()) std::memcpy(elements.data(), corners.data(), corners.size() * sizeof(Index));
}

/// Adds the values of a view that belong to the elements or nodes that find() gives a position.
template <class Find>
void add_view(const MshView& view, std::size_t entries, std::vector<DataArray>& data, const Find& find) {
  const auto each = to_size_t(view.components);
  std::vector<double> all;
  for (std::size_t i = 0; i < view.numbers.size(); ++i) {
    const Index at = find(view.numbers[i]);
    if (at < 0) continue;
    if (all.empty()) all.assign(entries * each, kNan);
    std::copy_n(&view.values[i * each], each, &all[to_size_t(at) * each]);
  }
  if (all.empty()) return;
  std::erase_if(data, [&view](const DataArray& array) { return array.name == view.name; });
  data.push_back({view.name, view.components, std::move(all)});
}

class Builder {
 public:
  Builder(MshModel model, const IoContext& context) : model_(std::move(model)), context_(context) {}

  TetMesh build() {
    mesh_.dialect = std::move(model_.dialect);
    mesh_.points = std::move(model_.points);
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    mesh_.periodic = std::move(model_.periodic);
    mesh_.others = blocks_of_lists();
    set_tags();
    set_elements();
    add_views();
    std::erase_if(mesh_.others, [](const ElementBlock& block) { return block.tags.empty(); });
    erase_mid_side_nodes();
    return std::move(mesh_);
  }

 private:
  void erase_mid_side_nodes() {
    // Elements that the file repeats are one.
    for (const std::size_t list : {kMshTets, kMshTriangles, kMshEdges}) {
      const std::vector<std::uint8_t>& flags = model_.elements[list].has_middles;
      model_.middles.complete[to_size_t(msh_type_of(list).dimension)] =
          to_size_t(std::count(flags.begin(), flags.end(), 1));
    }
    const auto number_of = [this](Index v) { return model_.nodes.number(v); };
    for (const std::string& warning : erase_middles(model_.middles, mesh_, number_of)) context_.warn(warning);
  }

  std::vector<DataArray>& data(std::size_t list) {
    if (list == kMshTets) return mesh_.tet_data;
    if (list == kMshTriangles) return mesh_.triangle_data;
    if (list == kMshEdges) return mesh_.edge_data;
    return mesh_.others[list - kMshFirstOther].data;
  }
  std::vector<int>& tags(std::size_t list) {
    if (list == kMshTets) return mesh_.tet_tags;
    if (list == kMshTriangles) return mesh_.triangle_tags;
    if (list == kMshEdges) return mesh_.edge_tags;
    return mesh_.others[list - kMshFirstOther].tags;
  }

  /// Tags, groups, and the numbers of entities and partitions as data.
  void set_tags() {
    const bool grouped = has_groups(model_.cells);
    mesh_.cell_tags_name = grouped ? kMshGroupTags : kMshEntityTags;
    const std::vector<int> cell_tags = tags_of(model_);
    mesh_.groups = groups_of(model_, cell_tags);
    std::vector<int> entities, partitions;
    for (const MshCell& cell : model_.cells) {
      entities.push_back(cell.entity);
      partitions.push_back(cell.partition);
    }
    const bool partitioned = std::any_of(partitions.begin(), partitions.end(), [](int p) { return p != 0; });
    for (std::size_t list = 0; list < kMshLists; ++list) {
      const MshElements& elements = model_.elements[list];
      tags(list) = by_element(elements, cell_tags);
      if (elements.cell.empty()) continue;
      if (grouped) data(list).push_back({kMshEntities, 1, by_element(elements, entities)});
      if (partitioned) data(list).push_back({kMshPartitions, 1, by_element(elements, partitions)});
    }
    if (partitioned) {
      context_.warn(std::string("the partitions are kept as the data \"") + kMshPartitions +
                    "\" of elements, which are written as data; to partition the result: gmsh -part N");
    }
  }

  void set_elements() {
    unpack(model_.elements[kMshTets].corners, mesh_.tets);
    unpack(model_.elements[kMshTriangles].corners, mesh_.triangles);
    unpack(model_.elements[kMshEdges].corners, mesh_.edges);
    for (std::size_t list = kMshFirstOther; list < kMshLists; ++list) {
      mesh_.others[list - kMshFirstOther].element2vertex = std::move(model_.elements[list].corners);
    }
  }

  void add_views() {
    std::array<NumberIndex, kMshLists> indices;
    const auto any_on_elements =
        std::any_of(model_.views.begin(), model_.views.end(), [](const MshView& view) { return !view.on_nodes; });
    if (any_on_elements) {
      for (std::size_t list = 0; list < kMshLists; ++list) indices[list] = NumberIndex(model_.elements[list].number);
    }
    for (const MshView& view : model_.views) {
      if (view.on_nodes) {
        add_view(view, mesh_.points.size(), mesh_.point_data, [this](std::int64_t n) { return model_.nodes.rank(n); });
        continue;
      }
      for (std::size_t list = 0; list < kMshLists; ++list) {
        const NumberIndex& index = indices[list];
        add_view(view, model_.elements[list].number.size(), data(list), [&index](std::int64_t n) {
          const Index rank = index.rank(n);
          return rank < 0 ? rank : span_of(index.order())[rank];
        });
      }
    }
  }

  MshModel model_;
  const IoContext& context_;
  TetMesh mesh_;
};

}  // namespace

TetMesh mesh_of(MshModel model, const IoContext& context) { return Builder(std::move(model), context).build(); }

}  // namespace tetune
