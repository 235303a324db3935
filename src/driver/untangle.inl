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

/// A mesh as the host sees it.
struct HostMesh {
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<Links> links;

  template <class Backend>
  explicit HostMesh(const WorkMesh<Backend>& mesh)
      : points(mesh.points.download()), tets(mesh.tet2vertex.download()), links(mesh.tet2tet.download()) {}

  /// Calls f(slot, tetrahedron, face, normal) for the faces of the boundary.
  template <class F>
  void for_boundary_faces(const F& f) const {
    for (std::size_t slot = 0; slot < tets.size(); ++slot) {
      if (tets[slot][0] == kFreeSlot) continue;
      for (int face = 0; face < 4; ++face) {
        if (links[slot][face] != kNoLink) continue;
        Vec3 corner[3];
        for (int k = 0; k < 3; ++k) {
          corner[k] = vec(points[static_cast<std::size_t>(tets[slot][face_vertex(face, k)])]);
        }
        f(static_cast<Index>(slot), tets[slot], face, cross(corner[1] - corner[0], corner[2] - corner[0]));
      }
    }
  }
};

/// Those of some slots whose volume is not positive in exact arithmetic.
inline std::vector<Index> exactly_tangled(const HostMesh& mesh, std::vector<Index> slots) {
  const auto positive = [&](Index slot) {
    std::array<Point3, 4> p;
    for (std::size_t k = 0; k < 4; ++k) {
      const Tet& tet = mesh.tets[static_cast<std::size_t>(slot)];
      const Point& at = mesh.points[static_cast<std::size_t>(tet[static_cast<int>(k)])];
      p[k] = {at.x, at.y, at.z};
    }
    return orient_sign(p[0], p[1], p[2], p[3]) > 0;
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), positive), slots.end());
  return slots;
}

/// For each vertex that keeps to a plane, whether the faces of the boundary around it do not all face the same way.
inline std::vector<std::uint8_t> folded_vertices(const HostMesh& mesh, const std::vector<Mobility>& kind) {
  std::vector<Vec3> first(kind.size(), Vec3{});
  std::vector<std::uint8_t> folded(kind.size(), 0);
  mesh.for_boundary_faces([&](Index, const Tet& tet, int face, const Vec3& normal) {
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(tet[face_vertex(face, k)]);
      if (kind[v] != Mobility::plane) continue;
      if (dot(first[v], first[v]) == 0) first[v] = normal;
      if (dot(first[v], normal) < 0) folded[v] = 1;
    }
  });
  return folded;
}

/// The slots with a face of the boundary that folds over the rim of its plane, where it did not before: the volumes are
/// positive, but the surface is another one.
inline std::vector<Index> newly_folded(const HostMesh& mesh, const std::vector<Mobility>& kind,
                                       const std::vector<std::uint8_t>& before) {
  const std::vector<std::uint8_t> folded = folded_vertices(mesh, kind);
  std::vector<Index> slots;
  if (std::find(folded.begin(), folded.end(), 1) == folded.end()) return slots;
  mesh.for_boundary_faces([&](Index slot, const Tet& tet, int face, const Vec3&) {
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(tet[face_vertex(face, k)]);
      if (folded[v] != 0 && before[v] == 0) slots.push_back(slot);
    }
  });
  return slots;
}

}  // namespace untangle_detail

/// Returns the slots that are still not positive, or whose surface folds. It stops when `proceed()` says false.
template <class Backend, class Proceed>
std::vector<Index> untangle(const Backend& par, WorkingSet<Backend>& work, const Proceed& proceed) {
  using namespace untangle_detail;
  WorkMesh<Backend>& mesh = work.mesh;
  const EnergyLaw law = mesh.law;
  const Span<std::uint8_t> awake = work.mobilities.awake.span();
  work.mobilities.local = true;
  const std::vector<Mobility> kind = work.mobilities.kind.download();
  const std::vector<std::uint8_t> folded = folded_vertices(HostMesh(mesh), kind);
  Size tangled = flag_tangled(par, mesh, awake);
  bool go_on = true;
  for (int round = 0; round < kRounds && tangled > 0 && go_on; ++round) {
    mesh.law = kShapeLaw;
    if (round >= kFirstFlips && work.flips.max_ring > 0) {
      refresh_energy(par, mesh, work.flips);
      activate_all(par, mesh, work.flips);
      activate_around(par, mesh, work.flips, Span<const std::uint8_t>(awake));
      flip_until_none(par, mesh, work.flips, awake);
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
  const HostMesh result(mesh);
  const std::vector<Index> left = exactly_tangled(result, find_tets(par, mesh, IsTangled{mesh.view()}).download());
  return left.empty() ? newly_folded(result, kind, folded) : left;
}

}  // namespace tetune
