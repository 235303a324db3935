// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/element_kinds.hpp"
#include "mesh/sorted.hpp"
#include "tetune/mesh.hpp"

/// The syntax of .inp files of Abaqus and CalculiX: keywords, parameters, names, element types, numbers.
namespace tetune {

/// A card as its keyword line has it: upper case, without blanks; values in quotation marks as they are.
struct InpKeyword {
  std::string name;
  std::vector<std::pair<std::string, std::string>> parameters;

  /// The value of a parameter, or nullptr. A parameter without a value is empty.
  const std::string* find(std::string_view parameter) const;
  bool has(std::string_view parameter) const { return find(parameter) != nullptr; }
};

/// Parses a keyword line, with the lines that continue it.
InpKeyword parse_inp_keyword(std::string_view line);

/// The fields of a data line, without blanks around them; those of a trailing comma are left out.
std::vector<std::string_view> inp_fields(std::string_view line);

/// A name as it is compared: without blanks and in upper case, or as it is between quotation marks.
std::string inp_name(std::string_view written);
/// A name as it is written, without quotation marks.
std::string unquoted_inp_name(std::string_view written);

/// Reads an integer of at most 18 digits that fills the field; returns false for other fields.
bool parse_inp_integer(std::string_view field, std::int64_t& value);

/// The role of an element type in a mesh.
struct InpElementType {
  enum class Role {
    tetrahedron,
    quadratic_tetrahedron,
    block,
    triangle,
    quadratic_triangle,
    edge,
    quadratic_edge,
    unknown,
  };
  Role role = Role::unknown;
  /// 0 where unknown: the element ends with its line, unless a comma continues that.
  int nodes = 0;
  /// ElementBlock::kind.
  const char* kind = nullptr;

  /// Whether an element of a block has mid-side nodes; they follow the vertices.
  bool has_middles() const { return role == Role::block && nodes > find_element_kind(kind)->vertices; }
  bool is_triangle() const { return role == Role::triangle || role == Role::quadratic_triangle; }
  bool is_edge() const { return role == Role::edge || role == Role::quadratic_edge; }
};
InpElementType inp_element_type(const std::string& type);

/// The number of a face in Abaqus, 1 to 4, by the opposite vertex, 0 to 3; and the opposite vertex by that number.
inline constexpr std::array<int, 4> kInpFaceOpposite{3, 4, 2, 1};
inline constexpr std::array<int, 5> kInpOppositeFace{-1, 3, 2, 0, 1};

/// Appends a coordinate with the digits that read back to the same bits, or as many of them as fit into 20 characters:
/// both programs read no more. Returns whether all of them fit.
bool append_inp_real(std::string& out, double value);

/// Appends numbers in lines of 16.
void append_inp_labels(std::string& out, const std::vector<std::int64_t>& labels, std::string_view newline);

}  // namespace tetune
