// SPDX-License-Identifier: Apache-2.0
// Universal files of I-deas (.unv): units, nodes, elements, groups.
#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/node_numbers.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "io/tag_numbers.hpp"
#include "io/unv/unv_elements.hpp"
#include "io/unv/unv_format.hpp"
#include "io/unv/unv_groups.hpp"
#include "mesh/node_sets.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The largest number of a node or element: one of the ten columns stays blank, so that programs that read words find
/// each number.
constexpr std::int64_t kMaxUnvNumber = 999'999'999;
constexpr const char* kUnvMark = "    -1\n";
/// The data set of units as Salome writes it: factors of length, force and temperature, and the offset of the latter.
constexpr std::string_view kMetersAndNewtons =
    "         1  SI: Meter (newton)         2\n"
    "   1.0000000000000000D+00   1.0000000000000000D+00   1.0000000000000000D+00\n"
    "   2.7314999999999998D+02\n";

void append_integer(std::string& text, std::int64_t number) { append_right(text, number, kUnvIntegerWidth); }
/// 17 digits, which read back to the same bits, and the exponent of Fortran.
void append_real(std::string& text, double value) {
  std::array<char, 40> digits;
  char* const end =
      print_real(digits.data(), digits.data() + digits.size(), value, std::chars_format::scientific, 16).ptr;
  std::replace(digits.data(), end, 'e', 'D');
  append_right(text, std::string_view(digits.data(), std::size_t(end - digits.data())), kUnvRealWidth);
}

class UnvWriter {
 public:
  /// `middles`: the mid-side nodes of `mesh`; null where it has none.
  UnvWriter(FileWriter& file, const TetMesh& mesh, const Middles* middles, const IoContext& context)
      : file_(file), mesh_(mesh), middles_(middles), context_(context), cpu_(context.threads) {}

  void write() {
    check_size();
    node_numbers_ = numbers_of_nodes(mesh_, middles_, kMaxUnvNumber, context_);
    number_properties();
    const bool is_read = mesh_.dialect.starts_with(kUnvDialect);
    if (const std::string_view units = is_read ? unv_units(mesh_) : kMetersAndNewtons; !units.empty()) {
      write_set("164", [&] { file_.write(units); });
    }
    write_set("2411", [this] { write_nodes(); });
    write_set("2412", [this] {
      for (const UnvElementKind& kind : kUnvElementKinds) write_elements(kind);
    });
    const std::vector<UnvWrittenGroup> groups = unv_groups_to_write(mesh_, properties_, context_);
    if (groups.empty()) return;
    write_set(is_of_gmsh() ? kUnvGroupsOfGmsh : kUnvGroups, [&] {
      for (const UnvWrittenGroup& group : groups) write_group(group);
    });
  }

 private:
  using Role = UnvElementKind::Role;

  /// Whether the groups are to be in the data set that Gmsh reads.
  bool is_of_gmsh() const { return mesh_.dialect.starts_with(std::string(kUnvDialect) + kUnvGroupsOfGmsh); }

  void check_size() const {
    std::size_t elements = mesh_.edges.size() + mesh_.triangles.size() + mesh_.tets.size();
    for (const ElementBlock& block : mesh_.others) elements += block.tags.size();
    if (std::int64_t(std::max(elements, mesh_.points.size())) > kMaxUnvNumber) {
      throw FileError("the mesh has more nodes or elements than the largest number of universal files, " +
                      std::to_string(kMaxUnvNumber) + ": write another format");
    }
  }

  template <class Write>
  void write_set(const char* number, const Write& write) {
    std::string text = kUnvMark;
    constexpr std::size_t kSetColumns = 6;
    append_right(text, number, kSetColumns);
    file_.write(text + '\n');
    write();
    file_.write(kUnvMark);
  }

  // Numbers of properties.

  void number_properties() {
    const std::array<std::set<int>, 4> tags = tags_by_dimension(mesh_);
    for (std::size_t dimension = 1; dimension <= 3; ++dimension) {
      // The tag 0 stands for no tag, and the number 0 for no property.
      std::set<int> numbered = tags[dimension];
      numbered.erase(0);
      std::map<int, int>& tag2number = properties_[dimension];
      tag2number = numbers_of_tags(numbered, {}, std::numeric_limits<int>::max());
      tag2number[0] = 0;
      warn_of_renumbered_tags(tag2number, int(dimension), "positive", context_);
    }
  }

  // Nodes and elements.

  void write_nodes() {
    refuse_infinite_points(mesh_);
    write_records(file_, cpu_, mesh_.points.size(), [this](std::string& text, std::size_t v) {
      append_integer(text, node_numbers_[v]);
      // The global coordinate system, and the color that I-deas gives nodes.
      text += "         1         1        11\n";
      for (const double x : mesh_.points[v]) append_real(text, x);
      text += '\n';
    });
  }

  /// Writes elements of a kind, one per tag; nodes_of(e, nodes) sets the n nodes of one, mid-side nodes last.
  template <class NodesOf>
  void write_records_of(const UnvElementKind& kind, std::size_t n, const std::vector<int>& tags,
                        const NodesOf& nodes_of) {
    const std::map<int, int>& tag2number = properties_[kind.dimension];
    write_records(file_, cpu_, tags.size(), [&](std::string& text, std::size_t e) {
      append_integer(text, next_element_ + std::int64_t(e));
      append_integer(text, n > kind.vertices ? kind.written_quadratic : kind.written);
      const int property = tag2number.at(tags[e]);
      append_integer(text, property);
      // The material. Gmsh takes it for the number of a group; where it reads groups, 0 adds none.
      append_integer(text, is_of_gmsh() ? 0 : property);
      text += "         7";
      append_integer(text, std::int64_t(n));
      text += '\n';
      if (kind.role == Role::edge) text += "         0         1         1\n";
      std::array<Index, kMaxNodes> nodes{}, listed{};
      nodes_of(e, nodes);
      for (std::size_t k = 0; k < n; ++k) listed[kind.place(n, k)] = nodes[k];
      constexpr std::size_t kPerLine = 8;
      for (std::size_t k = 0; k < n; ++k) {
        append_integer(text, span_of(node_numbers_)[listed[k]]);
        if ((k + 1) % kPerLine == 0 || k + 1 == n) text += '\n';
      }
    });
    std::vector<std::int64_t>* members = nullptr;
    for (std::size_t e = 0; e < tags.size(); ++e) {
      if (e == 0 || tags[e] != tags[e - 1]) members = &members_[kind.dimension][tags[e]];
      members->push_back(next_element_++);
    }
  }
  template <std::size_t N, std::size_t E>
  void write_simplices(const UnvElementKind& kind, const std::vector<std::array<Index, N>>& elements,
                       const std::vector<int>& tags, const std::array<Pair, E>& edges) {
    const std::size_t n = N + (middles_ != nullptr ? E : 0);
    write_records_of(kind, n, tags, [&](std::size_t e, std::array<Index, kMaxNodes>& nodes) {
      list_simplex(mesh_, elements[e], middles_, edges, nodes);
    });
  }
  void write_elements(const UnvElementKind& kind) {
    if (kind.role == Role::edge) return write_simplices(kind, mesh_.edges, mesh_.edge_tags, kEdgeEdges);
    if (kind.role == Role::triangle) {
      return write_simplices(kind, mesh_.triangles, mesh_.triangle_tags, kTriangleEdges);
    }
    if (kind.role == Role::tetrahedron) return write_simplices(kind, mesh_.tets, mesh_.tet_tags, kTetEdges);
    if (kind.role != Role::other) return;
    for (const ElementBlock& block : mesh_.others) {
      if (block.kind != kind.block) continue;
      const std::span<const Pair> edges = middle_edges(mesh_, block, MiddleOrder::base_between_top);
      write_records_of(
          kind, kind.vertices + edges.size(), block.tags,
          [&](std::size_t e, std::array<Index, kMaxNodes>& nodes) { list_other(block, e, middles_, edges, nodes); });
    }
  }

  // Groups.

  void write_group(const UnvWrittenGroup& group) {
    std::vector<std::pair<std::int64_t, std::int64_t>> entities;  // codes and numbers
    if (group.in_set != nullptr) {
      for (std::size_t v = 0; v < group.in_set->size(); ++v) {
        if ((*group.in_set)[v] != 0) entities.emplace_back(kUnvNode, node_numbers_[v]);
      }
    }
    for (const auto& [dimension, tag] : group.tags) {
      const auto& tag2members = members_[to_size_t(dimension)];
      const auto members = tag2members.find(tag);
      if (members == tag2members.end()) continue;
      for (const std::int64_t element : members->second) entities.emplace_back(kUnvElement, element);
    }
    std::string text;
    append_integer(text, group.number);
    for (int field = 0; field < 6; ++field) append_integer(text, 0);
    append_integer(text, std::ssize(entities));
    file_.write(text + '\n' + group.name + '\n');
    write_records(file_, cpu_, (entities.size() + 1) / 2, [&](std::string& line, std::size_t i) {
      for (std::size_t k = 2 * i; k < std::min(2 * i + 2, entities.size()); ++k) {
        append_integer(line, entities[k].first);
        append_integer(line, entities[k].second);
        line += "         0         0";
      }
      line += '\n';
    });
  }

  FileWriter& file_;
  const TetMesh& mesh_;
  const Middles* middles_;
  const IoContext& context_;
  backend::Cpu cpu_;
  std::vector<std::int64_t> node_numbers_;
  std::array<std::map<int, int>, 4> properties_;                     ///< numbers by tag, for each dimension
  std::array<std::map<int, std::vector<std::int64_t>>, 4> members_;  ///< numbers of elements by tag, for each dimension
  std::int64_t next_element_ = 1;
};

}  // namespace

void write_unv(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  for (const ElementBlock& block : mesh.others) {
    const bool is_known = std::any_of(kUnvElementKinds.begin(), kUnvElementKinds.end(),
                                      [&block](const UnvElementKind& e) { return e.block == block.kind; });
    if (!is_known && block.kind != kPoints) throw FileError("universal files have no elements of kind " + block.kind);
    if (block.kind == kPoints) warn_of_point_elements(context);
  }
  warn_of_lists(mesh, context);
  warn_of_point_tags(mesh, context);
  warn_of_data_but_node_sets(mesh, context);
  write_with_middles(mesh, MiddlesOf::all,
                     [&](const TetMesh& m, const Middles* middles) { UnvWriter(file, m, middles, context).write(); });
}

}  // namespace tetune
