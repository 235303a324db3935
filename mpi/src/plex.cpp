// SPDX-License-Identifier: Apache-2.0
#include "plex.hpp"

#include <limits>
#include <numeric>
#include <set>

#include "measure.hpp"
#include "rounds.hpp"
#include "star_forest.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// The global number of each vertex of a new DMPlex: the position of its coordinates.
std::vector<Id> ids_of(MPI_Comm comm, PetscSF vertex_sf, Id owned_count) {
  const std::vector<Id> sizes = all_gather(comm, owned_count);
  std::vector<Id> begin(sizes.size());
  std::exclusive_scan(sizes.begin(), sizes.end(), begin.begin(), Id{0});
  PetscInt count = 0;
  const PetscInt* leaves = nullptr;
  const PetscSFNode* roots = nullptr;
  check_petsc(PetscSFGetGraph(vertex_sf, nullptr, &count, &leaves, &roots));
  std::vector<Id> ids(std::size_t(count), 0);
  for (PetscInt i = 0; i < count; ++i) {
    item(ids, leaves != nullptr ? leaves[i] : i) = item(begin, roots[i].rank) + roots[i].index;
  }
  return ids;
}

/// Sets the labels of a new DMPlex by the tags of its entities.
class LabelWriter {
 public:
  LabelWriter(DM dm, const Labels& labels) : dm_(dm), labels_(labels), created_(labels.names.size()) {
    for (std::size_t l = 0; l < created_.size(); ++l) {
      check_petsc(DMCreateLabel(dm, labels.names[l].c_str()));
      check_petsc(DMGetLabel(dm, labels.names[l].c_str(), &created_[l]));
      // DMLabelSetValue() ignores the default value.
      check_petsc(DMLabelSetDefaultValue(created_[l], unused_value(int(l))));
    }
  }

  /// Sets the values that a tag stands for on a point of dimension d.
  void set(std::size_t d, PetscInt point, int tag) const {
    const auto at = labels_.tag2values[d].find(tag);
    if (at == labels_.tag2values[d].end()) return;
    for (const auto& [label, value] : at->second) check_petsc(DMLabelSetValue(item(created_, label), point, value));
  }

  /// Sets the values on the faces or edges with these vertices.
  template <std::size_t N, class PointOf>
  void set_all(const std::vector<Element<N>>& elements, PointOf point_of) const {
    for (const Element<N>& e : elements) {
      std::array<PetscInt, N> corners{};
      for (std::size_t k = 0; k < N; ++k) corners[k] = point_of(e.v[k]);
      PetscInt count = 0;
      const PetscInt* join = nullptr;
      check_petsc(DMPlexGetFullJoin(dm_, N, corners.data(), &count, &join));
      if (count == 1) set(N - 1, join[0], e.tag);
      check_petsc(DMPlexRestoreJoin(dm_, N, corners.data(), &count, &join));
    }
  }

  void finish() const {
    for (std::size_t l = 0; l < created_.size(); ++l) {
      if (labels_.completed[l] != 0) check_petsc(DMPlexLabelComplete(dm_, created_[l]));
      check_petsc(DMLabelSetDefaultValue(created_[l], labels_.defaults[l]));
    }
  }

 private:
  int unused_value(int label) const {
    std::set<int> used;
    for (const auto& tags : labels_.tag2values) {
      for (const auto& [tag, values] : tags) {
        for (const auto& [l, value] : values) {
          if (l == label) used.insert(value);
        }
      }
    }
    int unused = -1;
    while (used.count(unused) > 0) --unused;
    return unused;
  }

  DM dm_;
  const Labels& labels_;
  std::vector<DMLabel> created_;
};

}  // namespace

DM plex_of(MPI_Comm comm, Part part, Totals& totals, const Labels& labels) {
  close_gaps(comm, part, totals);
  const Pieces pieces = address(part, std::vector<int>(part.mesh.tets.size(), 0), 0).pieces;
  part = {};
  std::vector<PetscReal> x;
  const std::vector<Vertex> owned = vertices_at_owner(comm, pieces.vertices, totals);
  for (const Vertex& v : owned) x.insert(x.end(), v.x.begin(), v.x.end());
  std::vector<PetscInt> cells;
  for (const Cell& c : pieces.cells) {
    for (const Id v : c.v) cells.push_back(PetscInt(v));
  }
  DM dm = nullptr;
  PetscSF vertex_sf = nullptr;
  check_petsc(DMPlexCreateFromCellListParallelPetsc(comm, 3, petsc_size(pieces.cells), petsc_size(owned), PETSC_DECIDE,
                                                    4, labels.interpolated ? PETSC_TRUE : PETSC_FALSE, cells.data(), 3,
                                                    x.data(), &vertex_sf, nullptr, &dm));
  const IdMap local(ids_of(comm, vertex_sf, std::ssize(owned)));
  check_petsc(PetscSFDestroy(&vertex_sf));
  PetscInt first_vertex = 0;
  PetscInt end = 0;
  check_petsc(DMPlexGetDepthStratum(dm, 0, &first_vertex, &end));
  const auto point_of = [&local, first_vertex](Id id) -> PetscInt { return first_vertex + local[id]; };

  const LabelWriter writer(dm, labels);
  for (const Vertex& v : pieces.vertices) {
    if (local[v.id] >= 0) writer.set(0, point_of(v.id), v.tag);
  }
  PetscInt cell = 0;
  check_petsc(DMPlexGetHeightStratum(dm, 0, &cell, &end));
  for (const Cell& c : pieces.cells) writer.set(3, cell++, c.tag);
  if (labels.interpolated) {
    writer.set_all(pieces.sides, point_of);
    writer.set_all(pieces.lines, point_of);
  }
  writer.finish();
  return dm;
}

namespace {

/// The tags that stand for values of the label of kSets.
std::vector<int> tags_with(const Labels& labels, std::size_t depth, const std::vector<int>& values) {
  std::vector<int> tags;
  for (const int value : values) {
    bool any = false;
    for (const auto& [tag, combination] : labels.tag2values[depth]) {
      for (const auto& [label, v] : combination) {
        if (v != value || item(labels.names, label) != kSets[depth]) continue;
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
