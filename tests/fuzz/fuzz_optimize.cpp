// SPDX-License-Identifier: Apache-2.0
// optimize() on any arrays and any options: it throws and leaves the mesh as it was, or returns a valid one.
#include <fuzzer/FuzzedDataProvider.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "fuzz.hpp"

namespace tetune::fuzz {
namespace {

/// Larger meshes take longer and found nothing more.
constexpr int kMaxCells = 3;

/// Numbers of the mesh and the options. Half of all inputs are tame, without values that are refused at once, so that
/// much of the time goes into the optimization; the others are wild.
class Source {
 public:
  Source(const std::uint8_t* data, std::size_t size) : data_(data, size), wild_(data_.ConsumeBool()) {}

  bool wild() const { return wild_; }
  /// One time in n of the wild ones.
  bool wildly(int n) { return wild_ && whole(0, n - 1) == 0; }

  bool flag() { return data_.ConsumeBool(); }
  int whole(int least, int most) { return data_.ConsumeIntegralInRange(least, most); }
  /// Below `n`; of wild inputs sometimes any value.
  Index id(std::size_t n) {
    return n == 0 || wildly(16) ? data_.ConsumeIntegral<Index>() : whole(0, static_cast<int>(n) - 1);
  }
  int tag() { return wildly(16) ? data_.ConsumeIntegral<int>() : whole(0, 3); }
  /// In [-2, 2]; of wild inputs sometimes any double.
  double real() {
    switch (wild_ ? whole(0, 7) : 3) {
      case 0:
        return data_.ConsumeFloatingPoint<double>();
      case 1:
        return data_.PickValueInArray({0.0, -0.0, 1e-300, 1e300, std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::quiet_NaN(), 5e-324, 1e150, 1e-150});
      case 2:
        return whole(-4, 4);
      default:
        return data_.ConsumeFloatingPointInRange(-2.0, 2.0);
    }
  }
  template <class T, std::size_t N>
  T pick(const T (&values)[N]) {
    return data_.PickValueInArray(values);
  }
  std::size_t left() { return data_.remaining_bytes(); }

 private:
  FuzzedDataProvider data_;
  bool wild_;
};

/// n x n x n cells of six tetrahedra.
void add_lattice(TetMesh& mesh, int n) {
  const auto id = [n](const std::array<int, 3>& at) {
    return static_cast<Index>((at[2] * (n + 1) + at[1]) * (n + 1) + at[0]);
  };
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) mesh.points.push_back({1.0 * i, 1.0 * j, 1.0 * k});
    }
  }
  std::array<std::size_t, 3> path{0, 1, 2};
  bool odd = false;
  for (int p = 0; p < 6; ++p, odd = p == 1 || p == 2 || p == 5) {
    for (int cell = 0; cell < n * n * n; ++cell) {
      std::array<int, 3> at{cell % n, cell / n % n, cell / n / n};
      std::array<Index, 4> tet{id(at), 0, 0, 0};
      for (std::size_t s = 0; s < 3; ++s) {
        ++at[path[s]];
        tet[s + 1] = id(at);
      }
      if (odd) std::swap(tet[2], tet[3]);
      mesh.tets.push_back(tet);
    }
    std::next_permutation(path.begin(), path.end());
  }
}

template <std::size_t N>
void add_entities(Source& from, const TetMesh& mesh, std::vector<std::array<Index, N>>& list, std::vector<int>& tags) {
  for (int n = from.whole(0, 8); n > 0; --n) {
    std::array<Index, N> entity{};
    // Corners of one tetrahedron, or of anything.
    const Index tet = from.id(mesh.tets.size());
    const bool one = tet >= 0 && static_cast<std::size_t>(tet) < mesh.tets.size() && from.flag();
    for (std::size_t k = 0; k < N; ++k) {
      entity[k] = one ? mesh.tets[static_cast<std::size_t>(tet)][k] : from.id(mesh.points.size());
    }
    list.push_back(entity);
    tags.push_back(from.tag());
  }
}

void add_ids(Source& from, std::vector<Index>& list, std::size_t n) {
  for (int count = from.whole(0, 4); count > 0; --count) list.push_back(from.id(n));
}

TetMesh make_mesh(Source& from) {
  TetMesh mesh;
  if (const int n = from.whole(0, kMaxCells); n > 0) {
    add_lattice(mesh, n);
    const double size = from.flag() ? std::pow(10, from.whole(-6, 6)) : std::abs(from.real());
    const double away = from.flag() ? 0 : from.real() * std::pow(10, from.whole(0, 12));
    for (Point3& p : mesh.points) {
      for (double& x : p) x = x * size + away;
    }
    for (int edits = from.whole(0, 16); edits > 0; --edits) {
      Point3& p = mesh.points[static_cast<std::size_t>(from.whole(0, static_cast<int>(mesh.points.size()) - 1))];
      double& x = p[static_cast<std::size_t>(from.whole(0, 2))];
      x = from.wildly(4) ? from.real() : x + size * from.real() / 8;
    }
    for (int edits = from.wildly(2) ? from.whole(0, 4) : 0; edits > 0; --edits) {
      auto& tet = mesh.tets[static_cast<std::size_t>(from.whole(0, static_cast<int>(mesh.tets.size()) - 1))];
      tet[static_cast<std::size_t>(from.whole(0, 3))] = from.id(mesh.points.size());
    }
    if (from.flag()) mesh.tets.resize(static_cast<std::size_t>(from.whole(0, static_cast<int>(mesh.tets.size()))));
  } else {
    for (int count = from.whole(0, 20); count > 0; --count)
      mesh.points.push_back({from.real(), from.real(), from.real()});
    for (int count = from.whole(0, 40); count > 0; --count) {
      std::array<Index, 4> tet{};
      for (Index& v : tet) v = from.id(mesh.points.size());
      mesh.tets.push_back(tet);
    }
  }
  if (from.flag()) orient_uniformly(mesh, 1);
  mesh.point_tags.assign(mesh.points.size(), 0);
  mesh.tet_tags.assign(mesh.tets.size(), 1);
  for (int count = from.whole(0, 8); count > 0 && !mesh.tets.empty(); --count) {
    mesh.tet_tags[static_cast<std::size_t>(from.whole(0, static_cast<int>(mesh.tets.size()) - 1))] = from.tag();
  }
  add_entities(from, mesh, mesh.triangles, mesh.triangle_tags);
  add_entities(from, mesh, mesh.edges, mesh.edge_tags);
  add_ids(from, mesh.corners, mesh.points.size());
  add_ids(from, mesh.required_vertices, mesh.points.size());
  add_ids(from, mesh.ridges, mesh.edges.size());
  add_ids(from, mesh.required_edges, mesh.edges.size());
  add_ids(from, mesh.required_triangles, mesh.triangles.size());
  add_ids(from, mesh.required_tets, mesh.tets.size());
  if (from.wildly(8)) {
    ElementBlock block{"Pyramids", from.whole(-1, 6), {}, {}, {}};
    for (int n = from.whole(0, 10); n > 0; --n) block.element2vertex.push_back(from.id(mesh.points.size()));
    for (int n = from.whole(0, 2); n > 0; --n) block.tags.push_back(from.tag());
    add_ids(from, block.required, block.tags.size());
    mesh.others.push_back(block);
  }
  if (from.wildly(16)) {  // lists of the wrong length
    const std::size_t n = static_cast<std::size_t>(from.whole(0, 8));
    from.pick({&mesh.point_tags, &mesh.tet_tags, &mesh.triangle_tags, &mesh.edge_tags})->resize(n);
  }
  return mesh;
}

Options make_options(Source& from, const TetMesh& mesh) {
  Options o;
  o.device = Device::cpu;
  o.boundary = from.pick({Boundary::fixed, Boundary::preserve, Boundary::slide});
  o.energy = from.pick({Energy::shape, Energy::shape, Energy::harmonic});
  o.effort = from.pick({Effort::fast, Effort::standard, Effort::best});
  o.keep_vertices = from.flag();
  if (from.flag()) o.max_growth = from.wildly(2) ? from.real() : from.whole(1, 100);
  o.surface_vertices = from.pick({SurfaceVertices::automatic, SurfaceVertices::keep, SurfaceVertices::edit});
  o.relocation = from.pick({Relocation::newton, Relocation::newton, Relocation::gradient});
  o.termination = from.pick({Termination::relative, Termination::relative, Termination::paper});
  o.untangle = from.flag();
  if (from.flag()) o.feature_angle = from.wildly(2) ? from.real() : from.whole(1, 180);
  // Rarely: the bound takes many times as long as all else, and longest on meshes as small as these.
  if (from.whole(0, 15) == 0 && (from.wild() || o.boundary == Boundary::slide))
    o.max_deviation = from.wild() ? from.real() : std::abs(from.real());
  o.open_boundaries = from.flag();
  for (int n = from.whole(0, 2); n > 0; --n) o.frozen_regions.push_back(from.tag());
  for (int n = from.whole(0, 2); n > 0; --n) o.frozen_patches.push_back(from.tag());
  if (from.flag()) {
    o.frozen_vertices.resize(from.wildly(16) ? 3 : mesh.points.size());
    for (std::uint8_t& frozen : o.frozen_vertices) frozen = from.left() > 0 && from.whole(0, 7) == 0;
  }
  o.max_iterations = from.whole(from.wild() ? -1 : 1, 20);
  o.threads = from.wildly(32) ? from.whole(-2, 3) : 1;
  o.flips = from.flag() || from.flag();
  o.max_ring = from.wildly(16) ? from.whole(-9, 99) : from.whole(3, 7);
  o.boundary_flips = from.flag();
  o.trace_angles = from.flag();
  for (int n = from.wild() ? from.whole(0, 2) : 0; n > 0; --n) {
    o.targets.push_back({static_cast<Measure>(from.whole(0, static_cast<int>(kMeasures) - 1)), from.real()});
  }
  return o;
}

/// All bits of a mesh; coordinates by their bits, as NaN differs from itself.
bool same(const TetMesh& a, const TetMesh& b) {
  const auto bits = [](const TetMesh& m) {
    return std::string_view(reinterpret_cast<const char*>(m.points.data()), m.points.size() * sizeof(Point3));
  };
  return bits(a) == bits(b) && a.tets == b.tets && a.point_tags == b.point_tags && a.tet_tags == b.tet_tags &&
         a.triangles == b.triangles && a.triangle_tags == b.triangle_tags && a.edges == b.edges &&
         a.edge_tags == b.edge_tags;
}

void check_result(const TetMesh& before, const TetMesh& after, const Options& options, const Report& report) {
  if (const ValidationReport valid = validate(after, 1); !valid.ok()) fail(valid.message(false));
  if (options.effort != Effort::best && before.points.size() != after.points.size()) fail("vertices came or went");
  if (double(after.points.size()) + 1 < 0.9 * double(before.points.size())) fail("too many vertices were removed");
  const auto stays = [&](std::size_t v) {
    if (v >= before.points.size()) return;
    std::size_t now = v;
    if (!report.vertex2original.empty()) {
      const auto at = std::find(report.vertex2original.begin(), report.vertex2original.end(), static_cast<Index>(v));
      if (at == report.vertex2original.end()) fail("a frozen vertex was removed");
      now = static_cast<std::size_t>(at - report.vertex2original.begin());
    }
    if (before.points[v] != after.points[now]) fail("a frozen vertex moved");
  };
  for (const Index v : before.required_vertices) stays(static_cast<std::size_t>(v));
  for (std::size_t v = 0; v < options.frozen_vertices.size(); ++v) {
    if (options.frozen_vertices[v] != 0) stays(v);
  }
  if (report.tets_untangled > 0 || options.energy != Energy::shape) return;
  check_worst(before, quality(before, 1), quality(after, 1), options.effort);
}

}  // namespace
}  // namespace tetune::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetune;
  fuzz::Source from(data, size);
  const TetMesh before = fuzz::make_mesh(from);
  const Options options = fuzz::make_options(from, before);
  TetMesh after = before;
  try {
    const Report report = optimize(after, options);
    fuzz::check_result(before, after, options, report);
  } catch (const Error&) {
    if (!fuzz::same(before, after)) fuzz::fail("threw, and changed the mesh");
  }
  return 0;
}
