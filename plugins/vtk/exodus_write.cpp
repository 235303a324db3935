// SPDX-License-Identifier: Apache-2.0
// Exodus II through the library that comes with VTK, as exodus_read.cpp reads it.
#include <charconv>
#include <cstring>
#include <iterator>
#include <map>
#include <memory>
#include <string_view>

#include "exodus.hpp"
#include "exodus_elements.hpp"
#include "exodus_file.hpp"
#include "io/group_order.hpp"
#include "io/losses.hpp"
#include "io/second_order.hpp"
#include "io/tag_numbers.hpp"
#include "limited_names.hpp"
#include "mesh/node_sets.hpp"

namespace tetune::plugin {
namespace {

class Writer {
 public:
  Writer(const File& file, TetMesh mesh, Warnings& warnings)
      : file_(file), mesh_(std::move(mesh)), warnings_(warnings) {}

  void write() {
    const auto middles = mesh_.second_order ? std::make_unique<Middles>(mesh_) : nullptr;
    elements_ = exodus_elements(mesh_, middles.get(), warnings_);
    find_node_sets();
    shorten_all_names();
    choose_names();
    for (OutSet& set : elements_.side_sets) set.name = group_name(2, set.tag);
    warn_of_losses();
    std::int64_t elements = 0;
    for (const OutBlock& block : elements_.blocks) elements += std::ssize(block.elements);
    const auto count = [](const auto& list) { return std::ssize(list); };
    file_.check(ex_put_init(file_.id(), "written by tetune", 3, count(mesh_.points), elements, count(elements_.blocks),
                            count(node_sets_), count(elements_.side_sets)),
                "write the sizes");
    write_points();
    write_blocks();
    write_sets(EX_SIDE_SET, elements_.side_sets);
    write_sets(EX_NODE_SET, node_sets_);
    write_variables();
  }

 private:
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

  /// Moves the sets of nodes out of the data. Each keeps its number where that is positive and no other set has it.
  void find_node_sets() {
    std::vector<DataArray> rest;
    FreeNumbers numbers({});
    std::vector<std::size_t> renumbered;
    for (DataArray& array : mesh_.point_data) {
      if (!is_node_set(array)) {
        rest.push_back(std::move(array));
        continue;
      }
      const std::string_view text = std::string_view(array.name).substr(kNodeSet.size());
      OutSet& set = node_sets_.emplace_back();
      std::from_chars(text.data(), text.data() + text.size(), set.id);
      if (set.id <= 0 || !numbers.take(set.id)) renumbered.push_back(node_sets_.size() - 1);
      if (const auto colon = text.find(':'); colon != text.npos) set.name = text.substr(colon + 1);
      const auto& flags = std::get<std::vector<std::uint8_t>>(array.values);
      for (std::size_t v = 0; v < flags.size(); ++v) {
        if (flags[v] != 0) set.entries.push_back(int(v) + 1);
      }
    }
    mesh_.point_data = std::move(rest);
    for (const std::size_t i : renumbered) node_sets_[i].id = numbers.take_lowest();
    if (!renumbered.empty()) {
      warnings_.push_back(std::to_string(renumbered.size()) +
                          " node sets get other numbers: Exodus' are positive, and different for each set");
    }
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
    for (OutSet& set : node_sets_) sets.push_back({&set.name, kMost});
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

  // Blocks and sets are defined all at once: the library rewrites the head of the file, which lists them, each time.

  void write_blocks() {
    if (elements_.blocks.empty()) return;
    std::vector<ex_block> blocks;
    for (const OutBlock& block : elements_.blocks) {
      const KindOfElement& kind = kKinds[block.kind];
      ex_block& written = blocks.emplace_back();
      written.id = block.id;
      written.type = EX_ELEM_BLOCK;
      std::strncpy(written.topology, kind.written, sizeof written.topology - 1);
      written.num_entry = std::ssize(block.elements);
      written.num_nodes_per_entry = kind.nodes;
    }
    file_.check(ex_put_block_params(file_.id(), blocks.size(), blocks.data()), "write the element blocks");
    for (const OutBlock& block : elements_.blocks) {
      file_.check(ex_put_conn(file_.id(), EX_ELEM_BLOCK, block.id, block.nodes.data(), nullptr, nullptr),
                  "write the elements");
      put_name(EX_ELEM_BLOCK, block.id, group_name(block.dimension, block.tag));
    }
  }

  void write_sets(ex_entity_type type, std::vector<OutSet>& sets) {
    if (sets.empty()) return;
    const auto values = [](std::vector<int>& list) { return list.empty() ? nullptr : list.data(); };
    std::vector<ex_set> written;
    written.reserve(sets.size());
    for (OutSet& set : sets) {
      written.push_back({set.id, type, std::ssize(set.entries), 0, values(set.entries), values(set.sides), nullptr});
    }
    file_.check(ex_put_sets(file_.id(), written.size(), written.data()), "write the sets");
    for (const OutSet& set : sets) put_name(type, set.id, set.name);
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
      for (const OutBlock& block : elements_.blocks)
        table.insert(table.end(), elemental.size(), block.kind < kTriangles ? 1 : 0);
      file_.check(ex_put_truth_table(file_.id(), EX_ELEM_BLOCK, int(elements_.blocks.size()), int(elemental.size()),
                                     table.data()),
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
      for (const OutBlock& block : elements_.blocks) {
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
  ExodusElements elements_;
  std::vector<OutSet> node_sets_;
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
