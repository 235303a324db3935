// SPDX-License-Identifier: Apache-2.0
#include "io/msh/msh_layout.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "backend/span.hpp"
#include "io/losses.hpp"
#include "io/tag_numbers.hpp"
#include "mesh/listed_faces.hpp"
#include "mesh/whole_number.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The tags of the entities of one dimension, by number.
using EntityTags = std::map<int, int>;

template <std::size_t N>
MshKind kind_of(std::size_t list, const std::vector<std::array<Index, N>>& elements, const std::vector<int>& tags,
                const std::vector<DataArray>& data) {
  return {&msh_type_of(list), elements.empty() ? nullptr : elements.front().data(), &tags, &data};
}

std::vector<MshKind> kinds_of(const TetMesh& mesh) {
  std::vector<MshKind> kinds{kind_of(kMshTets, mesh.tets, mesh.tet_tags, mesh.tet_data),
                             kind_of(kMshTriangles, mesh.triangles, mesh.triangle_tags, mesh.triangle_data),
                             kind_of(kMshEdges, mesh.edges, mesh.edge_tags, mesh.edge_data)};
  for (const ElementBlock& block : mesh.others) {
    const std::size_t list = list_of(mesh, block);
    if (list == kOtherLists) throw FileError("Gmsh has no elements of kind " + block.kind);
    kinds.push_back({&msh_type_of(kMshFirstOther + list), block.element2vertex.data(), &block.tags, &block.data});
  }
  std::erase_if(kinds, [](const MshKind& kind) { return kind.size() == 0; });
  std::stable_sort(kinds.begin(), kinds.end(),
                   [](const MshKind& a, const MshKind& b) { return a.type->dimension < b.type->dimension; });
  std::int64_t next = 1;
  for (MshKind& kind : kinds) {
    kind.first_number = next;
    next += std::ssize(*kind.tags);
  }
  return kinds;
}

/// The numbers of the entities of a kind as its data have them; empty where they are not known.
std::vector<int> known_numbers(const MshKind& kind) {
  std::vector<int> numbers;
  for (const DataArray& array : *kind.data) {
    if (array.name != kMshEntities || array.components != 1) continue;
    const auto add = [&numbers](const auto& values) {
      for (const auto value : values) {
        const std::optional<int> number = whole_number(double(value));
        numbers.push_back(number && *number > 0 ? *number : 0);
      }
    };
    std::visit(add, array.values);
  }
  const bool known = numbers.size() == kind.size() && std::find(numbers.begin(), numbers.end(), 0) == numbers.end();
  return known ? numbers : std::vector<int>();
}

/// The numbers of the entities of each kind, if all are known and the elements of an entity have one tag.
std::vector<std::vector<int>> known_entities(std::span<const MshKind> kinds, EntityTags& tags) {
  std::vector<std::vector<int>> numbers;
  for (const MshKind& kind : kinds) {
    numbers.push_back(known_numbers(kind));
    if (numbers.back().empty()) return {};
    int last = 0;
    for (std::size_t e = 0; e < kind.size(); ++e) {
      const int number = numbers.back()[e];
      if (number == last && (*kind.tags)[e] == (*kind.tags)[e - 1]) continue;
      last = number;
      if (tags.try_emplace(number, (*kind.tags)[e]).first->second != (*kind.tags)[e]) return {};
    }
  }
  return numbers;
}

/// Makes each tag an entity: of the number of the tag, or of minus that number, as the reader expects of entities in no
/// group; else of a free one.
std::vector<std::vector<int>> entities_of_tags(std::span<const MshKind> kinds, EntityTags& tags) {
  std::set<int> used;
  for (const MshKind& kind : kinds) {
    for (std::size_t e = 0; e < kind.size(); ++e) {
      if (e == 0 || (*kind.tags)[e] != (*kind.tags)[e - 1]) used.insert((*kind.tags)[e]);
    }
  }
  std::map<int, int> tag2entity = numbers_of_tags(used, {}, std::numeric_limits<int>::max());
  for (const auto& [tag, entity] : tag2entity) tags[entity] = tag;
  std::vector<std::vector<int>> numbers;
  for (const MshKind& kind : kinds) {
    numbers.emplace_back();
    numbers.back().reserve(kind.size());
    for (std::size_t e = 0; e < kind.size(); ++e) {
      const bool same = e > 0 && (*kind.tags)[e] == (*kind.tags)[e - 1];
      numbers.back().push_back(same ? numbers.back().back() : tag2entity[(*kind.tags)[e]]);
    }
  }
  return numbers;
}

/// Warns of what happens to the elements of a dimension with some tags, of which there may be thousands.
void warn_of_first(int dimension, const std::vector<std::string>& changes, const IoContext& context) {
  if (changes.empty()) return;
  std::string text = "elements of dimension " + std::to_string(dimension) + " " + changes.front();
  if (changes.size() > 1) text += "; likewise those with " + std::to_string(changes.size() - 1) + " more tags";
  context.warn(text);
}

/// The groups of the entities of one dimension: those with the tag of an entity, or one of the number of the tag. A tag
/// that came as the number of an entity is no group.
class GroupsOfTags {
 public:
  GroupsOfTags(const TetMesh& mesh, int dimension, const EntityTags& tags, const IoContext& context) {
    std::set<int> taken;  // numbers of groups
    for (const Group& group : mesh.groups) {
      if (group.dimension != dimension) continue;
      taken.insert(group.number);
      for (const int tag : group.tags) tag2groups_[tag].push_back(group.number);
    }
    if (mesh.cell_tags_name == kMshEntityTags) return;
    std::set<int> loose;
    for (const auto& [number, tag] : tags) {
      if (tag > 0 && !tag2groups_.contains(tag)) loose.insert(tag);
    }
    FreeNumbers free_numbers(taken);
    for (const int tag : loose) {
      if (free_numbers.take(tag)) tag2groups_[tag] = {tag};
    }
    std::vector<std::string> changes;
    for (const int tag : loose) {
      if (tag2groups_.contains(tag)) continue;
      tag2groups_[tag] = {free_numbers.take_lowest()};
      changes.push_back("with the tag " + std::to_string(tag) + ", which is in no group, get the tag " +
                        std::to_string(tag2groups_[tag][0]) + ": a group has the number " + std::to_string(tag));
    }
    warn_of_first(dimension, changes, context);
  }

  std::vector<int> of(int tag) const {
    const auto found = tag2groups_.find(tag);
    return found == tag2groups_.end() ? std::vector<int>() : found->second;
  }

 private:
  std::map<int, std::vector<int>> tag2groups_;
};

/// Warns of tags that are one tag when the file is read: that of a group is its number, where an entity is in no other.
void warn_of_merged_msh_tags(const TetMesh& mesh, std::span<const MshLayoutEntity> entities, const IoContext& context) {
  std::map<int, std::set<int>> group2tags;
  for (const MshLayoutEntity& entity : entities) {
    if (entity.groups.size() == 1) group2tags[entity.groups[0]].insert(entity.tag);
  }
  for (const Group& group : mesh.groups) {
    const auto found = group2tags.find(group.number);
    if (group.dimension != entities.front().dimension || found == group2tags.end() || found->second.size() < 2)
      continue;
    warn_of_merged_tags(group, found->second.size(), context);
  }
}

/// Adds the entities and periodic links of one dimension after the other to a layout.
class MshEntityLayout {
 public:
  MshEntityLayout(const TetMesh& mesh, const IoContext& context, MshLayout& layout)
      : mesh_(mesh), context_(context), layout_(layout) {}

  /// Adds the entities of a dimension with these kinds of elements.
  void add(int dimension, std::span<MshKind> kinds) {
    EntityTags tags;
    std::vector<std::vector<int>> numbers = known_entities(kinds, tags);
    bool is_renumbered = false;
    if (numbers.empty() && !kinds.empty()) {
      tags.clear();
      numbers = entities_of_tags(kinds, tags);
      is_renumbered =
          std::any_of(kinds.begin(), kinds.end(), [](const MshKind& kind) { return !known_numbers(kind).empty(); });
    }
    linked_.clear();
    if (is_renumbered) {
      warn_of_dropped_links(dimension);
    } else {
      add_links(dimension, tags);
    }
    const std::map<int, Index> positions = add_entities(dimension, tags);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      kinds[k].entity.reserve(kinds[k].size());
      for (std::size_t e = 0; e < kinds[k].size(); ++e) {
        const bool same = e > 0 && numbers[k][e] == numbers[k][e - 1];
        kinds[k].entity.push_back(same ? kinds[k].entity.back() : positions.at(numbers[k][e]));
      }
    }
  }

 private:
  /// Adds the periodic links of a dimension; linked_ gets the entities that only they name.
  void add_links(int dimension, const EntityTags& tags) {
    for (const PeriodicLink& link : mesh_.periodic) {
      if (link.dimension != dimension) continue;
      layout_.links.push_back(link);
      for (const int number : {link.entity, link.master}) {
        if (!tags.contains(number)) linked_.insert(number);
      }
    }
  }
  /// Where the entities of the mesh have new numbers, links are not kept.
  void warn_of_dropped_links(int dimension) const {
    const auto dropped = std::count_if(mesh_.periodic.begin(), mesh_.periodic.end(),
                                       [&](const PeriodicLink& link) { return link.dimension == dimension; });
    if (dropped == 0) return;
    context_.warn(std::to_string(dropped) + " periodic links of dimension " + std::to_string(dimension) +
                  " are not written: elements of one entity have different tags, so that entities get new numbers");
  }

  /// Adds the entities of these tags and the linked ones; returns their positions by number.
  std::map<int, Index> add_entities(int dimension, EntityTags& tags) {
    for (const int number : linked_) tags.emplace(number, 0);
    const GroupsOfTags groups(mesh_, dimension, tags, context_);
    std::map<int, Index> positions;
    std::vector<std::string> in_no_group;
    const std::size_t first = layout_.entities.size();
    for (const auto& [number, tag] : tags) {
      positions[number] = to_index(layout_.entities.size());
      MshLayoutEntity entity{dimension, number, tag};
      entity.has_elements = !linked_.contains(number);
      if (entity.has_elements) entity.groups = groups.of(tag);
      if (entity.groups.empty() && tag < 0 && !mesh_.cell_tags_name.starts_with("gmsh")) {
        in_no_group.push_back("with the tag " + std::to_string(tag) + " are entity " + std::to_string(number) +
                              ", in no group: Gmsh's groups have positive numbers");
      }
      layout_.entities.push_back(std::move(entity));
    }
    warn_of_first(dimension, in_no_group, context_);
    if (!tags.empty()) warn_of_merged_msh_tags(mesh_, std::span(layout_.entities).subspan(first), context_);
    return positions;
  }

  const TetMesh& mesh_;
  const IoContext& context_;
  MshLayout& layout_;
  std::set<int> linked_;  ///< numbers of entities
};

std::array<Index, 3> side_of(std::span<const Index> vertices) {
  std::array<Index, 3> side{-1, -1, -1};
  std::copy(vertices.begin(), vertices.end(), side.begin());
  return side;
}

/// Sets MshLayoutEntity::bounds of entities of simplices of a dimension.
void find_bounds(int dimension, std::size_t vertices, MshLayout& layout) {
  std::vector<std::pair<std::array<Index, 3>, Index>> listed;  // sides with their entities
  const auto simplices = [&layout](int of_dimension, const auto& f) {
    for (const MshKind& kind : layout.kinds) {
      if (kind.type->dimension == of_dimension && kind.type->corners == of_dimension + 1) f(kind);
    }
  };
  simplices(dimension - 1, [&](const MshKind& kind) {
    for (std::size_t e = 0; e < kind.size(); ++e) {
      listed.emplace_back(side_of({kind.corners(e), to_size_t(dimension)}), kind.entity[e]);
    }
  });
  if (listed.empty()) return;
  const ListedFaces<3> sides(std::move(listed), vertices);
  std::set<std::pair<Index, Index>> found;
  simplices(dimension, [&](const MshKind& kind) {
    const auto n = to_size_t(dimension) + 1;
    for (std::size_t e = 0; e < kind.size(); ++e) {
      const std::span<const Index> corners(kind.corners(e), n);
      if (sides.count_listed(corners) < dimension) continue;
      for (std::size_t left_out = 0; left_out < n; ++left_out) {
        std::array<Index, 3> side{};
        std::copy_n(corners.begin(), left_out, side.begin());
        std::copy(corners.begin() + std::ptrdiff_t(left_out) + 1, corners.end(),
                  side.begin() + std::ptrdiff_t(left_out));
        sides.find(side_of({side.data(), n - 1}), [&](Index entity) { found.emplace(kind.entity[e], entity); });
      }
    }
  });
  for (const auto& [entity, side] : found) {
    span_of(layout.entities)[entity].bounds.push_back(span_of(layout.entities)[side].number);
  }
}

void find_boxes(const TetMesh& mesh, MshLayout& layout) {
  constexpr double kMost = std::numeric_limits<double>::max();
  std::vector<std::uint8_t> is_set(layout.entities.size(), 0);
  for (const MshKind& kind : layout.kinds) {
    for (std::size_t e = 0; e < kind.size(); ++e) {
      std::array<double, 6>& box = span_of(layout.entities)[kind.entity[e]].box;
      std::uint8_t& set = span_of(is_set)[kind.entity[e]];
      if (set == 0) box = {kMost, kMost, kMost, -kMost, -kMost, -kMost};
      set = 1;
      for (const Index v : std::span(kind.corners(e), to_size_t(kind.type->corners))) {
        const Point3& p = span_of(mesh.points)[v];
        for (std::size_t k = 0; k < 3; ++k) {
          box[k] = std::min(box[k], p[k]);
          box[k + 3] = std::max(box[k + 3], p[k]);
        }
      }
    }
  }
}

/// Gives periodic entities of dimension 0 without elements the position of their vertex.
void place_points(const TetMesh& mesh, MshLayout& layout) {
  for (const PeriodicLink& link : layout.links) {
    if (link.dimension != 0 || link.pairs.empty()) continue;
    const auto place = [&](int number, Index vertex) {
      MshLayoutEntity& entity = span_of(layout.entities)[layout.find(0, number)];
      const Point3& p = span_of(mesh.points)[vertex];
      for (std::size_t k = 0; !entity.has_elements && k < 3; ++k) entity.box[k] = entity.box[k + 3] = p[k];
    };
    place(link.master, link.pairs[0][1]);
    place(link.entity, link.pairs[0][0]);
  }
}

}  // namespace

Index MshLayout::find(int dimension, int number) const {
  const auto is_before = [](const MshLayoutEntity& entity, const std::pair<int, int>& sought) {
    return std::pair{entity.dimension, entity.number} < sought;
  };
  return to_index(std::lower_bound(entities.begin(), entities.end(), std::pair{dimension, number}, is_before) -
                  entities.begin());
}

MshLayout lay_out(const TetMesh& mesh, const IoContext& context) {
  MshLayout layout;
  layout.kinds = kinds_of(mesh);
  if (layout.kinds.empty())
    throw FileError("the mesh has no elements; an .msh file without them has no entities for its vertices");
  MshEntityLayout entities(mesh, context, layout);
  for (int dimension = 0; dimension <= 3; ++dimension) {
    const auto is_before = [dimension](const MshKind& kind) { return kind.type->dimension < dimension; };
    const auto first = std::find_if_not(layout.kinds.begin(), layout.kinds.end(), is_before);
    const auto last = std::find_if(first, layout.kinds.end(),
                                   [dimension](const MshKind& kind) { return kind.type->dimension != dimension; });
    const auto kinds =
        std::span(layout.kinds).subspan(std::size_t(first - layout.kinds.begin()), std::size_t(last - first));
    entities.add(dimension, kinds);
  }
  for (int dimension = 1; dimension <= 3; ++dimension) find_bounds(dimension, mesh.points.size(), layout);
  find_boxes(mesh, layout);
  place_points(mesh, layout);
  for (const Group& group : mesh.groups) {
    if (!group.name.empty()) layout.names.push_back(group);
  }
  return layout;
}

}  // namespace tetune
