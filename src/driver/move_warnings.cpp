// SPDX-License-Identifier: Apache-2.0
#include "driver/move_warnings.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "backend/span.hpp"
#include "math/orient.hpp"
#include "mesh/messages.hpp"

namespace tetune {
namespace {

/// A corner of an element and the ends of its edges there, by their positions among the vertices of the element, in
/// the order in which they span a positive volume.
using ElementCorner = std::array<std::uint8_t, 4>;

/// The element is degenerate at the apex of a pyramid.
constexpr std::array<ElementCorner, 4> kPyramidCorners{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<ElementCorner, 6> kPrismCorners{
    {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5}, {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}}};
constexpr std::array<ElementCorner, 8> kHexCorners{
    {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}}};

/// Empty for kinds that are no solids.
std::span<const ElementCorner> corners_of(const ElementBlock& block) {
  const auto has = [&block](std::string_view kind, int vertices) {
    return block.kind == kind && block.vertices_per_element == vertices;
  };
  if (has("Pyramids", 5)) return kPyramidCorners;
  if (has("Prisms", 6)) return kPrismCorners;
  if (has("Hexahedra", 8)) return kHexCorners;
  return {};
}

/// The sign of det(p1-p0, p2-p0, p3-p0).
int sign_of_volume(const Point3& p0, const Point3& p1, const Point3& p2, const Point3& p3) {
  const Orient o = orient(vec(p0), vec(p1), vec(p2), vec(p3));
  if (o.certified()) return 1;
  return is_certified(-o.det, o.bound) ? -1 : orient_sign(p0, p1, p2, p3);
}

/// The sign of the Jacobian determinant at all corners of an element; 0 where these differ or one is 0.
std::int8_t sign_of(const TetMesh& mesh, const ElementBlock& block, Index element) {
  const Span<const Point3> points = span_of(mesh.points);
  const Index* const vertices = block.element2vertex.data() + Size{element} * block.vertices_per_element;
  int common = 0;
  for (const auto& [corner, a, b, c] : corners_of(block)) {
    const int sign =
        sign_of_volume(points[vertices[corner]], points[vertices[a]], points[vertices[b]], points[vertices[c]]);
    if (sign == 0 || (common != 0 && sign != common)) return 0;
    common = sign;
  }
  return static_cast<std::int8_t>(common);
}

/// Removes the elements that have the same sign at all corners as before.
void keep_inverted(const TetMesh& result, InvertedOthers& others, const std::vector<std::int8_t>& signs) {
  const ElementBlock& block = result.others[others.block];
  std::size_t kept = 0;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const Index element = others.elements[i];
    if (sign_of(result, block, element) != signs[i]) others.elements[kept++] = element;
  }
  others.elements.resize(kept);
}

/// Appends the sentence on inverted elements.
void append_text(const InvertedOthers& inverted, bool one_based, std::string& text) {
  text += "the motion inverted ";
  text += std::to_string(inverted.elements.size());
  text += " of the ";
  text += inverted.kind;
  append_first_ids(inverted.elements, one_based, text);
  text += ": their vertices go where the targets say, and only the volumes of tetrahedra are kept positive";
}

/// An upper bound on the length of a warning.
constexpr std::size_t kMaxText = 400;

}  // namespace

std::vector<std::string> MoveReport::warnings(bool one_based) const {
  std::vector<std::string> texts;
  if (frozen_moved > 0) texts.push_back(frozen_text(frozen_moved));
  for (const InvertedOthers& inverted : inverted_others) append_text(inverted, one_based, texts.emplace_back());
  return texts;
}

std::string frozen_text(std::int64_t frozen_moved) {
  return "targets move " + std::to_string(frozen_moved) +
         " frozen vertices: a vertex with a target goes there, frozen or not; give it none, and it stays";
}

std::int64_t count_frozen_moved(const TetMesh& mesh, const Options& options, const std::vector<std::uint8_t>& moves) {
  std::vector<std::uint8_t> frozen(mesh.points.size(), 0);
  const auto add = [&frozen](const auto& elements, const std::vector<int>& tags, const std::vector<int>& frozen_tags) {
    for (Size i = 0; i < std::ssize(tags) && !frozen_tags.empty(); ++i) {
      if (std::find(frozen_tags.begin(), frozen_tags.end(), span_of(tags)[i]) == frozen_tags.end()) continue;
      for (const Index v : span_of(elements)[i]) span_of(frozen)[v] = 1;
    }
  };
  add(mesh.tets, mesh.tet_tags, options.frozen_regions);
  add(mesh.triangles, mesh.triangle_tags, options.frozen_patches);
  std::int64_t count = 0;
  for (Size v = 0; v < std::ssize(frozen); ++v) {
    const bool is_frozen = span_of(frozen)[v] != 0 ||
                           (v < std::ssize(options.frozen_vertices) && span_of(options.frozen_vertices)[v] != 0);
    if (is_frozen && span_of(moves)[v] != 0) ++count;
  }
  return count;
}

MoveWarnings::MoveWarnings(const TetMesh& mesh, const Options& options, const std::vector<std::uint8_t>& moves)
    : frozen_moved_(count_frozen_moved(mesh, options, moves)) {
  if (frozen_moved_ > 0) frozen_text_ = frozen_text(frozen_moved_);
  for (std::size_t block = 0; block < mesh.others.size(); ++block) {
    const ElementBlock& others = mesh.others[block];
    if (corners_of(others).empty()) continue;
    InvertedOthers movable{others.kind, block, {}};
    std::vector<std::int8_t> signs;
    const auto each = to_size_t(others.vertices_per_element);
    for (std::size_t first = 0; first + each <= others.element2vertex.size(); first += each) {
      const auto vertices = std::span(others.element2vertex).subspan(first, each);
      if (std::none_of(vertices.begin(), vertices.end(), [&](Index v) { return span_of(moves)[v] != 0; })) continue;
      const Index element = to_index(first / each);
      const std::int8_t sign = sign_of(mesh, others, element);
      if (sign == 0) continue;
      movable.elements.push_back(element);
      signs.push_back(sign);
    }
    if (movable.elements.empty()) continue;
    others_.push_back(std::move(movable));
    signs_.push_back(std::move(signs));
    texts_.emplace_back().reserve(kMaxText);
  }
}

void MoveWarnings::add_to(const TetMesh& result, MoveReport& report) {
  std::vector<std::string>& warnings = report.optimization.warnings;
  report.frozen_moved = frozen_moved_;
  if (frozen_moved_ > 0) warnings.push_back(std::move(frozen_text_));
  for (std::size_t i = 0; i < others_.size(); ++i) {
    keep_inverted(result, others_[i], signs_[i]);
    if (others_[i].elements.empty()) continue;
    append_text(others_[i], false, texts_[i]);
    warnings.push_back(std::move(texts_[i]));
  }
  std::erase_if(others_, [](const InvertedOthers& inverted) { return inverted.elements.empty(); });
  report.inverted_others.swap(others_);
}

}  // namespace tetune
