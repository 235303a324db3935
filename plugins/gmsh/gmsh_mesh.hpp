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

/// Gmsh's numbers of the element types that tetune reads.
inline constexpr int kEdge = 1, kTriangle = 2, kTet = 4, kEdge3 = 8, kTriangle6 = 9, kTet10 = 11;
/// In the order of kOtherKinds.
inline constexpr std::array<int, 5> kOtherTypes{15, 3, 7, 6, 5};

/// Tags of entities, which are named by dimension and number.
using EntityTags = std::map<std::pair<int, int>, int>;

/// The limits of a format.
struct Format {
  double msh_version = 0;  ///< 0: not Gmsh's own format; the number of an entity is then the tag of its elements
  bool groups = true;
  int max_entity = std::numeric_limits<int>::max();  ///< largest number of an entity
};

/// The result of to_gmsh().
struct Handover {
  bool all_grouped = true;
  /// The tags of entities in no group that from_gmsh() would not find by itself.
  EntityTags loose_tags;
};

/// Reads the model that Gmsh has opened; `loose_tags`: the known tags of entities in no group.
TetMesh from_gmsh(const EntityTags& loose_tags, Warnings& warnings);
/// Makes a mesh the model of Gmsh. Raises the version of the format where entities in no group need it.
Handover to_gmsh(TetMesh mesh, Format& format, Warnings& warnings);
/// Warns of the data that formats other than .msh cannot hold.
void warn_of_data(const TetMesh& mesh, Warnings& warnings);
/// Appends point and element data to an .msh file.
void append_data(const std::string& file, const TetMesh& mesh, Warnings& warnings);

}  // namespace tetune::plugin
