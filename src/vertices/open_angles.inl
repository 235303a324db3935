// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocate/reduce_colors.hpp"
#include "vertices/angle_ring.hpp"
#include "vertices/open_angles.hpp"

namespace tetune {
namespace open_angles_detail {

struct MovedCount {
  Size count = 0;
  TETUNE_HD void merge(const MovedCount& other) { count += other.count; }
};

struct OpenAngle {
  static constexpr Size kGrain = 16;
  MeshView mesh;
  RingsView rings;
  Span<const Index> vertices;
  Span<const Mobility> kind;
  Span<const Vec3> axis;
  Span<const Leash> leash;
  Span<Site> site;
  ReferenceView reference;
  double max_deviation;
  Span<const std::uint8_t> flags;
  double enough;

  TETUNE_HD MovedCount operator()(Size i) const {
    const Index v = vertices[i];
    const Size begin = rings.offsets[v];
    const auto count = static_cast<int>(rings.offsets[v + 1] - begin);
    if (flags[v] == 0 || count == 0) return {};
    const AngleRing ring(mesh, rings.faces.data() + begin, count);
    Vec3 x = vec(mesh.points[v]);
    const Leash held = leash.size() == 0 || kind[v] == Mobility::free ? Leash{} : leash[v];
    if (kind[v] == Mobility::curve || kind[v] == Mobility::surface) {
      SlideWay way{reference, DeviationBound(reference, mesh.points, site, v, max_deviation), kind[v], site[v], site[v],
                   held};
      if (!ring.open(x, way, enough)) return {};
      site[v] = way.site;
    } else {
      FreeWay way{{kind[v], axis[v], held}};
      if (!ring.open(x, way, enough)) return {};
    }
    mesh.points[v] = point(x);
    return {1};
  }
};

}  // namespace open_angles_detail

template <class Backend>
Size open_angles(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
                 Mobilities<Backend>& mobilities, Span<const std::uint8_t> flags, double enough) {
  using namespace open_angles_detail;
  return reduce_colors<MovedCount>(par, coloring,
                                   [&](Span<const Index> vertices) {
                                     return OpenAngle{mesh.view(),
                                                      rings,
                                                      vertices,
                                                      mobilities.kind.span(),
                                                      mobilities.axis.span(),
                                                      mobilities.leashes(),
                                                      mobilities.site.span(),
                                                      mobilities.reference.view(),
                                                      mobilities.max_deviation,
                                                      flags,
                                                      enough};
                                   })
      .count;
}

}  // namespace tetune
