// SPDX-License-Identifier: Apache-2.0
// The part of a DMPlex that a rank has.
#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "plex.hpp"
#include "star_forest.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// The names of the labels of all ranks, except those that every DMPlex has.
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
    std::vector<int> defaults;
    for (std::size_t l = 0; l < labels.names.size(); ++l) {
      DMLabel label = nullptr;
      check_petsc(DMGetLabel(dm, labels.names[l].c_str(), &label));
      completed.push_back(label == nullptr ? 1 : read(dm, label, int(l)));
      defaults.push_back(label == nullptr ? std::numeric_limits<int>::max() : default_of(label));
    }
    if (completed.empty()) return;
    labels.completed = all_reduce(comm, completed, MPI_MIN);
    labels.defaults = all_reduce(comm, defaults, MPI_MIN);
    // A value that DMPlexLabelComplete() restores from the closure of other points is no constraint of its own.
    for (auto& [point, values] : values_) {
      std::sort(values.begin(), values.end());  // each rank has the values of a label in an order of its own
      std::erase_if(values, [this, at = point](const auto& v) {
        return item(labels_.completed, v.first) != 0 && implied_.count({at, v}) > 0;
      });
    }
    std::erase_if(values_, [](const auto& entry) { return entry.second.empty(); });
  }

  /// Points that have values, in increasing order.
  const std::map<PetscInt, Labels::Values>& values() const { return values_; }

 private:
  static int default_of(DMLabel label) {
    PetscInt value = 0;
    check_petsc(DMLabelGetDefaultValue(label, &value));
    return int{value};
  }

  /// Reads a label; returns 1 where it holds the closure of its points.
  int read(DM dm, DMLabel label, int l) {
    IS value_is = nullptr;
    check_petsc(DMLabelGetNonEmptyStratumValuesIS(label, &value_is));
    PetscInt strata = 0;
    const PetscInt* stratum_values = nullptr;
    check_petsc(ISGetLocalSize(value_is, &strata));
    check_petsc(ISGetIndices(value_is, &stratum_values));
    bool complete = true;
    for (PetscInt s = 0; s < strata; ++s) complete = read_stratum(dm, label, l, stratum_values[s]) && complete;
    check_petsc(ISRestoreIndices(value_is, &stratum_values));
    check_petsc(ISDestroy(&value_is));
    return complete ? 1 : 0;
  }

  /// Reads the points of one value; returns whether the label holds their closure.
  bool read_stratum(DM dm, DMLabel label, int l, PetscInt stratum) {
    IS point_is = nullptr;
    check_petsc(DMLabelGetStratumIS(label, stratum, &point_is));
    PetscInt count = 0;
    const PetscInt* points = nullptr;
    check_petsc(ISGetLocalSize(point_is, &count));
    check_petsc(ISGetIndices(point_is, &points));
    const std::pair value(l, int{stratum});
    bool complete = true;
    for (PetscInt i = 0; i < count; ++i) {
      values_[points[i]].push_back(value);
      PetscInt closure_size = 0;
      PetscInt* closure = nullptr;
      check_petsc(DMPlexGetTransitiveClosure(dm, points[i], PETSC_TRUE, &closure_size, &closure));
      for (PetscInt c = 1; c < closure_size; ++c) {
        PetscBool has = PETSC_FALSE;
        check_petsc(DMLabelStratumHasPoint(label, stratum, closure[2 * c], &has));
        complete = complete && has == PETSC_TRUE;
        if (has == PETSC_TRUE) implied_.insert({closure[2 * c], value});
      }
      check_petsc(DMPlexRestoreTransitiveClosure(dm, points[i], PETSC_TRUE, &closure_size, &closure));
    }
    check_petsc(ISRestoreIndices(point_is, &points));
    check_petsc(ISDestroy(&point_is));
    return complete;
  }

  Labels& labels_;
  std::map<PetscInt, Labels::Values> values_;
  std::set<std::pair<PetscInt, std::pair<int, int>>> implied_;
};

/// One tag per combination of values that points of one dimension have, the same on all ranks: the value itself where
/// it is the only one and belongs to the label of kSets.
std::map<Labels::Values, int> number_combinations(MPI_Comm comm, const std::set<Labels::Values>& here,
                                                  const Labels& labels, std::size_t depth) {
  std::vector<int> packed;
  for (const Labels::Values& values : here) {
    packed.push_back(int_size(values));
    for (const auto& [label, value] : values) packed.insert(packed.end(), {label, value});
  }
  std::set<Labels::Values> all;
  const std::vector<int> received = gather_all(comm, packed, MPI_INT);
  for (std::size_t at = 0; at < received.size();) {
    Labels::Values values(std::size_t(received[at++]));
    for (auto& [label, value] : values) {
      label = received[at++];
      value = received[at++];
    }
    all.insert(values);
  }
  const auto usual = [&](const Labels::Values& values) {
    return values.size() == 1 && values[0].second != 0 && item(labels.names, values[0].first) == kSets[depth];
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

/// Numbers entities, which several ranks may have, such that those with the same vertices have the same id.
template <std::size_t N>
void number_by_vertices(MPI_Comm comm, std::vector<Element<N>>& elements, Id& total) {
  std::vector<std::array<Id, N>> keys;
  std::vector<int> to;
  const int ranks = size_of(comm);
  for (const Element<N>& e : elements) {
    keys.push_back(e.v);
    std::sort(keys.back().begin(), keys.back().end());
    to.push_back(int(keys.back()[0] % ranks));
  }
  const Route route(comm, to);
  const auto received = route.send(keys);
  auto different = received;
  std::sort(different.begin(), different.end());
  different.erase(std::unique(different.begin(), different.end()), different.end());
  const Id first = sum_before(comm, std::ssize(different));
  std::vector<Id> answers;
  for (const auto& key : received) {
    answers.push_back(first + (std::lower_bound(different.begin(), different.end(), key) - different.begin()));
  }
  const std::vector<Id> ids = route.answer(answers);
  for (std::size_t i = 0; i < elements.size(); ++i) elements[i].id = ids[i];
  total = all_reduce(comm, std::ssize(different), MPI_SUM);
}

/// The global numbers of vertices.
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
  /// PETSc stores the number n of a vertex that another rank owns as -1 - n.
  Id of(PetscInt vertex) const {
    const PetscInt n = numbers_[vertex - begin_];
    return n < 0 ? -1 - n : n;
  }
  /// The numbers of the vertices of a point, in the order of its closure.
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
  if (overlap > 0) throw MeshError("the DMPlex has overlap; optimize first, then call DMPlexDistributeOverlap");
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
  if (others > 0) throw MeshError(std::to_string(others) + " cells of the DMPlex are not tetrahedra");
}

Point3 coordinates_of(PetscSection section, const PetscScalar* values, PetscInt vertex) {
  PetscInt offset = 0;
  check_petsc(PetscSectionGetOffset(section, vertex, &offset));
  return {PetscRealPart(values[offset]), PetscRealPart(values[offset + 1]), PetscRealPart(values[offset + 2])};
}

/// The tags of points.
class PointTags {
 public:
  PointTags(MPI_Comm comm, DM dm, Labels& labels) {
    const PointLabels point_labels(comm, dm, labels);
    PetscInt depth = 0;
    check_petsc(DMPlexGetDepth(dm, &depth));
    depth = all_reduce(comm, int{depth}, MPI_MAX);
    const auto& values = point_labels.values();
    for (int d = 0; d < 4; ++d) {
      if (!labels.interpolated && (d == 1 || d == 2)) continue;
      PetscInt begin = 0;
      PetscInt end = 0;
      check_petsc(DMPlexGetDepthStratum(dm, labels.interpolated || d == 0 ? d : depth, &begin, &end));
      std::set<Labels::Values> combinations;
      for (auto at = values.lower_bound(begin); at != values.end() && at->first < end; ++at) {
        combinations.insert(at->second);
      }
      const auto tags = number_combinations(comm, combinations, labels, std::size_t(d));
      for (const auto& [combination, tag] : tags) item(labels.tag2values, d)[tag] = combination;
      for (auto at = values.lower_bound(begin); at != values.end() && at->first < end; ++at) {
        point2tag_[at->first] = tags.at(at->second);
      }
    }
  }
  /// Returns 0 for a point without values.
  int operator[](PetscInt point) const {
    const auto at = point2tag_.find(point);
    return at == point2tag_.end() ? 0 : at->second;
  }
  /// Calls f(point, tag) for each point of a dimension that has a tag.
  template <class F>
  void for_each(DM dm, PetscInt dimension, F f) const {
    PetscInt begin = 0;
    PetscInt end = 0;
    check_petsc(DMPlexGetDepthStratum(dm, dimension, &begin, &end));
    for (auto at = point2tag_.lower_bound(begin); at != point2tag_.end() && at->first < end; ++at) {
      f(at->first, at->second);
    }
  }

 private:
  std::map<PetscInt, int> point2tag_;
};

void read_vertices(DM dm, const VertexNumbers& numbers, const PointTags& tags, std::vector<Vertex>& vertices) {
  PetscSection section = nullptr;
  Vec local = nullptr;
  const PetscScalar* values = nullptr;
  check_petsc(DMGetCoordinateSection(dm, &section));
  check_petsc(DMGetCoordinatesLocal(dm, &local));
  check_petsc(VecGetArrayRead(local, &values));
  for (PetscInt v = numbers.begin(); v < numbers.end(); ++v) {
    vertices.push_back({numbers.of(v), coordinates_of(section, values, v), tags[v], 0});
  }
  check_petsc(VecRestoreArrayRead(local, &values));
}

}  // namespace

Part part_of(DM dm, Totals& totals, Labels& labels) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  check_plex(comm, dm);
  DMPlexInterpolatedFlag interpolated = DMPLEX_INTERPOLATED_NONE;
  check_petsc(DMPlexIsInterpolatedCollective(dm, &interpolated));
  labels.interpolated = interpolated == DMPLEX_INTERPOLATED_FULL;
  const PointTags tags(comm, dm, labels);
  const VertexNumbers numbers(dm);
  Pieces pieces;
  read_vertices(dm, numbers, tags, pieces.vertices);
  Id max_id = -1;
  for (const Vertex& v : pieces.vertices) max_id = std::max(max_id, v.id);
  totals.vertices = all_reduce(comm, max_id, MPI_MAX) + 1;
  PetscInt begin = 0;
  PetscInt end = 0;
  check_petsc(DMPlexGetHeightStratum(dm, 0, &begin, &end));
  Id next = sum_before(comm, end - begin);
  totals.cells = all_reduce(comm, Id{end - begin}, MPI_SUM);
  for (PetscInt c = begin; c < end; ++c) pieces.cells.push_back({next++, numbers.of_corners<4>(c), tags[c], 0});
  if (labels.interpolated) {
    tags.for_each(dm, 2, [&](PetscInt point, int tag) {
      pieces.sides.push_back({0, numbers.of_corners<3>(point), tag, 0});
    });
    tags.for_each(dm, 1, [&](PetscInt point, int tag) {
      pieces.lines.push_back({0, numbers.of_corners<2>(point), tag, 0});
    });
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
    labels.defaults.push_back(-1);
    const std::set<int> here(tags[d]->begin(), tags[d]->end());
    for (const int tag : gather_all(comm, std::vector<int>(here.begin(), here.end()), MPI_INT)) {
      if (tag != 0) labels.tag2values[d][tag] = {{int(d), tag}};
    }
  }
  return labels;
}

}  // namespace tetune::mpi
