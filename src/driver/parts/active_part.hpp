// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "boundary/constraints.hpp"
#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

/// Options::only_below: the tetrahedra that may change are a mesh of their own while they are optimized, and then take
/// their place in the whole mesh again.
namespace tetune {

/// The tetrahedra that may change.
struct ActiveTets {
  std::vector<std::uint8_t> flags;  ///< 1 per tetrahedron that may change
  std::int64_t bad = 0;             ///< number of those that miss a limit
  std::int64_t count = 0;           ///< number of those that may change
};

/// Returns the flagged tetrahedra that are not locked, and all within `rings` around them. A flagged locked tetrahedron
/// whose volume is not positive is included, so that the part is refused with it.
ActiveTets activate(const TetMesh& mesh, std::vector<std::uint8_t> flags, const Constraints& constraints, int rings);

/// Finds the tetrahedra that miss a limit, but for locked ones, and those within Options::rings around them. Inverted
/// and flat tetrahedra miss every limit.
ActiveTets find_active(const TetMesh& mesh, const Constraints& constraints, const Options& options);

/// Whether the lists of a mesh are of features. It depends on the whole mesh: see count_unsupported().
struct ListedFeatures {
  bool corners = false;    ///< the listed corners do not move
  bool edges = false;      ///< tagged edges are feature lines
  bool line_ends = false;  ///< their ends and junctions do not move
};

/// A part of a mesh, optimized for itself. Vertices that tetrahedra outside the part have are frozen. Faces between the
/// part and the rest are required triangles with a tag of their own, so that no vertex slides onto them.
///
/// A vertex that may move has all its tetrahedra in the part, so that it has the same degrees of freedom as in the
/// whole mesh.
struct ActivePart {
  TetMesh mesh;
  Options options;  ///< for the part
  std::vector<Index> vertex2whole, tet2whole, triangle2whole, edge2whole;
  /// Whether a listed triangle stays although the result of the part lacks it: an element outside the part has it.
  std::vector<std::uint8_t> triangle_stays;
  /// Whether a listed edge stays although the result of the part lacks it: it constrains, or an element outside the
  /// part has it (lasting_edges()).
  std::vector<std::uint8_t> edge_stays;
  bool is_moved = false;  ///< its vertices followed targets
};

/// The numbers in the whole mesh of the vertices and tetrahedra of the result of a part.
struct PartMaps {
  std::vector<Index> vertex2whole, tet2whole;
};

ActivePart take_part(const TetMesh& mesh, const ActiveTets& active, const Constraints& constraints,
                     const ListedFeatures& features, const Options& options);

/// Puts the optimized part in its place. Entries of the whole mesh that are not in the part, and those that are the
/// same in the result, keep their numbers; others take the numbers that became free, in increasing order, and then new
/// ones behind all others. Where there are fewer than before, the gaps are closed, and the order stays. No more
/// vertices may have been removed than inserted.
///
/// `report` is that of the part, and becomes one of the whole mesh; its targets count the other tetrahedra as locked.
/// Returns where the entries of the result of the part are. When it throws, the mesh is as before. `stop_transfer`: as
/// of replace_mesh().
PartMaps replace_part(TetMesh& mesh, ActivePart part, const ActiveTets& active,
                      const std::function<bool()>& stop_transfer, Report& report);

}  // namespace tetune
