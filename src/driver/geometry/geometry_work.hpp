// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "mesh/id_maps.hpp"
#include "tetune/geometry.hpp"
#include "tetune/options.hpp"

/// The mesh between the runs of optimize_on_geometry().
namespace tetune {

/// The tags of a work mesh: one per combination of a face of the model with a tag of the caller or with none.
class PatchTags {
 public:
  int add(std::int32_t face, std::optional<int> caller) {
    const auto [at, is_new] = ids_.try_emplace({face, caller}, int(tags_.size()) + 1);
    if (is_new) tags_.push_back({face, caller});
    return at->second;
  }
  std::int32_t face(int tag) const { return tags_[std::size_t(tag - 1)].first; }
  std::optional<int> caller(int tag) const { return tags_[std::size_t(tag - 1)].second; }
  /// The tags that stand for one of the caller's.
  std::vector<int> of_caller(const std::vector<int>& callers) const {
    std::vector<int> found;
    for (int tag = 1; tag <= int(tags_.size()); ++tag) {
      if (caller(tag) && std::find(callers.begin(), callers.end(), *caller(tag)) != callers.end()) found.push_back(tag);
    }
    return found;
  }

 private:
  using Key = std::pair<std::int32_t, std::optional<int>>;
  std::map<Key, int> ids_;
  std::vector<Key> tags_;
};

/// Whether elements of one vertex hold it.
enum class PointElements : std::uint8_t { hold, do_not_hold };

/// Flags the vertices that the caller or the mesh holds. Requires options that check_frozen_vertices() accepts.
inline std::vector<std::uint8_t> held_by_caller(const TetMesh& mesh, const Options& options, PointElements points) {
  std::vector<std::uint8_t> held = options.frozen_vertices;
  held.resize(mesh.points.size(), 0);
  const auto hold = [&](const auto& vertices) {
    for (const Index v : vertices) span_of(held)[v] = 1;
  };
  const auto has = [](const std::vector<int>& list, int tag) {
    return std::find(list.begin(), list.end(), tag) != list.end();
  };
  hold(mesh.required_vertices);
  for (const Index e : mesh.required_edges) hold(span_of(mesh.edges)[e]);
  for (const Index t : mesh.required_triangles) hold(span_of(mesh.triangles)[t]);
  for (const Index t : mesh.required_tets) hold(span_of(mesh.tets)[t]);
  for (Size t = 0; t < std::ssize(mesh.triangles); ++t) {
    if (has(options.frozen_patches, span_of(mesh.triangle_tags)[t])) hold(span_of(mesh.triangles)[t]);
  }
  for (Size t = 0; t < std::ssize(mesh.tets); ++t) {
    if (has(options.frozen_regions, span_of(mesh.tet_tags)[t])) hold(span_of(mesh.tets)[t]);
  }
  for (const ElementBlock& block : mesh.others) {
    if (points == PointElements::hold || block.kind != kPoints) hold(block.element2vertex);
  }
  return held;
}

/// Whether a vertex is on a vertex, edge or face of the model.
inline bool has_entity(const GeometryEntity& entity) { return entity.dimension >= 0 && entity.dimension <= 2; }

/// A mesh between runs, with the entities of the model that its vertices are on.
struct WorkState {
  TetMesh mesh;  ///< its triangles are the whole surface, with the tags of PatchTags
  std::vector<GeometryEntity> entities;
  std::vector<std::uint8_t> held;

  void follow_result(const std::vector<Index>& new2old) {
    if (new2old.empty()) return;
    entities = gather_entries_or(entities, new2old, GeometryEntity());
    held = gather_entries_or(held, new2old, std::uint8_t{0});
  }
  bool may_move(Size v) const { return span_of(held)[v] == 0 && has_entity(span_of(entities)[v]); }
};

}  // namespace tetune
