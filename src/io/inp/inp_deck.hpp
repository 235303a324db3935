// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/inp/inp_card_kind.hpp"
#include "io/inp/inp_parts.hpp"
#include "io/number_index.hpp"
#include "io/registry.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// A part of the text of a deck, in the order of the file; the contents of included files stand in their place.
struct InpPiece {
  enum class Kind { text, nodes, tets, triangles, set, faces, condition };
  Kind kind = Kind::text;
  std::string_view text;
  /// The position of the card in a list of InpModel: node_cards, tet_cards or triangle_cards for the kinds nodes, tets
  /// and triangles, set_cards for set, face_cards for faces, conditions for condition.
  Index card = -1;
  /// The nodes, tetrahedra or triangles that it defines, one after another.
  Index first = 0, last = 0;
};

/// A *NODE card, or an *ELEMENT card of tetrahedra or triangles.
struct InpEntityCard {
  Index set = -1;    ///< that its entities are in
  Index first = 0;   ///< the first of its entities
  std::string type;  ///< of elements
};

/// An element with the shape of a triangle, as a shell or a membrane.
struct InpTriangle {
  Index element;
  Index card;  ///< position in InpModel::triangle_cards
  const char* line;
  std::array<Index, 3> vertices;  ///< nodes, as listed
  bool has_middles;
  /// Whether it is a face of tetrahedra, and changes with these; else it stays.
  bool is_face = false;
  Index tet = -1;     ///< the first of these,
  int opposite = -1;  ///< and its vertex opposite the face
  int tag = 0;        ///< of its patch, where it is a face
};

/// A set of nodes or elements: all cards of one name.
struct InpSet {
  std::string name;        ///< as written, without quotation marks; in a deck of parts as the assembly names it
  std::string key;         ///< by which names are compared (InpReferences::key())
  std::string parameters;  ///< of a further card of the set: "*NSET, NSET=name"
  bool of_nodes = false;
  /// Nodes by position, elements by position among all elements; ascending.
  std::vector<Index> members;
  /// Mid-side nodes, which are not in `members`; ascending.
  std::vector<Index> middles;
  /// Whether a set of nodes has all mid-side nodes of its regions and patches; new ones are then added to it.
  bool adds_middles = false;
  /// Positions in InpModel::set_cards.
  std::vector<Index> cards;
  /// Whether a set of tetrahedra is used by one line of faces alone: it follows these faces, and defines no region.
  bool is_auxiliary = false;
  /// Whether every member of a set of nodes keeps its position.
  bool is_held = false;
  /// For a set of nodes that is not held: the vertices of tetrahedra that are in none of its regions and patches, which
  /// keep their position; ascending.
  std::vector<Index> rest;
  /// Tags of the regions in a set of elements; of those with all vertices in a set of nodes.
  std::vector<int> regions;
  /// Tags of the quadrilaterals in a set of elements, and of the edges.
  std::vector<int> quads, lines;
  /// Face groups with all vertices in a set of nodes.
  std::vector<Index> groups;
  /// Tags of the patches with all vertices in a set of nodes; of those of triangles in a set of elements.
  std::vector<int> patches;
};

/// An *NSET or *ELSET card.
struct InpSetCard {
  Index set = -1;
  std::string_view head;           ///< the keyword line
  std::vector<Index> members;      ///< that it lists by number
  std::vector<Index> nested;       ///< sets that it lists by name
  std::vector<std::string> names;  ///< of these, as written
  bool in_assembly = false;        ///< names in it are those of the assembly (InpReferences)
  bool generates = false;
  bool follows_elements = false;  ///< *NSET, ELSET=: it lists nothing
};

/// A face of a tetrahedron: 1 to 4 as Abaqus counts.
struct InpFace {
  Index element;
  int face;
  auto operator<=>(const InpFace&) const = default;
};

/// A line with a set of elements in the place of one.
struct InpFaceSet {
  Index set;
  int face;
  std::string line;
};

/// Lines `element, <before><face><after>` of one card: the faces of a *SURFACE, or those under one load.
struct InpFaceGroup {
  std::string before, after;
  std::vector<InpFace> faces;    ///< of tetrahedra, ascending
  std::vector<InpFace> direct;   ///< those that no auxiliary set lists
  std::vector<InpFaceSet> sets;  ///< auxiliary ones
};

/// A *SURFACE card, or one of loads on faces.
struct InpFaceCard {
  std::string_view head;
  std::string name, key;      ///< of a *SURFACE, as those of a set
  bool in_assembly = false;   ///< see InpReferences
  std::string other_lines;    ///< that are no faces of tetrahedra
  std::vector<Index> groups;  ///< positions in InpModel::face_groups
};

/// A data line with values of a node, or of each node of a set.
struct InpConditionLine {
  std::string_view text;
  Index node = -1, set = -1;  ///< one of them, or none where it does not exist
};

/// The lines of all cards with one keyword line in one step.
struct InpCondition {
  std::string name;  ///< of the cards, as written
  InpCardKind::Condition kind;
  bool in_assembly = false;  ///< see InpReferences
  std::vector<InpConditionLine> lines{};
  /// A line is so long that the next one can continue it: none of them is interpreted.
  bool may_continue = false;
  /// The piece of the last line, which lines of inserted nodes follow. -1: there is none.
  Index last_piece = -1;
};

/// A face of a patch belongs to a group by the tetrahedron on one of its sides.
struct InpPatchMember {
  Index group;
  int side;  ///< 0: the tetrahedron that the normal of the triangle points away from
  auto operator<=>(const InpPatchMember&) const = default;
};

/// The tetrahedra of one tag.
struct InpRegion {
  int tag;
  std::vector<Index> sets;
};

/// The triangles of one tag.
struct InpPatch {
  int tag;
  std::vector<InpPatchMember> members{};
  Index card = -1;            ///< the *ELEMENT card of which the triangles are elements, or -1
  std::vector<Index> sets{};  ///< that have these elements
};

/// The contents of a deck.
struct InpModel {
  std::deque<std::string> files;  ///< their bytes, which all views refer to
  const char* newline = "\n";
  InpReferences references;
  std::vector<InpPiece> pieces;

  std::vector<std::int64_t> node_labels;
  std::vector<const char*> node_lines;  ///< where the line of each begins
  std::vector<Point3> points;
  NumberIndex nodes;
  std::vector<InpEntityCard> node_cards;

  std::vector<std::int64_t> element_labels;
  std::vector<Index> element2tet;  ///< -1 for other elements
  NumberIndex elements;
  std::size_t text_elements = 0;  ///< the number of those that a mesh cannot have

  std::vector<Index> tet2element;
  std::vector<std::array<Index, 4>> tets;  ///< nodes, as listed
  /// The edges of second-order elements by their nodes, ascending, with their mid-side nodes.
  std::vector<std::pair<std::array<Index, 2>, Index>> middles;
  std::vector<Index> fixed_middles;  ///< those of elements of other kinds, ascending
  std::vector<Index> held_middles;   ///< mid-side nodes that other cards name and no set can follow
  bool is_second_order = false, is_straight = false;
  std::vector<const char*> tet_lines;
  std::vector<Index> tet2card;
  std::vector<InpEntityCard> tet_cards;

  /// The elements that are edges of tetrahedra, with their position in TetMesh::edges.
  std::vector<std::pair<Index, Index>> lines;

  std::vector<InpTriangle> triangles;  ///< in the order of elements
  std::vector<InpEntityCard> triangle_cards;

  std::vector<InpSet> sets;
  std::vector<InpSetCard> set_cards;
  std::vector<InpFaceGroup> face_groups;
  std::vector<InpFaceCard> face_cards;
  std::vector<InpCondition> conditions;

  std::vector<InpRegion> regions;  ///< by tag, ascending
  std::vector<InpPatch> patches;   ///< by tag, ascending
  std::vector<int> tet_tags;       ///< per tetrahedron

  /// A node or element of the mesh as lines in the assembly, or in its part, name it.
  std::string reference(std::int64_t label, bool in_assembly) const {
    return (in_assembly ? references.written_prefix() : std::string()) + std::to_string(label);
  }

  /// The position of a node or element with this number, or -1.
  Index node(std::int64_t label) const { return position(nodes, label); }
  Index element(std::int64_t label) const { return position(elements, label); }
  /// The position in `triangles` of an element, or -1.
  Index triangle(Index element) const {
    const auto at = std::lower_bound(triangles.begin(), triangles.end(), element,
                                     [](const InpTriangle& t, Index e) { return t.element < e; });
    return at == triangles.end() || at->element != element ? -1 : to_index(at - triangles.begin());
  }

 private:
  static Index position(const NumberIndex& index, std::int64_t label) {
    const Index rank = index.rank(label);
    return rank < 0 ? -1 : span_of(index.order())[rank];
  }
};

/// A deck and the mesh that was read from it.
class AbaqusDeck {
 public:
  explicit AbaqusDeck(InpModel model) : model_(std::move(model)) {}
  const InpModel& model() const { return model_; }

 private:
  InpModel model_;
};

/// Writes a mesh that has no deck.
void write_inp_plain(FileWriter& file, const TetMesh& mesh, const IoContext& context);

}  // namespace tetune
