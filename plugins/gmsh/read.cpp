// SPDX-License-Identifier: GPL-2.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "gmsh_mesh.hpp"
#include "io/second_order.hpp"

namespace tetune::plugin {
namespace {

/// The map from Gmsh's numbers, which may have gaps, to indices.
class Numbers {
 public:
  explicit Numbers(std::vector<std::size_t> sorted) : sorted_(std::move(sorted)) {}
  Index find(std::size_t number) const {
    const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), number);
    if (at == sorted_.end() || *at != number) return -1;
    return Index(at - sorted_.begin());
  }

 private:
  std::vector<std::size_t> sorted_;
};

/// The elements of one kind: their data, and their numbers in Gmsh.
struct FoundKind {
  std::vector<int> geometrical;
  std::vector<std::size_t> elements;
};

class Reader {
 public:
  Reader(TetMesh& mesh, Warnings& warnings) : mesh_(mesh), warnings_(warnings) {}

  void read() {
    const Numbers nodes = read_nodes();
    read_groups();
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities);
    for (const auto& [dimension, entity] : entities) read_entity(nodes, dimension, entity);
    if (grouped_) {
      // The tag is the number of the group; the number of the entity is kept as data.
      add_data(mesh_.tet_data, kGeometrical, tets_.geometrical);
      add_data(mesh_.triangle_data, kGeometrical, triangles_.geometrical);
      add_data(mesh_.edge_data, kGeometrical, edges_.geometrical);
      for (std::size_t k = 0; k < others_.size(); ++k) {
        add_data(others_[k].data, kGeometrical, other_kinds_[k].geometrical);
      }
    }
    read_views(nodes);
    for (ElementBlock& block : others_) {
      if (!block.tags.empty()) mesh_.others.push_back(std::move(block));
    }
    for (std::string& warning : erase_middles(middles_, mesh_)) warnings_.push_back(std::move(warning));
  }

 private:
  Numbers read_nodes() {
    std::vector<std::size_t> numbers;
    std::vector<double> x;
    std::vector<double> none;
    gmsh::model::mesh::getNodes(numbers, x, none, -1, -1, false, false);
    if (std::ssize(numbers) > std::numeric_limits<Index>::max()) {
      throw FileError("more than 2^31 nodes");
    }
    std::vector<std::size_t> order(numbers.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return numbers[a] < numbers[b]; });
    std::vector<std::size_t> sorted;
    sorted.reserve(order.size());
    for (const std::size_t i : order) {
      if (!sorted.empty() && sorted.back() == numbers[i]) {
        throw FileError("node " + std::to_string(numbers[i]) + " occurs twice");
      }
      sorted.push_back(numbers[i]);
      mesh_.points.push_back({x[3 * i], x[3 * i + 1], x[3 * i + 2]});
    }
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    return Numbers(std::move(sorted));
  }

  void read_groups() {
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    grouped_ = !groups.empty();
    mesh_.cell_tags_name = grouped_ ? kPhysical : kGeometrical;
    for (const auto& [dimension, number] : groups) {
      Group group{dimension, number, {}, {}};
      gmsh::model::getPhysicalName(dimension, number, group.name);
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dimension, number, entities);
      for (const int entity : entities) group.tags.push_back(tag_of(dimension, std::abs(entity)));
      std::sort(group.tags.begin(), group.tags.end());
      group.tags.erase(std::unique(group.tags.begin(), group.tags.end()), group.tags.end());
      mesh_.groups.push_back(std::move(group));
    }
  }

  /// The number of the entity's physical group; minus its own where it is in several or in none; its own where the
  /// file has no groups.
  int tag_of(int dimension, int entity) const {
    const std::vector<int> groups = groups_of(dimension, entity);
    if (!grouped_) return entity;
    return groups.size() == 1 ? std::abs(groups[0]) : -entity;
  }

  static std::vector<int> groups_of(int dimension, int entity) {
    std::vector<int> groups;
    gmsh::model::getPhysicalGroupsForEntity(dimension, entity, groups);
    return groups;
  }

  struct Entity {
    int number;
    int tag;
    bool has_several_groups;
  };

  void read_entity(const Numbers& nodes, int dimension, int number) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> elements;
    std::vector<std::vector<std::size_t>> corners;
    gmsh::model::mesh::getElements(types, elements, corners, dimension, number);
    if (types.empty()) return;
    const Entity entity{number, tag_of(dimension, number), groups_of(dimension, number).size() > 1};
    for (std::size_t i = 0; i < types.size(); ++i) read_elements(nodes, entity, types[i], elements[i], corners[i]);
  }

  void read_elements(const Numbers& nodes, const Entity& entity, int type, const std::vector<std::size_t>& elements,
                     const std::vector<std::size_t>& corners) {
    if (elements.empty()) return;
    const std::size_t each = corners.size() / elements.size();
    std::vector<Index> v(each);
    // Version 2.2 lists an element once for each of its groups.
    std::set<std::vector<std::size_t>> seen;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const auto numbers = entry_of(corners, std::int64_t(e), each);
      if (entity.has_several_groups && !seen.emplace(numbers.begin(), numbers.end()).second) continue;
      for (std::size_t k = 0; k < each; ++k) {
        v[k] = nodes.find(numbers[k]);
        if (v[k] < 0) {
          throw FileError("element " + std::to_string(elements[e]) + " has node " + std::to_string(numbers[k]) +
                          ", which does not exist");
        }
      }
      add(type, v, elements[e], entity);
    }
  }

  void add(int type, const std::vector<Index>& v, std::size_t element, const Entity& entity) {
    const auto note = [&](FoundKind& kind, std::vector<int>& tags) {
      tags.push_back(entity.tag);
      kind.geometrical.push_back(entity.number);
      kind.elements.push_back(element);
    };
    switch (type) {
      case kTet10:
        add_middles(v, kGmshTetEdges, middles_);
        [[fallthrough]];
      case kTet:
        mesh_.tets.push_back({v[0], v[1], v[2], v[3]});
        return note(tets_, mesh_.tet_tags);
      case kTriangle6:
        add_middles(v, kTriangleEdges, middles_);
        [[fallthrough]];
      case kTriangle:
        mesh_.triangles.push_back({v[0], v[1], v[2]});
        return note(triangles_, mesh_.triangle_tags);
      case kEdge3:
        add_middles(v, kEdgeEdges, middles_);
        [[fallthrough]];
      case kEdge:
        mesh_.edges.push_back({v[0], v[1]});
        return note(edges_, mesh_.edge_tags);
      default:
        break;
    }
    const auto at = std::find(kOtherTypes.begin(), kOtherTypes.end(), type);
    if (at == kOtherTypes.end()) {
      std::string name;
      int dimension = 0;
      int order = 0;
      int all = 0;
      int first_order = 0;
      std::vector<double> places;
      gmsh::model::mesh::getElementProperties(type, name, dimension, order, all, places, first_order);
      const std::string found = "element " + std::to_string(element) + " is a \"" + name + "\"";
      const bool is_other = first_order != dimension + 1;
      if (is_other && order == 2) throw FileError(found + ": " + kNodesOnFaces);
      throw FileError(found +
                      ", which tetune does not read; it reads points, and lines, triangles, tetrahedra, "
                      "quadrilaterals, pyramids, prisms and hexahedra of first or second order");
    }
    const std::size_t k(at - kOtherTypes.begin());
    ElementBlock& block = others_[k];
    block.element2vertex.insert(block.element2vertex.end(), v.begin(), v.begin() + block.vertices_per_element);
    note(other_kinds_[k], block.tags);
    if (block.second_order) add_middles(v, edges_of_kind(block.kind, MiddleOrder::gmsh), middles_);
  }

  template <class T>
  static void add_data(std::vector<DataArray>& data, const std::string& name, const std::vector<T>& values) {
    if (!values.empty()) data.push_back({name, 1, values});
  }

  /// Data of nodes and elements: the first step of each view.
  void read_views(const Numbers& nodes) {
    std::vector<int> views;
    gmsh::view::getTags(views);
    for (const int view : views) {
      const std::string option = "View[" + std::to_string(gmsh::view::getIndex(view)) + "].";
      std::string name;
      gmsh::option::getString(option + "Name", name);
      double steps = 1;
      gmsh::option::getNumber(option + "NbTimeStep", steps);
      if (steps > 1) warnings_.push_back("of the data \"" + name + "\" the first step is kept");
      std::string type;
      std::vector<std::size_t> numbers;
      std::vector<std::vector<double>> values;
      double time = 0;
      int components = 0;
      gmsh::view::getModelData(view, 0, type, numbers, values, time, components);
      if (components < 1 || (type != "NodeData" && type != "ElementData")) {
        warnings_.push_back("the data \"" + name + "\" of type \"" + type + "\" is not kept");
        continue;
      }
      const std::size_t each(components);
      const auto add = [&](std::size_t entries, std::vector<DataArray>& data, const auto& find) {
        std::vector<double> all(entries * each, std::numeric_limits<double>::quiet_NaN());
        bool found = false;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
          const Index at = find(numbers[i]);
          if (at < 0 || values[i].size() != each) continue;
          found = true;
          std::copy(values[i].begin(), values[i].end(), entry_of(all, at, each).begin());
        }
        if (found) data.push_back({name, components, std::move(all)});
      };
      if (type == "NodeData") {
        add(mesh_.points.size(), mesh_.point_data, [&nodes](std::size_t n) { return nodes.find(n); });
        continue;
      }
      const auto add_elements = [&](const FoundKind& kind, std::vector<DataArray>& data) {
        std::map<std::size_t, Index> position;
        for (std::size_t e = 0; e < kind.elements.size(); ++e) position[kind.elements[e]] = Index(e);
        add(kind.elements.size(), data, [&position](std::size_t n) {
          const auto at = position.find(n);
          return at == position.end() ? -1 : at->second;
        });
      };
      add_elements(tets_, mesh_.tet_data);
      add_elements(triangles_, mesh_.triangle_data);
      add_elements(edges_, mesh_.edge_data);
      for (std::size_t k = 0; k < others_.size(); ++k) add_elements(other_kinds_[k], others_[k].data);
    }
  }

  TetMesh& mesh_;
  Warnings& warnings_;
  bool grouped_ = false;
  FoundKind tets_, triangles_, edges_;
  std::vector<ElementBlock> others_ = blocks_of_lists();
  std::array<FoundKind, kOtherLists> other_kinds_;
  MiddleList middles_;
};

}  // namespace

TetMesh from_gmsh(Warnings& warnings) {
  TetMesh mesh;
  Reader(mesh, warnings).read();
  return mesh;
}

}  // namespace tetune::plugin
