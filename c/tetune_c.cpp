// SPDX-License-Identifier: Apache-2.0
// The C interface, over the public C++ headers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "objects.hpp"

namespace {

using tetune::Index;
using tetune::TetMesh;
using tetune::c::checked;
using tetune::c::guarded;
using tetune::c::InvalidArgument;
using tetune::c::require;

thread_local std::string last_error;
thread_local std::vector<std::string> last_warnings;  // of the last file that was read or written

/// The number of entries of a caller's array, which exists unless it is empty.
std::size_t checked_size(const void* array, std::int64_t count) {
  require(count >= 0 && count <= std::numeric_limits<Index>::max(),
          "a number of entries is negative or above 2^31 - 1");
  require(array != nullptr || count == 0, "a null pointer was given where an array is required");
  return std::size_t(count);
}

template <class T, std::size_t n>
std::vector<std::array<T, n>> rows(const T* values, std::int64_t count) {
  std::vector<std::array<T, n>> result(checked_size(values, count));
  for (std::size_t i = 0; i < result.size(); ++i) std::copy_n(values + n * i, n, result[i].begin());
  return result;
}

template <class Vector>
auto* first_value(const Vector& rows) {
  return rows.empty() ? nullptr : rows.data()->data();
}

/// The vector of a kind of entities, const as the mesh is.
template <class Mesh>
auto* tags_of(Mesh& mesh, tetune_kind kind) {
  switch (kind) {
    case TETUNE_VERTICES:
      return &mesh.point_tags;
    case TETUNE_EDGES:
      return &mesh.edge_tags;
    case TETUNE_TRIANGLES:
      return &mesh.triangle_tags;
    case TETUNE_TETRAHEDRA:
      return &mesh.tet_tags;
  }
  throw InvalidArgument{"an unknown kind of entities was given"};
}

std::vector<Index>& required_of(TetMesh& mesh, tetune_kind kind) {
  switch (kind) {
    case TETUNE_VERTICES:
      return mesh.required_vertices;
    case TETUNE_EDGES:
      return mesh.required_edges;
    case TETUNE_TRIANGLES:
      return mesh.required_triangles;
    case TETUNE_TETRAHEDRA:
      return mesh.required_tets;
  }
  throw InvalidArgument{"an unknown kind of entities was given"};
}

tetune::Context hooks_of(tetune_progress_function progress, void* user) {
  tetune::Context context;
  if (progress != nullptr) {
    context.progress = [progress, user](const tetune::Progress& now) {
      const tetune_progress state{now.phase, now.fraction, now.seconds, now.worst_angle};
      return progress(&state, user) != 0;
    };
  }
  return context;
}

/// Runs `optimize`, which returns a tetune::Report; `report` may be null.
template <class F>
void run(tetune_report** report, const F& optimize) {
  // Allocated before the mesh changes.
  std::unique_ptr<tetune_report> made(report == nullptr ? nullptr : new tetune_report{});
  tetune::Report done = optimize();
  if (report == nullptr) return;
  made->report = std::move(done);
  *report = made.release();
}

tetune::Options options_of(const tetune_options* options) {
  return options == nullptr ? tetune::Options{} : options->options;
}

std::optional<double> limit_of(double value) { return std::isnan(value) ? std::nullopt : std::optional<double>(value); }

}  // namespace

tetune_status tetune::c::failed(tetune_status status, const char* text) noexcept {
  try {
    last_error = text;
  } catch (const std::bad_alloc&) {
    last_error.clear();
  }
  return status;
}

const char* tetune_version(void) { return TETUNE_VERSION; }

const char* tetune_last_error(void) { return last_error.c_str(); }

int64_t tetune_last_warnings(void) { return std::ssize(last_warnings); }

const char* tetune_last_warning(int64_t position) {
  const char* text = nullptr;
  guarded([&] {
    require(position >= 0 && position < std::ssize(last_warnings), "there is no warning at this position");
    text = last_warnings[std::size_t(position)].c_str();
  });
  return text;
}

tetune_status tetune_mesh_create(const double* points, int64_t vertices, const int32_t* tetrahedra, int64_t count,
                                 tetune_mesh** mesh) {
  return guarded([&] {
    checked(mesh) = nullptr;
    TetMesh made;
    made.points = rows<double, 3>(points, vertices);
    made.tets = rows<Index, 4>(tetrahedra, count);
    made.point_tags.resize(made.points.size());
    made.tet_tags.resize(made.tets.size());
    *mesh = new tetune_mesh{std::move(made)};
  });
}

void tetune_mesh_destroy(tetune_mesh* mesh) { delete mesh; }

tetune_status tetune_mesh_read(const char* path, tetune_mesh** mesh) {
  return guarded([&] {
    last_warnings.clear();
    checked(mesh) = nullptr;
    *mesh = new tetune_mesh{tetune::read_mesh(&checked(path), &last_warnings)};
  });
}

tetune_status tetune_mesh_write(const tetune_mesh* mesh, const char* path) {
  return guarded([&] {
    last_warnings.clear();
    tetune::write_mesh(&checked(path), checked(mesh).mesh, 0, &last_warnings);
  });
}

tetune_status tetune_mesh_set_elements(tetune_mesh* mesh, tetune_kind kind, const int32_t* ids, int64_t count) {
  return guarded([&] {
    TetMesh& to = checked(mesh).mesh;
    require(kind == TETUNE_EDGES || kind == TETUNE_TRIANGLES, "only edges and triangles can be set");
    if (kind == TETUNE_EDGES) {
      auto edges = rows<Index, 2>(ids, count);
      std::vector<int> tags(edges.size());
      to.edges = std::move(edges);
      to.edge_tags = std::move(tags);
      to.ridges.clear();
      to.required_edges.clear();
      to.edge_data.clear();
    } else {
      auto triangles = rows<Index, 3>(ids, count);
      std::vector<int> tags(triangles.size());
      to.triangles = std::move(triangles);
      to.triangle_tags = std::move(tags);
      to.required_triangles.clear();
      to.triangle_data.clear();
    }
  });
}

tetune_status tetune_mesh_set_tags(tetune_mesh* mesh, tetune_kind kind, const int32_t* tags, int64_t count) {
  return guarded([&] {
    std::vector<int>& to = *tags_of(checked(mesh).mesh, kind);
    require(checked_size(tags, count) == to.size(), "there must be one tag per entity");
    std::copy_n(tags, to.size(), to.begin());
  });
}

tetune_status tetune_mesh_set_required(tetune_mesh* mesh, tetune_kind kind, const int32_t* positions, int64_t count) {
  return guarded([&] {
    std::vector<Index>& to = required_of(checked(mesh).mesh, kind);
    to.assign(positions, positions + checked_size(positions, count));
  });
}

int64_t tetune_mesh_count(const tetune_mesh* mesh, tetune_kind kind) {
  std::int64_t count = 0;
  guarded([&] { count = std::ssize(*tags_of(checked(mesh).mesh, kind)); });
  return count;
}

const double* tetune_mesh_points(const tetune_mesh* mesh) {
  const double* points = nullptr;
  guarded([&] { points = first_value(checked(mesh).mesh.points); });
  return points;
}

const int32_t* tetune_mesh_elements(const tetune_mesh* mesh, tetune_kind kind) {
  const Index* ids = nullptr;
  guarded([&] {
    const TetMesh& from = checked(mesh).mesh;
    require(kind != TETUNE_VERTICES, "vertices have coordinates: tetune_mesh_points()");
    if (kind == TETUNE_EDGES) ids = first_value(from.edges);
    if (kind == TETUNE_TRIANGLES) ids = first_value(from.triangles);
    if (kind == TETUNE_TETRAHEDRA) ids = first_value(from.tets);
  });
  return ids;
}

const int32_t* tetune_mesh_tags(const tetune_mesh* mesh, tetune_kind kind) {
  const int* tags = nullptr;
  guarded([&] { tags = tags_of(checked(mesh).mesh, kind)->data(); });
  return tags;
}

tetune_status tetune_mesh_validate(const tetune_mesh* mesh) {
  return guarded([&] {
    const tetune::ValidationReport report = tetune::validate(checked(mesh).mesh);
    if (!report.ok()) throw tetune::MeshError(report.message(false));
  });
}

tetune_status tetune_mesh_quality(const tetune_mesh* mesh, tetune_quality* quality) {
  return guarded([&] {
    const tetune::Quality q = tetune::quality(checked(mesh).mesh);
    checked(quality) = {q.dihedral_min,   q.dihedral_max, q.dihedral_p5, q.mean_ratio,
                        q.mean_ratio_min, q.volume,       q.worst_tet};
  });
}

tetune_status tetune_options_create(tetune_options** options) {
  return guarded([&] {
    checked(options) = nullptr;
    *options = new tetune_options{};
  });
}

void tetune_options_destroy(tetune_options* options) { delete options; }

tetune_status tetune_options_set(tetune_options* options, const char* name, const char* value) {
  return guarded([&] { tetune::set_option(checked(options).options, &checked(name), &checked(value)); });
}

tetune_status tetune_optimize(tetune_mesh* mesh, const tetune_options* options, tetune_progress_function progress,
                              void* user, tetune_report** report) {
  if (report != nullptr) *report = nullptr;
  return guarded([&] {
    TetMesh& to = checked(mesh).mesh;
    run(report, [&] { return tetune::optimize(to, options_of(options), hooks_of(progress, user)); });
  });
}

void tetune_report_destroy(tetune_report* report) { delete report; }

tetune_status tetune_criteria_create(const char* preset, tetune_criteria** criteria) {
  return guarded([&] {
    checked(criteria) = nullptr;
    const tetune::AcceptanceCriteria* known = preset == nullptr ? nullptr : tetune::find_preset(preset);
    if (preset != nullptr && known == nullptr) {
      throw tetune::OptionError("there are no criteria of the name '" + std::string(preset) + "'");
    }
    *criteria = new tetune_criteria{known == nullptr ? tetune::AcceptanceCriteria{"criteria", {}} : *known};
  });
}

void tetune_criteria_destroy(tetune_criteria* criteria) { delete criteria; }

tetune_status tetune_criteria_add(tetune_criteria* criteria, const char* measure, double warn, double fail,
                                  double allowed_percent) {
  return guarded([&] {
    const tetune::CheckMeasureInfo* known = tetune::find_check_measure(&checked(measure));
    if (known == nullptr) throw tetune::OptionError("there is no measure '" + std::string(measure) + "'");
    const tetune::AcceptanceCriterion criterion{known->measure, limit_of(warn), limit_of(fail), allowed_percent};
    tetune::check_criterion(criterion);
    checked(criteria).criteria.criteria.push_back(criterion);
  });
}

tetune_status tetune_mesh_check(const tetune_mesh* mesh, const tetune_criteria* criteria, tetune_verdict* verdict) {
  return guarded([&] {
    const tetune::AcceptanceReport report = tetune::check(checked(mesh).mesh, checked(criteria).criteria);
    checked(verdict) = tetune_verdict(report.verdict);
  });
}

tetune_status tetune_optimize_towards(tetune_mesh* mesh, const tetune_criteria* criteria, const tetune_options* options,
                                      tetune_progress_function progress, void* user, tetune_report** report,
                                      tetune_verdict* verdict) {
  if (report != nullptr) *report = nullptr;
  return guarded([&] {
    TetMesh& to = checked(mesh).mesh;
    const tetune::AcceptanceCriteria& limits = checked(criteria).criteria;
    run(report, [&] {
      tetune::CriteriaReport done = tetune::optimize_towards(to, limits, options_of(options), hooks_of(progress, user));
      if (verdict != nullptr) *verdict = tetune_verdict(done.after.verdict);
      return std::move(done.optimization);
    });
  });
}
