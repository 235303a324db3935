// SPDX-License-Identifier: Apache-2.0
#include "driver/parts/active_part.hpp"

#include <algorithm>
#include <utility>

#include "backend/span.hpp"
#include "boundary/vertex_dof.hpp"
#include "driver/distributed_interface.hpp"
#include "mesh/listed_faces.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/vertex_layers.hpp"
#include "quality/limits.hpp"

namespace tetune {
namespace {

using Marks = std::vector<std::uint8_t>;

/// Takes a part out of a mesh.
class PartTaker {
 public:
  PartTaker(const TetMesh& mesh, const ActiveTets& active, const Constraints& constraints, const Options& options)
      : mesh_(mesh), constraints_(constraints), active_(active.flags), vertex2part_(mesh.points.size(), -1) {
    part_.options = options;
    part_.options.only_below.clear();
    part_.options.rings = Options().rings;
    part_.options.frozen_regions.clear();
    part_.options.frozen_patches.clear();
    take_vertices(vertices_of(mesh.tets, active.flags, mesh.points.size()),
                  vertices_of_others(mesh.tets, active.flags, mesh.points.size()));
    take_tets(active.flags);
  }

  ActivePart take(const ListedFeatures& features, const std::vector<int>& frozen_patches) {
    if (features.corners) freeze(VertexConstraint::corner);
    if (features.line_ends) freeze(VertexConstraint::line_end);
    take_triangles(frozen_patches);
    take_edges(features);
    const std::vector<std::array<Index, 4>> rest = tets_of_rest();
    const OtherElements others(mesh_);
    part_.triangle_stays = triangles_of(rest, others);
    part_.edge_stays = edges_of(rest, others);
    list_cut(part_.mesh, on_cut_);
    part_.options.frozen_vertices = std::move(frozen_);
    return std::move(part_);
  }

 private:
  Index to_part(Index v) const { return span_of(vertex2part_)[v]; }

  void take_vertices(const Marks& in_part, const Marks& in_rest) {
    for (Index v = 0; v < std::ssize(in_part); ++v) {
      if (span_of(in_part)[v] == 0) continue;
      span_of(vertex2part_)[v] = to_index(part_.vertex2whole.size());
      part_.vertex2whole.push_back(v);
      part_.mesh.points.push_back(span_of(mesh_.points)[v]);
      on_cut_.push_back(span_of(in_rest)[v]);
      const bool held = on_cut_.back() != 0 || span_of(constraints_.vertices)[v] == VertexConstraint::frozen;
      frozen_.push_back(held ? 1 : 0);
    }
    part_.mesh.point_tags.assign(part_.mesh.points.size(), 0);
  }

  void take_tets(const Marks& active) {
    Marks locked(mesh_.tets.size(), 0);
    for (const Index t : constraints_.locked_tets) span_of(locked)[t] = 1;
    for (Index t = 0; t < std::ssize(active); ++t) {
      if (span_of(active)[t] == 0) continue;
      if (span_of(locked)[t] != 0) part_.mesh.required_tets.push_back(to_index(part_.tet2whole.size()));
      part_.tet2whole.push_back(t);
      auto tet = span_of(mesh_.tets)[t];
      for (Index& v : tet) v = to_part(v);
      part_.mesh.tets.push_back(tet);
      part_.mesh.tet_tags.push_back(span_of(mesh_.tet_tags)[t]);
    }
  }

  /// Freezes the vertices of one constraint.
  void freeze(VertexConstraint constraint) {
    for (Index v = 0; v < std::ssize(constraints_.vertices); ++v) {
      if (span_of(constraints_.vertices)[v] == constraint && to_part(v) >= 0) span_of(frozen_)[to_part(v)] = 1;
    }
  }

  /// Translates a listed entity. Returns false unless all its vertices are in the part; those that are get frozen then.
  /// They are on the cut, or the entity is no face or edge of the mesh.
  template <std::size_t N>
  bool translate(std::array<Index, N>& entity) {
    const auto is_outside = [this](Index v) { return to_part(v) < 0; };
    const bool inside = std::none_of(entity.begin(), entity.end(), is_outside);
    for (Index& v : entity) {
      v = to_part(v);
      if (!inside && v >= 0) span_of(frozen_)[v] = 1;
    }
    return inside;
  }

  void take_triangles(const std::vector<int>& frozen_patches) {
    TetMesh& to = part_.mesh;
    for (Index i = 0; i < std::ssize(mesh_.triangles); ++i) {
      auto triangle = span_of(mesh_.triangles)[i];
      if (!translate(triangle)) continue;
      const int tag = span_of(mesh_.triangle_tags)[i];
      const bool required =
          (!constraints_.required_triangles.empty() && span_of(constraints_.required_triangles)[i] != 0) ||
          std::find(frozen_patches.begin(), frozen_patches.end(), tag) != frozen_patches.end();
      if (required) to.required_triangles.push_back(to_index(to.triangles.size()));
      part_.triangle2whole.push_back(i);
      to.triangles.push_back(triangle);
      to.triangle_tags.push_back(tag);
    }
  }

  void take_edges(const ListedFeatures& features) {
    Marks is_ridge(mesh_.edges.size(), 0);
    Marks is_required(mesh_.edges.size(), 0);
    for (const Index e : mesh_.ridges) span_of(is_ridge)[e] = 1;
    for (const Index e : mesh_.required_edges) span_of(is_required)[e] = 1;
    TetMesh& to = part_.mesh;
    for (Index i = 0; i < std::ssize(mesh_.edges); ++i) {
      auto edge = span_of(mesh_.edges)[i];
      if (!translate(edge)) continue;
      const int tag = span_of(mesh_.edge_tags)[i];
      const Index at = to_index(to.edges.size());
      if (span_of(is_ridge)[i] != 0 || (features.edges && tag != 0)) to.ridges.push_back(at);
      if (span_of(is_required)[i] != 0) to.required_edges.push_back(at);
      part_.edge2whole.push_back(i);
      to.edges.push_back(edge);
      to.edge_tags.push_back(tag);
    }
  }

  /// The tetrahedra outside the part with an edge in it, in ids of the part; -1: a vertex outside.
  std::vector<std::array<Index, 4>> tets_of_rest() const {
    std::vector<std::array<Index, 4>> rest;
    if (part_.mesh.triangles.empty() && part_.mesh.edges.empty()) return rest;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (active_[t] != 0) continue;
      auto tet = mesh_.tets[t];
      for (Index& v : tet) v = to_part(v);
      if (std::count(tet.begin(), tet.end(), -1) < 3) rest.push_back(tet);
    }
    return rest;
  }

  /// Marks the listed triangles that are faces of tetrahedra outside the part or sides of elements of other kinds.
  Marks triangles_of(const std::vector<std::array<Index, 4>>& rest, const OtherElements& others) const {
    const TetMesh& part = part_.mesh;
    std::vector<std::pair<std::array<Index, 3>, Index>> listed;
    for (Index i = 0; i < std::ssize(part.triangles); ++i) listed.emplace_back(span_of(part.triangles)[i], i);
    const ListedFaces<3> faces(std::move(listed), part.points.size());
    Marks stays(part.triangles.size(), 0);
    for (const auto& tet : rest) {
      for (std::size_t f = 0; f < 4; ++f) {
        faces.find(ascending_face(tet, f), [&stays](Index i) { span_of(stays)[i] = 1; });
      }
    }
    for (std::size_t i = 0; i < stays.size(); ++i) {
      if (others.have(span_of(mesh_.triangles)[part_.triangle2whole[i]])) stays[i] = 1;
    }
    return stays;
  }

  /// Marks the listed edges that last because of their constraints, or of tetrahedra outside the part or elements of
  /// other kinds.
  Marks edges_of(const std::vector<std::array<Index, 4>>& rest, const OtherElements& others) const {
    Marks stays = lasting_edges(part_.mesh, rest, OtherElements(part_.mesh));
    for (std::size_t e = 0; e < stays.size(); ++e) {
      if (others.have(span_of(mesh_.edges)[part_.edge2whole[e]])) stays[e] = 1;
    }
    return stays;
  }

  const TetMesh& mesh_;
  const Constraints& constraints_;
  const Marks& active_;  ///< per tetrahedron
  std::vector<Index> vertex2part_;
  Marks on_cut_, frozen_;  ///< per vertex of the part
  ActivePart part_;
};

}  // namespace

std::size_t list_cut(TetMesh& part, const Marks& on_cut) {
  const auto is_on_cut = [&on_cut](Index v) { return span_of(on_cut)[v] != 0; };
  std::vector<std::array<Index, 3>> faces;
  for (const auto& tet : part.tets) {
    for (std::size_t f = 0; f < 4; ++f) {
      const std::array<Index, 3> face = ascending_face(tet, f);
      if (std::all_of(face.begin(), face.end(), is_on_cut)) faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end());
  const std::size_t listed = part.triangles.size();
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool shared = (i > 0 && faces[i - 1] == faces[i]) || (i + 1 < faces.size() && faces[i + 1] == faces[i]);
    if (shared) continue;
    part.required_triangles.push_back(to_index(part.triangles.size()));
    part.triangles.push_back(faces[i]);
    part.triangle_tags.push_back(kCutTag);
  }
  return part.triangles.size() - listed;
}

ActiveTets activate(const TetMesh& mesh, std::vector<std::uint8_t> flags, const Constraints& constraints, int rings) {
  ActiveTets active;
  active.flags = std::move(flags);
  const TetMeshView view(mesh, unit_scale(mesh));
  for (const Index t : constraints.locked_tets) {
    if (view.six_volume(view.tet(t)) > 0) span_of(active.flags)[t] = 0;
  }
  active.count = active.bad = std::count(active.flags.begin(), active.flags.end(), 1);
  std::int64_t before = 0;
  for (int ring = 0; ring < rings && active.count > before; ++ring) {
    active.flags = tets_at(mesh.tets, vertices_of(mesh.tets, active.flags, mesh.points.size()));
    before = std::exchange(active.count, std::count(active.flags.begin(), active.flags.end(), 1));
  }
  return active;
}

ActiveTets find_active(const TetMesh& mesh, const Constraints& constraints, const Options& options) {
  return activate(mesh, tets_missing_limits(mesh, options.only_below, options.threads), constraints, options.rings);
}

ActivePart take_part(const TetMesh& mesh, const ActiveTets& active, const Constraints& constraints,
                     const ListedFeatures& features, const Options& options) {
  return PartTaker(mesh, active, constraints, options).take(features, options.frozen_patches);
}

}  // namespace tetune
