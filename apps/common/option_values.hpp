// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
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

/// A length in the mesh's unit, or in percent of the diagonal of its bounding box.
struct Length {
  double value = 0;
  bool is_percentage = false;
  double in(const Box& box) const;
};

/// Parses a length, for example "0.01" or "0.1%". Throws OptionError, whose message names `option`.
Length parse_length(const std::string& option, const std::string& text);

/// Parses a bound, for example of `info --min-quality`: "radius_ratio=5", or "0.2" of the measure `by_default` if there
/// is one. Throws OptionError, whose message names `option`.
Target parse_bound(const std::string& option, const std::string& text, std::optional<Measure> by_default);

/// A region or patch that an option names.
struct TagOrName {
  enum class Of { region, patch };
  Of of;
  int tag;           ///< if the name is empty
  std::string name;  ///< of a group

  bool is_region() const { return of == Of::region; }
};

/// Parses "tag=1,2,patch=7,tag=steel" and appends the regions and patches to `frozen`. Throws OptionError.
void parse_freeze(const std::string& text, std::vector<TagOrName>& frozen);

/// Adds the tags of frozen regions and patches to `options`. Throws OptionError if the mesh does not have them; the
/// message lists those that it has.
void freeze(const std::vector<TagOrName>& frozen, const std::string& mesh_name, const TetMesh& mesh, Options& options);

/// Returns the tags of triangles that `patches` lists as numbers or as names of groups. Throws OptionError if the mesh
/// has no such patch; the message lists those that it has.
std::vector<int> find_patches(const std::string& option, const std::vector<std::string>& patches,
                              const std::string& mesh_name, const TetMesh& mesh);

/// Adds the links of --periodic, a list of axes, and of --periodic-map, a file.
void add_links(const std::vector<std::string>& axes, const std::string& map, const std::string& mesh_name,
               TetMesh& mesh);

}  // namespace tetune::cli
