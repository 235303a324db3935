// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "backend/cpu.hpp"
#include "driver/carry_vertex_sets.hpp"
#include "driver/parts/active_part.hpp"
#include "driver/report/targets.hpp"
#include "driver/transfer_stop.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/keep_entities.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/transfer/conserve.hpp"

namespace tetune {
namespace {

/// A change of a list: some entries get new values, others are appended or erased. New entries take the numbers that
/// became free, in increasing order, then those behind the last; gaps that remain are closed.
class ListChange {
 public:
  ListChange(std::vector<Index> freed, std::size_t size) : gaps_(std::move(freed)), end_(to_index(size)) {}

  /// The number of a new entry.
  Index take() { return next_ < gaps_.size() ? gaps_[next_++] : end_++; }
  /// Entry i of those of apply() goes to number[i]. Called once, after take().
  void set_numbers(std::vector<Index> numbers) {
    numbers_ = std::move(numbers);
    gaps_.erase(gaps_.begin(), gaps_.begin() + Size(next_));
    next_ = 0;
  }
  std::size_t size() const { return to_size_t(end_) - gaps_.size(); }
  /// The number after the gaps are closed.
  Index renumbered(Index old) const {
    return old - to_index(std::lower_bound(gaps_.begin(), gaps_.end(), old) - gaps_.begin());
  }

  /// After reserve(), apply() does not fail.
  template <class T>
  void reserve(std::vector<T>& list) const {
    list.reserve(to_size_t(end_));
  }
  template <class T>
  void apply(std::vector<T>& list, const std::vector<T>& entries) const {
    list.resize(to_size_t(end_));
    for (Size i = 0; i < std::ssize(entries); ++i) span_of(list)[span_of(numbers_)[i]] = span_of(entries)[i];
    for (std::size_t g = 0; g < gaps_.size(); ++g) {
      const auto first = list.begin() + gaps_[g] + 1;
      const auto last = g + 1 < gaps_.size() ? list.begin() + gaps_[g + 1] : list.end();
      std::move(first, last, first - 1 - Size(g));
    }
    list.resize(size());
  }

 private:
  std::vector<Index> gaps_;  ///< increasing
  std::size_t next_ = 0;     ///< those before are taken
  Index end_;
  std::vector<Index> numbers_;
};

/// The numbers in the whole mesh of entries of the part that its result lacks.
std::vector<Index> freed_numbers(const std::vector<Index>& part2whole, const std::vector<std::uint8_t>& is_kept) {
  std::vector<Index> freed;
  for (Size i = 0; i < std::ssize(part2whole); ++i) {
    if (span_of(is_kept)[i] == 0) freed.push_back(span_of(part2whole)[i]);
  }
  return freed;
}

template <std::size_t N>
std::array<Index, N> translated(std::array<Index, N> entity, const std::vector<Index>& map) {
  for (Index& v : entity) v = span_of(map)[v];
  return entity;
}

/// The number of entities that stay although the result of the part lacks them.
std::int64_t absent_that_stay(std::vector<std::uint8_t> stays, const std::vector<Index>& originals) {
  for (const Index i : originals) {
    if (i < std::ssize(stays)) span_of(stays)[i] = 0;
  }
  return std::count(stays.begin(), stays.end(), 1);
}

/// The changes of the whole mesh by the result of the part.
class PartReplacement {
 public:
  PartReplacement(const TetMesh& mesh, const ActivePart& part, const std::function<bool()>& stop_transfer,
                  Report& report)
      : mesh_(mesh), part_(part), stop_transfer_(stop_transfer), report_(report) {
    change_vertices();
    change_tets();
    change_triangles();
    change_edges();
    transfer_data();
  }

  /// When it throws, the mesh is as before.
  void apply(TetMesh& mesh) {
    vertices_.reserve(mesh.points);
    vertices_.reserve(mesh.point_tags);
    if (!mesh.deck_nodes.empty()) vertices_.reserve(mesh.deck_nodes);
    tets_.reserve(mesh.tets);
    tets_.reserve(mesh.tet_tags);
    triangles_.reserve(mesh.triangles);
    triangles_.reserve(mesh.triangle_tags);
    // From here on nothing can fail.
    apply_to_lists(mesh);
    mesh.corners.swap(corners_);
    for (Index& t : mesh.required_tets) t = tets_.renumbered(t);
    for (Index& t : mesh.required_triangles) t = triangles_.renumbered(t);
    keep_edges(mesh, edge2new_);
    mesh.point_data.swap(point_data_);
    mesh.tet_data.swap(tet_data_);
    mesh.triangle_data.swap(triangle_data_);
    mesh.edge_data.swap(edge_data_);
  }

  const std::vector<Index>& vertex2whole() const { return vertex2whole_; }
  const std::vector<Index>& tet2whole() const { return tet2whole_; }
  const ListChange& tets() const { return tets_; }

 private:
  void apply_to_lists(TetMesh& mesh) const {
    vertices_.apply(mesh.points, part_.mesh.points);
    vertices_.apply(mesh.point_tags, point_tags_);
    if (!mesh.deck_nodes.empty()) vertices_.apply(mesh.deck_nodes, deck_nodes_);
    tets_.apply(mesh.tets, new_tets_);
    tets_.apply(mesh.tet_tags, part_.mesh.tet_tags);
    triangles_.apply(mesh.triangles, new_triangles_);
    triangles_.apply(mesh.triangle_tags, triangle_tags_);
  }

  void change_vertices() {
    const std::vector<Index> original = explicit_map(report_.vertex2original, part_.mesh.points.size());
    std::vector<std::uint8_t> is_kept(part_.vertex2whole.size(), 0);
    for (const Index v : original) {
      if (v >= 0) span_of(is_kept)[v] = 1;
    }
    const std::vector<Index> freed = freed_numbers(part_.vertex2whole, is_kept);
    vertices_ = ListChange(freed, mesh_.points.size());
    for (const Index v : original) {
      vertex2whole_.push_back(v >= 0 ? span_of(part_.vertex2whole)[v] : vertices_.take());
      point_tags_.push_back(v >= 0 ? span_of(mesh_.point_tags)[vertex2whole_.back()] : 0);
      if (!mesh_.deck_nodes.empty())
        deck_nodes_.push_back(v >= 0 ? span_of(mesh_.deck_nodes)[vertex2whole_.back()] : 0);
    }
    vertices_.set_numbers(vertex2whole_);
    for (const Index v : mesh_.corners) {
      if (!std::binary_search(freed.begin(), freed.end(), v)) corners_.push_back(v);
    }
    if (report_.vertex2original.empty()) return;
    vertex2original_ = identity_map(mesh_.points.size());
    vertex2original_.resize(vertices_.size(), -1);
    for (const Index v : freed) span_of(vertex2original_)[v] = -1;
  }

  /// A tetrahedron that is the same in the result, also where it was replaced and made again, keeps its number and the
  /// order of its vertices.
  void change_tets() {
    std::map<std::array<Index, 4>, Index> vertices2original;
    for (Index i = 0; i < std::ssize(part_.tet2whole); ++i) {
      vertices2original.emplace(ascending(span_of(mesh_.tets)[span_of(part_.tet2whole)[i]]), i);
    }
    std::vector<std::uint8_t> is_kept(part_.tet2whole.size(), 0);
    for (Size t = 0; t < std::ssize(part_.mesh.tets); ++t) {
      const auto& tet = span_of(part_.mesh.tets)[t];
      new_tets_.push_back(translated(tet, vertex2whole_));
      tet2whole_.push_back(-1);
      const auto found = vertices2original.find(ascending(new_tets_.back()));
      if (found == vertices2original.end() || has_inserted_vertex(tet)) continue;
      const Index whole = span_of(part_.tet2whole)[found->second];
      const auto& before = span_of(mesh_.tets)[whole];
      if (!is_even_permutation(new_tets_.back(), before)) continue;
      span_of(report_.tet2original)[t] = found->second;
      tet2whole_.back() = whole;
      new_tets_.back() = before;
      span_of(is_kept)[found->second] = 1;
    }
    tets_ = ListChange(freed_numbers(part_.tet2whole, is_kept), mesh_.tets.size());
    for (Index& whole : tet2whole_) whole = whole < 0 ? tets_.take() : whole;
    tets_.set_numbers(tet2whole_);
    tet2original_ = identity_map(mesh_.tets.size());
    tets_.apply(tet2original_, gather_entries(part_.tet2whole, report_.tet2original));
    for (Index& t : tet2whole_) t = tets_.renumbered(t);
  }

  /// Whether a vertex was inserted. It may have taken the number of a removed one.
  bool has_inserted_vertex(const std::array<Index, 4>& tet) const {
    const auto is_inserted = [this](Index v) { return span_of(report_.vertex2original)[v] < 0; };
    return !report_.vertex2original.empty() && std::any_of(tet.begin(), tet.end(), is_inserted);
  }

  void change_triangles() {
    const std::vector<Index> original = explicit_map(report_.triangle2original, part_.mesh.triangles.size());
    std::vector<std::uint8_t> is_kept = part_.triangle_stays;
    std::vector<Index> numbers;
    std::vector<Index> wholes;
    for (Size i = 0; i < std::ssize(original); ++i) {
      const Index from = span_of(original)[i];
      const bool is_of_cut = from >= std::ssize(part_.triangle2whole);
      if (is_of_cut || span_of(part_.triangle_stays)[from] != 0) continue;
      wholes.push_back(span_of(part_.triangle2whole)[from]);
      // The first of several that descend from one triangle takes its place.
      numbers.push_back(span_of(is_kept)[from] == 0 ? wholes.back() : -1);
      span_of(is_kept)[from] = 1;
      new_triangles_.push_back(translated(span_of(part_.mesh.triangles)[i], vertex2whole_));
    }
    triangles_ = ListChange(freed_numbers(part_.triangle2whole, is_kept), mesh_.triangles.size());
    for (Index& number : numbers) number = number < 0 ? triangles_.take() : number;
    triangles_.set_numbers(std::move(numbers));
    triangle_tags_ = gather_entries(mesh_.triangle_tags, wholes);
    triangle2original_ = identity_map(mesh_.triangles.size());
    triangles_.apply(triangle2original_, wholes);
    report_.triangles_dropped -= absent_that_stay(part_.triangle_stays, original);
  }

  void change_edges() {
    const std::vector<Index> original = explicit_map(report_.edge2original, part_.mesh.edges.size());
    std::vector<std::uint8_t> is_kept = part_.edge_stays;
    for (const Index e : original) span_of(is_kept)[e] = 1;
    std::vector<std::uint8_t> keep(mesh_.edges.size(), 1);
    for (const Index e : freed_numbers(part_.edge2whole, is_kept)) span_of(keep)[e] = 0;
    edge2new_ = positions_of_kept(keep);
    edge2original_ = kept_of(edge2new_);
    report_.edges_dropped -= absent_that_stay(part_.edge_stays, original);
  }

  /// Returns false where the transfer is given up.
  bool conserve() {
    std::vector<std::array<Index, 4>> tets = mesh_.tets;
    tets_.apply(tets, new_tets_);
    std::optional<ConservedData> data = conserve_data_until_stopped(backend::Cpu(part_.options.threads, stop_transfer_),
                                                                    mesh_, tets, tet2original_, report_.places);
    if (!data) {
      report_transfer_given_up(report_);
      return false;
    }
    point_data_ = std::move(data->point_data);
    tet_data_ = std::move(data->tet_data);
    report_.uncovered = data->uncovered;
    return true;
  }

  void transfer_data() {
    tet_data_ = take_entries(mesh_.tet_data, tet2original_);
    if (part_.options.data != DataTransfer::carry) {
      std::vector<MeshPlace> places(vertices_.size());
      for (Index v = 0; v < std::ssize(places); ++v) span_of(places)[v].vertices.fill(v);
      for (Size i = 0; i < std::ssize(report_.places); ++i) {
        MeshPlace& place = span_of(places)[span_of(vertex2whole_)[i]];
        place = span_of(report_.places)[i];
        place.vertices = translated(place.vertices, part_.vertex2whole);
      }
      report_.places = std::move(places);
      if (part_.options.data != DataTransfer::conserve || !conserve()) {
        point_data_ = interpolate_point_data(mesh_.point_data, report_.places);
      }
    } else if (vertex2original_.empty() || mesh_.point_data.empty()) {
      point_data_ = mesh_.point_data;
    } else {
      const TetMesh after = shape_of_result();
      point_data_ = carry_point_data(mesh_.point_data, vertex2original_, after.points, after.tets);
    }
    carry_sets();
    triangle_data_ = take_entries(mesh_.triangle_data, triangle2original_);
    edge_data_ = take_entries(mesh_.edge_data, edge2original_);
    report_.vertex2original = std::move(vertex2original_);
    report_.tet2original = std::move(tet2original_);
    report_.triangle2original = empty_if_identity(std::move(triangle2original_), mesh_.triangles.size());
    report_.edge2original = empty_if_identity(std::move(edge2original_), mesh_.edges.size());
  }

  /// Carries sets of nodes, and gives inserted vertices tags. Requires the data and the places of the whole mesh.
  void carry_sets() {
    std::function<TetMesh()> make_shape;
    if (!part_.is_moved || !report_.places.empty()) make_shape = [this] { return shape_of_result(); };
    const std::vector<int> tags = carry_vertex_sets(mesh_, vertex2original_, report_.places, make_shape, point_data_);
    auto tag = tags.begin();  // inserted vertices have taken numbers in increasing order
    for (std::size_t i = 0; i < report_.vertex2original.size(); ++i) {
      if (report_.vertex2original[i] < 0) point_tags_[i] = *tag++;
    }
  }

  /// The points, tetrahedra and regions of the whole result.
  TetMesh shape_of_result() const {
    TetMesh after;
    after.points = mesh_.points;
    after.tets = mesh_.tets;
    after.tet_tags = mesh_.tet_tags;
    vertices_.apply(after.points, part_.mesh.points);
    tets_.apply(after.tets, new_tets_);
    tets_.apply(after.tet_tags, part_.mesh.tet_tags);
    return after;
  }

  const TetMesh& mesh_;
  const ActivePart& part_;
  const std::function<bool()>& stop_transfer_;
  Report& report_;
  ListChange vertices_{{}, 0}, tets_{{}, 0}, triangles_{{}, 0};
  std::vector<std::array<Index, 4>> new_tets_;
  std::vector<std::array<Index, 3>> new_triangles_;
  std::vector<int> point_tags_, triangle_tags_;
  std::vector<std::int64_t> deck_nodes_;  ///< 0 for inserted vertices
  std::vector<Index> corners_, edge2new_;
  std::vector<Index> vertex2whole_, tet2whole_;
  std::vector<Index> vertex2original_, tet2original_, triangle2original_, edge2original_;
  std::vector<DataArray> point_data_, tet_data_, triangle_data_, edge_data_;
};

/// Extends the reports on targets to the whole mesh: outside the part tetrahedra are locked.
void extend_targets(const TetMesh& mesh, const PartReplacement& replacement, const ActiveTets& active, int threads,
                    Report& report) {
  for (TargetReport& r : report.targets) {
    r.tets = report.tets_after;
    for (MissedTet& missed : r.worst) {
      missed.tet = span_of(replacement.tet2whole())[missed.tet];
      for (Index& v : missed.edge) v = v < 0 ? v : span_of(replacement.vertex2whole())[v];
    }
  }
  const auto number = [&](Index t) { return replacement.tets().renumbered(t); };
  add_locked(mesh, active.flags, threads, number, report.targets);
}

}  // namespace

PartMaps replace_part(TetMesh& mesh, ActivePart part, const ActiveTets& active,
                      const std::function<bool()>& stop_transfer, Report& report) {
  report.fixed_vertices += std::ssize(mesh.points) - report.vertices;
  report.vertices = std::ssize(mesh.points);
  report.tets_after += std::ssize(mesh.tets) - report.tets_before;
  report.tets_before = std::ssize(mesh.tets);
  PartReplacement replacement(mesh, part, stop_transfer, report);
  extend_targets(mesh, replacement, active, part.options.threads, report);
  PartMaps maps{replacement.vertex2whole(), replacement.tet2whole()};
  replacement.apply(mesh);
  return maps;
}

}  // namespace tetune
