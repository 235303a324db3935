// SPDX-License-Identifier: Apache-2.0
#include "mesh/tet_orientation.hpp"

#include <algorithm>
#include <numeric>

#include "backend/cpu.hpp"
#include "math/orient.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/validate_arrays.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The error bound below which a volume is tiny. The bound depends on the order of the vertices, which flips choose
/// freely: if it is above this in one order, it is above kOrientBound * kOrientUnderflow / 8 in every order.
constexpr double kTinyBound = 1e-270;

struct ComputeSign {
  const TetMeshView& mesh;
  Span<std::int8_t> signs;
  void operator()(Size t) const {
    mesh.prefetch_ahead(t);
    const Tet tet = mesh.tet(t);
    const Orient o = orient(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
    if (o.certified()) {
      signs[t] = 1;
    } else if (is_certified(-o.det, o.bound)) {
      signs[t] = -1;
    } else {
      const Span<const Point3> p = mesh.points;
      const int sign = orient_sign(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]);
      signs[t] = sign > 0 && !(o.bound > kTinyBound) ? kTinyVolume : static_cast<std::int8_t>(sign);
    }
  }
};

/// For each tetrahedron the tetrahedra across its faces, and whether both list the common face in opposite senses.
class Neighbors {
 public:
  struct Neighbor {
    Index tet = -1;
    bool opposite_sense = false;
  };

  explicit Neighbors(const TetMesh& mesh) : neighbors_(mesh.tets.size()), counts_(mesh.tets.size(), 0) {
    for_each_face(sorted_half_faces(mesh), [this](auto begin, auto end) {
      if (end - begin != 2) return;
      add(begin[0], begin[1]);
      add(begin[1], begin[0]);
    });
  }
  Span<const Neighbor> of(Index t) const {
    const auto tet = to_size_t(t);
    return {neighbors_[tet].data(), counts_[tet]};
  }

 private:
  void add(const SortedHalfFace& from, const SortedHalfFace& to) {
    const auto tet = to_size_t(from.tet);
    neighbors_[tet][counts_[tet]++] = {to.tet, from.odd != to.odd};
  }

  std::vector<std::array<Neighbor, 4>> neighbors_;
  std::vector<std::uint8_t> counts_;
};

/// Returns for each tetrahedron 1 if it has to be turned so that neighbors list their common face in opposite senses
/// and each connected part has a positive volume. Where no choice is consistent, neighbors keep disagreeing.
std::vector<std::uint8_t> find_tets_to_turn(const TetMesh& mesh) {
  const Neighbors neighbors(mesh);
  constexpr std::uint8_t kUnvisited = 2;
  std::vector<std::uint8_t> result(mesh.tets.size(), kUnvisited);
  const Span<std::uint8_t> turned = span_of(result);
  const TetMeshView view(mesh, unit_scale(mesh));
  std::vector<Index> part;
  for (Index seed = 0; seed < turned.size(); ++seed) {
    if (turned[seed] != kUnvisited) continue;
    turned[seed] = 0;
    part.assign(1, seed);
    double volume = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Index t = part[i];
      const double v = view.six_volume(view.tet(t));
      volume += turned[t] != 0 ? -v : v;
      const auto across = neighbors.of(t);
      for (Size f = 0; f < across.size(); ++f) {
        std::uint8_t& neighbor = turned[across[f].tet];
        if (neighbor != kUnvisited) continue;
        neighbor = across[f].opposite_sense ? turned[t] : 1 - turned[t];
        part.push_back(across[f].tet);
      }
    }
    if (volume >= 0) continue;
    for (const Index t : part) turned[t] ^= 1;
  }
  return result;
}

}  // namespace

std::vector<std::int8_t> volume_signs(const TetMesh& mesh, int threads) {
  std::vector<std::int8_t> signs(mesh.tets.size());
  const TetMeshView view(mesh, unit_scale(mesh));
  backend::Cpu(threads).for_each(std::ssize(mesh.tets), ComputeSign{view, span_of(signs)});
  return signs;
}

std::vector<SortedHalfFace> sorted_half_faces(const TetMesh& mesh) {
  const TetMeshView view(mesh);
  // Half-faces are grouped by their lowest vertex, and sorted within the groups, which are small.
  std::vector<std::size_t> group_end(mesh.points.size() + 1, 0);
  const auto for_each = [&](const auto& f) {
    for (Index t = 0; t < view.tets.size(); ++t) {
      for (int face = 0; face < 4; ++face) f(face_key(view.tet(t), face), t);
    }
  };
  for_each([&](const FaceKey& key, Index) { ++span_of(group_end)[key.low + 1]; });
  std::partial_sum(group_end.begin(), group_end.end(), group_end.begin());
  std::vector<SortedHalfFace> half_faces(4 * mesh.tets.size());
  for_each([&](const FaceKey& key, Index t) {
    half_faces[span_of(group_end)[key.low]++] = {{key.low, key.middle, key.high}, t, key.odd};
  });
  auto begin = half_faces.begin();
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const auto end = half_faces.begin() + static_cast<std::ptrdiff_t>(group_end[v]);
    std::sort(begin, end, [](const SortedHalfFace& a, const SortedHalfFace& b) {
      return a.vertices != b.vertices ? a.vertices < b.vertices : a.tet < b.tet;
    });
    begin = end;
  }
  return half_faces;
}

std::int64_t orient_uniformly(TetMesh& mesh, int threads) {
  if (mesh.tets.empty() || !validate_arrays(mesh).ok()) return 0;
  const std::vector<std::int8_t> signs = volume_signs(mesh, threads);
  if (std::find(signs.begin(), signs.end(), -1) == signs.end()) return 0;
  const bool all_inverted = *std::max_element(signs.begin(), signs.end()) < 0;
  const std::vector<std::uint8_t> turned =
      all_inverted ? std::vector<std::uint8_t>(mesh.tets.size(), 1) : find_tets_to_turn(mesh);
  const std::int64_t count = std::count(turned.begin(), turned.end(), 1);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t] != 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  }
  if (count == std::ssize(turned)) mesh.listed_inside_out = !mesh.listed_inside_out;
  return count;
}

}  // namespace tetune
