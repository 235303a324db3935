// SPDX-License-Identifier: Apache-2.0
// Decks (.inp) of meshes that were read from other formats: nodes, elements, sets and surfaces by tag.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "io/inp/inp_deck.hpp"
#include "io/inp/inp_format.hpp"
#include "io/losses.hpp"
#include "io/second_order.hpp"
#include "mesh/listed_faces.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// A kind of ElementBlock and the types with which its elements are written.
struct InpWrittenKind {
  const char* kind;
  const char* type;
  const char* second_order_type;  ///< null: neither program has one
  int dimension;
};
constexpr std::array<InpWrittenKind, 4> kInpKinds{{{"Pyramids", "C3D5", nullptr, 3},
                                                   {"Prisms", "C3D6", "C3D15", 3},
                                                   {"Hexahedra", "C3D8", "C3D20", 3},
                                                   {"Quadrilaterals", "S4", "S8R", 2}}};

/// A face of a tetrahedron in a patch.
struct PatchFace {
  Index tet;
  int face;
};

void warn_of_losses_in_inp(const TetMesh& mesh, const IoContext& context) {
  warn_of_data(mesh, context);
  warn_of_point_tags(mesh, context);
  if (!mesh.edges.empty()) {
    context.warn(std::to_string(mesh.edges.size()) + " edges are not written: in a deck they would be elements");
  }
  warn_of_lists(mesh, context);
  warn_of_empty_groups(mesh, context);
}

class InpPlainWriter {
 public:
  InpPlainWriter(FileWriter& file, const TetMesh& mesh, const Middles* middles, const IoContext& context)
      : out_(file), mesh_(mesh), middles_(middles), context_(context) {}

  void write() {
    warn_of_losses_in_inp(mesh_, context_);
    out_.write("*HEADING\ntetune\n*NODE, NSET=Nall\n");
    std::size_t shortened = 0;
    write_lines(mesh_.points.size(), [&](std::string& line, std::size_t v) {
      line += std::to_string(v + 1);
      for (const double x : mesh_.points[v]) {
        if (!append_inp_real(line += ", ", x)) ++shortened;
      }
    });
    if (shortened > 0) {
      context_.warn(std::to_string(shortened) +
                    " coordinates are rounded, as both programs read at most 20 characters of a number");
    }
    write_tets();
    for (const ElementBlock& block : mesh_.others) write_block(block);
    find_patches();
    for (const auto& [tag, faces] : patches_) write_patch("Surface" + std::to_string(tag), {tag});
    for (const Group& group : mesh_.groups) write_group(group);
    renamed_.warn(context_);
  }

 private:
  /// Writes n lines; put(line, i) appends one of them.
  template <class Put>
  void write_lines(std::size_t n, const Put& put) {
    constexpr std::size_t kBuffer = std::size_t{1} << 20;
    std::string lines;
    for (std::size_t i = 0; i < n; ++i) {
      put(lines, i);
      lines += '\n';
      if (lines.size() < kBuffer && i + 1 < n) continue;
      out_.write(lines);
      lines.clear();
    }
  }
  static std::map<int, std::vector<std::size_t>> by_tag(const std::vector<int>& tags) {
    std::map<int, std::vector<std::size_t>> lists;
    for (std::size_t i = 0; i < tags.size(); ++i) lists[tags[i]].push_back(i);
    return lists;
  }
  void start_elements(const char* type, int dimension, int tag) {
    std::string head = std::string("*ELEMENT, TYPE=") + type;
    if (tag != 0) {
      head += ", ELSET=" + start_of(dimension) + std::to_string(tag);
      element_tags_.insert({dimension, tag});
    }
    out_.write(head + "\n");
  }

  std::array<Index, 4> listed(std::size_t t) const {
    std::array<Index, 4> v = mesh_.tets[t];
    if (mesh_.listed_inside_out) std::swap(v[2], v[3]);
    return v;
  }
  void write_tets() {
    for (const auto& [tag, tets] : by_tag(mesh_.tet_tags)) {
      start_elements(middles_ == nullptr ? "C3D4" : "C3D10", 3, tag);
      write_lines(tets.size(), [&, &list = tets](std::string& line, std::size_t i) {
        line += std::to_string(list[i] + 1);
        const std::array<Index, 4> v = listed(list[i]);
        for (const Index u : v) line.append(", ").append(std::to_string(u + 1));
        if (middles_ == nullptr) return;
        for (const auto& [a, b] : kTetEdges) {
          line.append(", ").append(std::to_string(middles_->of(v[to_size_t(a)], v[to_size_t(b)]) + 1));
        }
      });
    }
    next_element_ = mesh_.tets.size() + 1;
  }
  void write_block(const ElementBlock& block) {
    if (block.kind == kPoints) return context_.warn("elements of one vertex are not written");
    const auto kind = std::find_if(kInpKinds.begin(), kInpKinds.end(),
                                   [&block](const InpWrittenKind& k) { return block.kind == k.kind; });
    if (kind == kInpKinds.end()) throw FileError("a deck has no type for elements of kind " + block.kind);
    const std::span<const Pair> edges = middle_edges(mesh_, block, MiddleOrder::base_top_between);
    const char* const type = edges.empty() ? kind->type : kind->second_order_type;
    if (type == nullptr) {
      throw FileError("neither Abaqus nor CalculiX has " + block.kind +
                      " with mid-side nodes; write another format, or elements of first order");
    }
    const std::size_t each = to_size_t(block.vertices_per_element) + edges.size();
    for (const auto& [tag, elements] : by_tag(block.tags)) {
      start_elements(type, kind->dimension, tag);
      write_lines(elements.size(), [&, &list = elements](std::string& line, std::size_t i) {
        constexpr std::size_t kPerLine = 16;  // as both programs read at most
        line += std::to_string(next_element_ + list[i]);
        std::array<Index, kMaxNodes> nodes{};
        list_other(block, list[i], middles_, edges, nodes);
        for (std::size_t k = 0; k < each; ++k) {
          line.append((k + 1) % kPerLine == 0 ? ",\n" : ", ").append(std::to_string(nodes[k] + 1));
        }
      });
    }
    next_element_ += block.tags.size();
  }

  // Patches: the listed triangles with a tag that are faces of tetrahedra.

  void find_patches() {
    const std::int64_t untagged = std::count(mesh_.triangle_tags.begin(), mesh_.triangle_tags.end(), 0);
    if (untagged > 0) context_.warn(std::to_string(untagged) + " triangles without a tag are not written");
    std::vector<std::pair<std::array<Index, 3>, Index>> tagged;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (mesh_.triangle_tags[i] != 0) tagged.emplace_back(mesh_.triangles[i], to_index(i));
    }
    if (tagged.empty()) return;
    const ListedFaces<3> triangles(std::move(tagged), mesh_.points.size());
    std::vector<std::uint8_t> is_written(mesh_.triangles.size(), 0);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      triangles.find_in_tet(listed(t), [&](std::size_t k, Index triangle) {
        if (std::exchange(span_of(is_written)[triangle], 1) != 0) return;  // by the tetrahedron on the other side
        patches_[span_of(mesh_.triangle_tags)[triangle]].push_back({to_index(t), kInpFaceOpposite[k]});
      });
    }
    const auto missing = std::ssize(is_written) - std::count(is_written.begin(), is_written.end(), 1) - untagged;
    if (missing > 0) {
      context_.warn(std::to_string(missing) + " triangles are not written, as they are no faces of tetrahedra");
    }
  }

  /// The vertices of a face, with the middles of its edges.
  void add_vertices(const PatchFace& f, std::vector<std::int64_t>& labels) const {
    const std::array<Index, 4> v = listed(to_size_t(f.tet));
    std::vector<Index> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      if (int(k) != kInpOppositeFace[to_size_t(f.face)]) corners.push_back(v[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      labels.push_back(corners[k] + 1);
      if (middles_ != nullptr) labels.push_back(middles_->of(corners[k], corners[(k + 1) % 3]) + 1);
    }
  }
  /// Writes the patches of some tags as a surface and as a set of nodes of one name.
  void write_patch(const std::string& name, const std::vector<int>& tags) {
    std::vector<std::int64_t> labels;
    std::string text = "*SURFACE, TYPE=ELEMENT, NAME=" + name + "\n";
    for (const int tag : tags) {
      const auto found = patches_.find(tag);
      if (found == patches_.end()) continue;
      for (const PatchFace& f : found->second) {
        text += std::to_string(f.tet + 1) + ", S" + std::to_string(f.face) + "\n";
        add_vertices(f, labels);
      }
    }
    if (labels.empty()) return;
    sort_unique(labels);
    text += "*NSET, NSET=" + name + "\n";
    append_inp_labels(text, labels, "\n");
    out_.write(text);
  }

  void write_group(const Group& group) {
    if (group.dimension < 2 || group.name.empty()) return;
    std::vector<int> of_elements;
    std::vector<int> of_patches;
    for (const int tag : group.tags) {
      if (element_tags_.count({group.dimension, tag}) > 0) of_elements.push_back(tag);
      if (group.dimension == 2 && patches_.count(tag) > 0) of_patches.push_back(tag);
    }
    const bool is_empty = of_elements.empty() && of_patches.empty();
    const std::optional<std::string> name = is_empty ? std::nullopt : free_name(group);
    if (!name) return;
    write_patch(*name, of_patches);
    if (of_elements.empty()) return;
    std::string text = "*ELSET, ELSET=" + *name + "\n";
    for (const int tag : of_elements) text += start_of(group.dimension) + std::to_string(tag) + ",\n";
    out_.write(text);
  }
  /// Names of the sets of tags begin with this.
  static std::string start_of(int dimension) { return dimension == 3 ? "Volume" : "Surface"; }
  /// The name of a group as both programs read it; none where the set of its tag has this name.
  std::optional<std::string> free_name(const Group& group) {
    constexpr std::size_t kMaxLength = 80;
    std::string name = group.name.substr(0, kMaxLength - 4);
    const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
    const auto is_plain = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
    std::replace_if(
        name.begin(), name.end(), [&](char c) { return !is_plain(c); }, '_');
    if (!is_letter(name[0]) && name[0] != '_') name.insert(name.begin(), '_');
    const std::string start = start_of(group.dimension);
    if (group.tags.size() == 1 && inp_name(name) == inp_name(start + std::to_string(group.tags[0]))) return {};
    const std::string base = name;
    for (int n = 2; is_tag_name(name, start) || !names_.insert({group.dimension, inp_name(name)}).second; ++n) {
      name = base + "_" + std::to_string(n);
    }
    renamed_.add(group.name, name);
    return name;
  }
  static bool is_tag_name(const std::string& name, const std::string& start) {
    const std::string key = inp_name(name);
    std::int64_t value = 0;
    return key.starts_with(inp_name(start)) && parse_inp_integer(key.substr(start.size()), value);
  }

  FileWriter& out_;
  const TetMesh& mesh_;
  const Middles* middles_;
  const IoContext& context_;
  std::size_t next_element_ = 1;
  std::map<int, std::vector<PatchFace>> patches_;
  std::set<std::pair<int, int>> element_tags_;   ///< of elements, by dimension: faces of tetrahedra are none
  std::set<std::pair<int, std::string>> names_;  ///< by dimension
  RenamedGroups renamed_;
};

}  // namespace

void write_inp_plain(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  // Edges and triangles of no tetrahedron are not written; their nodes would be of no element.
  write_with_middles(mesh, MiddlesOf::tets_and_others, [&](const TetMesh& m, const Middles* middles) {
    InpPlainWriter(file, m, middles, context).write();
  });
}

}  // namespace tetune
