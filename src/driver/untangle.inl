// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "driver/working_set.inl"
#include "driver/worst.inl"

/// Makes every volume positive: vertices move under an energy that does not end where a volume does (docs/method.md,
/// "Untangling").
namespace tetune {
namespace untangle_detail {

/// Rounds begin as soft as these in turn, as what is stuck at one softness comes free at another; each sweep is harder
/// by a factor.
inline constexpr double kSoft[] = {0.3, 0.9, 3, 0.09};
inline constexpr double kHarder = 0.7;
inline constexpr int kSweeps = 16;
inline constexpr int kRounds = 12;
/// Not before this round: where much is tangled flips make knots that no position of the vertices undoes.
inline constexpr int kFirstFlips = 2;

/// Its volume is not certified positive.
struct IsTangled {
  MeshView mesh;
  TETUNE_HD bool operator()(Size t) const { return mesh.alive(t) && working_set_detail::NotCertified{mesh}(t); }
};

/// Flags the vertices of those, and no others; returns how many there are.
template <class Backend>
Size flag_tangled(const Backend& par, WorkMesh<Backend>& mesh, Span<std::uint8_t> flags) {
  const auto tets = find_tets(par, mesh, IsTangled{mesh.view()});
  par.fill(flags, std::uint8_t{0});
  flag_corners(par, mesh, tets.span(), flags);
  return tets.size();
}

/// The slots whose volume is not positive in exact arithmetic.
template <class Backend>
std::vector<Index> exactly_tangled(const Backend& par, WorkMesh<Backend>& mesh) {
  std::vector<Index> slots = find_tets(par, mesh, IsTangled{mesh.view()}).download();
  if (slots.empty()) return slots;
  const std::vector<Point> points = mesh.points.download();
  const std::vector<Tet> tets = mesh.tet2vertex.download();
  const auto positive = [&](Index slot) {
    std::array<Point3, 4> p;
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& at = points[static_cast<std::size_t>(tets[static_cast<std::size_t>(slot)][static_cast<int>(k)])];
      p[k] = {at.x, at.y, at.z};
    }
    return orient_sign(p[0], p[1], p[2], p[3]) > 0;
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), positive), slots.end());
  return slots;
}

}  // namespace untangle_detail

/// Returns the slots that are still not positive. It stops when `proceed()` says false.
template <class Backend, class Proceed>
std::vector<Index> untangle(const Backend& par, WorkingSet<Backend>& work, const Proceed& proceed) {
  using namespace untangle_detail;
  WorkMesh<Backend>& mesh = work.mesh;
  const EnergyLaw law = mesh.law;
  const Span<std::uint8_t> awake = work.mobilities.awake.span();
  work.mobilities.local = true;
  Size tangled = flag_tangled(par, mesh, awake);
  bool go_on = true;
  for (int round = 0; round < kRounds && tangled > 0 && go_on; ++round) {
    mesh.law = kShapeLaw;
    if (round >= kFirstFlips && work.flips.max_ring > 0) {
      refresh_energy(par, mesh, work.flips);
      activate_all(par, mesh, work.flips);
      activate_around(par, mesh, work.flips, Span<const std::uint8_t>(awake));
      for (Size flips = 1; flips > 0 && work.flips.active.size() > 0;) {
        flips = flip_pass(par, mesh, work.flips, awake).flips();
      }
      tangled = flag_tangled(par, mesh, awake);
    }
    build_rings(par, mesh, work.rings);
    color_vertices(par, work.rings.view(), work.mobilities.kind.span(), work.coloring, work.mobilities.stars());
    mesh.law.softness = kSoft[static_cast<std::size_t>(round) % std::size(kSoft)];
    for (int sweep = 0; sweep < kSweeps && tangled > 0 && go_on; ++sweep) {
      flag_neighbours(par, mesh, awake);
      soft_sweep(par, mesh, work.rings.view(), work.coloring, work.mobilities, NewtonStep{1, 1e-10});
      tangled = flag_tangled(par, mesh, awake);
      mesh.law.softness *= kHarder;
      go_on = proceed();
    }
  }
  mesh.law = law;
  work.mobilities.local = false;
  par.fill(awake, std::uint8_t{1});
  return exactly_tangled(par, mesh);
}

}  // namespace tetune
