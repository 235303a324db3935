// SPDX-License-Identifier: Apache-2.0
#include "quality/smallest_angle.hpp"

#include <vector>

#include "energy/quality_floor.hpp"
#include "math/angle.hpp"
#include "math/elementary.hpp"
#include "quality/shape_loop.hpp"

namespace tetune {
namespace {

/// The largest cotangent of the dihedral angles of one chunk of the tetrahedra.
double max_cot_of_chunk(const TetMeshView& mesh, Size chunk) {
  double max_cot = -kInfeasible;
  const Size end = shape_chunk_begin(mesh.tets.size(), chunk + 1);
  for (Size first = shape_chunk_begin(mesh.tets.size(), chunk); first < end; first += kShapeLanes) {
    Vec3T<ShapePack> p[4];
    load_points(mesh, first, end - 1, p);
    const ShapePack w = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    const ShapePack cots = QualityFloor::dihedral_cots(p, w).max;
    for (int l = 0; l < kShapeLanes; ++l) max_cot = std::max(max_cot, double{cots[l]});
  }
  return max_cot;
}

}  // namespace

double smallest_dihedral(const TetMesh& mesh, int threads) {
  if (mesh.tets.empty()) return 180;
  const TetMeshView view(mesh, unit_scale(mesh));
  std::vector<double> max_cots(to_size_t(shape_chunk_count(view.tets.size())));
  backend::Cpu(threads).for_parts(std::ssize(max_cots),
                                  [&](Size chunk) { span_of(max_cots)[chunk] = max_cot_of_chunk(view, chunk); });
  return kDegreesPerRadian * elementary::atan2(1, *std::max_element(max_cots.begin(), max_cots.end()));
}

}  // namespace tetune
