// SPDX-License-Identifier: Apache-2.0
#include "reference/generate.hpp"

#include <random>

#include "backend/cpu.hpp"
#include "math/orient.hpp"
#include "mesh/connect.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune::reference {
namespace {

/// The six paths along the axes from one corner of a cell to the opposite one; the last three are odd permutations.
constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

Index lattice_vertex(int n, const std::array<int, 3>& at) { return (at[2] * (n + 1) + at[1]) * (n + 1) + at[0]; }

/// Calls f({i, j, k}) for 0 <= i, j, k < n with i varying fastest.
template <class F>
void for_each_cell(int n, const F& f) {
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) f(std::array<int, 3>{i, j, k});
    }
  }
}

/// The tetrahedra before and after a 2-3 flip of the face between two tetrahedra.
struct Flip23 {
  Tet before[2], after[3];

  Flip23(const Tet& t, int face, const Tet& other, int other_face) : before{t, other} {
    const Index a = t[face];
    const Index b = other[other_face];
    const Index v[3] = {t[face_vertex(face, 0)], t[face_vertex(face, 1)], t[face_vertex(face, 2)]};
    for (int m = 0; m < 3; ++m) after[m] = {{a, v[m], v[(m + 1) % 3], b}};
  }
  /// Whether each new volume is at least 1e-4 of the sum of the old ones.
  bool is_valid(const TetMeshView& mesh) const {
    const auto volume = [&mesh](const Tet& t) {
      return orient(mesh.position(t[0]), mesh.position(t[1]), mesh.position(t[2]), mesh.position(t[3])).det;
    };
    const double min_volume = 1e-4 * (volume(before[0]) + volume(before[1]));
    return volume(after[0]) >= min_volume && volume(after[1]) >= min_volume && volume(after[2]) >= min_volume;
  }
};

std::array<Index, 4> to_array(const Tet& t) { return {t[0], t[1], t[2], t[3]}; }

}  // namespace

TetMesh lattice(int n, double jitter, std::uint32_t seed) {
  TetMesh m;
  std::mt19937 random(seed);
  for_each_cell(n + 1, [&](const std::array<int, 3>& at) {
    Point3 p{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double shift = jitter * (2 * (static_cast<double>(random()) / 4294967295.0) - 1);
      p[a] = (at[a] + (at[a] > 0 && at[a] < n ? shift : 0)) / n;
    }
    m.points.push_back(p);
  });
  m.tets.reserve(to_size_t(Size{6} * n * n * n));
  for_each_cell(n, [&](const std::array<int, 3>& cell) {
    for (int p = 0; p < 6; ++p) {
      std::array<int, 3> at = cell;
      std::array<Index, 4> tet{lattice_vertex(n, at), 0, 0, 0};
      for (std::size_t s = 0; s < 3; ++s) {
        ++at[to_size_t(kPaths[p][s])];
        tet[s + 1] = lattice_vertex(n, at);
      }
      if (p >= 3) std::swap(tet[2], tet[3]);
      m.tets.push_back(tet);
    }
  });
  m.point_tags.assign(m.points.size(), 0);
  m.tet_tags.assign(m.tets.size(), 0);
  return m;
}

TetMesh scrambled(TetMesh mesh, int rounds, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (int round = 0; round < rounds; ++round) {
    const backend::Cpu cpu(1);
    WorkMesh<backend::Cpu> work = upload_mesh(cpu, mesh);
    build_adjacency(cpu, work);
    const Span<FaceAdjacency> adjacency = work.view().tet2tet;
    std::vector<char> flags(mesh.tets.size(), 0);
    const Span<char> used = span_of(flags);
    for (Index t = 0; t < used.size(); ++t) {
      for (int f = 0; f < 4; ++f) {
        const HalfFace across = adjacency[t][f];
        if (across == kNoHalfFace || random() % 2 == 0) continue;
        const Index other = tet_of(across);
        const int tag = span_of(mesh.tet_tags)[t];
        if (other < t || used[t] != 0 || used[other] != 0 || tag != span_of(mesh.tet_tags)[other]) continue;
        const TetMeshView view(mesh);
        const Flip23 flip(view.tet(t), f, view.tet(other), face_of(across));
        if (!flip.is_valid(view)) continue;
        used[t] = used[other] = 1;
        span_of(mesh.tets)[t] = to_array(flip.after[0]);
        span_of(mesh.tets)[other] = to_array(flip.after[1]);
        mesh.tets.push_back(to_array(flip.after[2]));
        mesh.tet_tags.push_back(tag);
      }
    }
  }
  return mesh;
}

}  // namespace tetune::reference
