// SPDX-License-Identifier: GPL-2.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <set>

#include "gmsh_mesh.hpp"
#include "second_order.hpp"

namespace tetune::plugin {
namespace {

constexpr std::array<Pair, 6> kTet10Edges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {2, 3}, {1, 3}}};

/// The elements of one kind on their way to Gmsh.
struct Kind {
  int dimension;
  int type;
  std::size_t corners;  ///< nodes of an element that are vertices of the mesh
  std::vector<Index> element2vertex;
  const std::vector<int>* tags;
  const std::vector<DataArray>* data;
  std::vector<Pair> middles;
  std::vector<int> entities;
  std::size_t first_element = 0;  ///< number of the first one
  std::size_t size() const { return tags->size(); }
};

const DataArray* find(const std::vector<DataArray>& data, const std::string& name) {
  const auto at = std::find_if(data.begin(), data.end(), [&name](const DataArray& a) { return a.name == name; });
  return at == data.end() ? nullptr : &*at;
}

template <std::size_t N>
Kind kind_of(int dimension, int type, const std::vector<std::array<Index, N>>& elements, const std::vector<int>& tags,
             const std::vector<DataArray>& data, std::vector<Pair> middles) {
  Kind kind{dimension, type, N, {}, &tags, &data, std::move(middles), {}};
  for (const auto& e : elements) kind.element2vertex.insert(kind.element2vertex.end(), e.begin(), e.end());
  return kind;
}

std::vector<Kind> kinds_of(const TetMesh& mesh) {
  const auto pairs = [&mesh](const auto& edges) {
    return mesh.second_order ? std::vector<Pair>(edges.begin(), edges.end()) : std::vector<Pair>();
  };
  const bool second = mesh.second_order;
  std::vector<Kind> kinds;
  kinds.push_back(kind_of(3, second ? kTet10 : kTet, mesh.tets, mesh.tet_tags, mesh.tet_data, pairs(kTet10Edges)));
  kinds.push_back(kind_of(2, second ? kTriangle6 : kTriangle, mesh.triangles, mesh.triangle_tags, mesh.triangle_data,
                          pairs(kTriangleEdges)));
  kinds.push_back(kind_of(1, second ? kEdge3 : kEdge, mesh.edges, mesh.edge_tags, mesh.edge_data, pairs(kEdgeEdges)));
  for (const ElementBlock& block : mesh.others) {
    const auto* const other = std::find_if(std::begin(kOtherKinds), std::end(kOtherKinds),
                                           [&block](const OtherKind& k) { return k.name == block.kind; });
    if (other == std::end(kOtherKinds)) throw FileError("Gmsh has no elements of kind " + block.kind);
    kinds.push_back({other->dimension,
                     kOtherTypes[static_cast<std::size_t>(other - std::begin(kOtherKinds))],
                     static_cast<std::size_t>(other->vertices),
                     block.element2vertex,
                     &block.tags,
                     &block.data,
                     {},
                     {}});
  }
  return kinds;
}

/// Gives each element the entity that it came from, if that is known and all elements of one have the same tag. Returns
/// the entities with their tags; none if it is not so.
std::map<int, int> known_entities(std::vector<Kind>& kinds, int dimension) {
  std::map<int, int> entity2tag;
  for (Kind& kind : kinds) {
    if (kind.dimension != dimension || kind.size() == 0) continue;
    const DataArray* array = find(*kind.data, kGeometrical);
    kind.entities.clear();
    if (array != nullptr && array->components == 1) {
      std::visit(
          [&kind](const auto& values) {
            for (const auto v : values) {
              const auto number = static_cast<double>(v);
              const bool possible = number >= 1 && number <= std::numeric_limits<int>::max();
              kind.entities.push_back(possible ? static_cast<int>(number) : 0);
            }
          },
          array->values);
    }
    if (kind.entities.size() != kind.size()) return {};
    for (std::size_t e = 0; e < kind.size(); ++e) {
      const auto [at, fresh] = entity2tag.try_emplace(kind.entities[e], (*kind.tags)[e]);
      if (kind.entities[e] <= 0 || at->second != (*kind.tags)[e]) return {};
    }
  }
  return entity2tag;
}

/// Gives the elements of each tag an entity of the tag's number; where that cannot be one, of minus that number, as
/// from_gmsh() takes entities in no group, or of one that is not taken. Returns the entities with their tags.
std::map<int, int> entities_of_tags(std::vector<Kind>& kinds, int dimension, std::set<int> taken, int largest) {
  std::map<int, int> tag2entity;
  for (const Kind& kind : kinds) {
    if (kind.dimension != dimension) continue;
    for (const int tag : *kind.tags) tag2entity[tag] = 0;
    taken.insert(kind.tags->begin(), kind.tags->end());
  }
  FreeNumbers free_numbers(std::move(taken));
  for (auto& [tag, entity] : tag2entity) {
    if (tag > 0 && tag <= largest) entity = tag;
    if (tag < 0 && tag >= -largest && free_numbers.take(-tag)) entity = -tag;
  }
  std::map<int, int> entity2tag;
  for (auto& [tag, entity] : tag2entity) {
    if (entity == 0) entity = free_numbers.take_lowest();
    entity2tag[entity] = tag;
  }
  for (Kind& kind : kinds) {
    if (kind.dimension != dimension) continue;
    kind.entities.clear();
    for (const int tag : *kind.tags) kind.entities.push_back(tag2entity[tag]);
  }
  return entity2tag;
}

std::map<int, int> find_entities(std::vector<Kind>& kinds, int dimension, const std::vector<Group>& groups,
                                 const Format& format) {
  if (format.msh_version > 0) {
    std::map<int, int> known = known_entities(kinds, dimension);
    if (!known.empty()) return known;
  }
  // add_groups() makes groups of such numbers, and I-deas' files have one list of groups for all dimensions.
  std::set<int> taken;
  for (const Group& group : groups) {
    if (format.msh_version == 0 && format.groups) taken.insert(group.number);
  }
  return entities_of_tags(kinds, dimension, std::move(taken), format.largest);
}

/// For each entity of a dimension those one lower that bound it: that share a side with it.
class Boundaries {
 public:
  Boundaries(const std::vector<Kind>& kinds, int dimension) {
    if (dimension == 0) return;
    using Side = std::vector<Index>;
    std::vector<std::pair<Side, int>> sides;
    for (const Kind& kind : kinds) {
      if (kind.dimension != dimension - 1) continue;
      for (std::size_t e = 0; e < kind.size(); ++e) {
        const auto first = kind.element2vertex.begin() + static_cast<std::ptrdiff_t>(e * kind.corners);
        Side side(first, first + static_cast<std::ptrdiff_t>(kind.corners));
        std::sort(side.begin(), side.end());
        sides.emplace_back(std::move(side), kind.entities[e]);
      }
    }
    std::sort(sides.begin(), sides.end());
    for (const Kind& kind : kinds) {
      // Simplices: their sides are all but one of their vertices.
      if (kind.dimension != dimension || kind.corners != static_cast<std::size_t>(dimension) + 1) continue;
      for (std::size_t e = 0; e < kind.size(); ++e) {
        for (std::size_t left_out = 0; left_out < kind.corners; ++left_out) {
          Side side;
          for (std::size_t k = 0; k < kind.corners; ++k) {
            if (k != left_out) side.push_back(kind.element2vertex[e * kind.corners + k]);
          }
          std::sort(side.begin(), side.end());
          auto at = std::lower_bound(sides.begin(), sides.end(), std::pair{side, 0},
                                     [](const auto& a, const auto& b) { return a.first < b.first; });
          for (; at != sides.end() && at->first == side; ++at) entity2sides_[kind.entities[e]].insert(at->second);
        }
      }
    }
  }
  std::vector<int> of(int entity) const {
    const auto at = entity2sides_.find(entity);
    return at == entity2sides_.end() ? std::vector<int>() : std::vector<int>(at->second.begin(), at->second.end());
  }

 private:
  std::map<int, std::set<int>> entity2sides_;
};

/// Enters the physical groups of one dimension; returns the entities that are in none, with their tags.
std::map<int, int> add_groups(const TetMesh& mesh, int dimension, const std::map<int, int>& entity2tag,
                              const Format& format, Warnings& warnings) {
  std::map<int, int> loose;
  std::map<int, std::vector<int>> number2entities;
  std::vector<std::string> renumbered;
  for (const auto& [entity, tag] : entity2tag) {
    bool grouped = false;
    for (const Group& group : mesh.groups) {
      if (group.dimension != dimension || std::find(group.tags.begin(), group.tags.end(), tag) == group.tags.end()) {
        continue;
      }
      number2entities[group.number].push_back(entity);
      grouped = true;
    }
    if (format.msh_version == 0 && entity != tag && !(grouped && format.groups)) {
      // Where there are groups, a positive tag is that of its group, and what has no tag is in none.
      if (tag < 0 || !format.groups) {
        renumbered.push_back(std::to_string(tag) + " is written as " + std::to_string(entity));
      }
    }
    // A tag is a group, unless it came as an entity's number. Other formats than .msh tell what is in no group from
    // what is in another by nothing else.
    const bool from_entity = format.msh_version > 0 && mesh.cell_tags_name == kGeometrical;
    if (!grouped && !from_entity && (tag > 0 || (tag < 0 && format.msh_version == 0))) {
      number2entities[tag > 0 ? tag : entity].push_back(entity);
      grouped = true;
    }
    if (!grouped) loose[entity] = tag;
    if (!grouped && tag < 0 && !mesh.cell_tags_name.starts_with("gmsh")) {
      warnings.push_back("Gmsh's groups have positive numbers: elements of dimension " + std::to_string(dimension) +
                         " with the tag " + std::to_string(tag) + " are entity " + std::to_string(entity) +
                         ", in no group");
    }
  }
  if (!renumbered.empty()) {
    const std::string rest = renumbered.size() == 1 ? "" : ", and " + std::to_string(renumbered.size() - 1) + " more";
    warnings.push_back("the format's numbers are from 1 to " + std::to_string(format.largest) +
                       ": of elements of dimension " + std::to_string(dimension) + " the tag " + renumbered.front() +
                       rest);
  }
  for (const auto& [number, entities] : number2entities) {
    gmsh::model::addPhysicalGroup(dimension, entities, number);
  }
  for (const Group& group : mesh.groups) {
    if (group.dimension != dimension || group.name.empty()) continue;
    if (number2entities.count(group.number) == 0) {
      warnings.push_back("the group \"" + group.name + "\" has no elements; it is not written");
      continue;
    }
    gmsh::model::setPhysicalName(dimension, group.number, group.name);
  }
  return loose;
}

/// Nodes of an element as Gmsh numbers them; without those in the middles of edges where there are no `middles`.
template <class Take>
void for_each_node(const Kind& kind, std::size_t element, const Middles* middles, const Take& take) {
  const Index* v = kind.element2vertex.data() + element * kind.corners;
  for (std::size_t k = 0; k < kind.corners; ++k) take(static_cast<std::size_t>(v[k]) + 1);
  if (middles == nullptr) return;
  for (const Pair& p : kind.middles) take(static_cast<std::size_t>(middles->of(v[p[0]], v[p[1]])) + 1);
}

/// Not 0 for each node, numbered from 1, that an element has: Gmsh writes no others.
std::vector<std::uint8_t> used_nodes(const TetMesh& mesh, const std::vector<Kind>& kinds, const Middles* middles) {
  std::vector<std::uint8_t> used(mesh.points.size() + 1, 0);
  for (const Kind& kind : kinds) {
    for (std::size_t e = 0; e < kind.size(); ++e) {
      for_each_node(kind, e, middles, [&used](std::size_t node) { used[node] = 1; });
    }
  }
  return used;
}

/// With `classify` each node belongs to the entity of lowest dimension that has it, without it all belong to `home`.
void add_nodes(const TetMesh& mesh, const std::vector<Kind>& kinds, const Middles* middles, std::pair<int, int> home,
               bool classify) {
  std::vector<std::pair<int, int>> owner(mesh.points.size() + 1, {-1, 0});
  for (const Kind& kind : kinds) {
    if (!classify) break;
    for (std::size_t e = 0; e < kind.size(); ++e) {
      for_each_node(kind, e, middles, [&](std::size_t node) {
        if (owner[node].first < 0) owner[node] = {kind.dimension, kind.entities[e]};
      });
    }
  }
  struct Nodes {
    std::vector<std::size_t> numbers;
    std::vector<double> x;
  };
  std::map<std::pair<int, int>, Nodes> entity2nodes;
  const std::vector<std::uint8_t> used = used_nodes(mesh, kinds, middles);
  for (std::size_t node = 1; node < owner.size(); ++node) {
    if (used[node] == 0) continue;
    Nodes& nodes = entity2nodes[owner[node].first < 0 ? home : owner[node]];
    nodes.numbers.push_back(node);
    nodes.x.insert(nodes.x.end(), mesh.points[node - 1].begin(), mesh.points[node - 1].end());
  }
  for (const auto& [entity, nodes] : entity2nodes) {
    gmsh::model::mesh::addNodes(entity.first, entity.second, nodes.numbers, nodes.x);
  }
}

void add_elements(const Kind& kind, const Middles* middles) {
  std::map<int, std::pair<std::vector<std::size_t>, std::vector<std::size_t>>> entity2elements;
  for (std::size_t e = 0; e < kind.size(); ++e) {
    auto& [numbers, nodes] = entity2elements[kind.entities[e]];
    numbers.push_back(kind.first_element + e);
    for_each_node(kind, e, middles, [&nodes = nodes](std::size_t node) { nodes.push_back(node); });
  }
  for (const auto& [entity, elements] : entity2elements) {
    gmsh::model::mesh::addElementsByType(entity, kind.type, elements.first, elements.second);
  }
}

/// Numbers elements from the lowest dimension up, as Gmsh does.
void number_elements(std::vector<Kind>& kinds) {
  std::stable_sort(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) { return a.dimension < b.dimension; });
  std::size_t next = 1;
  for (Kind& kind : kinds) {
    kind.first_element = next;
    next += kind.size();
  }
}

void warn_of_lists(const TetMesh& mesh, Warnings& warnings) {
  const bool listed = !mesh.corners.empty() || !mesh.required_vertices.empty() || !mesh.ridges.empty() ||
                      !mesh.required_edges.empty() || !mesh.required_triangles.empty() || !mesh.required_tets.empty();
  if (listed) warnings.push_back("there is no room for lists of corners, ridges and required entities");
  const auto any = [](const std::vector<int>& tags) {
    return std::any_of(tags.begin(), tags.end(), [](int t) { return t != 0; });
  };
  if (any(mesh.point_tags)) warnings.push_back("there is no room for tags of vertices");
}

}  // namespace

Handover to_gmsh(TetMesh mesh, Format& format, Warnings& warnings) {
  warn_of_lists(mesh, warnings);
  const auto middles = mesh.second_order ? std::make_unique<Middles>(mesh) : nullptr;
  std::vector<Kind> kinds = kinds_of(mesh);
  number_elements(kinds);
  gmsh::model::add("tetune");
  EntityTags loose;
  std::pair<int, int> home{-1, 0};  // an entity of the highest dimension, for the nodes to start on
  for (int dimension = 0; dimension <= 3; ++dimension) {
    const std::map<int, int> entity2tag = find_entities(kinds, dimension, mesh.groups, format);
    const Boundaries boundaries(kinds, dimension);
    for (const auto& [entity, tag] : entity2tag) {
      gmsh::model::addDiscreteEntity(dimension, entity, boundaries.of(entity));
      home = {dimension, entity};
    }
    for (const auto& [entity, tag] : add_groups(mesh, dimension, entity2tag, format, warnings)) {
      loose[{dimension, entity}] = tag;
    }
  }
  if (home.first < 0) throw FileError("the mesh has no elements; Gmsh writes none without");
  const std::vector<std::uint8_t> used = used_nodes(mesh, kinds, middles.get());
  if (const auto unused = std::count(used.begin() + 1, used.end(), 0); unused > 0) {
    warnings.push_back(std::to_string(unused) + " vertices are in no element; Gmsh does not write them");
  }
  Handover done;
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  const bool any_group = !groups.empty();
  done.all_grouped = loose.empty();
  for (const auto& [entity, tag] : loose) {
    if (tag != (any_group ? -entity.second : entity.second)) done.loose_tags[entity] = tag;
  }
  if (format.msh_version == 0 && format.groups && !any_group) {
    warnings.emplace_back("nothing has a tag: the number 1 is written for it");
  }
  if (format.msh_version > 0 && format.msh_version < 4 && any_group && !done.all_grouped) {
    format.msh_version = 4.1;
    warnings.emplace_back("Gmsh writes no groups to version 2.2 where elements are in none; this is version 4.1");
  }
  // In formats that do not tell the entities of nodes, Gmsh numbers nodes entity by entity: all are on one.
  add_nodes(mesh, kinds, middles.get(), home, format.msh_version > 4);
  for (const Kind& kind : kinds) add_elements(kind, middles.get());
  return done;
}

void warn_of_data(const TetMesh& mesh, Warnings& warnings) {
  std::set<std::string> names;
  const auto add = [&names](const std::vector<DataArray>& data) {
    for (const DataArray& array : data) {
      if (array.name != kGeometrical) names.insert(array.name);
    }
  };
  add(mesh.point_data);
  for (const Kind& kind : kinds_of(mesh)) add(*kind.data);
  for (const std::string& name : names) warnings.push_back("there is no room for the data \"" + name + "\"");
}

void append_data(const std::string& file, const TetMesh& mesh, Warnings& warnings) {
  std::vector<Kind> kinds = kinds_of(mesh);
  number_elements(kinds);
  gmsh::option::setNumber("PostProcessing.SaveMesh", 0);
  const auto append = [&](const std::string& name, const char* type, const std::vector<std::size_t>& numbers,
                          const std::vector<double>& values, int components) {
    if (components != 1 && components != 3 && components != 9) {
      warnings.push_back("Gmsh has no room for the data \"" + name + "\" of " + std::to_string(components) +
                         " components: 1, 3 or 9 are possible");
      return;
    }
    const int view = gmsh::view::add(name);
    gmsh::view::addHomogeneousModelData(view, 0, "tetune", type, numbers, values, 0, components);
    gmsh::view::write(view, file, true);
  };
  const auto as_doubles = [](const DataArray& array) {
    return std::visit([](const auto& v) { return std::vector<double>(v.begin(), v.end()); }, array.values);
  };
  const std::vector<std::uint8_t> used = used_nodes(mesh, kinds, nullptr);
  for (const DataArray& array : mesh.point_data) {
    const std::vector<double> all = as_doubles(array);
    const auto each = static_cast<std::size_t>(array.components);
    std::vector<std::size_t> numbers;
    std::vector<double> values;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      if (used[v + 1] == 0) continue;
      numbers.push_back(v + 1);
      for (std::size_t c = 0; c < each; ++c) values.push_back(all[v * each + c]);
    }
    append(array.name, "NodeData", numbers, values, array.components);
  }
  // One name is one view, whatever kinds of elements have it.
  std::set<std::string> done{kGeometrical};
  for (const Kind& kind : kinds) {
    for (const DataArray& array : *kind.data) {
      if (!done.insert(array.name).second) continue;
      std::vector<std::size_t> numbers;
      std::vector<double> values;
      for (const Kind& other : kinds) {
        const DataArray* same = find(*other.data, array.name);
        if (same == nullptr || same->components != array.components) continue;
        const std::vector<double> own = as_doubles(*same);
        values.insert(values.end(), own.begin(), own.end());
        for (std::size_t e = 0; e < other.size(); ++e) numbers.push_back(other.first_element + e);
      }
      append(array.name, "ElementData", numbers, values, array.components);
    }
  }
}

}  // namespace tetune::plugin
