// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <limits>
#include <map>
#include <utility>

#include "plugin.hpp"

namespace tetune::plugin {

inline constexpr const char* kPhysical = "gmsh:physical";
inline constexpr const char* kGeometrical = "gmsh:geometrical";

/// Gmsh's numbers of the element types that tetune takes.
inline constexpr int kEdge = 1, kTriangle = 2, kTet = 4, kEdge3 = 8, kTriangle6 = 9, kTet10 = 11;
/// In the order of kOtherKinds.
inline constexpr std::array<int, 5> kOtherTypes{15, 3, 7, 6, 5};

/// Tags of entities, which are named by dimension and number.
using EntityTags = std::map<std::pair<int, int>, int>;

/// What a format has room for.
struct Format {
  double msh_version = 0;  ///< 0: none of Gmsh's own, and the number of an entity is the tag of its elements
  bool groups = true;
  int largest = std::numeric_limits<int>::max();  ///< number of an entity
};

/// How a mesh was handed over.
struct Handover {
  bool all_grouped = true;
  /// Of entities in no group, where from_gmsh() would give them others.
  EntityTags loose_tags;
};

/// Reads what Gmsh has opened; `loose_tags` are those of entities in no group, where they are known.
TetMesh from_gmsh(const EntityTags& loose_tags, Warnings& warnings);
/// Hands a mesh over to Gmsh. Raises the version where that of the format has no room for what is in no group.
Handover to_gmsh(TetMesh mesh, Format& format, Warnings& warnings);
/// Names the data that other formats than .msh have no room for.
void warn_of_data(const TetMesh& mesh, Warnings& warnings);
/// Appends point and element data to an .msh file.
void append_data(const std::string& file, const TetMesh& mesh, Warnings& warnings);

}  // namespace tetune::plugin
