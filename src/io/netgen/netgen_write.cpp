// SPDX-License-Identifier: Apache-2.0
// Meshes of Netgen and NGSolve (.vol, .vol.gz), as Netgen's Mesh::Load() reads them.
#include <algorithm>
#include <map>
#include <set>

#include "io/element_blocks.hpp"
#include "io/group_order.hpp"
#include "io/gzip.hpp"
#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/netgen/netgen_format.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "mesh/listed_faces.hpp"
#include "mesh/whole_number.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The name of a group as the rest of a line has it, without the blanks around it.
std::string name_in_netgen(const Group& group) { return without_control_characters(trimmed(group.name)); }

/// The numbers of the tags of one dimension: from 1, as each up to the largest has a line with its name.
class NetgenNumbers {
 public:
  NetgenNumbers(const TetMesh& mesh, int dimension, const std::vector<int>& tags, const char* other_kind) {
    std::set<int> used(tags.begin(), tags.end());
    for (const ElementBlock& block : mesh.others) {
      if (block.kind == std::string_view(other_kind)) used.insert(block.tags.begin(), block.tags.end());
      for (const NetgenKind& kind : kNetgenKinds) {
        if (kind.kind == block.kind && dimension == (kind.section == NetgenSection::volume ? 3 : 2))
          used.insert(block.tags.begin(), block.tags.end());
      }
    }
    int next = 1;
    for (const int tag : used) {
      if (keeps(tag)) {
        numbers_[tag] = tag;
        continue;
      }
      while (used.contains(next) && keeps(next)) ++next;
      is_changed_ = true;
      numbers_[tag] = next++;
    }
    for (const auto& [tag, number] : numbers_)
      names_.resize(std::max(names_.size(), to_size_t(number)), kNetgenUnnamed);
    for (const Group* const group : specific_first(mesh, dimension)) {
      if (!name_in_netgen(*group).empty()) add_name(*group);
    }
  }
  int of(int tag) const { return numbers_.at(tag); }
  const std::vector<std::string>& names() const { return names_; }
  /// Whether a tag has another number.
  bool is_changed() const { return is_changed_; }
  /// Whether a tag has several names, of which one is kept.
  bool is_shared() const { return is_shared_; }

 private:
  static constexpr int kMaxNumber = 9999;
  static bool keeps(int tag) { return tag >= 1 && tag <= kMaxNumber; }
  void add_name(const Group& group) {
    for (const int tag : group.tags) {
      const auto number = numbers_.find(tag);
      if (number == numbers_.end()) continue;
      std::string& name = names_[to_size_t(number->second - 1)];
      if (name != kNetgenUnnamed)
        is_shared_ = true;
      else
        name = name_in_netgen(group);
    }
  }
  std::map<int, int> numbers_;
  std::vector<std::string> names_;
  bool is_changed_ = false, is_shared_ = false;
};

/// The regions behind a surface element and in front of it, seen against its normal; 0: none.
using Sides = std::array<int, 2>;

/// Finds the regions on both sides of listed triangles and quadrilaterals.
class NetgenSides {
 public:
  NetgenSides(const TetMesh& mesh, const std::vector<std::array<Index, 4>>& faces, const NetgenNumbers& regions)
      : mesh_(mesh), faces_(faces), listed_(numbered(faces), mesh.points.size()), sides_(faces.size()) {
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const auto& tet = mesh.tets[t];
      for (int f = 0; f < 4; ++f) {
        const auto v = [&](int k) { return tet[to_size_t(face_vertex(f, k))]; };
        add({v(0), v(1), v(2), -1}, regions.of(mesh.tet_tags[t]), {});
      }
    }
    for (const ElementBlock& block : mesh.others) add_others(block, regions);
  }
  Sides of(std::size_t face) const { return sides_[face]; }

 private:
  using Face = std::array<Index, 4>;
  static std::vector<std::pair<Face, Index>> numbered(const std::vector<Face>& faces) {
    std::vector<std::pair<Face, Index>> list;
    for (const Face& face : faces) list.emplace_back(face, to_index(list.size()));
    return list;
  }
  void add_others(const ElementBlock& block, const NetgenNumbers& regions) {
    static const std::map<std::string, std::vector<Face>> faces_of{
        {"Pyramids", {{0, 1, 2, 3}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}},
        {"Prisms", {{0, 1, 2, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
        {"Hexahedra", {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}};
    const auto faces = faces_of.find(block.kind);
    if (faces == faces_of.end()) return;
    const std::size_t each = to_size_t(block.vertices_per_element);
    for (std::size_t i = 0; i < block.tags.size(); ++i) {
      const std::vector<Index> solid(block.element2vertex.begin() + std::ptrdiff_t(i * each),
                                     block.element2vertex.begin() + std::ptrdiff_t((i + 1) * each));
      for (Face face : faces->second) {
        for (Index& v : face) v = v < 0 ? -1 : span_of(solid)[v];
        add(face, regions.of(block.tags[i]), solid);
      }
    }
  }
  /// Adds the region of a solid to a listed face. The faces of tetrahedra, without `solid`, are oriented outwards.
  void add(const Face& face, int region, const std::vector<Index>& solid) {
    listed_.find(face, [&](Index listed) {
      const Face& seen = span_of(faces_)[listed];
      const bool is_behind = solid.empty() ? same_turn(seen, face) : is_below(seen, solid);
      span_of(sides_)[listed][is_behind ? 0 : 1] = region;
    });
  }
  static bool same_turn(const Face& a, const Face& b) {
    const auto at = std::find(b.begin(), b.end(), a[0]) - b.begin();
    return b[to_size_t((at + 1) % 3)] == a[1];
  }
  /// Whether the center of a solid is behind the first three vertices of a face.
  bool is_below(const Face& face, const std::vector<Index>& solid) const {
    const auto minus = [this](Index a, Index b) {
      const Point3& p = span_of(mesh_.points)[a];
      const Point3& q = span_of(mesh_.points)[b];
      return Point3{p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    };
    const Point3 u = minus(face[1], face[0]);
    const Point3 w = minus(face[2], face[0]);
    const Point3 normal{u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    double height = 0;
    for (const Index v : solid) {
      const Point3 d = minus(v, face[0]);
      height += d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
    }
    return height < 0;
  }
  const TetMesh& mesh_;
  const std::vector<Face>& faces_;
  const ListedFaces<4> listed_;
  std::vector<Sides> sides_;
};

class NetgenWriter {
 public:
  NetgenWriter(LineWriter& out, const TetMesh& mesh, const Middles* middles)
      : out_(out), mesh_(mesh), middles_(middles) {}

  void write(const IoContext& context) {
    out_.text("mesh3d\ndimension\n3\ngeomtype\n0\n\n");
    write_surface();
    write_solids();
    write_edges();
    section("points", mesh_.points.size());
    out_.lines(mesh_.points.size(), [this](auto& entry, std::size_t v) {
      for (const double x : mesh_.points[v]) entry.real(x);
    });
    write_point_elements();
    write_names("materials", regions_);
    write_names("bcnames", patches_);
    write_names("cd2names", lines_);
    write_names("cd3names", points_);
    write_identifications();
    out_.text("\nendmesh\n");
    const auto all = {&regions_, &patches_, &lines_, &points_};
    if (std::any_of(all.begin(), all.end(), [](const NetgenNumbers* n) { return n->is_changed(); })) {
      context.warn("tags that are not from 1 to 9999, 0 included, have other numbers");
    }
    if (std::any_of(all.begin(), all.end(), [](const NetgenNumbers* n) { return n->is_shared(); })) {
      warn_of_shared_names(context);
    }
  }

 private:
  void section(const char* name, std::size_t n) {
    out_.text(std::string("\n").append(name).append("\n").append(std::to_string(n)).append("\n"));
  }
  const ElementBlock* block_of(std::string_view kind) const {
    const auto at = std::find_if(others_.begin(), others_.end(), [kind](const auto& b) { return b.kind == kind; });
    return at == others_.end() ? nullptr : &*at;
  }
  /// Writes an element with its nodes in the order of Netgen.
  template <std::size_t n, std::size_t m, class Order>
  void put(LineWriter::Entry& entry, const std::array<Index, n>& v, const Order& order,
           const std::array<Pair, m>& edges) {
    const bool second = middles_ != nullptr && middles_->has(v);
    std::array<Index, n + m> nodes{};
    for (std::size_t k = 0; k < n; ++k) nodes[to_size_t(order[k])] = v[k];
    for (std::size_t e = 0; second && e < m; ++e) {
      nodes[to_size_t(order[n + e])] = middles_->of(v[to_size_t(edges[e][0])], v[to_size_t(edges[e][1])]);
    }
    const std::size_t count = second ? n + m : n;
    entry.integer(count);
    for (std::size_t k = 0; k < count; ++k) entry.integer(nodes[k] + 1);
  }

  /// The numbers of faces of the geometry per triangle, 0 for none; empty without data. Some formats make them doubles.
  std::vector<int> surface_numbers() const {
    std::vector<int> numbers;
    for (const DataArray& array : mesh_.triangle_data) {
      if (array.name != kNetgenSurface || array.components != 1) continue;
      numbers.clear();
      const auto add = [&numbers](const auto& values) {
        for (const auto value : values) numbers.push_back(whole_number(double(value)).value_or(0));
      };
      std::visit(add, array.values);
    }
    return numbers;
  }

  void write_surface() {
    std::vector<std::array<Index, 4>> faces;
    for (const auto& [a, b, c] : mesh_.triangles) faces.push_back({a, b, c, -1});
    const ElementBlock* const quads = block_of(kNetgenKinds[0].kind);
    const std::size_t quad_count = quads == nullptr ? 0 : quads->tags.size();
    for (std::size_t i = 0; i < quad_count; ++i) {
      const Index* const v = quads->element2vertex.data() + 4 * i;
      faces.push_back({v[0], v[1], v[2], v[3]});
    }
    const NetgenSides sides(mesh_, faces, regions_);
    const std::vector<int> surfaces = surface_numbers();
    section("surfaceelements", faces.size());
    const auto head = [&](auto& entry, std::size_t face, int surface, int number) {
      entry.integer(surface);
      entry.integer(number);
      for (const int region : sides.of(face)) entry.integer(region);
    };
    out_.lines(mesh_.triangles.size(), [&](auto& entry, std::size_t i) {
      const int number = patches_.of(mesh_.triangle_tags[i]);
      head(entry, i, !surfaces.empty() && surfaces[i] > 0 ? surfaces[i] : number, number);
      put(entry, mesh_.triangles[i], kNetgenTriangle, kTriangleEdges);
    });
    out_.lines(quad_count, [&](auto& entry, std::size_t i) {
      const std::size_t face = mesh_.triangles.size() + i;
      head(entry, face, patches_.of(quads->tags[i]), patches_.of(quads->tags[i]));
      entry.integer(4);
      for (const Index v : faces[face]) entry.integer(v + 1);
    });
  }

  void write_solids() {
    std::size_t n = mesh_.tets.size();
    for (const NetgenKind& kind : kNetgenKinds) {
      if (kind.section == NetgenSection::volume && block_of(kind.kind) != nullptr)
        n += block_of(kind.kind)->tags.size();
    }
    section("volumeelements", n);
    out_.lines(mesh_.tets.size(), [this](auto& entry, std::size_t t) {
      entry.integer(regions_.of(mesh_.tet_tags[t]));
      put(entry, mesh_.tets[t], kNetgenTet, kTetEdges);
    });
    for (const NetgenKind& kind : kNetgenKinds) {
      const ElementBlock* const block = block_of(kind.kind);
      if (kind.section != NetgenSection::volume || block == nullptr) continue;
      out_.lines(block->tags.size(), [&](auto& entry, std::size_t i) {
        entry.integer(regions_.of(block->tags[i]));
        const std::size_t each = to_size_t(kind.vertices);
        entry.integer(each);
        for (std::size_t k = 0; k < each; ++k) {
          entry.integer(block->element2vertex[each * i + to_size_t(kind.order[k])] + 1);
        }
      });
    }
  }

  void write_edges() {
    section("edgesegmentsgi2", mesh_.edges.size());
    out_.lines(mesh_.edges.size(), [this](auto& entry, std::size_t i) {
      const int number = lines_.of(mesh_.edge_tags[i]);
      const auto& [a, b] = mesh_.edges[i];
      // The surface or edge, 0, both points, their triangles in the geometry, the surfaces, twice the edge and the
      // parameter on it.
      for (const Index value : {number, 0, a + 1, b + 1, -1, -1, 0, 0, number, 0, number, 0}) entry.integer(value);
    });
  }

  void write_point_elements() {
    const ElementBlock* const block = block_of(kPoints);
    section("pointelements", block == nullptr ? 0 : block->tags.size());
    if (block == nullptr) return;
    out_.lines(block->tags.size(), [&](auto& entry, std::size_t i) {
      entry.integer(block->element2vertex[i] + 1);
      entry.integer(points_.of(block->tags[i]));
    });
  }

  void write_names(const char* name, const NetgenNumbers& numbers) {
    if (numbers.names().empty()) return;
    section(name, numbers.names().size());
    int number = 0;
    for (const std::string& text : numbers.names()) out_.text(std::to_string(++number) + " " + text + "\n");
  }

  void write_identifications() {
    std::vector<std::array<Index, 3>> lines;
    Index number = 0;
    for (PeriodicLink link : mesh_.periodic) {
      if (link.dimension != 2) continue;  // its pairs are those of faces too
      ++number;
      if (middles_ != nullptr) middles_->extend(link);
      for (const auto& [image, master] : link.pairs) lines.push_back({master + 1, image + 1, number});
    }
    if (lines.empty()) return;
    section("identifications", lines.size());
    out_.lines(lines.size(), [&lines](auto& entry, std::size_t i) {
      for (const Index value : lines[i]) entry.integer(value);
    });
    section("identificationtypes", to_size_t(number));
    out_.lines(to_size_t(number), [](auto& entry, std::size_t) { entry.integer(kNetgenPeriodic); });
  }

  LineWriter& out_;
  const TetMesh& mesh_;
  const Middles* middles_;  ///< of elements of second order
  std::vector<ElementBlock> joined_;
  const std::vector<ElementBlock>& others_ = blocks_by_kind(mesh_, joined_);
  const NetgenNumbers regions_{mesh_, 3, mesh_.tet_tags, ""};
  const NetgenNumbers patches_{mesh_, 2, mesh_.triangle_tags, ""};
  const NetgenNumbers lines_{mesh_, 1, mesh_.edge_tags, ""};
  const NetgenNumbers points_{mesh_, 0, {}, kPoints};
};

void warn_of_netgen_losses(const TetMesh& mesh, const IoContext& context) {
  warn_of_point_tags(mesh, context);
  warn_of_lists(mesh, context);
  warn_of_data(mesh, context, kNetgenSurface);
  warn_of_empty_groups(mesh, context);
  RenamedGroups renamed;
  for (const Group& group : mesh.groups) renamed.add(group.name, name_in_netgen(group));
  renamed.warn(context);
  const auto is_default = [](const Group& group) { return name_in_netgen(group) == kNetgenUnnamed; };
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), is_default)) {
    context.warn(std::string("the group \"") + kNetgenUnnamed +
                 "\" loses its name, which stands for elements without one in the format");
  }
  if (mesh.triangles.empty()) context.warn("the mesh lists no triangles: Netgen needs them on the whole boundary");
}

void refuse_second_order_others(const TetMesh& mesh) {
  for (const ElementBlock& block : mesh.others) {
    if (!has_middles(mesh, block)) continue;
    throw FileError(block.kind + " with mid-side nodes are not written to Netgen's files; write another format, or " +
                    "elements of first order");
  }
}

void write_mesh_to(LineWriter out, const TetMesh& mesh, const IoContext& context) {
  refuse_second_order_others(mesh);
  warn_of_netgen_losses(mesh, context);
  // The edges of the format have no mid-side nodes.
  write_with_middles(mesh, MiddlesOf::all_but_edges, [&](const TetMesh& m, const Middles* middles) {
    if (const std::string text = lost_curved_edges(m, middles); !text.empty()) context.warn(text);
    NetgenWriter(out, m, middles).write(context);
  });
}

}  // namespace

void write_netgen(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  write_mesh_to({file, context.threads}, mesh, context);
}

void write_netgen_compressed(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  GzipWriter gzip(file);
  write_mesh_to({[&gzip](std::string_view text) { gzip.write(text); }, context.threads}, mesh, context);
  gzip.finish();
}

}  // namespace tetune
