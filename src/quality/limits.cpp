// SPDX-License-Identifier: Apache-2.0
#include "quality/limits.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "mesh/validate_arrays.hpp"
#include "quality/shape_loop.hpp"

namespace tetune {
namespace {

/// The squared cosine of the smallest dihedral angle of each lane, 0 for an angle of 90 degrees or more, and the
/// volume: much cheaper than all angles.
struct SmallestAngles {
  ShapePack cos2{}, six_volume;

  explicit SmallestAngles(const Vec3T<ShapePack> (&p)[4])
      : six_volume(dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0])) {
    Vec3T<ShapePack> n[4];
    ShapePack area2[4];
    for (int f = 0; f < 4; ++f) {
      const Vec3T<ShapePack>& a = p[face_vertex(f, 0)];
      n[f] = cross(p[face_vertex(f, 1)] - a, p[face_vertex(f, 2)] - a);
      area2[f] = dot(n[f], n[f]);
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const ShapePack cosine = -dot(n[i], n[j]);
        const ShapePack square = cosine * cosine / (area2[i] * area2[j]);
        for (int l = 0; l < kShapeLanes; ++l) {
          // Degenerate faces, whose square is NaN, are found by the volume.
          if (!(cosine[l] <= 0 || square[l] <= cos2[l])) cos2[l] = square[l];
        }
      }
    }
  }
};

/// Whether a shape misses one of the limits, or has no positive volume.
bool misses_any(const TetShape& shape, const std::vector<Target>& limits) {
  const Measures measures = all_measures(shape);
  return !(shape.volume > 0) || std::any_of(limits.begin(), limits.end(), [&](const Target& limit) {
    return misses(limit, value(measures, limit.measure));
  });
}

/// Finds the tetrahedra of a chunk that miss a limit, where all limits are ones of the smallest dihedral angle and
/// `degrees`, at most 90, is the largest: those that are not clearly above it are measured.
void find_small_angles(const TetMeshView& mesh, const std::vector<Target>& limits, double degrees, Size chunk,
                       Span<std::uint8_t> missing) {
  const double cosine = elementary::cos(degrees / kDegreesPerRadian);
  constexpr double kMargin = 1e-9;  // far above the rounding errors of SmallestAngles
  const double clear_cos2 = cosine * cosine - kMargin;
  const Size end = shape_chunk_begin(missing.size(), chunk + 1);
  for (Size first = shape_chunk_begin(missing.size(), chunk); first < end; first += kShapeLanes) {
    Vec3T<ShapePack> p[4];
    load_points(mesh, first, end - 1, p);
    const SmallestAngles angles(p);
    for (int l = 0; l < kShapeLanes && first + l < end; ++l) {
      if (angles.six_volume[l] > 0 && angles.cos2[l] < clear_cos2) continue;
      Vec3 corners[4];
      for (int k = 0; k < 4; ++k) corners[k] = {p[k].x[l], p[k].y[l], p[k].z[l]};
      missing[first + l] = misses_any(TetShape(corners), limits) ? 1 : 0;
    }
  }
}

}  // namespace

std::vector<std::uint8_t> tets_missing_limits(const TetMesh& mesh, const std::vector<Target>& limits, int threads) {
  require_arrays(mesh);
  const TetMeshView view(mesh, unit_scale(mesh));
  double degrees = 0;
  bool small_angles = true;
  for (const Target& limit : limits) {
    small_angles = small_angles && limit.measure == Measure::min_dihedral;
    degrees = std::max(degrees, limit.value);
  }
  std::vector<std::uint8_t> flags(mesh.tets.size(), 0);
  const Span<std::uint8_t> missing = span_of(flags);
  backend::Cpu(threads).for_parts(shape_chunk_count(missing.size()), [&](Size chunk) {
    if (small_angles) return find_small_angles(view, limits, degrees, chunk, missing);
    for_each_shape(view, chunk, [&](const TetShapeT<ShapePack>& shapes, int l, Size t) {
      missing[t] = misses_any(lane(shapes, l), limits) ? 1 : 0;
    });
  });
  return flags;
}

}  // namespace tetune
