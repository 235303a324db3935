// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "driver/slide_on.hpp"
#include "par/cpu.hpp"

namespace tetune {
namespace {

/// The reference at the start, in the caller's numbers and order.
SlideSurface tell_surface(const WorkingSet<par::Cpu>& work, const std::vector<Point3>& points) {
  const ReferenceSurface<par::Cpu>& reference = work.mobilities.reference;
  const std::vector<Index> vertex2original = work.mesh.vertex2original.download();
  const auto to_original = [&vertex2original](Index v) {
    return v < 0 ? v : vertex2original[static_cast<std::size_t>(v)];
  };
  SlideSurface told;
  told.points = points;
  told.kind.resize(points.size());
  told.line.resize(points.size());
  told.site.resize(points.size(), kNoSite);
  for (std::size_t w = 0; w < points.size(); ++w) {
    const auto v = static_cast<std::size_t>(vertex2original[w]);
    const auto at = static_cast<Size>(w);
    told.kind[v] = reference.kind.span()[at];
    const LineVertex line = reference.line.span()[at];
    told.line[v] = {to_original(line.next[0]), to_original(line.next[1])};
    if (told.kind[v] != Mobility::free) told.site[v][0] = vertex2original[w];
  }
  for (Size t = 0; t < reference.triangles.size(); ++t) {
    const SurfaceTriangle triangle = reference.triangles.span()[t];
    told.triangles.push_back({to_original(triangle.v[0]), to_original(triangle.v[1]), to_original(triangle.v[2])});
    std::uint8_t walls = 0;
    for (Size k = 0; k < 3; ++k) {
      if (reference.across.span()[3 * t + k] == kWall) walls |= static_cast<std::uint8_t>(1U << k);
    }
    told.walls.push_back(walls);
  }
  return told;
}

}  // namespace

template Report optimize_on(const par::Cpu&, TetMesh&, const Options&, const Context&, SlideSurface*);

SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options) {
  const par::Cpu par(options.threads);
  WorkingSet<par::Cpu> work;
  Report report;
  load(par, mesh, options, nullptr, work, report);
  return tell_surface(work, mesh.points);
}
}  // namespace tetune
