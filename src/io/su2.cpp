// SPDX-License-Identifier: Apache-2.0
// SU2's native meshes (.su2): the SU2 documentation, "Mesh File".
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include "backend/span.hpp"
#include "io/checked_count.hpp"
#include "io/element_blocks.hpp"
#include "io/group_order.hpp"
#include "io/line_writer.hpp"
#include "io/losses.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "io/text_cursor.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr int kTriangle = 5;
constexpr int kTetrahedron = 10;

/// The list of a file that an element is in: the solids, or a marker of the boundary.
enum class Su2List : std::uint8_t { solids, marker };

/// A kind of ElementBlock and its type in VTK, whose order of vertices SU2 has.
struct Su2Kind {
  int type;
  const char* kind;
  int vertices;
  Su2List list;
};
constexpr std::array<Su2Kind, 4> kSu2Kinds{{{9, "Quadrilaterals", 4, Su2List::marker},
                                            {12, "Hexahedra", 8, Su2List::solids},
                                            {13, "Prisms", 6, Su2List::solids},
                                            {14, "Pyramids", 5, Su2List::solids}}};

class Su2Reader {
 public:
  Su2Reader(const std::string& path, std::string_view text, const IoContext& context)
      : cursor_(path, text), path_(path), context_(context) {}

  TetMesh read() {
    while (!at_end()) read_section();
    if (!has_points_ || !has_elements_) {
      cursor_.fail(std::string("the file has no ") + (has_points_ ? "NELEM=" : "NPOIN=") + " section");
    }
    mesh_.tet_tags.assign(mesh_.tets.size(), 0);
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    if (marker_ < markers_) {
      context_.warn(path_ + ": " + std::to_string(marker_) + " of " + std::to_string(markers_) +
                    " markers (NMARK=) are there; the file may be cut short");
    }
    for (const std::string& name : skipped_) context_.warn(path_ + ": the section " + name + " is not kept");
    return std::move(mesh_);
  }

 private:
  /// Skips comments, and returns whether nothing follows.
  bool at_end() {
    while (cursor_.peek().starts_with('%')) cursor_.line();
    return cursor_.at_end();
  }
  std::int64_t integer(const char* name) {
    at_end();
    return cursor_.integer(name);
  }

  /// Reads "NAME= value", with or without blanks around the sign; the cursor is then before the value.
  std::string keyword() {
    const char* const all = cursor_.skip(0);
    const std::string_view line = cursor_.line();
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
      cursor_.skip(all - cursor_.skip(0));
      cursor_.fail("expected a section such as NELEM=, found \"" + printable(line.substr(0, 40)) +
                   "\"; the section before it is longer than it says");
    }
    cursor_.skip(line.data() + equals + 1 - cursor_.skip(0));
    std::string name(all, to_size_t(line.data() + equals - all));
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    name.erase(std::remove_if(name.begin(), name.end(), is_blank), name.end());
    return name;
  }

  /// The rest of the line without a comment and the blanks around it: a name may hold '#'.
  std::string rest_of_line() {
    const std::string_view line = cursor_.line();
    std::string text(line.substr(0, line.find('%')));
    const auto begin = text.find_first_not_of(" \t");
    return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
  }

  void read_section() {
    const std::string name = keyword();
    if (name == "NDIME") {
      if (cursor_.integer("dimension") != 3) cursor_.fail("the dimension must be 3");
    } else if (name == "NZONE") {
      if (cursor_.integer("number of zones") != 1) cursor_.fail("the file has several zones; write each to a file");
    } else if (name == "NELEM") {
      if (has_elements_) cursor_.fail("a second NELEM= section");
      read_elements(count("number of elements", 5), Su2List::solids);
      has_elements_ = true;
    } else if (name == "NPOIN") {
      read_points();
      has_points_ = true;
    } else if (name == "MARKER_TAG") {
      read_marker();
    } else {
      if (name == "NMARK") markers_ = cursor_.integer("number of markers");
      skip(name);
    }
  }

  /// Skips a section without a part of the mesh.
  void skip(const std::string& name) {
    constexpr std::array<std::string_view, 3> kWithoutContent{"NMARK", "NPERIODIC", "IZONE"};
    const bool is_periodic = name.starts_with("PERIODIC_");
    if (!is_periodic && std::find(kWithoutContent.begin(), kWithoutContent.end(), name) == kWithoutContent.end()) {
      skipped_.insert(printable(name));
    }
    cursor_.line();
    while (!at_end()) {
      const char* const start = cursor_.skip(0);
      const bool is_next = cursor_.line().find('=') != std::string_view::npos;
      if (!is_next) continue;
      cursor_.skip(start - cursor_.skip(0));
      return;
    }
  }

  std::size_t count(const char* name, int numbers) { return checked_count(cursor_, name, numbers, kMaxTets); }
  Index vertex() {
    const std::int64_t v = cursor_.integer("point number");
    if (v < 0 || v > std::numeric_limits<Index>::max()) {
      cursor_.fail("point number out of range: " + std::to_string(v) + "; numbers count from 0");
    }
    return Index(v);
  }

  void read_points() {
    if (has_points_) cursor_.fail("a second NPOIN= section");
    mesh_.points.resize(count("number of points", 3));
    cursor_.line();  // further counts
    for (Point3& p : mesh_.points) {
      at_end();
      for (double& x : p) x = cursor_.real("coordinate");
      while (!cursor_.line_done()) cursor_.word();  // its number
    }
  }

  void read_elements(std::size_t n, Su2List list) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t type = integer("type of an element");
      if (type == kTetrahedron && list == Su2List::solids) {
        mesh_.tets.push_back({});
        for (Index& v : mesh_.tets.back()) v = vertex();
      } else if (type == kTriangle && list == Su2List::marker) {
        mesh_.triangles.push_back({});
        for (Index& v : mesh_.triangles.back()) v = vertex();
        mesh_.triangle_tags.push_back(marker_);
      } else {
        read_other(type, list);
      }
      while (!cursor_.line_done()) cursor_.word();  // its number
    }
  }

  void read_other(std::int64_t type, Su2List list) {
    const auto kind =
        std::find_if(kSu2Kinds.begin(), kSu2Kinds.end(), [type](const Su2Kind& k) { return k.type == type; });
    if (kind == kSu2Kinds.end() || kind->list != list) {
      cursor_.fail("elements of type " + std::to_string(type) + " cannot be " +
                   (list == Su2List::marker ? "in a marker" : "solids"));
    }
    ElementBlock& block = element_block(mesh_, kind->kind, kind->vertices);
    for (int k = 0; k < kind->vertices; ++k) block.element2vertex.push_back(vertex());
    block.tags.push_back(list == Su2List::marker ? marker_ : 0);
  }

  void read_marker() {
    const TextCursor at_name = cursor_;
    const std::string name = rest_of_line();
    if (name.empty()) at_name.fail("MARKER_TAG= has no name");
    ++marker_;
    mesh_.groups.push_back({2, marker_, name, {marker_}});
    if (at_end() || keyword() != "MARKER_ELEMS")
      cursor_.fail("MARKER_ELEMS= is expected after MARKER_TAG= " + printable(name));
    const auto elements = count("number of elements of the marker", 3);
    if (!at_end() && cursor_.peek().starts_with("SEND_TO")) {
      cursor_.fail("the file is a part of a partitioned mesh (SEND_TO); use the whole mesh");
    }
    read_elements(elements, Su2List::marker);
  }

  TextCursor cursor_;
  const std::string& path_;
  const IoContext& context_;
  TetMesh mesh_;
  int marker_ = 0;            ///< the number of the last marker read
  std::int64_t markers_ = 0;  ///< their number by NMARK=
  bool has_points_ = false, has_elements_ = false;
  std::set<std::string> skipped_;
};

const Su2Kind* find_su2_kind(std::string_view block) {
  const auto kind =
      std::find_if(kSu2Kinds.begin(), kSu2Kinds.end(), [block](const Su2Kind& k) { return k.kind == block; });
  return kind == kSu2Kinds.end() ? nullptr : &*kind;
}

/// A triangle or quadrilateral of a marker.
struct Su2Face {
  int type;
  std::array<Index, 4> vertices;
  std::size_t size() const { return type == kTriangle ? 3 : 4; }
};

/// The elements of a mesh by markers: one per group of triangles, and one per other tag.
class Su2Markers {
 public:
  Su2Markers(const TetMesh& mesh, const IoContext& context) {
    const std::vector<const Group*> empty = empty_groups(mesh);
    for (const Group* const group : specific_first(mesh, 2)) {
      const std::string name = marker_of(group->name.empty() ? "patch" + std::to_string(group->number) : group->name);
      for (const int tag : group->tags) is_shared_ |= !names_.emplace(tag, name).second;
      if (std::binary_search(empty.begin(), empty.end(), group)) faces_[name];
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      add(mesh.triangle_tags[i], {kTriangle, {a, b, c}});
    }
    for (const ElementBlock& block : mesh.others) {
      if (block.kind != std::string_view(kSu2Kinds[0].kind)) continue;
      for (std::size_t i = 0; i < block.tags.size(); ++i) {
        const Index* const v = block.element2vertex.data() + 4 * i;
        add(block.tags[i], {kSu2Kinds[0].type, {v[0], v[1], v[2], v[3]}});
      }
    }
    renamed_.warn(context);
  }
  const std::map<std::string, std::vector<Su2Face>>& faces() const { return faces_; }
  /// Whether a tag is in several groups; its elements are in the marker of that with the fewest tags.
  bool is_shared() const { return is_shared_; }

 private:
  void add(int tag, const Su2Face& face) {
    auto name = names_.find(tag);
    if (name == names_.end()) {
      name = names_.emplace(tag, marker_of("patch" + std::to_string(tag), MarkerOf::single_tag)).first;
    }
    faces_[name->second].push_back(face);
  }
  enum class MarkerOf : std::uint8_t { group, single_tag };
  /// The marker of a name, in which SU2 reads no blanks and no comment; two names have two markers, and a tag that is
  /// in no group has its own.
  std::string marker_of(const std::string& name, MarkerOf of = MarkerOf::group) {
    std::string plain = name;
    std::replace_if(
        plain.begin(), plain.end(), [](unsigned char c) { return c <= ' ' || c == '%'; }, '_');
    std::string marker = plain;
    for (int n = 2; marker2owner_.try_emplace(marker, name, of).first->second != std::pair{name, of}; ++n) {
      marker = plain + "_" + std::to_string(n);
    }
    renamed_.add(name, marker);
    return marker;
  }

  RenamedGroups renamed_;
  std::map<int, std::string> names_;
  std::map<std::string, std::pair<std::string, MarkerOf>> marker2owner_;
  std::map<std::string, std::vector<Su2Face>> faces_;
  bool is_shared_ = false;
};

void warn_of_losses_in_su2(const TetMesh& mesh, const IoContext& context) {
  const auto has_region = [](const ElementBlock& block) {
    const Su2Kind* const kind = find_su2_kind(block.kind);
    return kind != nullptr && kind->list == Su2List::solids && has_tag(block.tags);
  };
  if (has_tag(mesh.tet_tags) || std::any_of(mesh.others.begin(), mesh.others.end(), has_region)) {
    context.warn("the format cannot hold regions: tags of tetrahedra and other solids are lost");
  }
  const auto is_lost = [](const Group& group) { return group.dimension != 2 && !group.name.empty(); };
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), is_lost)) {
    context.warn("the format cannot hold the names of groups other than those of triangles");
  }
  warn_of_point_tags(mesh, context);
  if (!mesh.edges.empty()) context.warn("the format cannot hold edges");
  warn_of_lists(mesh, context);
  warn_of_data(mesh, context);
  if (mesh.triangles.empty()) context.warn("the mesh lists no triangles: SU2 needs a marker on the whole boundary");
  if (mesh.second_order) context.warn(lost_middles(mesh));
}

}  // namespace

TetMesh read_su2(const std::string& path, const IoContext& context) {
  const MappedFile file(path);
  return Su2Reader(path, file.bytes(), context).read();
}

void write_su2(FileWriter& file, const TetMesh& mesh, const IoContext& context) {
  warn_of_losses_in_su2(mesh, context);
  std::size_t solids = mesh.tets.size();
  for (const ElementBlock& block : mesh.others) {
    const Su2Kind* const kind = find_su2_kind(block.kind);
    if (kind != nullptr && kind->list == Su2List::solids) solids += block.tags.size();
    if (kind == nullptr) context.warn("the format cannot hold elements of kind " + block.kind);
  }
  LineWriter out(file, context.threads);
  out.text("NDIME= 3\nNELEM= " + std::to_string(solids) + "\n");
  out.lines(mesh.tets.size(), [&](auto& entry, std::size_t t) {
    auto tet = mesh.tets[t];
    if (mesh.listed_inside_out) std::swap(tet[2], tet[3]);
    entry.integer(kTetrahedron);
    for (const Index v : tet) entry.integer(v);
  });
  for (const ElementBlock& block : mesh.others) {
    const Su2Kind* const kind = find_su2_kind(block.kind);
    if (kind == nullptr || kind->list != Su2List::solids) continue;
    out.lines(block.tags.size(), [&](auto& entry, std::size_t i) {
      entry.integer(kind->type);
      const std::size_t n = to_size_t(kind->vertices);
      for (std::size_t k = 0; k < n; ++k) entry.integer(block.element2vertex[n * i + k]);
    });
  }
  out.text("NPOIN= " + std::to_string(mesh.points.size()) + "\n");
  out.lines(mesh.points.size(), [&](auto& entry, std::size_t v) {
    for (const double x : mesh.points[v]) entry.real(x);
  });
  const Su2Markers markers(mesh, context);
  if (markers.is_shared())
    context.warn("a triangle can be in one marker only: it is in that of its group with the fewest tags");
  out.text("NMARK= " + std::to_string(markers.faces().size()) + "\n");
  for (const auto& [name, faces] : markers.faces()) {
    out.text("MARKER_TAG= " + name + "\nMARKER_ELEMS= " + std::to_string(faces.size()) + "\n");
    out.lines(faces.size(), [&elements = faces](auto& entry, std::size_t i) {
      entry.integer(elements[i].type);
      for (std::size_t k = 0; k < elements[i].size(); ++k) entry.integer(elements[i].vertices[k]);
    });
  }
}

}  // namespace tetune
