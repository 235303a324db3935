// SPDX-License-Identifier: Apache-2.0
// Exodus II through the library that comes with VTK: element blocks, side sets, node sets and variables.
#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "exodus.hpp"
#include "exodus_file.hpp"
#include "io/second_order.hpp"
#include "io/tag_numbers.hpp"
#include "mesh/node_sets.hpp"

namespace tetune::plugin {
namespace {

/// One element block of a file.
struct Block {
  int id = 0;
  std::size_t kind = 0;  ///< position in kKinds
  std::int64_t elements = 0;
  std::int64_t first = 0;      ///< number of its first element, from 0
  std::int64_t first_tet = 0;  ///< position of its first tetrahedron in the mesh
};

std::size_t kind_of(const ex_block& block) {
  std::string name = block.topology;
  for (char& c : name) c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    if (block.num_nodes_per_entry != kKinds[k].nodes) continue;
    for (const char* start : kKinds[k].names) {
      if (name.rfind(start, 0) == 0) return k;
    }
  }
  const std::string found = "element block " + std::to_string(block.id) + " is of type \"" + block.topology +
                            "\" with " + std::to_string(block.num_nodes_per_entry) + " nodes";
  for (std::size_t list = 0; list < kOtherLists; ++list) {
    const KindOfElement& kind = kKinds[kOthers + list];
    if (!is_second_order_list(list) || block.num_nodes_per_entry <= kind.nodes) continue;
    const auto is_start = [&name](const char* start) { return name.rfind(start, 0) == 0; };
    if (std::any_of(kind.names.begin(), kind.names.end(), is_start)) throw FileError(found + ": " + kNodesOnFaces);
  }
  throw FileError(found +
                  ", which tetune does not read; it reads bars, triangles, tetrahedra, quadrilaterals, "
                  "pyramids, wedges and hexahedra of first or second order");
}

std::int64_t number_of_times(const File& file) { return ex_inquire_int(file.id(), EX_INQ_TIME); }

class ExodusReader {
 public:
  ExodusReader(const File& file, int time, TetMesh& mesh, Warnings& warnings)
      : file_(file), time_(time), mesh_(mesh), warnings_(warnings) {}

  void read() {
    ex_init_params counts{};
    file_.check(ex_get_init_ext(file_.id(), &counts), "read the sizes");
    if (counts.num_dim != 3) throw FileError("the mesh has dimension " + std::to_string(counts.num_dim) + ", not 3");
    constexpr std::int64_t kMost = std::numeric_limits<Index>::max();
    if (counts.num_nodes > kMost || counts.num_elem > kMost) throw FileError("more than 2^31 nodes or elements");
    read_points(counts.num_nodes);
    const std::vector<int> block_ids = file_.ids(EX_ELEM_BLOCK, counts.num_elem_blk);
    const std::vector<int> set_ids = file_.ids(EX_SIDE_SET, counts.num_side_sets);
    for (const int id : block_ids) free_numbers_.take(id);
    for (const int id : set_ids) free_numbers_.take(id);
    for (const int id : block_ids) read_block(id);
    for (const int id : set_ids) read_side_set(id);
    for (const int id : file_.ids(EX_NODE_SET, counts.num_node_sets)) read_node_set(id);
    read_variables();
    warn_of_losses_on_reading(file_, counts, warnings_);
    for (ElementBlock& block : others_) {
      if (!block.tags.empty()) mesh_.others.push_back(std::move(block));
    }
    for (std::string& warning : erase_middles(middles_, mesh_)) warnings_.push_back(std::move(warning));
  }

 private:
  std::string name_of(ex_entity_type type, int id) const {
    std::array<char, File::kNames + 1> name{};
    if (ex_get_name(file_.id(), type, id, name.data()) < 0) return "";
    return name.data();
  }

  void read_points(std::int64_t count) {
    const std::size_t n(count);
    std::vector<double> x(n), y(n), z(n);
    if (n > 0) file_.check(ex_get_coord(file_.id(), x.data(), y.data(), z.data()), "read the coordinates");
    mesh_.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) mesh_.points.push_back({x[i], y[i], z[i]});
    mesh_.point_tags.assign(n, 0);
  }

  void read_block(int id) {
    ex_block info{};
    info.id = id;
    info.type = EX_ELEM_BLOCK;
    file_.check(ex_get_block_param(file_.id(), &info), "read an element block");
    Block block{id, 0, info.num_entry, elements_, std::ssize(mesh_.tets)};
    elements_ += block.elements;
    if (block.elements == 0) return;
    block.kind = kind_of(info);
    const std::size_t each(info.num_nodes_per_entry);
    std::vector<int> nodes(each * std::size_t(block.elements));
    file_.check(ex_get_conn(file_.id(), EX_ELEM_BLOCK, id, nodes.data(), nullptr, nullptr), "read the elements");
    for (int& v : nodes) {
      if (v < 1 || v > std::ssize(mesh_.points)) {
        throw FileError("element block " + std::to_string(id) + " has node " + std::to_string(v) + "; there are " +
                        std::to_string(mesh_.points.size()));
      }
      --v;
    }
    const int tag = tag_of(id, "element block");
    for (std::size_t e = 0; e < nodes.size(); e += each) add(block.kind, nodes.data() + e, tag);
    const int dimension = block.kind < kTriangles ? 3 : block.kind < kEdges ? 2 : block.kind < kOthers ? 1 : -1;
    add_group(dimension >= 0 ? dimension : kind_of_list(block.kind - kOthers).dimension, tag,
              name_of(EX_ELEM_BLOCK, id));
    blocks_.push_back(block);
  }

  /// Returns the tag of a block or set: groups have positive numbers, and 0 is no tag.
  int tag_of(int id, const std::string& what) {
    if (id > 0) return id;
    const int tag = free_numbers_.take_lowest();
    warnings_.push_back(what + " " + std::to_string(id) + " gets the tag " + std::to_string(tag) +
                        ", as tags of groups are positive");
    return tag;
  }

  /// Adds a tag to the group of its name: blocks and sets of one name are one group.
  void add_group(int dimension, int tag, const std::string& name) {
    for (Group& group : mesh_.groups) {
      if (group.dimension != dimension || group.name != name || (name.empty() && group.number != tag)) continue;
      if (std::find(group.tags.begin(), group.tags.end(), tag) == group.tags.end()) group.tags.push_back(tag);
      return;
    }
    mesh_.groups.push_back({dimension, tag, name, {tag}});
  }

  void add(std::size_t kind, const int* v, int tag) {
    const std::span<const Index> nodes(v, std::size_t(kKinds[kind].nodes));
    switch (kind) {
      case kTets + 1:
        add_middles(nodes, kTetEdges, middles_);
        [[fallthrough]];
      case kTets:
        mesh_.tets.push_back({v[0], v[1], v[2], v[3]});
        mesh_.tet_tags.push_back(tag);
        return;
      case kTriangles + 1:
        add_middles(nodes, kTriangleEdges, middles_);
        [[fallthrough]];
      case kTriangles:
        mesh_.triangles.push_back({v[0], v[1], v[2]});
        mesh_.triangle_tags.push_back(tag);
        return;
      case kEdges + 1:
        add_middles(nodes, kEdgeEdges, middles_);
        [[fallthrough]];
      case kEdges:
        mesh_.edges.push_back({v[0], v[1]});
        mesh_.edge_tags.push_back(tag);
        return;
      default:
        break;
    }
    ElementBlock& block = others_[kind - kOthers];
    block.element2vertex.insert(block.element2vertex.end(), v, v + block.vertices_per_element);
    block.tags.push_back(tag);
    if (block.second_order) add_middles(nodes, edges_of_kind(block.kind, MiddleOrder::base_between_top), middles_);
  }

  /// Reads a side set, whose sides of tetrahedra become listed triangles.
  void read_side_set(int id) {
    const Set set = read_set(EX_SIDE_SET, id);
    const int tag = tag_of(id, "side set");
    std::int64_t left_out = 0;
    for (std::size_t i = 0; i < set.entries.size(); ++i) {
      const std::int64_t element = std::int64_t{set.entries[i]} - 1;
      const int side = set.sides[i];
      const Block* const block = block_of(element);
      if (block == nullptr) {
        throw FileError("side set " + std::to_string(id) + " has element " + std::to_string(element + 1) +
                        ", which does not exist");
      }
      if (block->kind >= kTriangles) {
        ++left_out;
        continue;
      }
      if (side < 1 || side > 4) {
        throw FileError("side set " + std::to_string(id) + " has side " + std::to_string(side) +
                        " of a tetrahedron; there are 4");
      }
      const auto& tet = item(mesh_.tets, block->first_tet + element - block->first);
      const auto& corners = item(kTetSides, side - 1);
      mesh_.triangles.push_back({tet[corners[0]], tet[corners[1]], tet[corners[2]]});
      mesh_.triangle_tags.push_back(tag);
      if (block->kind == kTets + 1) ++middles_.complete[2];  // those of the tetrahedron
    }
    add_group(2, tag, name_of(EX_SIDE_SET, id));
    if (left_out > 0) {
      warnings_.push_back(std::to_string(left_out) + " sides of elements that are not tetrahedra, of side set " +
                          std::to_string(id) + ", are not kept");
    }
  }

  /// The block of an element; null where there is none.
  const Block* block_of(std::int64_t element) const {
    const auto after = std::upper_bound(blocks_.begin(), blocks_.end(), element,
                                        [](std::int64_t e, const Block& block) { return e < block.first; });
    if (after == blocks_.begin()) return nullptr;
    const Block& block = *std::prev(after);
    return element < block.first + block.elements ? &block : nullptr;
  }

  /// Elements and their sides, or nodes, from 1.
  struct Set {
    std::vector<int> entries, sides;
  };

  Set read_set(ex_entity_type type, int id) const {
    int n = 0;
    int factors = 0;
    file_.check(ex_get_set_param(file_.id(), type, id, &n, &factors), "read a set");
    const auto size = std::size_t(n);
    Set set{std::vector<int>(size), std::vector<int>(type == EX_SIDE_SET ? size : 0)};
    int* const sides = type == EX_SIDE_SET ? set.sides.data() : nullptr;
    if (n > 0) file_.check(ex_get_set(file_.id(), type, id, set.entries.data(), sides), "read a set");
    return set;
  }

  void read_node_set(int id) {
    std::vector<std::uint8_t> in_set(mesh_.points.size(), 0);
    for (const int node : read_set(EX_NODE_SET, id).entries) {
      const std::int64_t v = std::int64_t{node} - 1;
      if (v < 0 || v >= std::ssize(in_set)) {
        throw FileError("node set " + std::to_string(id) + " has node " + std::to_string(v + 1) +
                        ", which does not exist");
      }
      item(in_set, v) = 1;
    }
    const std::string name = name_of(EX_NODE_SET, id);
    mesh_.point_data.push_back(
        {std::string(kNodeSet) + std::to_string(id) + (name.empty() ? "" : ":" + name), 1, std::move(in_set)});
  }

  /// Variables in sequence that are the components of one array.
  struct Components {
    std::size_t count = 1;  ///< 1: a scalar
    std::string name{};     ///< of the array
  };

  /// Those from `first` on: name_X, name_Y and possibly name_Z, or, as VTK writes them, nameX, nameY and possibly
  /// nameZ; or name_1 to name_4 and further. `taken`: all names.
  static Components find_components(const std::vector<DataArray>& data, std::size_t first,
                                    const std::set<std::string>& taken) {
    const std::string& name = data[first].name;
    const auto is_named = [&](std::size_t c, const std::string& text) {
      return first + c < data.size() && data[first + c].name == text;
    };
    for (const std::string separator : {"_", ""}) {
      if (name.size() < separator.size() + 2 || !name.ends_with(separator + "X")) continue;
      const std::string base = name.substr(0, name.size() - separator.size() - 1);
      const std::string start = base + separator;
      if (taken.contains(base) || !is_named(1, start + "Y")) return {};
      if (is_named(2, start + "Z")) return {3, base};
      return taken.contains(start + "Z") ? Components() : Components{2, base};
    }
    if (name.size() < 3 || !name.ends_with("_1")) return {};
    const std::string base = name.substr(0, name.size() - 2);
    if (taken.contains(base)) return {};
    std::size_t n = 1;
    while (is_named(n, base + "_" + std::to_string(n + 1))) ++n;
    return n > 3 ? Components{n, base} : Components();
  }

  /// Joins variables in sequence that are the components of one array, unless there is a variable with its name.
  static void join_components(std::vector<DataArray>& data) {
    std::set<std::string> taken;
    for (const DataArray& array : data) taken.insert(array.name);
    std::vector<DataArray> joined;
    for (std::size_t i = 0; i < data.size();) {
      const auto [each, name] = find_components(data, i, taken);
      if (each == 1) {
        joined.push_back(std::move(data[i++]));
        continue;
      }
      std::vector<double> values;
      const std::size_t n = std::get<std::vector<double>>(data[i].values).size();
      values.reserve(n * each);
      for (std::size_t v = 0; v < n; ++v) {
        for (std::size_t c = 0; c < each; ++c) values.push_back(std::get<std::vector<double>>(data[i + c].values)[v]);
      }
      joined.push_back({name, int(each), std::move(values)});
      taken.insert(name);
      i += each;
    }
    data = std::move(joined);
  }

  void read_variables() {
    const std::int64_t steps = number_of_times(file_);
    if (steps < 1) return;
    if (time_ > steps) throw FileError("there is no time " + std::to_string(time_) + " of " + std::to_string(steps));
    if (time_ == 0 && steps > 1) warnings_.push_back("of " + std::to_string(steps) + " times the first is kept");
    const int time = std::max(time_, 1);
    int index = 0;
    std::vector<DataArray> nodal;
    for (const std::string& name : file_.variable_names(EX_NODAL)) {
      std::vector<double> values(mesh_.points.size());
      file_.check(ex_get_var(file_.id(), time, EX_NODAL, ++index, 1, std::ssize(values), values.data()),
                  "read a variable");
      nodal.push_back({name, 1, std::move(values)});
    }
    join_components(nodal);
    std::move(nodal.begin(), nodal.end(), std::back_inserter(mesh_.point_data));
    index = 0;
    for (const std::string& name : file_.variable_names(EX_ELEM_BLOCK)) {
      ++index;
      std::vector<double> values;
      for (const Block& block : blocks_) {
        if (block.kind >= kTriangles) continue;
        const std::size_t first = values.size();
        values.resize(first + std::size_t(block.elements), std::numeric_limits<double>::quiet_NaN());
        // The call fails for a block without this variable, as the truth table says.
        ex_get_var(file_.id(), time, EX_ELEM_BLOCK, index, block.id, block.elements, values.data() + first);
      }
      if (!values.empty()) mesh_.tet_data.push_back({name, 1, std::move(values)});
    }
    join_components(mesh_.tet_data);
    if (index > 0 && std::any_of(blocks_.begin(), blocks_.end(), [](const Block& b) { return b.kind >= kTriangles; })) {
      warnings_.push_back("variables of elements are kept on tetrahedra only");
    }
  }

  const File& file_;
  const int time_;
  TetMesh& mesh_;
  Warnings& warnings_;
  FreeNumbers free_numbers_{{}};
  std::int64_t elements_ = 0;
  std::vector<Block> blocks_;
  std::vector<ElementBlock> others_ = blocks_of_lists();
  MiddleList middles_;
};

int open_to_read(const std::string& file) {
  int computing = sizeof(double);
  int stored = 0;
  float version = 0;
  return ex_open(file.c_str(), EX_READ, &computing, &stored, &version);
}

}  // namespace

TetMesh read_exodus(const std::string& file, int time, Warnings& warnings) {
  TetMesh mesh;
  const File in(open_to_read(file));
  ExodusReader(in, time, mesh, warnings).read();
  return mesh;
}

std::vector<double> exodus_times(const std::string& file) {
  const File in(open_to_read(file));
  const std::int64_t count = number_of_times(in);
  std::vector<double> times(std::size_t(std::max<std::int64_t>(count, 0)));
  if (!times.empty()) in.check(ex_get_all_times(in.id(), times.data()), "read the times");
  return times;
}

}  // namespace tetune::plugin
