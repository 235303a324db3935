// SPDX-License-Identifier: Apache-2.0
// Meshes of Netgen and NGSolve (.vol, .vol.gz), as Netgen's Mesh::Load() reads them.
#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "io/checked_count.hpp"
#include "io/element_collector.hpp"
#include "io/gzip.hpp"
#include "io/netgen/netgen_format.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "mesh/tet.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class NetgenReader {
 public:
  NetgenReader(const std::string& path, std::string_view text, const IoContext& context)
      : cursor_(path, text), path_(path), context_(context) {}

  TetMesh read() {
    if (cursor_.word() != "mesh3d") cursor_.fail("expected \"mesh3d\", with which files of Netgen start");
    for (std::string_view name = cursor_.word(); name != "endmesh"; name = cursor_.word()) {
      if (name.empty() && !has_points_) cursor_.fail("the file ends before its section \"points\"");
      if (name.empty()) {
        context_.warn(path_ + ": the file ends without \"endmesh\"; it may be incomplete");
        break;
      }
      read_section(std::string(name));
    }
    if (!has_points_) cursor_.fail("the file has no section \"points\"");
    if (!cursor_.at_end()) skipped_.insert("the geometry after the mesh");
    finish();
    for (const std::string& name : skipped_) context_.warn(path_ + ": " + name + " is not kept");
    return std::move(mesh_);
  }

 private:
  void read_section(const std::string& name) {
    if (name == "dimension") {
      if (cursor_.integer("dimension") != 3) cursor_.fail("the dimension must be 3");
    } else if (name == "geomtype") {
      cursor_.integer("type of the geometry");
    } else if (name.starts_with("surfaceelements")) {
      read_surface(name == "surfaceelementsgi" ? 1 : name == "surfaceelementsuv" ? 2 : 0);
    } else if (name == "volumeelements") {
      read_solids();
    } else if (name.starts_with("edgesegments")) {
      read_edges(name);
    } else if (name == "points") {
      read_points();
    } else if (name == "pointelements") {
      read_point_elements();
    } else if (const auto names = names_.find(name); names != names_.end()) {
      read_names(names->second);
    } else if (name == "edgedescriptors") {
      read_edge_descriptors();
    } else if (name == "identifications") {
      read_identifications();
    } else if (name == "identificationtypes") {
      types_.resize(count("number of types", 1));
      for (std::int64_t& type : types_) type = cursor_.integer("type of an identification");
    } else {
      skip(name);
    }
  }

  /// Skips a section without a part of the mesh, up to the next line that starts with the name of a section.
  void skip(const std::string& name) {
    // The descriptions of faces and their numbers repeat the data of surface elements; colors are for display.
    static const std::set<std::string_view> unused{"facedescriptors", "face_colours", "face_transparencies"};
    static const std::set<std::string_view> known{"facedescriptors",
                                                  "surfaceelements",
                                                  "surfaceelementsgi",
                                                  "surfaceelementsuv",
                                                  "volumeelements",
                                                  "edgesegments",
                                                  "edgesegmentsgi",
                                                  "edgesegmentsgi2",
                                                  "edgesegmentsgi3",
                                                  "points",
                                                  "pointelements",
                                                  "materials",
                                                  "bcnames",
                                                  "cd2names",
                                                  "cd3names",
                                                  "edgedescriptors",
                                                  "identifications",
                                                  "identificationtypes",
                                                  "identificationnames",
                                                  "singular_points",
                                                  "face_colours",
                                                  "curvedelements",
                                                  "singular_edge_left",
                                                  "singular_face_inside",
                                                  "singular_face_outside",
                                                  "endmesh",
                                                  "singular_edge_right",
                                                  "face_transparencies"};
    if (!TextCursor::is_letter(name[0])) {
      cursor_.fail("expected the name of a section, found \"" + printable(name.substr(0, 40)) +
                   "\"; the section before it is longer than it says");
    }
    if (!unused.contains(name)) skipped_.insert("the section " + printable(name.substr(0, 60)));
    cursor_.line();
    while (!cursor_.at_end() && !known.contains(cursor_.peek())) cursor_.line();
  }

  /// Throws FileError where entities of different sections do not fit, for which there is no line.
  [[noreturn]] void fail(const std::string& text) const { throw FileError(path_ + ": " + text); }
  std::size_t count(const char* name, int numbers) { return checked_count(cursor_, name, numbers, kMaxTets); }
  int integer(const char* name) {
    const std::int64_t value = cursor_.integer(name);
    if (value < -std::numeric_limits<int>::max() || value > std::numeric_limits<int>::max()) {
      cursor_.fail(std::string(name) + " is beyond 32 bits");
    }
    return int(value);
  }
  Index vertex() {
    const int v = integer("point number");
    if (v < 1) cursor_.fail("point number out of range: " + std::to_string(v) + "; numbers count from 1");
    return v - 1;
  }
  std::vector<Index> vertices(int n) {
    constexpr int kMaxNodes = 20;
    if (n < 1 || n > kMaxNodes) cursor_.fail("elements of " + std::to_string(n) + " nodes are not supported");
    std::vector<Index> list(to_size_t(n));
    for (Index& v : list) v = vertex();
    return list;
  }
  void skip_words(int n) {
    for (int i = 0; i < n; ++i) cursor_.word();
  }

  void read_points() {
    if (has_points_) cursor_.fail("a second section \"points\"");
    has_points_ = true;
    mesh_.points.resize(count("number of points", 3));
    for (Point3& p : mesh_.points) {
      for (double& x : p) x = cursor_.real("coordinate");
    }
  }

  /// `extra`: the number of parameters of the geometry at each node.
  void read_surface(int extra) {
    const std::size_t n = count("number of surface elements", 5);
    for (std::size_t i = 0; i < n; ++i) {
      const int surface = integer("number of a surface");
      const int tag = integer("number of a boundary condition");
      skip_words(2);  // regions on both sides
      int nodes = integer("number of nodes");
      if (nodes == 0) nodes = 3;
      const std::vector<Index> v = vertices(nodes);
      skip_words(extra * to_index(v.size()));
      if (nodes == 3 || nodes == 6) {
        add_simplex(v, 3, kNetgenTriangle, tag);
        surfaces_.push_back(surface);
      } else {
        add_other(v, tag, NetgenSection::surface);
      }
    }
  }

  void read_solids() {
    const std::size_t n = count("number of volume elements", 6);
    for (std::size_t i = 0; i < n; ++i) {
      const int tag = std::max(1, integer("number of a material"));
      const std::vector<Index> v = vertices(integer("number of nodes"));
      if (v.size() == 4 || v.size() == 10) {
        add_simplex(v, 4, kNetgenTet, tag);
      } else {
        add_other(v, tag, NetgenSection::volume);
      }
    }
  }

  /// Adds an element with its nodes at the places of `order`, of which those in the middles of edges follow the
  /// vertices.
  template <std::size_t N>
  void add_simplex(const std::vector<Index>& v, std::size_t vertices, const std::array<int, N>& order, int tag) {
    std::array<Index, N> nodes{};
    for (std::size_t k = 0; k < v.size(); ++k) nodes[k] = span_of(v)[order[k]];
    collector_.add_simplex(std::span(nodes).first(v.size()), vertices, tag);
  }

  void add_other(const std::vector<Index>& v, int tag, NetgenSection section) {
    for (const NetgenKind& kind : kNetgenKinds) {
      if (to_size_t(kind.vertices) != v.size() || kind.section != section) continue;
      std::array<Index, 8> nodes{};
      for (std::size_t k = 0; k < v.size(); ++k) nodes[k] = span_of(v)[kind.order[k]];
      return collector_.add_other(kind.kind, std::span(nodes).first(v.size()), tag);
    }
    cursor_.fail(std::string(section == NetgenSection::volume ? "volume" : "surface") + " elements of " +
                 std::to_string(v.size()) +
                 " nodes are not supported; of second order tetune reads tetrahedra and triangles of this format");
  }

  /// Each edge is listed once for each of its faces.
  void read_edges(const std::string& name) {
    const bool is_short = name == "edgesegmentsgi3";
    has_descriptors_ = is_short;
    const std::size_t n = count("number of edges", 4);
    for (std::size_t i = 0; i < n; ++i) {
      int tag = 0;
      if (!is_short) {
        tag = integer("number of a surface");
        skip_words(1);
      }
      const Index a = vertex();
      const Index b = vertex();
      skip_words(is_short || name == "edgesegmentsgi2" ? 4 : name == "edgesegmentsgi" ? 2 : 0);
      if (is_short) {
        tag = integer("number of an edge's description");
        if (tag == std::numeric_limits<int>::max()) cursor_.fail("the number of an edge's description is too large");
        ++tag;
      }
      if (name == "edgesegmentsgi2") {
        tag = integer("number of an edge");
        skip_words(3);
      }
      if (!edges_.insert(ascending(a, b)).second) continue;
      collector_.add_simplex(std::array{a, b}, 2, tag);
    }
  }

  void read_point_elements() {
    const std::size_t n = count("number of points", 2);
    for (std::size_t i = 0; i < n; ++i) {
      const std::array<Index, 1> node{vertex()};
      collector_.add_other(kPoints, node, integer("number of a point"));
    }
  }

  void add_name(int dimension, int tag, std::string_view name) {
    if (name.empty() || name == kNetgenUnnamed) return;
    const auto [at, is_new] = name2group_.try_emplace({dimension, std::string(name)}, mesh_.groups.size());
    if (is_new) mesh_.groups.push_back({dimension, tag, std::string(name), {}});
    mesh_.groups[at->second].tags.push_back(tag);
  }
  void read_names(int dimension) {
    const std::size_t n = count("number of names", 1);
    for (std::size_t i = 0; i < n; ++i) {
      const int tag = integer("number of a name");
      std::string_view name = cursor_.line();
      const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
      while (!name.empty() && is_blank(name.front())) name.remove_prefix(1);
      while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
      // The names of edges are those of their descriptions, where edges refer to these.
      if (tag > 0 && !(dimension == 1 && has_descriptors_)) add_name(dimension, tag, name);
    }
  }
  /// Edges refer to descriptions by position; several have the same number if the edge of the geometry has several
  /// faces.
  void read_edge_descriptors() {
    descriptors_.resize(count("number of edges", 6));
    std::set<std::pair<int, std::string>> named;
    for (int& number : descriptors_) {
      number = integer("number of an edge");
      skip_words(5);
      std::string_view name = cursor_.word();
      while (!cursor_.line_done()) name = cursor_.word();  // two more numbers in newer files
      if (has_descriptors_ && number > 0 && named.emplace(number, name).second) add_name(1, number, name);
    }
  }

  void read_identifications() {
    const std::size_t n = count("number of identified points", 3);
    for (std::size_t i = 0; i < n; ++i) {
      const Index master = vertex();
      const Index image = vertex();
      identified_[integer("number of an identification")].push_back({image, master});
    }
  }

  void finish() {
    if (has_descriptors_ && !descriptors_.empty()) {
      for (int& tag : mesh_.edge_tags) {
        if (tag < 1 || to_size_t(tag) > descriptors_.size()) {
          fail("an edge has no description among the " + std::to_string(descriptors_.size()) +
               " of the section \"edgedescriptors\"");
        }
        tag = span_of(descriptors_)[tag - 1];
      }
    }
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    if (surfaces_ != mesh_.triangle_tags) mesh_.triangle_data.push_back({kNetgenSurface, 1, surfaces_});
    for (auto& [number, pairs] : identified_) {
      const bool has_type = number > 0 && to_size_t(number) <= types_.size();
      if (has_type && span_of(types_)[number - 1] != kNetgenPeriodic) {
        skipped_.insert("the identification " + std::to_string(number) + ", which is not periodic,");
      } else {
        PeriodicLink link{2, 0, 0, {}, std::move(pairs)};
        link.entity = tag_of(link, 0);
        link.master = tag_of(link, 1);
        mesh_.periodic.push_back(std::move(link));
      }
    }
    const auto check = [this](const char* what, Index v) {
      if (to_size_t(v) < mesh_.points.size()) return;
      fail(std::string(what) + " " + std::to_string(v + 1) + ", and the file has " +
           std::to_string(mesh_.points.size()) + " points");
    };
    MiddleList& middles = collector_.middles();
    middles.complete[1] = mesh_.edges.size();  // edges have no mid-side nodes, and get none on writing
    for (const Middle& m : middles.nodes) check("an element has point", std::max({m.node, m.ends[0], m.ends[1]}));
    for (const PeriodicLink& link : mesh_.periodic) {
      for (const auto& [a, b] : link.pairs) check("an identification has point", std::max(a, b));
    }
    try {
      for (const std::string& text : erase_middles(middles, mesh_)) context_.warn(path_ + ": " + text);
    } catch (const FileError& e) {
      fail(e.what());
    }
  }
  /// The tag of a triangle whose vertices are all images (side 0), or images of others (side 1).
  int tag_of(const PeriodicLink& link, std::size_t side) const {
    std::set<Index> in;
    for (const auto& pair : link.pairs) in.insert(pair[side]);
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const auto& t = mesh_.triangles[i];
      if (in.contains(t[0]) && in.contains(t[1]) && in.contains(t[2])) return mesh_.triangle_tags[i];
    }
    return 0;
  }

  TextCursor cursor_;
  const std::string& path_;
  const IoContext& context_;
  TetMesh mesh_;
  ElementCollector collector_{mesh_, MiddleOrder::base_top_between};  // which other kinds have none of
  const std::map<std::string, int> names_{{"materials", 3}, {"bcnames", 2}, {"cd2names", 1}, {"cd3names", 0}};
  std::vector<std::int32_t> surfaces_;                             ///< of the triangles
  std::map<std::pair<int, std::string>, std::size_t> name2group_;  ///< by dimension and name
  std::set<std::array<Index, 2>> edges_;                           ///< listed ones
  std::map<int, std::vector<std::array<Index, 2>>> identified_;
  std::vector<std::int64_t> types_;  ///< of identifications
  std::vector<int> descriptors_;     ///< numbers of edges
  std::set<std::string> skipped_;
  bool has_points_ = false, has_descriptors_ = false;
};

}  // namespace

TetMesh read_netgen(const std::string& path, const IoContext& context) {
  const MappedFile file(path);
  if (ending_of(path) != ".gz") return NetgenReader(path, file.bytes(), context).read();
  return NetgenReader(path, gunzip(path, file.bytes()), context).read();
}

}  // namespace tetune
