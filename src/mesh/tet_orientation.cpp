// SPDX-License-Identifier: Apache-2.0
#include "mesh/tet_orientation.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "backend/cpu.hpp"
#include "math/mix_bits.hpp"
#include "math/orient.hpp"
#include "mesh/csr.hpp"
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

FaceKey key_of(const TetMeshView& mesh, HalfFace half_face) {
  return face_key(mesh.tet(tet_of(half_face)), face_of(half_face));
}

/// Hashes of the faces of a tetrahedron whose signed values cancel for the two half-faces of a face inside a region.
class FaceHashes {
 public:
  FaceHashes(const Tet& tet, int region) : region_(mix_bits(std::uint32_t(region)) | 1) {
    for (int k = 0; k < 4; ++k) vertices_[to_size_t(k)] = mix_bits(std::uint32_t(tet[k]));
  }
  /// Changes its sign with the sense in which the face is listed. It is a sum of antisymmetric values g of the edges of
  /// the face, g(a, b) = a b (b - a): over the faces across from an inner vertex, a closed surface, these cancel.
  std::uint64_t signed_hash(int face) const {
    const std::uint64_t a = of(face, 0);
    const std::uint64_t b = of(face, 1);
    const std::uint64_t c = of(face, 2);
    return region_ * (b - a) * (c - a) * (c - b);
  }
  /// The hash of a face; equal for both of its half-faces.
  std::uint64_t key(int face) const { return of(face, 0) + of(face, 1) + of(face, 2); }

 private:
  std::uint64_t of(int face, int k) const { return vertices_[to_size_t(face_vertex(face, k))]; }

  std::array<std::uint64_t, 4> vertices_;
  std::uint64_t region_;
};

/// Finds the half-faces of the boundary and between regions, and few others. Sums of hashes that are 0 inside a region
/// are formed first at vertices, then at faces whose vertices are all at the surface.
class SurfaceFilter {
 public:
  SurfaceFilter(const TetMesh& mesh, const TetMeshView& view, const backend::Cpu& cpu)
      : view_(view), regions_(span_of(mesh.tet_tags)), cpu_(cpu) {}

  std::vector<HalfFace> run() {
    at_vertices_ = sum_up(view_.tets.size(), view_.points.size(), [this](Size t, Span<std::uint64_t> sums) {
      const FaceHashes faces = hashes(t);
      for (int k = 0; k < 4; ++k) sums[view_.tets[t][to_size_t(k)]] += faces.signed_hash(k);
    });
    std::vector<Index> tets(to_size_t(view_.tets.size()));
    const auto has_face = [this](Size t) { return has_surface_face(t); };
    tets.resize(to_size_t(cpu_.compact(std::ssize(tets), has_face, span_of(tets))));
    // About a slot per half-face.
    const Size bits = std::bit_width(4 * tets.size() + 1);
    shift_ = 64 - bits;
    at_faces_ = sum_up(std::ssize(tets), Size{1} << bits, [&](Size i, Span<std::uint64_t> sums) {
      const Index t = span_of(tets)[i];
      const FaceHashes faces = hashes(t);
      for (int f = 0; f < 4; ++f) {
        if (has_surface_vertices(view_.tet(t), f)) sums[slot_of(faces.key(f))] += faces.signed_hash(f);
      }
    });
    std::vector<unsigned> faces(tets.size());  // a bit per face
    cpu_.for_each(std::ssize(tets), [&](Size i) { span_of(faces)[i] = surface_faces(span_of(tets)[i]); });
    std::vector<HalfFace> found;
    for (Size i = 0; i < std::ssize(tets); ++i) {
      for (int f = 0; f < 4; ++f) {
        if ((span_of(faces)[i] >> f & 1) != 0) found.push_back(make_half_face(span_of(tets)[i], f));
      }
    }
    return found;
  }

 private:
  /// Calls add(i, sums) for each i in [0, n), with `sums` that no other thread changes, and returns the total of all
  /// sums.
  template <class Add>
  std::vector<std::uint64_t> sum_up(Size n, Size size, const Add& add) const {
    constexpr Size kMaxParts = 8;
    const Size parts = std::clamp<Size>(n / std::max<Size>(1, size), 1, std::min<Size>(kMaxParts, cpu_.threads()));
    std::vector<std::vector<std::uint64_t>> sums(to_size_t(parts));
    cpu_.for_parts(parts, [&](Size part) {
      std::vector<std::uint64_t>& own = span_of(sums)[part];
      own.assign(to_size_t(size), 0);
      for (Size i = n * part / parts; i < n * (part + 1) / parts; ++i) add(i, span_of(own));
    });
    std::vector<std::uint64_t> total = std::move(sums.front());
    for (std::size_t part = 1; part < sums.size(); ++part) {
      cpu_.for_each(size, [&](Size i) { span_of(total)[i] += span_of(sums[part])[i]; });
    }
    return total;
  }
  FaceHashes hashes(Size t) const { return {view_.tet(t), regions_[t]}; }
  bool is_inner(Index vertex) const { return span_of(at_vertices_)[vertex] == 0; }
  Size slot_of(std::uint64_t key) const { return key >> shift_; }

  bool has_surface_face(Size t) const {
    const auto& tet = view_.tets[t];
    return std::count_if(tet.begin(), tet.end(), [this](Index v) { return is_inner(v); }) <= 1;
  }
  bool has_surface_vertices(const Tet& tet, int face) const {
    for (int k = 0; k < 3; ++k) {
      if (is_inner(tet[face_vertex(face, k)])) return false;
    }
    return true;
  }
  unsigned surface_faces(Index t) const {
    const FaceHashes faces = hashes(t);
    unsigned found = 0;
    for (int f = 0; f < 4; ++f) {
      const bool is_candidate = has_surface_vertices(view_.tet(t), f) && span_of(at_faces_)[slot_of(faces.key(f))] != 0;
      if (is_candidate) found |= 1U << f;
    }
    return found;
  }

  const TetMeshView& view_;
  Span<const int> regions_;
  const backend::Cpu& cpu_;
  std::vector<std::uint64_t> at_vertices_;
  std::vector<std::uint64_t> at_faces_;  ///< each slot for the faces whose keys begin with the same bits
  Size shift_ = 0;
};

SortedHalfFace make_sorted(const TetMeshView& mesh, HalfFace half_face) {
  const FaceKey key = key_of(mesh, half_face);
  return {{key.low, key.middle, key.high}, tet_of(half_face), key.odd};
}

/// Sorts the half-faces of the same lowest vertex.
struct SortGroup {
  Span<const std::uint32_t> offsets;
  Span<SortedHalfFace> half_faces;
  void operator()(Size vertex) const {
    SortedHalfFace* begin = half_faces.data();
    std::sort(begin + offsets[vertex], begin + offsets[vertex + 1],
              [](const SortedHalfFace& a, const SortedHalfFace& b) {
                const auto& [low_a, middle_a, high_a] = a.vertices;
                const auto& [low_b, middle_b, high_b] = b.vertices;
                if (middle_a != middle_b) return middle_a < middle_b;
                return high_a != high_b ? high_a < high_b : a.tet < b.tet;
              });
  }
};

/// Sorts the half-faces half_face_at(0) to half_face_at(count - 1): they are grouped by their lowest vertex and sorted
/// within the groups, which are small.
template <class HalfFaceAt>
std::vector<SortedHalfFace> sort_half_faces(const TetMeshView& mesh, Size count, const HalfFaceAt& half_face_at,
                                            const backend::Cpu& cpu) {
  backend::Cpu::Buffer<std::uint32_t> offsets;
  backend::Cpu::Buffer<SortedHalfFace> half_faces;
  const Size vertices = mesh.points.size();
  const auto lowest_vertex = [&](Size i) { return Size{key_of(mesh, half_face_at(i)).low}; };
  const auto make = [&](Size i) { return make_sorted(mesh, half_face_at(i)); };
  build_csr_of<backend::Cpu, decltype(lowest_vertex), decltype(make), SortedHalfFace>(
      cpu, {.rows = vertices, .items = count, .row_of = lowest_vertex, .make = make}, offsets, half_faces);
  cpu.for_each(vertices, SortGroup{offsets, half_faces});
  return half_faces.download();
}

/// For each tetrahedron the tetrahedra across its faces, and whether both list the common face in opposite senses.
class Neighbors {
 public:
  struct Neighbor {
    Index tet = -1;
    bool opposite_sense = false;
  };

  Neighbors(const TetMesh& mesh, int threads) : neighbors_(mesh.tets.size()), counts_(mesh.tets.size(), 0) {
    for_each_face(sorted_half_faces(mesh, threads), [this](auto begin, auto end) {
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
/// and each connected part has a positive volume. Where no choice is consistent, as in a Moebius band, some
/// neighbors stay inconsistent.
std::vector<std::uint8_t> find_tets_to_turn(const TetMesh& mesh, int threads) {
  const Neighbors neighbors(mesh, threads);
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

std::vector<SortedHalfFace> sorted_half_faces(const TetMesh& mesh, int threads) {
  const TetMeshView view(mesh);
  const auto all = [](Size i) { return HalfFace(i); };
  return sort_half_faces(view, 4 * view.tets.size(), all, backend::Cpu(threads));
}

std::vector<SortedHalfFace> half_faces_at_surface(const TetMesh& mesh, int threads) {
  const TetMeshView view(mesh);
  const backend::Cpu cpu(threads);
  const std::vector<HalfFace> found = SurfaceFilter(mesh, view, cpu).run();
  const auto listed = [&](Size i) { return span_of(found)[i]; };
  return sort_half_faces(view, std::ssize(found), listed, cpu);
}

std::vector<std::array<Index, 3>> find_surface_faces(const TetMesh& mesh) {
  std::vector<std::array<Index, 3>> faces;
  for_each_surface_face(mesh, 1, [&](const SortedHalfFace& face, bool) { faces.push_back(face.vertices); });
  return faces;
}

std::int64_t orient_uniformly(TetMesh& mesh, int threads) {
  if (mesh.tets.empty() || !validate_arrays(mesh).ok()) return 0;
  const std::vector<std::int8_t> signs = volume_signs(mesh, threads);
  if (std::find(signs.begin(), signs.end(), -1) == signs.end()) return 0;
  const bool all_inverted = *std::max_element(signs.begin(), signs.end()) < 0;
  const std::vector<std::uint8_t> turned =
      all_inverted ? std::vector<std::uint8_t>(mesh.tets.size(), 1) : find_tets_to_turn(mesh, threads);
  const std::int64_t count = std::count(turned.begin(), turned.end(), 1);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t] != 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  }
  if (count == std::ssize(turned)) mesh.listed_inside_out = !mesh.listed_inside_out;
  return count;
}

bool is_even_permutation(const std::array<Index, 4>& a, const std::array<Index, 4>& b) {
  int inversions = 0;
  std::array<std::ptrdiff_t, 4> place;
  for (std::size_t k = 0; k < 4; ++k) place[k] = std::find(b.begin(), b.end(), a[k]) - b.begin();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) inversions += place[i] > place[j] ? 1 : 0;
  }
  return inversions % 2 == 0;
}

}  // namespace tetune
