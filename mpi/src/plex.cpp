// SPDX-License-Identifier: Apache-2.0
#include "plex.hpp"

#include <petscsf.h>

#include <limits>
#include <numeric>
#include <set>

#include "measure.hpp"
#include "rounds.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// The items of all ranks, on all, in the order of the ranks.
template <class T>
std::vector<T> gather_all(MPI_Comm comm, const std::vector<T>& items, MPI_Datatype type) {
  const std::vector<int> counts = all_gather(comm, static_cast<int>(items.size()));
  std::vector<int> begin(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), begin.begin(), 0);
  std::vector<T> all(static_cast<std::size_t>(begin.back() + counts.back()));
  MPI_Allgatherv(items.data(), counts[static_cast<std::size_t>(rank_of(comm))], type, all.data(), counts.data(),
                 begin.data(), type, comm);
  return all;
}

/// Names of the labels of all ranks, but for those that every DMPlex has of its own.
std::vector<std::string> label_names(MPI_Comm comm, DM dm) {
  PetscInt count = 0;
  check_petsc(DMGetNumLabels(dm, &count));
  std::vector<char> text;
  for (PetscInt i = 0; i < count; ++i) {
    const char* name = nullptr;
    check_petsc(DMGetLabelName(dm, i, &name));
    text.insert(text.end(), name, name + std::char_traits<char>::length(name) + 1);
  }
  std::set<std::string> names;
  const std::vector<char> all = gather_all(comm, text, MPI_CHAR);
  for (std::size_t at = 0; at < all.size(); at += std::string(&all[at]).size() + 1) {
    names.insert(&all[at]);
  }
  for (const char* own : {"depth", "celltype", "dim"}) names.erase(own);
  return {names.begin(), names.end()};
}

/// Reads the values of all labels on the points of one rank.
class PointLabels {
 public:
  PointLabels(MPI_Comm comm, DM dm, Labels& labels) : labels_(labels) {
    labels.names = label_names(comm, dm);
    std::vector<int> completed;
    for (std::size_t l = 0; l < labels.names.size(); ++l) {
      DMLabel label = nullptr;
      check_petsc(DMGetLabel(dm, labels.names[l].c_str(), &label));
      completed.push_back(label == nullptr ? 1 : read(dm, label, static_cast<int>(l)));
    }
    if (completed.empty()) return;
    labels.completed = all_reduce(comm, completed, MPI_MIN);
    // What the closure of others brings back is no constraint of its own.
    for (auto& [point, values] : values_) {
      std::erase_if(values, [this, at = point](const auto& v) {
        return labels_.completed[static_cast<std::size_t>(v.first)] != 0 && implied_.count({at, v}) > 0;
      });
    }
    std::erase_if(values_, [](const auto& entry) { return entry.second.empty(); });
  }

  /// Points that have values, in increasing order.
  const std::map<PetscInt, Labels::Values>& values() const { return values_; }

 private:
  int read(DM dm, DMLabel label, int l) {
    IS value_is = nullptr;
    check_petsc(DMLabelGetNonEmptyStratumValuesIS(label, &value_is));
    PetscInt strata = 0;
    const PetscInt* stratum_values = nullptr;
    check_petsc(ISGetLocalSize(value_is, &strata));
    check_petsc(ISGetIndices(value_is, &stratum_values));
    bool complete = true;
    for (PetscInt s = 0; s < strata; ++s) {
      const std::pair value(l, static_cast<int>(stratum_values[s]));
      IS point_is = nullptr;
      check_petsc(DMLabelGetStratumIS(label, stratum_values[s], &point_is));
      PetscInt count = 0;
      const PetscInt* points = nullptr;
      check_petsc(ISGetLocalSize(point_is, &count));
      check_petsc(ISGetIndices(point_is, &points));
      for (PetscInt i = 0; i < count; ++i) {
        values_[points[i]].push_back(value);
        PetscInt closure_size = 0;
        PetscInt* closure = nullptr;
        check_petsc(DMPlexGetTransitiveClosure(dm, points[i], PETSC_TRUE, &closure_size, &closure));
        for (PetscInt c = 1; c < closure_size; ++c) {
          PetscBool has = PETSC_FALSE;
          check_petsc(DMLabelStratumHasPoint(label, stratum_values[s], closure[2 * c], &has));
          complete = complete && has == PETSC_TRUE;
          if (has == PETSC_TRUE) implied_.insert({closure[2 * c], value});
        }
        check_petsc(DMPlexRestoreTransitiveClosure(dm, points[i], PETSC_TRUE, &closure_size, &closure));
      }
      check_petsc(ISRestoreIndices(point_is, &points));
      check_petsc(ISDestroy(&point_is));
    }
    check_petsc(ISRestoreIndices(value_is, &stratum_values));
    check_petsc(ISDestroy(&value_is));
    return complete ? 1 : 0;
  }

  Labels& labels_;
  std::map<PetscInt, Labels::Values> values_;
  std::set<std::pair<PetscInt, std::pair<int, int>>> implied_;
};

/// One tag for each combination of values that the points of one dimension have, the same on all ranks: the value
/// itself where that is the only one and of the usual label.
std::map<Labels::Values, int> number_combinations(MPI_Comm comm, const std::set<Labels::Values>& here,
                                                  const Labels& labels, std::size_t depth) {
  std::vector<int> packed;
  for (const Labels::Values& values : here) {
    packed.push_back(static_cast<int>(values.size()));
    for (const auto& [label, value] : values) packed.insert(packed.end(), {label, value});
  }
  std::set<Labels::Values> all;
  const std::vector<int> received = gather_all(comm, packed, MPI_INT);
  for (std::size_t at = 0; at < received.size();) {
    Labels::Values values(static_cast<std::size_t>(received[at++]));
    for (auto& [label, value] : values) {
      label = received[at++];
      value = received[at++];
    }
    all.insert(values);
  }
  const auto usual = [&](const Labels::Values& values) {
    return values.size() == 1 && values[0].second != 0 &&
           labels.names[static_cast<std::size_t>(values[0].first)] == kSets[depth];
  };
  std::set<int> used;
  for (const Labels::Values& values : all) {
    if (usual(values)) used.insert(values[0].second);
  }
  std::map<Labels::Values, int> tags;
  int next = 1;
  for (const Labels::Values& values : all) {
    if (usual(values)) {
      tags[values] = values[0].second;
      continue;
    }
    while (used.count(next) > 0) ++next;
    tags[values] = next++;
  }
  return tags;
}

/// Numbers entities that several ranks may have by their vertices.
template <std::size_t N>
void number_by_vertices(MPI_Comm comm, std::vector<Element<N>>& elements, Id& total) {
  std::vector<std::array<Id, N>> keys;
  std::vector<int> to;
  for (const Element<N>& e : elements) {
    keys.push_back(e.v);
    std::sort(keys.back().begin(), keys.back().end());
    to.push_back(static_cast<int>(keys.back()[0] % size_of(comm)));
  }
  const Route route(comm, to);
  const auto received = route.send(keys);
  auto different = received;
  std::sort(different.begin(), different.end());
  different.erase(std::unique(different.begin(), different.end()), different.end());
  const Id first = sum_before(comm, static_cast<Id>(different.size()));
  std::vector<Id> answers;
  for (const auto& key : received) {
    answers.push_back(first + (std::lower_bound(different.begin(), different.end(), key) - different.begin()));
  }
  const std::vector<Id> ids = route.answer(answers);
  for (std::size_t i = 0; i < elements.size(); ++i) elements[i].id = ids[i];
  total = all_reduce(comm, static_cast<Id>(different.size()), MPI_SUM);
}

/// Global numbers of the vertices of a point, in the order of its closure.
class VertexNumbers {
 public:
  explicit VertexNumbers(DM dm) : dm_(dm) {
    check_petsc(DMPlexGetDepthStratum(dm, 0, &begin_, &end_));
    check_petsc(DMPlexGetVertexNumbering(dm, &numbering_));
    check_petsc(ISGetIndices(numbering_, &numbers_));
  }
  ~VertexNumbers() { ISRestoreIndices(numbering_, &numbers_); }
  VertexNumbers(const VertexNumbers&) = delete;
  VertexNumbers& operator=(const VertexNumbers&) = delete;
  PetscInt begin() const { return begin_; }
  PetscInt end() const { return end_; }
  /// Those of other ranks are stored as -1 - number.
  Id of(PetscInt vertex) const {
    const PetscInt n = numbers_[vertex - begin_];
    return n < 0 ? -1 - n : n;
  }
  template <std::size_t N>
  std::array<Id, N> of_corners(PetscInt point) const {
    std::array<Id, N> ids{};
    std::size_t found = 0;
    PetscInt size = 0;
    PetscInt* closure = nullptr;
    check_petsc(DMPlexGetTransitiveClosure(dm_, point, PETSC_TRUE, &size, &closure));
    for (PetscInt c = 0; c < size; ++c) {
      const PetscInt q = closure[2 * c];
      if (q >= begin_ && q < end_ && found < N) ids[found++] = of(q);
    }
    check_petsc(DMPlexRestoreTransitiveClosure(dm_, point, PETSC_TRUE, &size, &closure));
    return ids;
  }

 private:
  DM dm_;
  IS numbering_ = nullptr;
  const PetscInt* numbers_ = nullptr;
  PetscInt begin_ = 0, end_ = 0;
};

void check_plex(MPI_Comm comm, DM dm) {
  PetscBool is_plex = PETSC_FALSE;
  check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(dm), DMPLEX, &is_plex));
  if (is_plex == PETSC_FALSE) throw MeshError("the DM is not a DMPlex");
  PetscInt dimension = 0;
  PetscInt space = 0;
  PetscInt overlap = 0;
  check_petsc(DMGetDimension(dm, &dimension));
  check_petsc(DMGetCoordinateDim(dm, &space));
  if (dimension != 3 || space != 3) {
    throw MeshError("the DMPlex has dimension " + std::to_string(dimension) + " in " + std::to_string(space) +
                    " coordinates; it must be one of tetrahedra in space");
  }
  check_petsc(DMPlexGetOverlap(dm, &overlap));
  if (overlap > 0) throw MeshError("the DMPlex has overlap; optimise first, then call DMPlexDistributeOverlap");
  PetscInt begin = 0;
  PetscInt end = 0;
  check_petsc(DMPlexGetHeightStratum(dm, 0, &begin, &end));
  Id others = 0;
  for (PetscInt c = begin; c < end; ++c) {
    DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
    check_petsc(DMPlexGetCellType(dm, c, &type));
    if (type != DM_POLYTOPE_TETRAHEDRON) ++others;
  }
  others = all_reduce(comm, others, MPI_SUM);
  if (others > 0) throw MeshError(std::to_string(others) + " cells of the DMPlex are no tetrahedra");
}

Point3 coordinates_of(PetscSection section, const PetscScalar* values, PetscInt vertex) {
  PetscInt offset = 0;
  check_petsc(PetscSectionGetOffset(section, vertex, &offset));
  return {PetscRealPart(values[offset]), PetscRealPart(values[offset + 1]), PetscRealPart(values[offset + 2])};
}

}  // namespace

Part part_of(DM dm, Totals& totals, Labels& labels) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  check_plex(comm, dm);
  DMPlexInterpolatedFlag interpolated = DMPLEX_INTERPOLATED_NONE;
  check_petsc(DMPlexIsInterpolatedCollective(dm, &interpolated));
  labels.interpolated = interpolated == DMPLEX_INTERPOLATED_FULL;
  const PointLabels point_labels(comm, dm, labels);
  PetscInt depth = 0;
  check_petsc(DMPlexGetDepth(dm, &depth));
  depth = all_reduce(comm, static_cast<int>(depth), MPI_MAX);

  // Tags of the points of each dimension.
  std::map<PetscInt, int> point2tag;
  for (std::size_t d = 0; d < 4; ++d) {
    if (!labels.interpolated && (d == 1 || d == 2)) continue;
    PetscInt begin = 0;
    PetscInt end = 0;
    check_petsc(
        DMPlexGetDepthStratum(dm, labels.interpolated || d == 0 ? static_cast<PetscInt>(d) : depth, &begin, &end));
    std::set<Labels::Values> here;
    const auto& values = point_labels.values();
    for (auto at = values.lower_bound(begin); at != values.end() && at->first < end; ++at) here.insert(at->second);
    const auto tags = number_combinations(comm, here, labels, d);
    for (const auto& [combination, tag] : tags) labels.tag2values[d][tag] = combination;
    for (auto at = values.lower_bound(begin); at != values.end() && at->first < end; ++at) {
      point2tag[at->first] = tags.at(at->second);
    }
  }
  const auto tag_of = [&point2tag](PetscInt point) {
    const auto at = point2tag.find(point);
    return at == point2tag.end() ? 0 : at->second;
  };

  Pieces pieces;
  const VertexNumbers vertices(dm);
  PetscSection section = nullptr;
  Vec local = nullptr;
  const PetscScalar* values = nullptr;
  check_petsc(DMGetCoordinateSection(dm, &section));
  check_petsc(DMGetCoordinatesLocal(dm, &local));
  check_petsc(VecGetArrayRead(local, &values));
  Id most = -1;
  for (PetscInt v = vertices.begin(); v < vertices.end(); ++v) {
    pieces.vertices.push_back({vertices.of(v), coordinates_of(section, values, v), tag_of(v), 0});
    most = std::max(most, pieces.vertices.back().id);
  }
  check_petsc(VecRestoreArrayRead(local, &values));
  totals.vertices = all_reduce(comm, most, MPI_MAX) + 1;

  PetscInt begin = 0;
  PetscInt end = 0;
  check_petsc(DMPlexGetHeightStratum(dm, 0, &begin, &end));
  Id next = sum_before(comm, end - begin);
  totals.cells = all_reduce(comm, static_cast<Id>(end - begin), MPI_SUM);
  for (PetscInt c = begin; c < end; ++c) {
    pieces.cells.push_back({next++, vertices.of_corners<4>(c), tag_of(c), 0});
  }
  if (labels.interpolated) {
    check_petsc(DMPlexGetDepthStratum(dm, 2, &begin, &end));
    for (auto at = point2tag.lower_bound(begin); at != point2tag.end() && at->first < end; ++at) {
      pieces.sides.push_back({0, vertices.of_corners<3>(at->first), at->second, 0});
    }
    check_petsc(DMPlexGetDepthStratum(dm, 1, &begin, &end));
    for (auto at = point2tag.lower_bound(begin); at != point2tag.end() && at->first < end; ++at) {
      pieces.lines.push_back({0, vertices.of_corners<2>(at->first), at->second, 0});
    }
  }
  number_by_vertices(comm, pieces.sides, totals.sides);
  number_by_vertices(comm, pieces.lines, totals.lines);
  return assemble(std::move(pieces));
}

Labels labels_of(MPI_Comm comm, const Part& part) {
  Labels labels;
  const std::array<const std::vector<int>*, 4> tags{&part.mesh.point_tags, &part.mesh.edge_tags,
                                                    &part.mesh.triangle_tags, &part.mesh.tet_tags};
  for (std::size_t d = 0; d < 4; ++d) {
    labels.names.emplace_back(kSets[d]);
    labels.completed.push_back(0);
    const std::set<int> here(tags[d]->begin(), tags[d]->end());
    for (const int tag : gather_all(comm, std::vector<int>(here.begin(), here.end()), MPI_INT)) {
      if (tag != 0) labels.tag2values[d][tag] = {{static_cast<int>(d), tag}};
    }
  }
  return labels;
}

namespace {

/// The global number of each vertex of a new DMPlex: the place of its coordinates.
std::vector<Id> ids_of(MPI_Comm comm, PetscSF vertex_sf, Id at_home) {
  const std::vector<Id> sizes = all_gather(comm, at_home);
  std::vector<Id> begin(sizes.size());
  std::exclusive_scan(sizes.begin(), sizes.end(), begin.begin(), Id{0});
  PetscInt count = 0;
  const PetscInt* leaves = nullptr;
  const PetscSFNode* roots = nullptr;
  check_petsc(PetscSFGetGraph(vertex_sf, nullptr, &count, &leaves, &roots));
  std::vector<Id> ids(static_cast<std::size_t>(count));
  for (PetscInt i = 0; i < count; ++i) {
    ids[static_cast<std::size_t>(leaves != nullptr ? leaves[i] : i)] =
        begin[static_cast<std::size_t>(roots[i].rank)] + roots[i].index;
  }
  return ids;
}

}  // namespace

DM plex_of(MPI_Comm comm, Part part, Totals& totals, const Labels& labels) {
  close_gaps(comm, part, totals);
  const Pieces pieces = address(part, std::vector<int>(part.mesh.tets.size(), 0), 0).pieces;
  part = {};
  std::vector<PetscReal> x;
  const std::vector<Vertex> home = vertices_at_home(comm, pieces.vertices, totals);
  for (const Vertex& v : home) x.insert(x.end(), v.x.begin(), v.x.end());
  std::vector<PetscInt> cells;
  for (const Cell& c : pieces.cells) {
    for (const Id v : c.v) cells.push_back(static_cast<PetscInt>(v));
  }
  DM dm = nullptr;
  PetscSF vertex_sf = nullptr;
  check_petsc(DMPlexCreateFromCellListParallelPetsc(
      comm, 3, static_cast<PetscInt>(pieces.cells.size()), static_cast<PetscInt>(home.size()), PETSC_DECIDE, 4,
      labels.interpolated ? PETSC_TRUE : PETSC_FALSE, cells.data(), 3, x.data(), &vertex_sf, nullptr, &dm));
  const IdMap local(ids_of(comm, vertex_sf, static_cast<Id>(home.size())));
  check_petsc(PetscSFDestroy(&vertex_sf));
  PetscInt first_vertex = 0;
  PetscInt end = 0;
  check_petsc(DMPlexGetDepthStratum(dm, 0, &first_vertex, &end));
  const auto point_of = [&local, first_vertex](Id id) { return first_vertex + local[id]; };

  std::vector<DMLabel> created(labels.names.size());
  for (std::size_t l = 0; l < created.size(); ++l) {
    check_petsc(DMCreateLabel(dm, labels.names[l].c_str()));
    check_petsc(DMGetLabel(dm, labels.names[l].c_str(), &created[l]));
  }
  const auto set = [&](std::size_t d, PetscInt point, int tag) {
    const auto at = labels.tag2values[d].find(tag);
    if (at == labels.tag2values[d].end()) return;
    for (const auto& [label, value] : at->second) {
      check_petsc(DMLabelSetValue(created[static_cast<std::size_t>(label)], point, value));
    }
  };
  for (const Vertex& v : pieces.vertices) {
    if (local[v.id] >= 0) set(0, point_of(v.id), v.tag);
  }
  PetscInt first_cell = 0;
  check_petsc(DMPlexGetHeightStratum(dm, 0, &first_cell, &end));
  for (std::size_t i = 0; i < pieces.cells.size(); ++i) {
    set(3, first_cell + static_cast<PetscInt>(i), pieces.cells[i].tag);
  }
  const auto set_all = [&](std::size_t d, const auto& elements) {
    for (const auto& e : elements) {
      std::array<PetscInt, 3> corners{};
      for (std::size_t k = 0; k < e.v.size(); ++k) corners[k] = point_of(e.v[k]);
      PetscInt count = 0;
      const PetscInt* join = nullptr;
      const auto n = static_cast<PetscInt>(e.v.size());
      check_petsc(DMPlexGetFullJoin(dm, n, corners.data(), &count, &join));
      if (count == 1) set(d, join[0], e.tag);
      check_petsc(DMPlexRestoreJoin(dm, n, corners.data(), &count, &join));
    }
  };
  if (labels.interpolated) {
    set_all(2, pieces.sides);
    set_all(1, pieces.lines);
  }
  for (std::size_t l = 0; l < created.size(); ++l) {
    if (labels.completed[l] != 0) check_petsc(DMPlexLabelComplete(dm, created[l]));
  }
  return dm;
}

namespace {

/// The tags that stand for values of a label.
std::vector<int> tags_with(const Labels& labels, std::size_t depth, const std::vector<int>& values) {
  std::vector<int> tags;
  for (const int value : values) {
    bool any = false;
    for (const auto& [tag, combination] : labels.tag2values[depth]) {
      for (const auto& [label, v] : combination) {
        if (v != value || labels.names[static_cast<std::size_t>(label)] != kSets[depth]) continue;
        tags.push_back(tag);
        any = true;
      }
    }
    if (any) continue;
    throw OptionError(std::string(depth == 3 ? "frozen_regions" : "frozen_patches") + " names value " +
                      std::to_string(value) + ", which no point has in the label \"" + kSets[depth] + "\"");
  }
  return tags;
}

}  // namespace
}  // namespace tetune::mpi

tetune::DistributedReport tetune::optimize(DM& dm, const Options& options, const std::function<bool()>& stop) {
  using namespace mpi;
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  Totals totals;
  Labels labels;
  Part part = part_of(dm, totals, labels);
  Options in_tags = options;
  in_tags.frozen_regions = tags_with(labels, 3, options.frozen_regions);
  in_tags.frozen_patches = tags_with(labels, 2, options.frozen_patches);
  const bool turned = orient_all(comm, part);
  const DistributedReport report = optimize_parts(comm, part, totals, in_tags, stop);
  if (turned) {
    for (auto& tet : part.mesh.tets) std::swap(tet[2], tet[3]);
  }
  DM better = plex_of(comm, std::move(part), totals, labels);
  const char* name = nullptr;
  check_petsc(PetscObjectGetName(reinterpret_cast<PetscObject>(dm), &name));
  check_petsc(PetscObjectSetName(reinterpret_cast<PetscObject>(better), name));
  check_petsc(DMCopyDisc(dm, better));
  check_petsc(DMDestroy(&dm));
  dm = better;
  return report;
}
