// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/curved_refusal.hpp"

#include <algorithm>
#include <string>

#include "mesh/tet_mesh_view.hpp"
#include "tetune/error.hpp"
#include "tetune/option_table.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Whether the caller holds something besides the surface.
bool has_frozen(const TetMesh& mesh, const Options& options) {
  const auto& flags = options.frozen_vertices;
  return !options.frozen_regions.empty() || !options.frozen_patches.empty() || !mesh.required_vertices.empty() ||
         !mesh.required_edges.empty() || !mesh.required_triangles.empty() || !mesh.required_tets.empty() ||
         std::any_of(flags.begin(), flags.end(), [](std::uint8_t flag) { return flag != 0; });
}

/// Ways to valid elements: options that let vertices be inserted, where that may help, and those that let the surface
/// give way.
std::vector<std::string> remedies_for(const TetMesh& mesh, const Options& options, const CurvedFailure& failure) {
  std::vector<std::string> remedies;
  // Where a face of the surface is folded, no inner vertex helps.
  const bool inside = failure.folded.empty();
  if (inside && options.keep_vertices) {
    remedies.emplace_back("let vertices be inserted (without keep_vertices)");
  } else if (inside && options.data != DataTransfer::carry) {
    remedies.emplace_back("let vertices be inserted (data=carry)");
  }
  if (!options.straighten && mesh.periodic.empty()) {
    remedies.emplace_back("let mid-side nodes of the surface move (straighten=true)");
  }
  if (has_frozen(mesh, options)) remedies.emplace_back("free frozen and required entities there");
  remedies.emplace_back("mesh the surface more finely there");
  return remedies;
}

std::string joined(const std::vector<std::string>& remedies) {
  std::string text;
  for (std::size_t i = 0; i < remedies.size(); ++i) {
    text += (i == 0 ? "" : i + 1 < remedies.size() ? ", " : ", or ") + remedies[i];
  }
  return text;
}

}  // namespace

void check_curved_input(const TetMesh& mesh, const Options& options) {
  check_options(options);
  if (!options.only_below.empty()) {
    throw OptionError("only_below: curved second-order elements are relaxed wherever they are; leave it out");
  }
  if (options.data == DataTransfer::conserve) {
    throw OptionError(
        "data=conserve intersects straight tetrahedra, and this mesh has curved ones; use data=interpolate");
  }
  if (options.straighten && !mesh.periodic.empty()) {
    throw OptionError("straighten=true: mid-side nodes of periodic vertices would no longer match; leave it out");
  }
  if (const ValidationReport report = validate(mesh, options.threads); !report.ok()) {
    throw MeshError(
        "the straight tetrahedra of a curved mesh have to be valid first (convert them to straight ones, in C++ by an "
        "empty curved_edges, and untangle these): " +
        report.message(false));
  }
}

void refuse_curved(const TetMesh& mesh, const Options& options, const CurvedFailure& failure) {
  if (failure.is_stopped) throw UntangleError(failure.invalid, failure.left, UntangleError::Reason::stopped, true);
  const Index first = failure.folded.empty() ? failure.left[0] : failure.folded[0];
  const Point3 place = TetMeshView(mesh).centroid(first);
  throw UntangleError(failure.invalid, failure.left, failure.folded, place,
                      joined(remedies_for(mesh, options, failure)));
}

}  // namespace tetune
