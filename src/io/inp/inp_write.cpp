// SPDX-License-Identifier: Apache-2.0
// Abaqus's and CalculiX's decks (.inp).
#include <algorithm>
#include <cstring>
#include <functional>

#include "io/inp/inp_follow.hpp"
#include "io/inp/inp_format.hpp"
#include "io/inp/inp_middles.hpp"
#include "io/losses.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class InpDeckWriter {
 public:
  InpDeckWriter(FileWriter& file, const InpModel& model, const TetMesh& mesh, const Middles* middles,
                const IoContext& context)
      : file_(file),
        model_(model),
        mesh_(mesh),
        middles_(middles),
        match_(match_inp(model, mesh)),
        changes_(follow_inp(model, mesh, match_, middles, context)),
        next_line_(model.conditions.size(), 0) {}

  void write() {
    for (const InpPiece& piece : model_.pieces) {
      if (piece.kind == InpPiece::Kind::text) out_ += piece.text;
      if (piece.kind == InpPiece::Kind::set) {
        write_card(piece, span_of(changes_.set_cards)[piece.card], span_of(model_.set_cards)[piece.card].head);
      }
      if (piece.kind == InpPiece::Kind::faces) {
        write_card(piece, span_of(changes_.face_cards)[piece.card], span_of(model_.face_cards)[piece.card].head);
      }
      if (piece.kind == InpPiece::Kind::condition) write_condition(piece);
      if (piece.kind == InpPiece::Kind::nodes) write_nodes(piece);
      if (piece.kind == InpPiece::Kind::tets) write_tets(piece);
      if (piece.kind == InpPiece::Kind::triangles) write_triangles(piece);
      flush(kBuffer);
    }
    flush(0);
  }

 private:
  static constexpr std::size_t kBuffer = std::size_t{1} << 20;

  void flush(std::size_t more_than) {
    if (out_.size() <= more_than) return;
    file_.write(out_);
    last_written_ = out_.back();
    out_.clear();
  }
  void end_line() {
    if ((out_.empty() ? last_written_ : out_.back()) != '\n') out_ += model_.newline;
  }

  /// Writes the text of a card, or a new one in the place of its first piece: others follow comments.
  void write_card(const InpPiece& piece, const std::optional<std::string>& text, std::string_view head) {
    if (!text) {
      out_ += piece.text;
    } else if (piece.text.data() == head.data()) {
      out_ += *text;
    }
  }

  /// Leaves out the lines of mid-side nodes whose edge is gone.
  void write_condition(const InpPiece& piece) {
    const std::vector<InpConditionLine>& lines = span_of(model_.conditions)[piece.card].lines;
    const char* from = piece.text.data();
    const char* const end = from + piece.text.size();
    // The pieces of a condition are written in the order of its lines.
    std::size_t& next = span_of(next_line_)[piece.card];
    for (; next < lines.size() && is_between(lines[next].text.data(), piece.text.data(), end); ++next) {
      const InpConditionLine& line = lines[next];
      if (line.node < 0 || span_of(match_.node2vertex)[line.node] >= 0) continue;
      out_ += text_of(from, line.text.data());
      from = std::find(line.text.data(), end, '\n');
      if (from != end) ++from;
    }
    out_ += text_of(from, end);
    const std::string& more = span_of(changes_.conditions)[piece.card];
    if (more.empty() || &piece != &span_of(model_.pieces)[span_of(model_.conditions)[piece.card].last_piece]) return;
    end_line();
    out_ += more;
  }

  void put_node(std::int64_t label, const Point3& p) {
    out_ += std::to_string(label);
    for (const double x : p) {
      out_ += ", ";
      append_inp_real(out_, x);
    }
    out_ += model_.newline;
  }
  void put_tet(Index t) {
    out_ += std::to_string(span_of(match_.tet_labels)[t]);
    for (const Index v : span_of(match_.listed)[t]) {
      out_ += ", ";
      out_ += std::to_string(span_of(match_.vertex_labels)[v]);
    }
    if (middles_ != nullptr) {
      for (const auto& [a, b] : kTetEdges) put_middle(span_of(match_.listed)[t], a, b);
    }
    out_ += model_.newline;
  }
  void put_triangle(Index i, bool has_middles) {
    const std::array<Index, 3>& triangle = span_of(mesh_.triangles)[i];
    out_ += std::to_string(span_of(match_.triangle_labels)[i]);
    for (const Index v : triangle) out_ += ", " + std::to_string(span_of(match_.vertex_labels)[v]);
    if (has_middles) {
      for (int k = 0; k < 3; ++k) put_middle(triangle, k, (k + 1) % 3);
    }
    out_ += model_.newline;
  }
  template <std::size_t N>
  void put_middle(const std::array<Index, N>& element, int a, int b) {
    const Index v = middles_->of(element[to_size_t(a)], element[to_size_t(b)]);
    out_ += ", " + std::to_string(span_of(match_.vertex_labels)[v]);
  }
  static bool is_between(const char* at, const char* first, const char* last) {
    return !std::less<>()(at, first) && std::less<>()(at, last);
  }
  /// The text of an entry of a piece, of which the next one starts at `next`.
  static std::string_view text_of(const char* line, const char* next) { return {line, to_size_t(next - line)}; }

  void write_nodes(const InpPiece& piece) {
    const char* const end = piece.text.data() + piece.text.size();
    for (Index i = piece.first; i < piece.last; ++i) {
      const Index v = span_of(match_.node2vertex)[i];
      if (v < 0) continue;
      const Point3& p = span_of(mesh_.points)[v];
      if (std::memcmp(&p, &span_of(model_.points)[i], sizeof p) != 0) {
        put_node(span_of(model_.node_labels)[i], p);
      } else {
        const char* const line = span_of(model_.node_lines)[i];
        out_ += text_of(line, i + 1 < piece.last ? span_of(model_.node_lines)[i + 1] : end);
      }
      flush(kBuffer);
    }
    if (piece.last < std::ssize(model_.node_labels) || match_.inserted.empty()) return;
    end_line();
    if (!changes_.appends_nodes) out_ += std::string("*NODE") + model_.newline;
    for (const Index v : match_.inserted) put_node(span_of(match_.vertex_labels)[v], span_of(mesh_.points)[v]);
    out_ += changes_.cards_after_nodes;
  }

  void write_tets(const InpPiece& piece) {
    const char* const end = piece.text.data() + piece.text.size();
    for (Index i = piece.first; i < piece.last; ++i) {
      const Index t = span_of(match_.old2tet)[i];
      if (t < 0) continue;
      if (span_of(match_.is_same)[i] == 0) {
        put_tet(t);
      } else {
        const char* const line = span_of(model_.tet_lines)[i];
        out_ += text_of(line, i + 1 < piece.last ? span_of(model_.tet_lines)[i + 1] : end);
      }
      flush(kBuffer);
    }
    const bool is_last = piece.last == std::ssize(model_.tets) || span_of(model_.tet2card)[piece.last] != piece.card;
    if (!is_last) return;
    if (!span_of(match_.added)[piece.card].empty()) end_line();
    for (const Index t : span_of(match_.added)[piece.card]) put_tet(t);
    out_ += span_of(changes_.cards_after_tets)[piece.card];
  }

  void write_triangles(const InpPiece& piece) {
    const char* const end = piece.text.data() + piece.text.size();
    const Span<const InpTriangle> triangles = span_of(model_.triangles);
    for (Index i = piece.first; i < piece.last; ++i) {
      const Index now = span_of(match_.old2triangle)[i];
      if (triangles[i].is_face && now < 0) continue;
      if (triangles[i].is_face && span_of(match_.is_same_triangle)[i] == 0) {
        put_triangle(now, triangles[i].has_middles);
      } else {
        out_ += text_of(triangles[i].line, i + 1 < piece.last ? triangles[i + 1].line : end);
      }
      flush(kBuffer);
    }
    const bool is_last = piece.last == triangles.size() || triangles[piece.last].card != piece.card;
    if (!is_last) return;
    const std::vector<Index>& added = span_of(match_.added_triangles)[piece.card];
    if (!added.empty()) end_line();
    for (const Index t : added) put_triangle(t, triangles[piece.first].has_middles);
    out_ += span_of(changes_.cards_after_triangles)[piece.card];
  }

  FileWriter& file_;
  const InpModel& model_;
  const TetMesh& mesh_;
  const Middles* middles_;
  InpMatch match_;
  InpChanges changes_;
  std::vector<std::size_t> next_line_;  ///< per condition, the first of its lines that is not written yet
  std::string out_;
  char last_written_ = '\n';  ///< for end_line(), after flush()
};

}  // namespace

std::string lost_deck(const TetMesh& mesh) {
  std::string text = "the format cannot hold the rest of the deck, such as materials, loads and steps";
  const std::size_t elements = mesh.deck->model().text_elements;
  if (elements > 0) text.append(", nor its elements of other types (").append(std::to_string(elements)).append(")");
  return text;
}

void write_inp(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  if (mesh.deck == nullptr) return write_inp_plain(file, mesh, context);
  const InpModel& model = mesh.deck->model();
  if (mesh.second_order != model.is_second_order) {
    throw FileError("the mesh and its deck have tetrahedra of different order; write another format");
  }
  warn_of_data(mesh, context);
  if (!mesh.second_order) return InpDeckWriter(file, model, mesh, nullptr, context).write();
  TetMesh with_middles = mesh;
  const Middles middles = add_inp_middles(model, with_middles);
  InpDeckWriter(file, model, with_middles, &middles, context).write();
}

}  // namespace tetune
