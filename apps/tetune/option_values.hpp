// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {

/// The box around all vertices; of none, a point at 0.
struct Box {
  Point3 low{}, high{};
  double diagonal() const;
};
Box bounding_box(const TetMesh& mesh);

/// A length as "0.01", in the mesh's unit, or as "0.1%" of the diagonal of its bounding box. Throws OptionError.
double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh);

/// A measure by its name in reports: "mean_ratio". Throws OptionError that names `option`.
Measure parse_measure(const std::string& option, const std::string& name);

/// A bound for `info --min-quality`: "0.2", of the mean ratio, or "radius_ratio=5". Throws OptionError.
Target parse_bound(const std::string& text);

/// What is frozen: regions, or patches.
struct Frozen {
  bool region;
  int tag;           ///< if there is no name
  std::string name;  ///< of a group
};

/// Adds what "tag=1,2,patch=7,tag=steel" names. Throws OptionError.
void parse_freeze(const std::string& text, std::vector<Frozen>& frozen);

/// Freezes the tags that these stand for in a mesh, which has to have them. Throws OptionError that says what there is.
void freeze(const std::vector<Frozen>& frozen, const std::string& mesh_name, const TetMesh& mesh, Options& options);

}  // namespace tetune::cli
