// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {

/// The bounding box of all vertices; without vertices, the origin.
struct Box {
  Point3 low{}, high{};
  double diagonal() const;
};
Box bounding_box(const TetMesh& mesh);

/// Parses a length: "0.01", in the mesh's unit, or "0.1%" of the diagonal of its bounding box. Throws OptionError.
double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh);

/// Parses the name of a measure, for example "mean_ratio". Throws OptionError, whose message names `option`.
Measure parse_measure(const std::string& option, const std::string& name);

/// Parses a bound, for example of `info --min-quality`: "0.2", of the measure `by_default`, or "radius_ratio=5". Throws
/// OptionError, whose message names `option`.
Target parse_bound(const std::string& option, const std::string& text, Measure by_default);

/// A frozen region or patch.
struct Frozen {
  bool region;
  int tag;           ///< if the name is empty
  std::string name;  ///< of a group
};

/// Parses "tag=1,2,patch=7,tag=steel" and appends the regions and patches to `frozen`. Throws OptionError.
void parse_freeze(const std::string& text, std::vector<Frozen>& frozen);

/// Adds the tags of frozen regions and patches to `options`. Throws OptionError if the mesh does not have them; the
/// message lists those that it has.
void freeze(const std::vector<Frozen>& frozen, const std::string& mesh_name, const TetMesh& mesh, Options& options);

/// Adds the links of --periodic, a list of axes, and of --periodic-map, a file.
void add_links(const std::vector<std::string>& axes, const std::string& map, const std::string& mesh_name,
               TetMesh& mesh);

}  // namespace tetune::cli
