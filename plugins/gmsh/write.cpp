// SPDX-License-Identifier: GPL-2.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "entities.hpp"
#include "io/losses.hpp"

namespace tetune::plugin {
namespace {

/// Adds the physical groups of one dimension to the model; returns whether every entity is in one.
bool add_groups(const TetMesh& mesh, int dimension, const std::map<int, int>& entity2tag, Warnings& warnings) {
  bool all_grouped = true;
  std::map<int, std::vector<int>> number2entities;
  std::map<int, std::set<int>> number2tags;  // of entities in one group alone
  std::vector<std::string> renumbered;
  for (const auto& [entity, tag] : entity2tag) {
    std::vector<int> numbers;
    for (const Group& group : mesh.groups) {
      if (group.dimension != dimension || std::find(group.tags.begin(), group.tags.end(), tag) == group.tags.end()) {
        continue;
      }
      number2entities[group.number].push_back(entity);
      numbers.push_back(group.number);
    }
    const bool grouped = !numbers.empty();
    if (numbers.size() == 1) number2tags[numbers[0]].insert(tag);
    // A positive tag is that of its group, and elements without a tag are in none.
    if (entity != tag && !grouped && tag < 0) {
      renumbered.push_back(std::to_string(tag) + " is written as " + std::to_string(entity));
    }
    // Groups are all that distinguishes elements without a tag.
    if (!grouped && tag != 0) number2entities[tag > 0 ? tag : entity].push_back(entity);
    all_grouped = all_grouped && (grouped || tag != 0);
  }
  if (!renumbered.empty()) {
    const std::string rest = renumbered.size() == 1 ? "" : ", and " + std::to_string(renumbered.size() - 1) + " more";
    warnings.push_back("the format's numbers are positive: of elements of dimension " + std::to_string(dimension) +
                       " the tag " + renumbered.front() + rest);
  }
  for (const auto& [number, entities] : number2entities) {
    gmsh::model::addPhysicalGroup(dimension, entities, number);
  }
  for (const Group& group : mesh.groups) {
    if (group.dimension != dimension || group.name.empty()) continue;
    if (number2entities.count(group.number) == 0) {
      warn_of_empty_group(group, {0, &warnings});
      continue;
    }
    gmsh::model::setPhysicalName(dimension, group.number, group.name);
    if (const std::size_t tags = number2tags[group.number].size(); tags > 1) {
      warn_of_merged_tags(group, tags, {0, &warnings});
    }
  }
  return all_grouped;
}

/// Calls take(node) for the nodes of an element, numbered from 1; for middle nodes only where `middles` is given.
template <class Take>
void for_each_node(const Kind& kind, std::size_t element, const Middles* middles, const Take& take) {
  const Index* v = kind.element2vertex.data() + element * kind.corners;
  for (std::size_t k = 0; k < kind.corners; ++k) take(std::size_t(v[k]) + 1);
  if (middles == nullptr) return;
  for (const Pair& p : kind.middles) take(std::size_t(middles->of(v[p[0]], v[p[1]])) + 1);
}

/// 1 for each node, numbered from 1, that an element has: Gmsh writes no others.
std::vector<std::uint8_t> used_nodes(const TetMesh& mesh, const std::vector<Kind>& kinds, const Middles* middles) {
  std::vector<std::uint8_t> used(mesh.points.size() + 1, 0);
  for (const Kind& kind : kinds) {
    for (std::size_t e = 0; e < kind.size(); ++e) {
      for_each_node(kind, e, middles, [&used](std::size_t node) { used[node] = 1; });
    }
  }
  return used;
}

/// Adds the nodes to one entity: Gmsh numbers nodes entity by entity, and so keeps their order.
void add_nodes(const TetMesh& mesh, const std::vector<std::uint8_t>& used, std::pair<int, int> entity) {
  std::vector<std::size_t> numbers;
  std::vector<double> x;
  for (std::size_t node = 1; node < used.size(); ++node) {
    if (used[node] == 0) continue;
    numbers.push_back(node);
    x.insert(x.end(), mesh.points[node - 1].begin(), mesh.points[node - 1].end());
  }
  gmsh::model::mesh::addNodes(entity.first, entity.second, numbers, x);
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

}  // namespace

bool to_gmsh(TetMesh mesh, Warnings& warnings) {
  warn_of_lists(mesh, {0, &warnings});
  warn_of_point_tags(mesh, {0, &warnings});
  const auto middles = mesh.second_order ? std::make_unique<Middles>(mesh) : nullptr;
  std::vector<Kind> kinds = kinds_of(mesh);
  number_elements(kinds);
  gmsh::model::add("tetune");
  bool all_grouped = true;
  std::pair<int, int> default_entity{-1, 0};  // one of the highest dimension
  for (int dimension = 0; dimension <= 3; ++dimension) {
    const std::map<int, int> entity2tag = find_entities(kinds, dimension, mesh.groups);
    const Boundaries boundaries(kinds, dimension, mesh.points.size());
    for (const auto& [entity, tag] : entity2tag) {
      gmsh::model::addDiscreteEntity(dimension, entity, boundaries.of(entity));
      default_entity = {dimension, entity};
    }
    if (!add_groups(mesh, dimension, entity2tag, warnings)) all_grouped = false;
  }
  if (default_entity.first < 0) throw FileError("the mesh has no elements; Gmsh writes no mesh without them");
  const std::vector<std::uint8_t> used = used_nodes(mesh, kinds, middles.get());
  if (const auto unused = std::count(used.begin() + 1, used.end(), 0); unused > 0) {
    warnings.push_back(std::to_string(unused) + " vertices are in no element; Gmsh does not write them");
  }
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  if (groups.empty()) warnings.emplace_back("nothing has a tag: the number 1 is written for it");
  add_nodes(mesh, used, default_entity);
  for (const Kind& kind : kinds) add_elements(kind, middles.get());
  return all_grouped;
}

}  // namespace tetune::plugin
