// SPDX-License-Identifier: Apache-2.0
// Universal files of I-deas (.unv): units, nodes, elements, groups.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
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

/// Of the ten columns of a number at least one is blank, so that programs that read words find it.
constexpr std::int64_t kMaxUnvNumber = 999'999'999;
constexpr std::size_t kIntegerColumns = 10, kRealColumns = 25;
constexpr Size kRecordsPerRange = 1 << 14;
constexpr const char* kUnvMark = "    -1\n";
/// As Salome writes them: factors of length, force and temperature, and the offset of the latter.
constexpr std::string_view kMetersAndNewtons =
    "         1  SI: Meter (newton)         2\n"
    "   1.0000000000000000D+00   1.0000000000000000D+00   1.0000000000000000D+00\n"
    "   2.7314999999999998D+02\n";

void append_columns(std::string& text, std::string_view number, std::size_t width) {
  text.append(width - std::min(width, number.size()), ' ').append(number);
}
void append_integer(std::string& text, std::int64_t number) {
  std::array<char, 24> digits;
  const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  append_columns(text, std::string_view(digits.data(), std::size_t(end - digits.data())), kIntegerColumns);
}
/// 17 digits, which read back to the same bits, and the exponent of Fortran.
void append_real(std::string& text, double value) {
  std::array<char, 40> digits;
  char* const end =
      print_real(digits.data(), digits.data() + digits.size(), value, std::chars_format::scientific, 16).ptr;
  std::replace(digits.data(), end, 'e', 'D');
  append_columns(text, std::string_view(digits.data(), std::size_t(end - digits.data())), kRealColumns);
}

class UnvWriter {
 public:
  /// `middles` is null for a mesh of first order; otherwise `mesh` has the mid-side nodes after its vertices, of which
  /// there are `vertices`.
  UnvWriter(FileWriter& file, const TetMesh& mesh, std::size_t vertices, const Middles* middles,
            const IoContext& context)
      : file_(file), mesh_(mesh), vertices_(vertices), middles_(middles), context_(context), cpu_(context.threads) {}

  void write() {
    check_size();
    node_numbers_ = numbers_of_nodes(mesh_, vertices_, kMaxUnvNumber, context_);
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

  /// Whether the groups are in the data set that Gmsh reads.
  bool is_of_gmsh() const { return mesh_.dialect.starts_with(std::string(kUnvDialect) + kUnvGroupsOfGmsh); }

  void check_size() const {
    std::size_t elements = mesh_.edges.size() + mesh_.triangles.size() + mesh_.tets.size();
    for (const ElementBlock& block : mesh_.others) elements += block.tags.size();
    if (std::int64_t(std::max(elements, mesh_.points.size())) > kMaxUnvNumber) {
      throw FileError("the mesh has more nodes or elements than universal files have numbers, " +
                      std::to_string(kMaxUnvNumber));
    }
  }

  template <class Write>
  void write_set(const char* number, const Write& write) {
    std::string text = kUnvMark;
    constexpr std::size_t kSetColumns = 6;
    append_columns(text, number, kSetColumns);
    file_.write(text + '\n');
    write();
    file_.write(kUnvMark);
  }
  /// Writes n records; put(text, i) appends one of them.
  template <class Put>
  void write_records(std::size_t n, const Put& put) {
    const auto format = [&put](std::string& text, Size begin, Size end) {
      text.clear();
      for (Size i = begin; i < end; ++i) put(text, to_size_t(i));
    };
    write_in_ranges(cpu_, Size(n), kRecordsPerRange, format, [this](const std::string& text) { file_.write(text); });
  }

  // Numbers of properties.

  template <class Use>
  void for_each_list_of_tags(const Use& use) const {
    use(1, mesh_.edge_tags);
    use(2, mesh_.triangle_tags);
    use(3, mesh_.tet_tags);
    for (const ElementBlock& block : mesh_.others) {
      if (block.kind != kPoints) use(block.kind == "Quadrilaterals" ? 2 : 3, block.tags);
    }
  }
  void number_properties() {
    for_each_list_of_tags([this](int dimension, const std::vector<int>& list) {
      std::set<int>& tags = tags_[to_size_t(dimension)];
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (i == 0 || list[i] != list[i - 1]) tags.insert(list[i]);
      }
    });
    for (std::size_t dimension = 1; dimension <= 3; ++dimension) {
      // 0 stands for no property as well.
      std::set<int> numbered = tags_[dimension];
      numbered.erase(0);
      std::map<int, int>& tag2number = properties_[dimension];
      tag2number = numbers_of_tags(numbered, {}, std::numeric_limits<int>::max());
      tag2number[0] = 0;
      std::string first;
      int renumbered = 0;
      for (const auto& [tag, number] : tag2number) {
        if (tag == number || renumbered++ > 0) continue;
        first = std::to_string(tag) + " is written as " + std::to_string(number);
      }
      if (renumbered == 0) continue;
      if (renumbered > 1) first += ", and " + std::to_string(renumbered - 1) + " more";
      context_.warn("the format's numbers are positive: of elements of dimension " + std::to_string(dimension) +
                    " the tag " + first);
    }
  }

  // Nodes and elements.

  void write_nodes() {
    for (const Point3& p : mesh_.points) {
      if (std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); })) continue;
      throw FileError("a coordinate is not finite; the format has no notation for it");
    }
    write_records(mesh_.points.size(), [this](std::string& text, std::size_t v) {
      append_integer(text, node_numbers_[v]);
      // The global coordinate system, and the color that I-deas gives nodes.
      text += "         1         1        11\n";
      for (const double x : mesh_.points[v]) append_real(text, x);
      text += '\n';
    });
  }

  /// Writes the elements with these tags; nodes_of(e, nodes) sets the n nodes of one, mid-side nodes last.
  template <class NodesOf>
  void write_records_of(const UnvElementKind& kind, std::size_t n, const std::vector<int>& tags,
                        const NodesOf& nodes_of) {
    const std::map<int, int>& tag2number = properties_[kind.dimension];
    write_records(tags.size(), [&](std::string& text, std::size_t e) {
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
      std::array<Index, 10> nodes{}, listed{};
      nodes_of(e, nodes);
      for (std::size_t k = 0; k < n; ++k) listed[unv_place(kind.role, n, k)] = nodes[k];
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
    write_records_of(kind, n, tags, [&](std::size_t e, std::array<Index, 10>& nodes) {
      std::array<Index, N> v = elements[e];
      if constexpr (N == 4) {
        if (mesh_.listed_inside_out) std::swap(v[2], v[3]);
      }
      std::copy(v.begin(), v.end(), nodes.begin());
      if (middles_ == nullptr) return;
      for (std::size_t k = 0; k < E; ++k) {
        nodes[N + k] = middles_->of(v[to_size_t(edges[k][0])], v[to_size_t(edges[k][1])]);
      }
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
      write_records_of(kind, kind.vertices, block.tags, [&](std::size_t e, std::array<Index, 10>& nodes) {
        std::copy_n(block.element2vertex.begin() + std::ptrdiff_t(e * kind.vertices), kind.vertices, nodes.begin());
      });
    }
  }

  // Groups.

  void write_group(const UnvWrittenGroup& group) {
    constexpr std::int64_t kNode = 7, kElement = 8;
    std::vector<std::pair<std::int64_t, std::int64_t>> entities;  // kinds and numbers
    if (group.in_set != nullptr) {
      for (std::size_t v = 0; v < group.in_set->size(); ++v) {
        if ((*group.in_set)[v] != 0) entities.emplace_back(kNode, node_numbers_[v]);
      }
    }
    for (const auto& [dimension, tag] : group.tags) {
      const auto& tag2members = members_[to_size_t(dimension)];
      const auto members = tag2members.find(tag);
      if (members == tag2members.end()) continue;
      for (const std::int64_t element : members->second) entities.emplace_back(kElement, element);
    }
    std::string text;
    append_integer(text, group.number);
    for (int field = 0; field < 6; ++field) append_integer(text, 0);
    append_integer(text, std::ssize(entities));
    file_.write(text + '\n' + group.name + '\n');
    write_records((entities.size() + 1) / 2, [&](std::string& line, std::size_t i) {
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
  std::size_t vertices_;
  const Middles* middles_;
  const IoContext& context_;
  backend::Cpu cpu_;
  std::vector<std::int64_t> node_numbers_;
  std::array<std::set<int>, 4> tags_;                                ///< by dimension, as those below
  std::array<std::map<int, int>, 4> properties_;                     ///< numbers by tag
  std::array<std::map<int, std::vector<std::int64_t>>, 4> members_;  ///< numbers of elements by tag
  std::int64_t next_element_ = 1;
};

}  // namespace

std::string unv_length_unit(const TetMesh& mesh) {
  constexpr std::array<const char*, 10> kUnits{"",           "",           "foot", "",           "foot",
                                               "millimeter", "centimeter", "inch", "millimeter", "unit of its user"};
  const int code = std::atoi(std::string(unv_units(mesh).substr(0, kIntegerColumns)).c_str());
  return code < 0 || code >= std::ssize(kUnits) ? "" : kUnits[to_size_t(code)];
}

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
  if (!mesh.second_order) return UnvWriter(file, mesh, mesh.points.size(), nullptr, context).write();
  TetMesh with_middles = mesh;
  const Middles middles(with_middles);
  UnvWriter(file, with_middles, mesh.points.size(), &middles, context).write();
}

}  // namespace tetune
