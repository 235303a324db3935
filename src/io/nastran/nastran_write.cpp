// SPDX-License-Identifier: Apache-2.0
// Nastran's bulk data (.bdf, .nas): nodes in large fields, elements in small ones.
#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/nastran/nastran_elements.hpp"
#include "io/nastran/nastran_fields.hpp"
#include "io/node_numbers.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "io/tag_numbers.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr std::size_t kSmallWidth = 8, kFieldsPerLine = 8;

void warn_of_losses_in_nastran(const TetMesh& mesh, const IoContext& context) {
  warn_of_lists(mesh, context);
  warn_of_point_tags(mesh, context);
  warn_of_names(mesh, context);
  warn_of_data(mesh, context);
  for (const ElementBlock& block : mesh.others) {
    if (block.kind == kPoints) warn_of_point_elements(context);
  }
}

/// Appends a name at the left of a small field.
void append_name(std::string& line, std::string_view name) { line.append(name).append(kSmallWidth - name.size(), ' '); }

class NastranWriter {
 public:
  /// `middles`: the mid-side nodes of `mesh`; null where it has none.
  NastranWriter(FileWriter& file, const TetMesh& mesh, const Middles* middles, const IoContext& context)
      : file_(file), mesh_(mesh), middles_(middles), context_(context), cpu_(context.threads) {}

  void write() {
    if (mesh_.points.size() > std::size_t(kMaxNastranNumber)) {
      throw FileError("the mesh has " + std::to_string(mesh_.points.size()) +
                      " nodes; Nastran's numbers have at most 8 digits: write another format");
    }
    node_numbers_ = numbers_of_nodes(mesh_, middles_, kMaxNastranNumber, context_);
    number_properties();
    // Without this comment in the first line pyNastran expects the statements of a whole deck.
    file_.write("$ pyNastran: punch=True\n$ tetune\n");
    write_nodes();
    for (const NastranElementKind& kind : kNastranElementKinds) write_elements(kind);
    file_.write("ENDDATA\n");
  }

 private:
  using Role = NastranElementKind::Role;

  // Numbers.

  void number_properties() {
    const std::array<std::set<int>, 4> tags = tags_by_dimension(mesh_);
    std::map<int, int> number2dimension;
    int shared = 0;
    for (int dimension = 1; dimension <= 3; ++dimension) {
      std::map<int, int>& tag2number = properties_[to_size_t(dimension)];
      tag2number = numbers_of_tags(tags[to_size_t(dimension)], {}, kMaxNastranNumber);
      for (const auto& entry : tag2number) {
        if (!number2dimension.emplace(entry.second, dimension).second && shared == 0) shared = entry.second;
      }
      warn_of_renumbered_tags(tag2number, dimension, "from 1 to " + std::to_string(kMaxNastranNumber), context_);
    }
    if (shared == 0) return;
    context_.warn("elements of different dimensions have the property " + std::to_string(shared) +
                  "; for Nastran all properties need different numbers");
  }

  // Cards.

  void write_nodes() {
    refuse_infinite_points(mesh_);
    std::atomic<Size> rounded{0};
    write_records(file_, cpu_, mesh_.points.size(), [&](std::string& text, std::size_t v) {
      append_name(text, "GRID*");
      append_right(text, node_numbers_[v], kNastranLargeField);
      append_right(text, "", kNastranLargeField);
      for (std::size_t k = 0; k < 3; ++k) {
        if (k == 2) append_name(text += "*\n", "*");
        std::string number;
        if (!append_nastran_real(number, mesh_.points[v][k])) rounded.fetch_add(1, std::memory_order_relaxed);
        append_right(text, number, kNastranLargeField);
      }
      text += '\n';
    });
    if (rounded == 0) return;
    context_.warn(std::to_string(rounded) + " coordinates are rounded to the 16 characters of Nastran's large fields");
  }

  /// The cards of the elements of one kind.
  struct Cards {
    std::string_view name;
    std::size_t dimension, nodes;  ///< of each element
    const std::vector<int>& tags;
  };

  /// Appends the nodes of a card after its name, its number and that of its property.
  void append_nodes(std::string& text, std::span<const Index> nodes) const {
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      // The numbers of the element and the property are fields too.
      if (k > 0 && (k + 2) % kFieldsPerLine == 0) append_name(text += "+\n", "+");
      append_right(text, span_of(node_numbers_)[nodes[k]], kSmallWidth);
    }
    text += '\n';
  }

  /// Writes elements; nodes_of(e, nodes) sets the nodes of one.
  template <class NodesOf>
  void write_cards(const Cards& cards, const NodesOf& nodes_of) {
    const std::map<int, int>& tag2number = properties_[cards.dimension];
    write_records(file_, cpu_, cards.tags.size(), [&](std::string& text, std::size_t e) {
      append_name(text, cards.name);
      append_right(text, next_element_ + std::int64_t(e), kSmallWidth);
      append_right(text, tag2number.at(cards.tags[e]), kSmallWidth);
      std::array<Index, kMaxNodes> nodes;
      nodes_of(e, nodes);
      append_nodes(text, std::span(nodes).first(cards.nodes));
    });
    next_element_ += std::ssize(cards.tags);
    if (next_element_ > kMaxNastranNumber) {
      throw FileError("the mesh has more elements than Nastran's numbers of at most 8 digits: write another format");
    }
  }

  template <std::size_t N, std::size_t E>
  void write_simplices(std::string_view card, const std::vector<std::array<Index, N>>& elements,
                       const std::vector<int>& tags, const std::array<Pair, E>& edges) {
    const std::size_t n = N + (middles_ != nullptr ? E : 0);
    write_cards({card, N - 1, n, tags}, [&](std::size_t e, std::array<Index, kMaxNodes>& nodes) {
      list_simplex(mesh_, elements[e], middles_, edges, nodes);
    });
  }

  void write_elements(const NastranElementKind& kind) {
    if (kind.card == "CROD") {
      const auto nodes_of = [this](std::size_t e, std::array<Index, kMaxNodes>& nodes) {
        std::copy(mesh_.edges[e].begin(), mesh_.edges[e].end(), nodes.begin());
      };
      return write_cards({kind.card, 1, 2, mesh_.edge_tags}, nodes_of);
    }
    if (kind.card == (middles_ == nullptr ? "CTRIA3" : "CTRIA6")) {
      return write_simplices(kind.card, mesh_.triangles, mesh_.triangle_tags, kTriangleEdges);
    }
    if (kind.role == Role::tetrahedron) return write_simplices(kind.card, mesh_.tets, mesh_.tet_tags, kTetEdges);
    if (kind.role != Role::other || !kind.is_written) return;
    for (const ElementBlock& block : mesh_.others) {
      if (block.kind != kind.block) continue;
      const std::span<const Pair> edges = middle_edges(mesh_, block, MiddleOrder::base_between_top);
      const bool is_quad8 = kind.card == "CQUAD4" && !edges.empty();
      write_cards(
          {is_quad8 ? "CQUAD8" : kind.card, kind.dimension(), kind.vertices + edges.size(), block.tags},
          [&](std::size_t e, std::array<Index, kMaxNodes>& nodes) { list_other(block, e, middles_, edges, nodes); });
    }
  }

  FileWriter& file_;
  const TetMesh& mesh_;
  const Middles* middles_;
  const IoContext& context_;
  backend::Cpu cpu_;
  std::vector<std::int64_t> node_numbers_;
  std::array<std::map<int, int>, 4> properties_;  ///< numbers by tag, for each dimension
  std::int64_t next_element_ = 1;
};

}  // namespace

void write_nastran(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  for (const ElementBlock& block : mesh.others) {
    const bool is_known = std::any_of(kNastranElementKinds.begin(), kNastranElementKinds.end(),
                                      [&block](const NastranElementKind& e) { return e.block == block.kind; });
    if (!is_known && block.kind != kPoints) throw FileError("Nastran has no elements of kind " + block.kind);
  }
  warn_of_losses_in_nastran(mesh, context);
  // Rods have no mid-side nodes.
  write_with_middles(mesh, MiddlesOf::all_but_edges, [&](const TetMesh& m, const Middles* middles) {
    if (const std::string text = lost_curved_edges(m, middles); !text.empty()) context.warn(text);
    NastranWriter(file, m, middles, context).write();
  });
}

}  // namespace tetune
