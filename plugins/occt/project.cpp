// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <tuple>

#include "classify.hpp"
#include "spatial_order.hpp"

namespace tetune::plugin {
namespace {

/// The points of each entity, near ones together: parameters of the last one are a good start, and OpenCASCADE keeps
/// the polynomial of the last span of a spline.
std::vector<Index> order_of(const ProjectQuery& query) {
  const std::vector<std::uint64_t> positions = positions_of(query.points);
  std::vector<Index> order(query.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    const auto key = [&](Index i) {
      return std::tuple(item(query.dimensions, i), item(query.entities, i), item(positions, i), i);
    };
    return key(a) < key(b);
  });
  return order;
}

}  // namespace

ProjectAnswer project(const ProjectQuery& query, const Model& model, Workers& workers) {
  ProjectAnswer answer;
  answer.points.resize(query.points.size());
  const std::vector<Index> order = order_of(query);
  const auto project_chunk = [&](NearestPoints& nearest, std::size_t begin, std::size_t end) {
    int last_entity = 0;
    std::optional<gp_Pnt2d> last;  // of a face
    for (std::size_t k = begin; k < end; ++k) {
      const Index i = order[k];
      const gp_Pnt p = pnt(item(query.points, i));
      const int entity = item(query.entities, i);
      gp_Pnt foot;
      if (item(query.dimensions, i) == 0) {
        foot = model.vertex(entity);
      } else if (item(query.dimensions, i) == 1) {
        foot = nearest.on_edge(entity, p).point;
      } else {
        if (entity != last_entity) last.reset();
        Foot found = nearest.on_face(entity, p, item(query.radii, i), last, query.precision);
        if (found.distance > item(query.radii, i)) found = nearest.on_face(entity, p, kAnyRadius);
        if (found.uv) last = found.uv;
        last_entity = entity;
        foot = found.point;
      }
      item(answer.points, i) = {foot.X(), foot.Y(), foot.Z()};
    }
  };
  workers.for_chunks(query.points.size(), query.threads, project_chunk);
  return answer;
}

}  // namespace tetune::plugin
