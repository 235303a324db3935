// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "io/element_blocks.hpp"
#include "io/inp/inp_cursor.hpp"
#include "io/inp/inp_deck.hpp"
#include "io/inp/inp_format.hpp"

namespace tetune {

/// A line of a data list, as it refers to entities of a deck: resolved when all of them are known.
struct InpSetLines {
  std::vector<std::int64_t> labels;
  std::vector<std::array<std::int64_t, 3>> ranges;  ///< first, last, step
  std::vector<std::string> names;                   ///< of sets, as written
  std::string elements;                             ///< *NSET, ELSET=
};
struct InpFaceLine {
  Index group;  ///< -1: the line certainly has no face of a tetrahedron
  int face;
  std::string of;    ///< a number or a set, as written
  std::string line;  ///< with its end
};

/// An element that is no tetrahedron.
struct InpOther {
  Index element;
  InpElementType type;
  std::size_t first_node, end_node;  ///< in InpScan::other_nodes
  const char* line;                  ///< where its first line begins
};

/// All that one pass over the text finds; numbers and names are not resolved.
struct InpScan {
  InpModel model;
  std::vector<std::string> paths;                    ///< of InpModel::files
  std::vector<InpSetLines> set_lines;                ///< per set card
  std::vector<std::vector<InpFaceLine>> face_lines;  ///< per face card
  /// Face groups by card and by what their lines have before and after the number of the face.
  std::map<std::tuple<std::size_t, std::string, std::string>, Index> face_group_of;
  std::vector<InpPlace> set_places, face_places;  ///< of cards
  int nodes_per_tet = 0;
  std::vector<std::int64_t> tet_node_labels;  ///< nodes_per_tet per tetrahedron
  std::vector<std::int64_t> other_nodes;
  std::vector<InpOther> others;
  /// Sets by kind (of nodes) and name.
  std::map<std::pair<bool, std::string>, Index> names;
  std::vector<Index> element2set;  ///< the set of its *ELEMENT card, or -1
  /// Names that occur in cards other than those of faces and their own definition; those in cards that pair nodes; and
  /// those in cards whose loads act on each node.
  std::set<std::string> mentioned, paired, loaded;
  /// Numbers in other cards.
  std::vector<std::int64_t> held_nodes, held_elements;
  /// The nodes to which lines of fields give values by number: those of new edges get such lines too.
  std::vector<std::int64_t> nodes_with_fields;

  /// Whether the present line is in the assembly or a step of a deck of parts (InpReferences).
  bool in_assembly = false;

  /// The name of a set or surface as the assembly has it.
  std::string full_name(std::string_view written) const {
    std::string prefix = in_assembly ? std::string() : model.references.written_prefix();
    std::erase(prefix, '"');
    return prefix + unquoted_inp_name(written);
  }
  std::string key(std::string_view written) const { return model.references.key(written, in_assembly); }
  bool parse_label(std::string_view field, std::int64_t& label) const {
    return model.references.parse_label(field, in_assembly, label);
  }
  /// The file and line of a byte of the text.
  InpPlace place_of(const char* at) const;
  /// An element that is no tetrahedron.
  const InpOther& other(Index element) const;
  /// The elements that other cards name by number, ascending. Requires InpModel::elements.
  std::vector<Index> find_held_elements() const;
};

/// Reads the text of a deck and of the files that it includes. Throws FileError.
InpScan scan_inp(const std::string& path, std::string bytes);

/// Throws FileError if a text without nodes is one of ANSYS's commands, whose files have the same ending.
void refuse_ansys_deck(const std::string& path, std::string_view text);

/// Holds the nodes of an element that the mesh cannot have.
void hold_nodes_of(const InpOther& other, const InpScan& scan, InpModel& model, TetMesh& mesh);

/// Makes elements of second order, but for tetrahedra, elements of unknown types, whose nodes are held, where the mesh
/// cannot have them: beside tetrahedra of first order, or where a mid-side node has another part.
void hold_unfit_others(InpScan& scan);

/// The block of a mesh for elements of a type that belongs to blocks.
inline ElementBlock& inp_block(TetMesh& mesh, const InpElementType& type) {
  return element_block(mesh, type.kind, find_element_kind(type.kind)->vertices, type.has_middles());
}

/// Finds the entities that the numbers and names refer to, and fills the model and the mesh but for tags.
void resolve_inp(InpScan& scan, TetMesh& mesh, const std::string& path, const IoContext& context);

/// Finds the triangles that are faces of tetrahedra; the mesh gets the others, and those that other cards name by
/// number, as required triangles or, with mid-side nodes, as required vertices.
void find_inp_triangles(const InpScan& scan, InpModel& model, TetMesh& mesh);

/// Finds the elements that are edges of tetrahedra, which are ridges of the mesh; it gets the others, and those that
/// other cards name by number, as required edges or, with mid-side nodes, as required vertices.
void find_inp_lines(const InpScan& scan, InpModel& model, TetMesh& mesh);

/// Lists the triangles of surfaces, of elements that are faces of tetrahedra, and of sets of nodes on the boundary,
/// with their tags; the rest of such sets of nodes is held.
void find_inp_patches(const InpScan& scan, InpModel& model, TetMesh& mesh, const IoContext& context);

/// The tags of the patches of each face group; one can occur twice.
std::vector<std::vector<int>> tags_of_face_groups(const InpModel& model);

/// Gives each tetrahedron a tag by the sets that it is in, and each triangle one by its surfaces and sets, so that
/// every set is a union of tags; and holds the nodes and elements that other cards name by number.
void partition_inp(const InpScan& scan, InpModel& model, TetMesh& mesh, const IoContext& context);

}  // namespace tetune
