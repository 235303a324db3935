// SPDX-License-Identifier: Apache-2.0
#include "measure.hpp"

#include <algorithm>
#include <utility>

#include "driver/distributed_interface.hpp"

namespace tetune::mpi {

Quality quality_of_all(MPI_Comm comm, const TetMesh& part, int threads) {
  Quality q;
  collective_try(comm, [&] { q = quality(part, threads); });
  const auto tets = double(q.tets);
  const bool some = q.tets > 0;
  const auto minima =
      all_reduce(comm, std::vector<double>{some ? q.dihedral_min : 180, some ? q.mean_ratio_min : 1}, MPI_MIN);
  const auto maxima = all_reduce(comm, std::vector<double>{q.dihedral_max, q.eta_max}, MPI_MAX);
  std::vector<double> sums{q.eta_sum, q.shape_sum, q.volume, q.mean_ratio * tets, q.dihedral_mean * tets};
  for (const double share : q.histogram) sums.push_back(share * tets);
  sums = all_reduce(comm, std::move(sums), MPI_SUM);
  Quality all;
  all.tets = all_reduce(comm, q.tets, MPI_SUM);
  if (all.tets == 0) return all;
  const auto count = double(all.tets);
  all.dihedral_min = minima[0];
  all.mean_ratio_min = minima[1];
  all.dihedral_max = maxima[0];
  all.eta_max = maxima[1];
  all.eta_sum = sums[0];
  all.shape_sum = sums[1];
  all.volume = sums[2];
  all.mean_ratio = sums[3] / count;
  all.dihedral_mean = sums[4] / count;
  for (std::size_t b = 0; b < all.histogram.size(); ++b) all.histogram[b] = sums[5 + b] / count;
  return all;
}

TetMesh at_first_cut(const Part& part) {
  TetMesh mesh;
  mesh.points = part.mesh.points;
  mesh.point_tags = part.mesh.point_tags;
  for (std::size_t t = 0; t < part.mesh.tets.size(); ++t) {
    const auto& tet = part.mesh.tets[t];
    const bool touches =
        std::any_of(tet.begin(), tet.end(), [&part](Index v) { return (item(part.vertex_flags, v) & kFirstCut) != 0; });
    if (!touches) continue;
    mesh.tets.push_back(tet);
    mesh.tet_tags.push_back(part.mesh.tet_tags[t]);
  }
  return mesh;
}

bool orient_all(MPI_Comm comm, Part& part) {
  const auto& x = part.mesh.points;
  const double scale = unit_scale(all_reduce(comm, largest_coordinate(x), MPI_MAX));
  Id positive = 0;
  for (const auto& tet : part.mesh.tets) {
    std::array<Point3, 3> e;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        e[i][k] = scale * item(x, tet[i + 1])[k] - scale * item(x, tet[0])[k];
      }
    }
    const double volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                          e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    if (volume > 0) ++positive;
  }
  if (all_reduce(comm, positive, MPI_SUM) > 0) return false;
  for (auto& tet : part.mesh.tets) std::swap(tet[2], tet[3]);
  return true;
}

}  // namespace tetune::mpi
