// SPDX-License-Identifier: Apache-2.0
// Exodus II through the library that comes with VTK, as exodus_read.cpp reads it.
#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <memory>
#include <set>

#include "exodus.hpp"
#include "exodus_file.hpp"
#include "io/group_order.hpp"
#include "io/losses.hpp"
#include "io/second_order.hpp"
#include "io/tag_numbers.hpp"
#include "limited_names.hpp"
#include "mesh/listed_faces.hpp"
#include "mesh/node_sets.hpp"

namespace tetune::plugin {
namespace {

/// The elements of one kind and tag, which become a block.
struct OutBlock {
  int id;
  std::size_t kind;
  int dimension;
  int tag;
  std::vector<int> nodes;             ///< from 1
  std::vector<std::size_t> elements;  ///< positions in the mesh's list of the kind
};

class Writer {
 public:
  Writer(const File& file, TetMesh mesh, Warnings& warnings)
      : file_(file), mesh_(std::move(mesh)), warnings_(warnings) {}

  void write() {
    const auto middles = mesh_.second_order ? std::make_unique<Middles>(mesh_) : nullptr;
    collect(middles.get());
    const std::map<int, std::vector<std::array<int, 2>>> side_sets = find_sides(middles.get());
    choose_ids();
    find_node_sets();
    shorten_all_names();
    choose_names();
    warn_of_losses();
    std::int64_t elements = 0;
    for (const OutBlock& block : blocks_) elements += std::ssize(block.elements);
    const auto count = [](const auto& list) { return std::ssize(list); };
    file_.check(ex_put_init(file_.id(), "written by tetune", 3, count(mesh_.points), elements, count(blocks_),
                            count(node_sets_), count(side_sets)),
                "write the sizes");
    write_points();
    for (const OutBlock& block : blocks_) {
      file_.check(ex_put_block(file_.id(), EX_ELEM_BLOCK, block.id, kKinds[block.kind].written, count(block.elements),
                               kKinds[block.kind].nodes, 0, 0, 0),
                  "write an element block");
      file_.check(ex_put_conn(file_.id(), EX_ELEM_BLOCK, block.id, block.nodes.data(), nullptr, nullptr),
                  "write the elements");
      put_name(EX_ELEM_BLOCK, block.id, group_name(block.dimension, block.tag));
    }
    for (const auto& [id, sides] : side_sets) {
      std::vector<int> of_elements, of_sides;
      for (const auto& [element, side] : sides) {
        of_elements.push_back(element);
        of_sides.push_back(side);
      }
      put_set(EX_SIDE_SET, id, of_elements, of_sides.data(), group_name(2, id));
    }
    for (const NodeSet& set : node_sets_) put_set(EX_NODE_SET, set.id, set.nodes, nullptr, set.name);
    write_variables();
  }

 private:
  struct NodeSet {
    int id;
    std::string name;
    std::vector<int> nodes;
  };

  /// Sorts elements into blocks of one kind and tag.
  void collect(const Middles* middles) {
    const std::size_t second = middles != nullptr ? 1 : 0;
    std::map<std::pair<std::size_t, int>, std::size_t> found;
    const auto add = [&](std::size_t kind, int dimension, int tag, const Index* v, std::size_t n, const auto& pairs,
                         std::size_t element) {
      const auto [at, fresh] = found.try_emplace({kind, tag}, blocks_.size());
      if (fresh) blocks_.push_back({0, kind, dimension, tag, {}, {}});
      OutBlock& block = blocks_[at->second];
      for (std::size_t k = 0; k < n; ++k) block.nodes.push_back(v[k] + 1);
      if (middles != nullptr) {
        for (const Pair& p : pairs) block.nodes.push_back(middles->of(v[p[0]], v[p[1]]) + 1);
      }
      block.elements.push_back(element);
    };
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      add(kTets + second, 3, mesh_.tet_tags[t], mesh_.tets[t].data(), 4, kTetEdges, t);
    }
    collect_loose_triangles(kTriangles + second, add);
    for (std::size_t e = 0; e < mesh_.edges.size(); ++e) {
      add(kEdges + second, 1, mesh_.edge_tags[e], mesh_.edges[e].data(), 2, kEdgeEdges, e);
    }
    for (const ElementBlock& block : mesh_.others) {
      const std::size_t list = list_of(mesh_, block);
      if (list == kOtherLists) throw FileError("Exodus has no elements of kind " + block.kind);
      const std::size_t each(block.vertices_per_element);
      for (std::size_t i = 0; i < block.tags.size(); ++i) {
        add(kOthers + list, kind_of_list(list).dimension, block.tags[i], block.element2vertex.data() + i * each, each,
            middle_edges(mesh_, block, MiddleOrder::base_between_top), i);
      }
    }
  }

  using Face = std::array<Index, 3>;
  /// Finds for each listed triangle the tetrahedron whose side it is, of two the one with the same orientation.
  /// Triangles of no tetrahedron become elements.
  template <class Add>
  void collect_loose_triangles(std::size_t kind, const Add& add) {
    std::vector<std::pair<Face, Index>> faces;
    for (const Face& triangle : mesh_.triangles) faces.emplace_back(triangle, index_count(faces));
    const ListedFaces<3> triangles(std::move(faces), mesh_.points.size());
    triangle2side_.assign(mesh_.triangles.size(), {-1, 0});
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      for (std::size_t s = 0; s < 4; ++s) {
        const auto& corners = kTetSides[s];
        const Face face{mesh_.tets[t][corners[0]], mesh_.tets[t][corners[1]], mesh_.tets[t][corners[2]]};
        triangles.find(face, [&](Index triangle) {
          const Face& listed = item(mesh_.triangles, triangle);
          const bool same_orientation =
              face == listed || Face{face[1], face[2], face[0]} == listed || Face{face[2], face[0], face[1]} == listed;
          auto& side = item(triangle2side_, triangle);
          if (side[0] < 0 || same_orientation) side = {std::int64_t(t), std::int64_t(s) + 1};
        });
      }
    }
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (triangle2side_[i][0] >= 0) continue;
      add(kind, 2, mesh_.triangle_tags[i], mesh_.triangles[i].data(), 3, kTriangleEdges, i);
    }
  }

  /// For each tag of triangles the sides with it, by the numbers of the elements in the file.
  std::map<int, std::vector<std::array<int, 2>>> find_sides(const Middles* middles) {
    const std::size_t kind = kTets + (middles != nullptr ? 1 : 0);
    std::vector<int> tet2element(mesh_.tets.size());
    int next = 0;
    for (const OutBlock& block : blocks_) {
      for (const std::size_t e : block.elements) {
        ++next;
        if (block.kind == kind) tet2element[e] = next;
      }
    }
    std::map<int, std::vector<std::array<int, 2>>> sets;
    FreeNumbers free_numbers({mesh_.triangle_tags.begin(), mesh_.triangle_tags.end()});
    std::map<int, int> renumbered;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const auto& [tet, side] = triangle2side_[i];
      if (tet < 0) continue;
      int tag = mesh_.triangle_tags[i];
      if (tag <= 0) tag = renumber(tag, free_numbers, renumbered, "side set");
      sets[tag].push_back({item(tet2element, tet), int(side)});
    }
    return sets;
  }

  /// Returns the number of a tag in Exodus, where numbers are positive.
  int renumber(int tag, FreeNumbers& free_numbers, std::map<int, int>& renumbered, const char* what) {
    const auto [at, fresh] = renumbered.try_emplace(tag, 0);
    if (fresh) {
      at->second = free_numbers.take_lowest();
      warnings_.push_back("Exodus' numbers are positive: the tag " + std::to_string(tag) + " is " + what + " " +
                          std::to_string(at->second));
    }
    return at->second;
  }

  /// Gives a block the number of its tag where that is positive and no block of another kind has it.
  void choose_ids() {
    std::set<int> tags;
    for (const OutBlock& block : blocks_) tags.insert(block.tag);
    FreeNumbers free_numbers(tags);
    std::set<int> used;
    int others = 0;
    for (OutBlock& block : blocks_) {
      block.id = block.tag;
      if (block.tag > 0 && used.insert(block.tag).second) continue;
      block.id = free_numbers.take_lowest();
      ++others;
    }
    if (others > 0) {
      warnings_.push_back("the numbers of element blocks are other than their tags: " + std::to_string(others) +
                          "; Exodus' are positive, and different for elements of different kinds");
    }
  }

  /// Chooses names of blocks and sets, of which several may have the name of one group.
  void choose_names() {
    bool is_shared = false;
    for (int dimension = 0; dimension <= 3; ++dimension) {
      for (const Group* const group : specific_first(mesh_, dimension)) {
        if (group->name.empty()) continue;
        for (const int tag : group->tags) {
          is_shared |= names_.try_emplace({dimension, tag}, group->name).first->second != group->name;
        }
      }
    }
    if (is_shared) warn_of_shared_names({0, &warnings_});
  }

  void warn_of_losses() {
    const IoContext context{0, &warnings_};
    warn_of_lists(mesh_, context);
    warn_of_point_tags(mesh_, context);
    warn_of_empty_groups(mesh_, context);
    if (!mesh_.triangle_data.empty() || !mesh_.edge_data.empty()) {
      warnings_.push_back("data are kept on vertices and tetrahedra only");
    }
    const std::string rounded = rounded_integers({&mesh_.point_data, &mesh_.tet_data}, "Exodus");
    if (!rounded.empty()) warnings_.push_back(rounded);
  }

  void find_node_sets() {
    std::vector<DataArray> rest;
    for (DataArray& array : mesh_.point_data) {
      if (!is_node_set(array)) {
        rest.push_back(std::move(array));
        continue;
      }
      const auto& flags = std::get<std::vector<std::uint8_t>>(array.values);
      NodeSet set{std::atoi(array.name.c_str() + kNodeSet.size()), {}, {}};
      if (const auto colon = array.name.find(':', kNodeSet.size()); colon != std::string::npos) {
        set.name = array.name.substr(colon + 1);
      }
      for (std::size_t v = 0; v < flags.size(); ++v) {
        if (flags[v] != 0) set.nodes.push_back(int(v) + 1);
      }
      node_sets_.push_back(std::move(set));
    }
    mesh_.point_data = std::move(rest);
  }

  /// The library cuts longer names.
  void shorten_all_names() {
    constexpr std::size_t kMost = File::kNames - 1;
    const auto shorten = [this](const std::vector<LimitedName>& names, const char* what) {
      shorten_names(
          names, [](char) { return std::size_t{1}; }, what, warnings_);
    };
    for (auto* data : {&mesh_.point_data, &mesh_.tet_data}) {
      std::vector<LimitedName> names;
      for (DataArray& array : *data) {
        const std::size_t each = components_of(array);
        names.push_back({&array.name, kMost - component_suffix(each, each - 1).size()});
      }
      shorten(names, "data");
    }
    std::vector<LimitedName> groups, sets;
    for (Group& group : mesh_.groups) groups.push_back({&group.name, kMost});
    for (NodeSet& set : node_sets_) sets.push_back({&set.name, kMost});
    shorten(groups, "group");
    shorten(sets, "node set");
  }

  void write_points() {
    std::array<std::vector<double>, 3> x;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k].reserve(mesh_.points.size());
      for (const Point3& p : mesh_.points) x[k].push_back(p[k]);
    }
    file_.check(ex_put_coord(file_.id(), x[0].data(), x[1].data(), x[2].data()), "write the coordinates");
  }

  std::string group_name(int dimension, int tag) const {
    const auto at = names_.find({dimension, tag});
    return at == names_.end() ? "" : at->second;
  }

  void put_name(ex_entity_type type, int id, const std::string& name) {
    if (!name.empty()) file_.check(ex_put_name(file_.id(), type, id, name.c_str()), "write a name");
  }

  void put_set(ex_entity_type type, int id, const std::vector<int>& entries, const int* extra,
               const std::string& name) {
    file_.check(ex_put_set_param(file_.id(), type, id, std::ssize(entries), 0), "write a set");
    if (!entries.empty()) file_.check(ex_put_set(file_.id(), type, id, entries.data(), extra), "write a set");
    put_name(type, id, name);
  }

  /// Exodus' variables are scalars: one for each component.
  struct Variable {
    std::string name;
    std::vector<double> values;
  };
  /// The end of the name of a component's variable, as ExodusReader joins them.
  static std::string component_suffix(std::size_t each, std::size_t component) {
    if (each <= 1) return "";
    std::string suffix = "_";
    return suffix.append(each <= 3 ? std::string(1, "XYZ"[component]) : std::to_string(component + 1));
  }
  static std::vector<Variable> variables_of(const std::vector<DataArray>& data) {
    std::vector<Variable> variables;
    for (const DataArray& array : data) {
      const std::size_t each = components_of(array);
      for (std::size_t c = 0; c < each; ++c) {
        Variable variable{array.name + component_suffix(each, c), {}};
        std::visit(
            [&](const auto& values) {
              for (std::size_t i = c; i < values.size(); i += each) {
                variable.values.push_back(double(values[i]));
              }
            },
            array.values);
        variables.push_back(std::move(variable));
      }
    }
    return variables;
  }

  void put_names(ex_entity_type type, const std::vector<Variable>& variables) {
    if (variables.empty()) return;
    file_.check(ex_put_variable_param(file_.id(), type, int(variables.size())), "write the variables");
    int index = 0;
    for (const Variable& v : variables) {
      file_.check(ex_put_variable_name(file_.id(), type, ++index, v.name.c_str()), "write the name of a variable");
    }
  }

  void write_variables() {
    const std::vector<Variable> nodal = variables_of(mesh_.point_data);
    const std::vector<Variable> elemental = variables_of(mesh_.tet_data);
    if (nodal.empty() && elemental.empty()) return;
    put_names(EX_NODAL, nodal);
    put_names(EX_ELEM_BLOCK, elemental);
    if (!elemental.empty()) {
      std::vector<int> table;
      for (const OutBlock& block : blocks_)
        table.insert(table.end(), elemental.size(), block.kind < kTriangles ? 1 : 0);
      file_.check(
          ex_put_truth_table(file_.id(), EX_ELEM_BLOCK, int(blocks_.size()), int(elemental.size()), table.data()),
          "write the variables");
    }
    const double time = 0;
    file_.check(ex_put_time(file_.id(), 1, &time), "write the time");
    int index = 0;
    for (const Variable& v : nodal) {
      file_.check(ex_put_var(file_.id(), 1, EX_NODAL, ++index, 1, std::ssize(v.values), v.values.data()),
                  "write a variable");
    }
    index = 0;
    for (const Variable& v : elemental) {
      ++index;
      for (const OutBlock& block : blocks_) {
        if (block.kind >= kTriangles) continue;
        std::vector<double> own;
        for (const std::size_t e : block.elements) own.push_back(v.values[e]);
        file_.check(ex_put_var(file_.id(), 1, EX_ELEM_BLOCK, index, block.id, std::ssize(own), own.data()),
                    "write a variable");
      }
    }
  }

  const File& file_;
  TetMesh mesh_;
  Warnings& warnings_;
  std::vector<OutBlock> blocks_;
  std::vector<std::array<std::int64_t, 2>> triangle2side_;
  std::vector<NodeSet> node_sets_;
  std::map<std::pair<int, int>, std::string> names_;  ///< by dimension and tag
};

}  // namespace

void write_exodus(const std::string& file, TetMesh mesh, Warnings& warnings) {
  int computing = sizeof(double);
  int stored = sizeof(double);
  File out(ex_create(file.c_str(), EX_CLOBBER | EX_LARGE_MODEL, &computing, &stored));
  Writer(out, std::move(mesh), warnings).write();
  out.close();
}

}  // namespace tetune::plugin
