// SPDX-License-Identifier: Apache-2.0
// Gmsh's .msh files, versions 2.2 and 4.1, text and binary.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <span>

#include "backend/span.hpp"
#include "io/losses.hpp"
#include "io/msh/msh_layout.hpp"
#include "io/msh/msh_sink.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class MshWriter {
 public:
  MshWriter(FileWriter& file, const TetMesh& mesh, const Middles* middles, const IoContext& context)
      : mesh_(mesh),
        middles_(middles),
        context_(context),
        layout_(lay_out(mesh, context)),
        is_old_(mesh.dialect.starts_with("msh 2.2")),
        sink_(file, !mesh.dialect.starts_with("msh") || !mesh.dialect.ends_with("text")) {}

  void write() {
    for (PeriodicLink& link : layout_.links) {
      if (middles_ != nullptr) middles_->extend(link);
    }
    write_header();
    write_names();
    if (is_old_) {
      write_old_nodes();
      write_old_elements();
    } else {
      write_entities();
      write_blocks_of_nodes();
      write_blocks_of_elements();
    }
    write_periodic();
    write_data();
    write_loose_tags();
    sink_.flush();
  }

 private:
  void write_header() {
    sink_.begin("MeshFormat");
    sink_.text(std::string(is_old_ ? "2.2" : "4.1") + (sink_.is_binary() ? " 1 8\n" : " 0 8\n"));
    if (sink_.is_binary()) sink_.integer(1);
    sink_.end("MeshFormat");
  }

  /// A name between quotation marks, with a warning where it has characters that cannot be there.
  std::string quoted(const std::string& name) const {
    std::string written = msh_quoted(name);
    if (name.find_first_of("\"\n\r") != std::string::npos) {
      context_.warn("names are written without quotation marks and ends of lines: " + written);
    }
    return written;
  }

  void write_names() {
    if (layout_.names.empty()) return;
    sink_.begin("PhysicalNames");
    sink_.text(std::to_string(layout_.names.size()) + "\n");
    for (const Group& group : layout_.names) {
      sink_.text(std::to_string(group.dimension) + " " + std::to_string(group.number) + " " + quoted(group.name) +
                 "\n");
    }
    sink_.text("$EndPhysicalNames\n");
  }

  void write_entities() {
    sink_.begin("Entities");
    for (int dimension = 0; dimension <= 3; ++dimension) {
      sink_.count(to_size_t(std::count_if(layout_.entities.begin(), layout_.entities.end(),
                                          [&](const auto& entity) { return entity.dimension == dimension; })));
    }
    sink_.end_line();
    for (const MshLayoutEntity& entity : layout_.entities) {
      sink_.integer(entity.number);
      for (std::size_t k = 0; k < (entity.dimension == 0 ? 3 : 6); ++k) sink_.real(entity.box[k]);
      sink_.count(entity.groups.size());
      for (const int group : entity.groups) sink_.integer(group);
      if (entity.dimension > 0) {
        sink_.count(entity.bounds.size());
        for (const int bound : entity.bounds) sink_.integer(bound);
      }
      sink_.end_line();
    }
    sink_.end("Entities");
  }

  void put_point(std::size_t v) {
    for (const double x : mesh_.points[v]) sink_.real(x);
    sink_.end_line();
  }

  /// Calls take(vertex) for the nodes of an element in the orientation of the file, in Gmsh's order.
  template <class Take>
  void for_each_node(const MshKind& kind, std::size_t element, const Take& take) const {
    std::array<Index, 8> v{};
    std::copy_n(kind.corners(element), kind.type->corners, v.begin());
    if (mesh_.listed_inside_out && kind.type->list == kMshTets) std::swap(v[2], v[3]);
    for (int k = 0; k < kind.type->corners; ++k) take(v[to_size_t(k)]);
    for (const auto& [a, b] : msh_middle_edges(written_type(kind))) {
      take(middles_->of(v[to_size_t(a)], v[to_size_t(b)]));
    }
  }
  const MshType& written_type(const MshKind& kind) const {
    const bool second = middles_ != nullptr && kind.type->list < kMshFirstOther;
    return second ? msh_second_order_type_of(kind.type->list) : *kind.type;
  }

  /// The vertices by entity: that of the lowest dimension that has the vertex in an element or a periodic pair; the
  /// last one for others. Gmsh takes the vertices of an entity for those of its periodic links.
  std::vector<std::vector<Index>> vertices_by_entity() const {
    std::vector<Index> owner(mesh_.points.size(), -1);
    const auto claim = [&owner](Index v, Index entity) {
      if (span_of(owner)[v] < 0) span_of(owner)[v] = entity;
    };
    for (int dimension = 0; dimension <= 3; ++dimension) {
      for (const MshKind& kind : layout_.kinds) {
        for (std::size_t e = 0; kind.type->dimension == dimension && e < kind.size(); ++e) {
          for_each_node(kind, e, [&](Index v) { claim(v, kind.entity[e]); });
        }
      }
      for (const PeriodicLink& link : layout_.links) {
        if (link.dimension != dimension) continue;
        const Index entity = layout_.find(dimension, link.entity);
        const Index master = layout_.find(dimension, link.master);
        for (const auto& pair : link.pairs) {
          claim(pair[0], entity);
          claim(pair[1], master);
        }
      }
    }
    std::vector<std::vector<Index>> vertices(layout_.entities.size());
    for (std::size_t v = 0; v < owner.size(); ++v) {
      (owner[v] < 0 ? vertices.back() : span_of(vertices)[owner[v]]).push_back(to_index(v));
    }
    return vertices;
  }

  void write_counts(std::size_t blocks, std::int64_t entries) {
    sink_.count(blocks);
    for (const std::int64_t n : {entries, std::int64_t{1}, entries}) sink_.long_integer(n);
    sink_.end_line();
  }

  void write_blocks_of_nodes() {
    const std::vector<std::vector<Index>> vertices = vertices_by_entity();
    const auto empty = std::count_if(vertices.begin(), vertices.end(), [](const auto& list) { return list.empty(); });
    sink_.begin("Nodes");
    write_counts(vertices.size() - to_size_t(empty), std::ssize(mesh_.points));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i].empty()) continue;
      sink_.integer(layout_.entities[i].dimension);
      sink_.integer(layout_.entities[i].number);
      sink_.integer(0);  // not parametric
      sink_.count(vertices[i].size());
      sink_.end_line();
      for (const Index v : vertices[i]) {
        sink_.long_integer(std::int64_t{v} + 1);
        sink_.end_line();
      }
      for (const Index v : vertices[i]) put_point(to_size_t(v));
    }
    sink_.end("Nodes");
  }

  void write_blocks_of_elements() {
    std::size_t blocks = 0;
    std::int64_t elements = 0;
    std::vector<std::vector<std::vector<Index>>> by_entity;  // per kind
    for (const MshKind& kind : layout_.kinds) {
      by_entity.emplace_back(layout_.entities.size());
      for (std::size_t e = 0; e < kind.size(); ++e) span_of(by_entity.back())[kind.entity[e]].push_back(to_index(e));
      blocks += to_size_t(std::count_if(by_entity.back().begin(), by_entity.back().end(),
                                        [](const auto& list) { return !list.empty(); }));
      elements += std::ssize(*kind.tags);
    }
    sink_.begin("Elements");
    write_counts(blocks, elements);
    for (std::size_t k = 0; k < layout_.kinds.size(); ++k) {
      for (std::size_t i = 0; i < layout_.entities.size(); ++i) {
        if (!by_entity[k][i].empty()) write_block(layout_.kinds[k], layout_.entities[i], by_entity[k][i]);
      }
    }
    sink_.end("Elements");
  }
  void write_block(const MshKind& kind, const MshLayoutEntity& entity, const std::vector<Index>& elements) {
    sink_.integer(entity.dimension);
    sink_.integer(entity.number);
    sink_.integer(written_type(kind).number);
    sink_.count(elements.size());
    sink_.end_line();
    for (const Index e : elements) {
      sink_.long_integer(kind.first_number + e);
      for_each_node(kind, to_size_t(e), [this](Index v) { sink_.long_integer(std::int64_t{v} + 1); });
      sink_.end_line();
    }
  }

  // Version 2.2.

  void write_old_nodes() {
    sink_.begin("Nodes");
    sink_.text(std::to_string(mesh_.points.size()) + "\n");
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      sink_.integer(to_index(v) + 1);
      put_point(v);
    }
    sink_.end("Nodes");
  }

  /// The times that an element is written: once for each group of its entity.
  const std::vector<int>& old_groups(const MshKind& kind, std::size_t element) const {
    static const std::vector<int> none{0};
    const std::vector<int>& groups = span_of(layout_.entities)[kind.entity[element]].groups;
    return groups.empty() ? none : groups;
  }

  void write_old_elements() {
    std::vector<std::size_t> counts;
    for (const MshKind& kind : layout_.kinds) {
      counts.push_back(0);
      for (std::size_t e = 0; e < kind.size(); ++e) counts.back() += old_groups(kind, e).size();
    }
    const std::size_t total = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
    if (excess_of(std::int64_t(total), kMaxEntries) != "")
      throw FileError("version 2.2 of .msh files cannot hold " + std::to_string(total) +
                      " elements; write another format");
    sink_.begin("Elements");
    sink_.text(std::to_string(total) + "\n");
    int repeated = to_index(layout_.kinds.back().first_number + std::ssize(*layout_.kinds.back().tags));
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const MshKind& kind = layout_.kinds[k];
      if (sink_.is_binary()) {
        for (const int word : {written_type(kind).number, to_index(counts[k]), 2}) sink_.integer(word);
      }
      for (std::size_t e = 0; e < kind.size(); ++e) {
        // The first keeps the number, to which data refer.
        int number = to_index(kind.first_number + std::int64_t(e));
        for (const int group : old_groups(kind, e)) {
          write_old_element(kind, e, number, group);
          number = repeated++;
        }
        --repeated;
      }
    }
    sink_.end("Elements");
  }
  void write_old_element(const MshKind& kind, std::size_t element, int number, int group) {
    sink_.integer(number);
    if (!sink_.is_binary()) {
      sink_.integer(written_type(kind).number);
      sink_.integer(2);
    }
    sink_.integer(group);
    sink_.integer(span_of(layout_.entities)[kind.entity[element]].number);
    for_each_node(kind, element, [this](Index v) { sink_.integer(v + 1); });
    sink_.end_line();
  }

  // The sections after the elements.

  void write_periodic() {
    if (layout_.links.empty()) return;
    const bool is_binary = sink_.is_binary();
    if (is_old_) sink_.set_binary(false);
    sink_.begin("Periodic");
    sink_.count(layout_.links.size());
    sink_.end_line();
    for (const PeriodicLink& link : layout_.links) {
      for (const int word : {link.dimension, link.entity, link.master}) sink_.integer(word);
      sink_.end_line();
      if (!is_old_) sink_.count(link.affine.size());
      if (is_old_ && !link.affine.empty()) sink_.text("Affine ");
      for (const double value : link.affine) sink_.real(value);
      if (!is_old_ || !link.affine.empty()) sink_.end_line();
      sink_.count(link.pairs.size());
      sink_.end_line();
      for (const auto& pair : link.pairs) {
        for (const Index v : pair) sink_.long_integer(std::int64_t{v} + 1);
        sink_.end_line();
      }
    }
    sink_.end("Periodic");
    sink_.set_binary(is_binary);
  }

  void write_data() {
    for (const DataArray& array : mesh_.point_data) {
      View view{array.name, array.components, {}, {}};
      add_values(array, 1, view);
      write_view("NodeData", view);
    }
    // All kinds of elements that have data of one name share a view.
    std::set<std::string> done{kMshEntities};
    for (const MshKind& kind : layout_.kinds) {
      for (const DataArray& array : *kind.data) {
        if (!done.insert(array.name).second) continue;
        View view{array.name, array.components, {}, {}};
        for (const MshKind& other : layout_.kinds) {
          for (const DataArray& same : *other.data) {
            if (same.name == array.name && same.components == array.components) {
              add_values(same, other.first_number, view);
            }
          }
        }
        write_view("ElementData", view);
      }
    }
    std::vector<const std::vector<DataArray>*> lists{&mesh_.point_data};
    for (const MshKind& kind : layout_.kinds) lists.push_back(kind.data);
    if (const std::string text = rounded_integers(lists, "Gmsh"); !text.empty()) context_.warn(text);
  }

  struct View {
    std::string name;
    int components;
    std::vector<std::int64_t> numbers;
    std::vector<double> values;
  };
  /// Adds the entries that are not undefined.
  static void add_values(const DataArray& array, std::int64_t first_number, View& view) {
    const auto each = to_size_t(std::max(1, array.components));
    const auto add = [&](const auto& values) {
      for (std::size_t i = 0; i + each <= values.size(); i += each) {
        const std::span entry(&values[i], each);
        if (std::all_of(entry.begin(), entry.end(), [](auto x) { return std::isnan(double(x)); })) continue;
        view.numbers.push_back(first_number + std::int64_t(i / each));
        for (const auto x : entry) view.values.push_back(double(x));
      }
    };
    std::visit(add, array.values);
  }
  void write_view(const char* section, const View& view) {
    if (view.components != 1 && view.components != 3 && view.components != 9) {
      context_.warn("Gmsh cannot hold the data \"" + view.name + "\" of " + std::to_string(view.components) +
                    " components: 1, 3 or 9 are possible");
      return;
    }
    sink_.begin(section);
    sink_.text("1\n" + quoted(view.name) + "\n1\n0\n3\n0\n" + std::to_string(view.components) + "\n" +
               std::to_string(view.numbers.size()) + "\n");
    const auto each = to_size_t(view.components);
    for (std::size_t i = 0; i < view.numbers.size(); ++i) {
      sink_.integer(to_index(view.numbers[i]));
      for (std::size_t c = 0; c < each; ++c) sink_.real(view.values[i * each + c]);
      sink_.end_line();
    }
    sink_.end(section);
  }

  /// The tags of entities in no group that the reader would not find by itself.
  void write_loose_tags() {
    const bool grouped = std::any_of(layout_.entities.begin(), layout_.entities.end(),
                                     [](const MshLayoutEntity& entity) { return !entity.groups.empty(); });
    std::string lines;
    for (const MshLayoutEntity& entity : layout_.entities) {
      if (!entity.has_elements || !entity.groups.empty() || entity.tag == (grouped ? -entity.number : entity.number))
        continue;
      lines += std::to_string(entity.dimension) + " " + std::to_string(entity.number) + " " +
               std::to_string(entity.tag) + "\n";
    }
    if (lines.empty()) return;
    sink_.begin("Comments");
    sink_.text(std::string(kMshLooseTags) + "\n" + lines + "$EndComments\n");
  }

  const TetMesh& mesh_;
  const Middles* middles_;  ///< of elements of second order
  const IoContext& context_;
  MshLayout layout_;
  bool is_old_;  ///< version 2.2
  MshSink sink_;
};

}  // namespace

void write_msh(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  warn_of_lists(mesh, context);
  warn_of_point_tags(mesh, context);
  write_with_middles(mesh, MiddlesOf::all,
                     [&](const TetMesh& m, const Middles* middles) { MshWriter(file, m, middles, context).write(); });
}

}  // namespace tetune
