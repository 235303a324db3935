// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdlib>

#include "mesh/sorted.hpp"

#include "io/msh/msh_sections.hpp"

namespace tetune {
namespace {

/// The sign of a group's number is that of the orientation.
void normalize(std::vector<int>& groups) {
  for (int& group : groups) group = std::abs(group);
  sort_unique(groups);
  std::erase(groups, 0);
}

/// Whether a type is a quadrilateral, pyramid, prism or hexahedron with nodes in the middles of faces.
bool has_nodes_on_faces(int type) {
  constexpr std::array<int, 4> kTypes{10, 12, 13, 14};
  return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
}

}  // namespace

void MshElementReader::read_entities(bool partitioned) {
  if (partitioned) {
    source_.long_integer("number of partitions");
    const std::size_t ghosts = source_.count("number of ghost entities", 2, 8);
    for (std::size_t i = 0; i < 2 * ghosts; ++i) source_.integer("ghost entity");
  }
  std::array<std::size_t, 4> counts{};
  for (std::size_t& n : counts) n = source_.count("number of entities", 4, 36);
  for (int dimension = 0; dimension <= 3; ++dimension) {
    for (std::size_t i = 0; i < counts[to_size_t(dimension)]; ++i) {
      const int number = source_.integer("number of an entity");
      Entity entity;
      if (partitioned) {
        entity.parent_dimension = source_.integer("dimension of the parent");
        entity.parent = source_.integer("number of the parent");
        const std::vector<int> partitions = integers("partition");
        entity.partition = partitions.empty() ? 0 : std::abs(partitions[0]);
      }
      for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) source_.real("coordinate of an entity");
      entity.groups = integers("group of an entity");
      if (dimension > 0) integers("boundary of an entity");
      normalize(entity.groups);
      entities_[{dimension, number}] = std::move(entity);
    }
  }
}

std::vector<int> MshElementReader::integers(const char* name) {
  std::vector<int> list(source_.count(name, 1, 4));
  for (int& value : list) value = source_.integer(name);
  return list;
}

void MshElementReader::read_elements() {
  if (source_.is_old()) {
    const std::size_t n = source_.text_count("number of elements", 4, 8);
    for (std::size_t i = 0; i < n;) i += source_.is_binary() ? read_old_block(n - i) : read_old_line();
  } else {
    read_blocks();
  }
}

std::size_t MshElementReader::read_old_line() {
  const std::int64_t number = source_.short_integer("number of an element");
  const MshType& type = type_of(source_.integer("type of an element"), number);
  const Index cell = read_old_cell(type.dimension, source_.integer("number of tags"));
  add_element(type, cell, number, [this] { return source_.short_integer("node"); });
  return 1;
}

/// A block of binary elements; returns their number.
std::size_t MshElementReader::read_old_block(std::size_t left) {
  const int number_of_type = source_.integer("type of elements");
  const std::size_t n = source_.checked(source_.integer("number of elements"), "number of elements", 1, 8);
  const int tags = source_.integer("number of tags");
  if (n > left || n == 0)
    source_.fail("a block has " + std::to_string(n) + " elements; " + std::to_string(left) + " are left");
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t number = source_.short_integer("number of an element");
    const MshType& type = type_of(number_of_type, number);
    const Index cell = read_old_cell(type.dimension, tags);
    add_element(type, cell, number, [this] { return source_.short_integer("node"); });
  }
  return n;
}

/// The tags of an element: group, entity, and the number of partitions with these.
Index MshElementReader::read_old_cell(int dimension, int tags) {
  int group = 0, entity = 0, partitions = 0, partition = 0;
  for (int i = 0; i < tags; ++i) {
    const int tag = source_.integer("tag of an element");
    if (i == 0) group = std::abs(tag);
    if (i == 1) entity = tag;
    if (i == 2) partitions = tag;
    if (i == 3 && partitions > 0) partition = std::abs(tag);
    // Negative ones are those for which the element is a ghost.
    if (i > 3 && i - 3 < partitions && tag < 0) model_.has_ghosts = true;
  }
  return cell_of({dimension, entity, group, partition});
}

void MshElementReader::read_blocks() {
  const std::int64_t blocks = source_.long_integer("number of blocks");
  source_.count("number of elements", 2, 16);
  source_.long_integer("least number");
  source_.long_integer("largest number");
  for (std::int64_t b = 0; b < blocks; ++b) {
    const int dimension = source_.integer("dimension of an entity");
    const int entity = source_.integer("number of an entity");
    const int number_of_type = source_.integer("type of elements");
    const std::size_t n = source_.count("number of elements of a block", 2, 16);
    if (n == 0) continue;
    const MshType& type = type_of(number_of_type, -1);
    if (type.dimension != dimension) {
      source_.fail("elements of type " + std::to_string(number_of_type) + " are in an entity of dimension " +
                   std::to_string(dimension));
    }
    const Index cell = cell_of({dimension, entity, 0, 0});
    if (span_of(model_.cells)[cell].is_dropped) {
      for (std::size_t i = 0; i < n * to_size_t(type.nodes + 1); ++i) source_.long_integer("node");
      continue;
    }
    reserve(type, n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t number = source_.long_integer("number of an element");
      add_element(type, cell, number, [this] { return source_.long_integer("node"); });
    }
  }
}

const MshType& MshElementReader::type_of(int number, std::int64_t element) {
  if (const MshType* type = find_msh_type(number)) return *type;
  const std::string found = (element < 0 ? "there are elements" : "element " + std::to_string(element) + " is") +
                            " of type " + std::to_string(number);
  if (has_nodes_on_faces(number)) source_.fail(found + ": " + kNodesOnFaces);
  source_.fail(found +
               ", which tetune does not read; it reads points, and lines, triangles, tetrahedra, "
               "quadrilaterals, pyramids, prisms and hexahedra of first or second order");
}

/// Makes room for the elements of a block. The room at least doubles, so that the elements of many small blocks are not
/// copied for each of them.
void MshElementReader::reserve(const MshType& type, std::size_t n) {
  const auto grow = [](auto& items, std::size_t more) {
    const std::size_t size = items.size() + more;
    if (size > items.capacity()) items.reserve(std::max(size, 2 * items.capacity()));
  };
  MshElements& list = model_.elements[type.list];
  grow(list.corners, n * to_size_t(type.corners));
  grow(list.cell, n);
  grow(list.number, n);
}

template <class ReadNode>
void MshElementReader::add_element(const MshType& type, Index cell, std::int64_t number, const ReadNode& read_node) {
  MshElements& list = model_.elements[type.list];
  const auto node = [&] {
    const std::int64_t given = read_node();
    const Index v = model_.nodes.rank(given);
    if (v >= 0) return v;
    source_.fail("element " + std::to_string(number) + " has node " + std::to_string(given) + ", which does not exist");
  };
  std::array<Index, kMaxNodes> nodes{};
  const auto listed = std::span(nodes).first(to_size_t(type.nodes));
  for (Index& v : listed) v = node();
  list.corners.insert(list.corners.end(), listed.begin(), listed.begin() + type.corners);
  if (type.nodes > type.corners) {
    add_middles(listed, msh_middle_edges(type), model_.middles);
    if (type.list < kMshFirstOther) {
      list.has_middles.resize(list.cell.size() + 1, 0);
      list.has_middles.back() = 1;
    }
  }
  list.cell.push_back(cell);
  list.number.push_back(number);
  if ((list.cell.size() & 0xffffU) != 0) return;
  const std::string excess = excess_of(std::ssize(list.cell), type.list == kMshTets ? kMaxTets : kMaxEntries);
  if (!excess.empty()) source_.fail("the mesh has " + excess);
}

/// The cell of an entity of version 4.1; or of an entity, group and partition of version 2.2.
Index MshElementReader::cell_of(const std::array<int, 4>& key) {
  if (key == last_key_) return last_cell_;
  const auto [at, is_new] = cell_of_.try_emplace(key, to_index(model_.cells.size()));
  if (is_new) model_.cells.push_back(make_cell(key));
  last_key_ = key;
  return last_cell_ = at->second;
}
MshCell MshElementReader::make_cell(const std::array<int, 4>& key) const {
  MshCell cell{key[0], key[1], key[3], {}};
  if (key[2] != 0) cell.groups = {key[2]};
  const auto known = entities_.find({key[0], key[1]});
  if (known == entities_.end()) return cell;
  const Entity& entity = known->second;
  cell.groups = entity.groups;
  cell.partition = entity.partition;
  if (entity.parent_dimension < 0) return cell;
  cell.is_dropped = entity.parent_dimension != key[0];
  cell.entity = entity.parent;
  return cell;
}

}  // namespace tetune
