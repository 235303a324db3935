// SPDX-License-Identifier: Apache-2.0
#include "classify.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "box.hpp"
#include "spatial_order.hpp"

namespace tetune::plugin {
namespace {

/// A face that a point may be on: its distance if that is within the point's radius, otherwise a lower bound of it.
struct NearFace {
  int face;
  double distance;
  std::optional<gp_Pnt2d> uv;
};

/// How far triangles are from a face.
struct Score {
  double distance;
  int face;
  auto operator<=>(const Score&) const = default;
};

using Faces = std::vector<int>;

bool includes(const Faces& larger, const Faces& smaller) {
  return std::includes(larger.begin(), larger.end(), smaller.begin(), smaller.end());
}

class Classifier {
 public:
  Classifier(const ClassifyQuery& query, const Model& model, Workers& workers)
      : q_(query), model_(model), workers_(workers) {}

  ClassifyAnswer run() {
    const std::size_t n = q_.points.size();
    a_.dimensions.assign(n, 0);
    a_.entities.assign(n, 0);
    a_.distances.assign(n, kAnyRadius);
    point2faces_.resize(n);
    is_known_.assign(n, 1);
    on_line_.assign(n, 0);
    find_neighbors();
    measure_points();
    find_faces_of_surfaces();
    assign_triangles();
    find_point_faces();
    find_lines();
    assign_model_vertices();
    for (std::size_t i = 0; i < n; ++i) assign_point(Index(i));
    for (const auto& line : lines_) assign_line(line);
    return std::move(a_);
  }

 private:
  struct Line {
    std::array<Index, 2> points;
    Faces faces;
  };

  gp_Pnt point(Index i) const { return pnt(item(q_.points, i)); }
  double radius(Index i) const { return item(q_.radii, i); }

  void find_neighbors() {
    neighbors_.resize(q_.points.size());
    for (const auto& t : q_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        item(neighbors_, t[k]).push_back(t[(k + 1) % 3]);
        item(neighbors_, t[k]).push_back(t[(k + 2) % 3]);
      }
    }
  }

  /// Finds the faces near each point. Every 64th one starts alone, the others after a neighbor: parameters of the
  /// neighbor start the search, and a face that is far from it is left out.
  void measure_points() {
    constexpr std::size_t kStride = 64;
    const std::size_t n = q_.points.size();
    near_.resize(n);
    std::vector<char> seen(n, 0);
    std::vector<std::pair<Index, Index>> front, next;  // point, neighbor
    for (std::size_t seed = 0; seed < n; seed += kStride) front.emplace_back(Index(seed), -1);
    const std::vector<std::uint64_t> positions = positions_of(q_.points);
    std::size_t unseen = 0;
    while (unseen < n) {
      for (const auto& [point, from] : front) item(seen, point) = 1;
      workers_.for_chunks(front.size(), q_.threads, [&](NearestPoints& nearest, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) measure(nearest, front[i].first, front[i].second);
      });
      next.clear();
      for (const auto& [point, from] : front) {
        for (const Index to : item(neighbors_, point)) {
          if (item(seen, to)) continue;
          item(seen, to) = 1;
          next.emplace_back(to, point);
        }
      }
      front.swap(next);
      std::sort(front.begin(), front.end(), [&](const auto& a, const auto& b) {
        return std::pair(item(positions, a.first), a.first) < std::pair(item(positions, b.first), b.first);
      });
      while (front.empty() && unseen < n) {
        if (!item(seen, unseen)) front.emplace_back(Index(unseen), -1);
        ++unseen;
      }
    }
  }

  void measure(NearestPoints& nearest, Index i, Index neighbor) {
    const gp_Pnt p = point(i);
    const double step = neighbor < 0 ? 0 : p.Distance(point(neighbor));
    for (int f = 1; f <= model_.faces(); ++f) {
      if (!model_.is_first_face(f) || box_distance(model_.face_box(f), p) > radius(i)) continue;
      const NearFace* known = neighbor < 0 ? nullptr : find(neighbor, f);
      if (known != nullptr && known->distance - step > radius(i)) {
        item(near_, i).push_back({f, known->distance - step, {}});
        continue;
      }
      const Foot foot = nearest.on_face(f, p, radius(i), known != nullptr ? known->uv : std::nullopt);
      item(near_, i).push_back({f, foot.distance, foot.uv});
      item(a_.distances, i) = std::min(item(a_.distances, i), foot.distance);
    }
    if (item(a_.distances, i) > radius(i)) item(a_.distances, i) = distance_from_model(nearest, p);
  }

  double distance_from_model(NearestPoints& nearest, const gp_Pnt& p) {
    double least = kAnyRadius;
    for (int f = 1; f <= model_.faces(); ++f) {
      if (box_distance(model_.face_box(f), p) < least) least = std::min(least, nearest.on_face(f, p, least).distance);
    }
    return least;
  }

  const NearFace* find(Index i, int face) const {
    for (const NearFace& near : item(near_, i)) {
      if (near.face == face) return &near;
    }
    return nullptr;
  }

  /// A surface of the mesh's file: the faces that all its triangles are near, with the sum of distances of vertices.
  struct FileSurface {
    std::vector<Score> scores;
    double radii = 0;  ///< sum of the radii of the same vertices
  };

  /// The faces that all vertices of a triangle are near, with the sum of their distances.
  std::vector<Score> vertex_scores(const std::array<Index, 3>& t) const {
    std::vector<Score> scores;
    for (const NearFace& near : item(near_, t[0])) {
      double sum = 0;
      for (const Index i : t) {
        const NearFace* other = find(i, near.face);
        sum += other != nullptr && other->distance <= radius(i) ? other->distance : kAnyRadius;
      }
      if (sum < kAnyRadius) scores.push_back({sum, near.face});
    }
    return scores;
  }

  /// Whether the first of sorted scores is clearly the least.
  static bool is_clear(const std::vector<Score>& scores, double r) {
    return scores.size() == 1 ||
           (scores.size() > 1 && scores[1].distance > kClearer * scores[0].distance + kRounding * r);
  }

  std::map<int, FileSurface> file_surfaces() const {
    std::map<int, FileSurface> surfaces;
    for (std::size_t t = 0; t < q_.surfaces.size(); ++t) {
      if (q_.surfaces[t] == 0) continue;
      const std::vector<Score> near = vertex_scores(q_.triangles[t]);
      const auto [at, is_new] = surfaces.try_emplace(q_.surfaces[t]);
      std::vector<Score>& scores = at->second.scores;
      for (const Index i : q_.triangles[t]) at->second.radii += radius(i);
      if (is_new) {
        scores = near;
        continue;
      }
      for (Score& score : scores) {
        const auto other = std::find_if(near.begin(), near.end(), [&](const Score& s) { return s.face == score.face; });
        score.distance += other != near.end() ? other->distance : kAnyRadius;
      }
      std::erase_if(scores, [](const Score& score) { return score.distance == kAnyRadius; });
    }
    for (auto& [number, surface] : surfaces) std::sort(surface.scores.begin(), surface.scores.end());
    return surfaces;
  }

  /// A surface of the mesh's file belongs to the face that all its triangles are clearly nearest to. Where these are
  /// several, it is the face of its number, if the numbers of all others are those of their faces.
  void find_faces_of_surfaces() {
    const std::map<int, FileSurface> surfaces = file_surfaces();
    bool have_same_numbers = true;
    for (const auto& [number, s] : surfaces) {
      if (is_clear(s.scores, s.radii) && s.scores[0].face != model_.first_face(number)) have_same_numbers = false;
    }
    for (const auto& [number, s] : surfaces) {
      const int own = model_.first_face(number);
      const auto is_own = [&](const Score& score) {
        return score.face == own && score.distance <= kClearer * s.scores[0].distance + kRounding * s.radii;
      };
      int& face = surface2face_[number];
      if (is_clear(s.scores, s.radii)) {
        face = s.scores[0].face;
      } else if (have_same_numbers && std::any_of(s.scores.begin(), s.scores.end(), is_own)) {
        face = own;
      }
      ++a_.surfaces;
      if (face != own || own == 0) ++a_.surfaces_differing;
    }
  }

  void assign_triangles() {
    const std::size_t n = q_.triangles.size();
    a_.triangle_faces.assign(n, 0);
    std::vector<char> ambiguous(n, 0);
    workers_.for_chunks(n, q_.threads, [&](NearestPoints& nearest, std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) ambiguous[t] = !assign_triangle(nearest, t);
    });
    a_.ambiguous_triangles = std::count(ambiguous.begin(), ambiguous.end(), 1);
  }

  /// Returns false where the triangle is near to several faces.
  bool assign_triangle(NearestPoints& nearest, std::size_t triangle) {
    const std::array<Index, 3>& t = q_.triangles[triangle];
    if (!q_.surfaces.empty() && q_.surfaces[triangle] != 0) {
      a_.triangle_faces[triangle] = surface2face_.at(q_.surfaces[triangle]);
      if (a_.triangle_faces[triangle] != 0) return true;
    }
    const double r = (radius(t[0]) + radius(t[1]) + radius(t[2])) / 3;
    bool all_near = true;
    for (const Index i : t) all_near = all_near && item(a_.distances, i) <= radius(i);
    std::vector<Score> scores = vertex_scores(t);
    if (scores.size() > 1) {
      for (Score& score : scores) {
        score.distance = kPointWeight * score.distance + middle_distances(nearest, t, score.face, r);
      }
      std::sort(scores.begin(), scores.end());
    }
    if (!is_clear(scores, r)) return !all_near;
    a_.triangle_faces[triangle] = scores[0].face;
    return true;
  }

  /// The sum of the distances of the midpoints of the edges and of the centroid.
  double middle_distances(NearestPoints& nearest, const std::array<Index, 3>& t, int face, double r) {
    double sum = 0;
    const std::optional<gp_Pnt2d> guess = find(t[0], face)->uv;
    const gp_XYZ p[3] = {point(t[0]).XYZ(), point(t[1]).XYZ(), point(t[2]).XYZ()};
    for (const gp_XYZ& middle : {(p[0] + p[1]) / 2, (p[1] + p[2]) / 2, (p[2] + p[0]) / 2, (p[0] + p[1] + p[2]) / 3}) {
      sum += std::min(nearest.on_face(face, middle, 4 * r, guess).distance, 4 * r);
    }
    return sum;
  }

  void find_point_faces() {
    for (std::size_t t = 0; t < q_.triangles.size(); ++t) {
      for (const Index i : q_.triangles[t]) {
        if (a_.triangle_faces[t] == 0) item(is_known_, i) = 0;
        item(point2faces_, i).push_back(a_.triangle_faces[t]);
      }
    }
    for (Faces& faces : point2faces_) sort_unique(faces);
  }

  static void sort_unique(Faces& faces) {
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  }

  /// Finds the edges of the mesh that are not between two triangles of one face.
  void find_lines() {
    std::vector<std::pair<std::array<Index, 2>, int>> sides;
    for (std::size_t t = 0; t < q_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = q_.triangles[t][k], b = q_.triangles[t][(k + 1) % 3];
        sides.push_back({{std::min(a, b), std::max(a, b)}, a_.triangle_faces[t]});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      Faces faces;
      for (end = begin; end < sides.size() && sides[end].first == sides[begin].first; ++end) {
        faces.push_back(sides[end].second);
      }
      if (faces.size() == 2 && faces[0] == faces[1]) continue;
      sort_unique(faces);
      if (faces[0] == 0) continue;
      for (const Index i : sides[begin].first) item(on_line_, i) = 1;
      lines_.push_back({sides[begin].first, std::move(faces)});
    }
  }

  void assign_model_vertices() {
    std::vector<Index> candidates;
    for (Index i = 0; i < index_count(q_.points); ++i) {
      if (item(is_known_, i) && item(on_line_, i)) candidates.push_back(i);
    }
    for (int v = 1; v <= model_.vertices(); ++v) {
      if (!model_.is_feature_vertex(v)) continue;
      Index best = -1;
      double least = kAnyRadius;
      for (const Index i : candidates) {
        const double d = point(i).Distance(model_.vertex(v));
        if (d > radius(i) || d >= least || item(point2faces_, i) != model_.faces_of_vertex(v)) continue;
        least = d;
        best = i;
      }
      if (best >= 0) set(best, 0, v, least);
      a_.unmatched_vertices += best < 0 ? 1 : 0;
    }
  }

  void set(Index i, std::int8_t dimension, int entity, double distance) {
    item(a_.dimensions, i) = dimension;
    item(a_.entities, i) = entity;
    item(a_.distances, i) = distance;
  }

  void assign_point(Index i) {
    const Faces& faces = item(point2faces_, i);
    if (item(a_.entities, i) != 0 || !item(is_known_, i) || faces.empty()) return;
    if (!item(on_line_, i)) {
      set(i, 2, faces[0], find(i, faces[0])->distance);
      return;
    }
    const auto [edge, distance] = nearest_edge(faces, point(i));
    if (distance <= radius(i)) {
      set(i, 1, edge, distance);
      return;
    }
    for (int v = 1; v <= model_.vertices(); ++v) {
      if (!model_.is_feature_vertex(v) || !includes(model_.faces_of_vertex(v), faces)) continue;
      const double d = point(i).Distance(model_.vertex(v));
      if (d <= radius(i) && (item(a_.entities, i) == 0 || d < item(a_.distances, i))) set(i, 0, v, d);
    }
  }

  void assign_line(const Line& line) {
    for (const Index i : line.points) {
      if (item(a_.entities, i) == 0 || item(a_.dimensions, i) == 2) return;
    }
    const gp_XYZ middle = (point(line.points[0]).XYZ() + point(line.points[1]).XYZ()) / 2;
    const auto [edge, distance] = nearest_edge(line.faces, middle);
    if (distance > radius(line.points[0]) + radius(line.points[1])) return;
    a_.edges.push_back(line.points);
    a_.edge_entities.push_back(edge);
  }

  /// The nearest edge of the model that bounds all of these faces, and its distance.
  std::pair<int, double> nearest_edge(const Faces& faces, const gp_Pnt& p) {
    std::pair<int, double> best{0, kAnyRadius};
    for (const int e : model_.edges_of_face(faces[0])) {
      if (!model_.is_feature_edge(e) || !includes(model_.faces_of_edge(e), faces)) continue;
      const double d = workers_.own().on_edge(e, p).distance;
      if (d < best.second) best = {e, d};
    }
    return best;
  }

  /// The distance of a vertex counts more than that of a midpoint, which is off its own face where that is curved.
  static constexpr double kPointWeight = 10;
  /// A face is clearly nearer than another one if this many times its distance is less.
  static constexpr double kClearer = 1.5;
  static constexpr double kRounding = 1e-6;

  const ClassifyQuery& q_;
  const Model& model_;
  Workers& workers_;
  ClassifyAnswer a_;
  std::vector<std::vector<Index>> neighbors_;
  std::vector<std::vector<NearFace>> near_;
  std::map<int, int> surface2face_;  ///< 0: by distance
  std::vector<Faces> point2faces_;   ///< faces of the triangles around each point
  std::vector<char> is_known_;       ///< all triangles around the point have a face
  std::vector<char> on_line_;
  std::vector<Line> lines_;
};

}  // namespace

ClassifyAnswer classify(const ClassifyQuery& query, const Model& model, Workers& workers) {
  return Classifier(query, model, workers).run();
}

}  // namespace tetune::plugin
