/* SPDX-License-Identifier: Apache-2.0
 * A C program over tetune.h: whole runs, and every kind of error. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tetune/tetune.h"

#define CHECK(condition)                                                                        \
  do {                                                                                          \
    if (!(condition)) {                                                                         \
      fprintf(stderr, "%s:%d: %s (%s)\n", __FILE__, __LINE__, #condition, tetune_last_error()); \
      exit(1);                                                                                  \
    }                                                                                           \
  } while (0)

enum { N = 4, SIDE = N + 1, VERTICES = SIDE * SIDE * SIDE, TETRAHEDRA = 6 * N * N * N };

static double points[3 * VERTICES];
static int32_t tetrahedra[4 * TETRAHEDRA];

static int32_t vertex(int x, int y, int z) { return (int32_t)((z * SIDE + y) * SIDE + x); }

/* A cube of Kuhn's tetrahedra with inner vertices off the lattice. */
static void make_cube(void) {
  static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  int32_t* tet = tetrahedra;
  int c[3];
  for (c[2] = 0; c[2] < SIDE; ++c[2]) {
    for (c[1] = 0; c[1] < SIDE; ++c[1]) {
      for (c[0] = 0; c[0] < SIDE; ++c[0]) {
        const int32_t v = vertex(c[0], c[1], c[2]);
        for (int k = 0; k < 3; ++k) {
          const int is_inner = c[0] % N != 0 && c[1] % N != 0 && c[2] % N != 0;
          points[3 * v + k] = c[k] + (is_inner ? 0.25 * sin(7.0 * v + 3.0 * k) : 0.0);
        }
        if (c[0] == N || c[1] == N || c[2] == N) continue;
        for (int i = 0; i < 6; ++i, tet += 4) {
          int at[3] = {c[0], c[1], c[2]};
          tet[0] = v;
          for (int k = 0; k < 3; ++k) {
            ++at[orders[i][k]];
            tet[k + 1] = vertex(at[0], at[1], at[2]);
          }
          if (i >= 3) { /* an odd order: the other orientation */
            const int32_t swapped = tet[1];
            tet[1] = tet[2];
            tet[2] = swapped;
          }
        }
      }
    }
  }
}

static int count_calls(const tetune_progress* progress, void* user) {
  CHECK(progress->fraction >= 0 && progress->fraction <= 1 && progress->phase != NULL);
  ++*(int*)user;
  return 1;
}
static int stop_at_once(const tetune_progress* progress, void* user) {
  (void)progress;
  (void)user;
  return 0;
}

static tetune_mesh* cube(void) {
  tetune_mesh* mesh = NULL;
  CHECK(tetune_mesh_create(points, VERTICES, tetrahedra, TETRAHEDRA, &mesh) == TETUNE_OK);
  return mesh;
}

static void test_run(void) {
  tetune_mesh* mesh = cube();
  tetune_options* options = NULL;
  tetune_report* report = NULL;
  tetune_quality before, after;
  int32_t tags[TETRAHEDRA];
  const int32_t held[1] = {vertex(1, 2, 3)};
  int calls = 0;
  for (int t = 0; t < TETRAHEDRA; ++t) tags[t] = points[3 * tetrahedra[4 * t]] < 0.5 * N ? 1 : 2;
  CHECK(tetune_mesh_validate(mesh) == TETUNE_OK);
  CHECK(tetune_mesh_set_tags(mesh, TETUNE_TETRAHEDRA, tags, TETRAHEDRA) == TETUNE_OK);
  CHECK(tetune_mesh_set_required(mesh, TETUNE_VERTICES, held, 1) == TETUNE_OK);
  CHECK(tetune_mesh_quality(mesh, &before) == TETUNE_OK);
  CHECK(tetune_options_create(&options) == TETUNE_OK);
  CHECK(tetune_options_set(options, "effort", "best") == TETUNE_OK);
  CHECK(tetune_options_set(options, "threads", "2") == TETUNE_OK);
  CHECK(tetune_options_set(options, "feature_angle", "30") == TETUNE_OK);
  CHECK(tetune_optimize(mesh, options, count_calls, &calls, &report) == TETUNE_OK);
  CHECK(tetune_mesh_quality(mesh, &after) == TETUNE_OK);
  CHECK(after.min_dihedral > before.min_dihedral && after.mean_ratio > before.mean_ratio);
  CHECK(fabs(after.volume - before.volume) < 1e-9 * before.volume);
  CHECK(calls > 0);
  const int32_t* vertex2original = tetune_report_original(report, TETUNE_VERTICES);
  int32_t now = 0;
  while (vertex2original != NULL && vertex2original[now] != held[0]) ++now;
  if (vertex2original == NULL) now = held[0];
  CHECK(memcmp(tetune_mesh_points(mesh) + 3 * now, points + 3 * held[0], 3 * sizeof(double)) == 0);
  CHECK(tetune_report_energy(report, 0) > 0 && tetune_report_energy(report, 1) > 0);
  CHECK(tetune_report_seconds(report) > 0 && strcmp(tetune_report_stop(report), "converged") == 0);
  CHECK(tetune_report_warnings(report) == 1);
  CHECK(strstr(tetune_report_warning(report, 0), "feature_angle") != NULL);
  CHECK(tetune_report_warning(report, 1) == NULL);
  const int32_t* original = tetune_report_original(report, TETUNE_TETRAHEDRA);
  for (int64_t t = 0; t < tetune_mesh_count(mesh, TETUNE_TETRAHEDRA); ++t) {
    CHECK(tetune_mesh_tags(mesh, TETUNE_TETRAHEDRA)[t] == tags[original[t]]);
  }
  CHECK(tetune_report_original(report, (tetune_kind)7) == NULL);
  tetune_report_destroy(report);
  tetune_options_destroy(options);
  tetune_mesh_destroy(mesh);
}

static void test_file(void) {
  tetune_mesh* mesh = cube();
  tetune_mesh* read = NULL;
  const int32_t triangle[3] = {vertex(0, 0, 0), vertex(1, 1, 0), vertex(1, 0, 0)};
  const int32_t patch[1] = {7};
  CHECK(tetune_mesh_set_elements(mesh, TETUNE_TRIANGLES, triangle, 1) == TETUNE_OK);
  CHECK(tetune_mesh_set_tags(mesh, TETUNE_TRIANGLES, patch, 1) == TETUNE_OK);
  CHECK(tetune_mesh_write(mesh, "c_test.meshb") == TETUNE_OK);
  CHECK(tetune_mesh_read("c_test.meshb", &read) == TETUNE_OK);
  CHECK(tetune_mesh_count(read, TETUNE_VERTICES) == VERTICES && tetune_mesh_count(read, TETUNE_EDGES) == 0);
  CHECK(memcmp(tetune_mesh_points(read), points, sizeof(points)) == 0);
  CHECK(memcmp(tetune_mesh_elements(read, TETUNE_TETRAHEDRA), tetrahedra, sizeof(tetrahedra)) == 0);
  CHECK(memcmp(tetune_mesh_elements(read, TETUNE_TRIANGLES), triangle, sizeof(triangle)) == 0);
  CHECK(tetune_mesh_tags(read, TETUNE_TRIANGLES)[0] == 7);
  CHECK(tetune_mesh_elements(read, TETUNE_EDGES) == NULL);
  CHECK(tetune_last_warnings() == 0 && tetune_last_warning(0) == NULL);
  int32_t corner = 0;
  CHECK(tetune_mesh_set_required(read, TETUNE_VERTICES, &corner, 1) == TETUNE_OK);
  CHECK(tetune_mesh_write(read, "c_test.su2") == TETUNE_OK);
  CHECK(tetune_last_warnings() == 1 && tetune_last_warning(-1) == NULL && tetune_last_warning(1) == NULL);
  CHECK(strstr(tetune_last_warning(0), "c_test.su2: the format cannot hold lists of corners") != NULL);
  FILE* file = fopen("c_test.su2", "a");
  fputs("UNKNOWN= 1\n", file);
  fclose(file);
  tetune_mesh* again = NULL;
  CHECK(tetune_mesh_read("c_test.su2", &again) == TETUNE_OK && tetune_last_warnings() == 1);
  CHECK(strstr(tetune_last_warning(0), "UNKNOWN is not kept") != NULL);
  tetune_mesh_destroy(again);
  CHECK(tetune_mesh_read("absent.mesh", &again) == TETUNE_FILE_ERROR && tetune_last_warnings() == 0);
  remove("c_test.su2");
  tetune_mesh_destroy(read);
  tetune_mesh_destroy(mesh);
  remove("c_test.meshb");
}

static void test_stop(void) {
  tetune_mesh* mesh = cube();
  tetune_report* report = NULL;
  CHECK(tetune_optimize(mesh, NULL, stop_at_once, NULL, &report) == TETUNE_OK);
  CHECK(strcmp(tetune_report_stop(report), "cancelled") == 0);
  CHECK(tetune_mesh_validate(mesh) == TETUNE_OK);
  tetune_report_destroy(report);
  tetune_mesh_destroy(mesh);
}

static void test_criteria(void) {
  tetune_mesh* mesh = cube();
  tetune_criteria* criteria = NULL;
  tetune_report* report = NULL;
  tetune_verdict verdict = TETUNE_FAIL;
  CHECK(tetune_criteria_create("calculix", &criteria) == TETUNE_OK);
  CHECK(tetune_mesh_check(mesh, criteria, &verdict) == TETUNE_OK && verdict == TETUNE_PASS);
  CHECK(tetune_criteria_add(criteria, "mean_ratio", 0.99, NAN, 0) == TETUNE_OK);
  CHECK(tetune_mesh_check(mesh, criteria, &verdict) == TETUNE_OK && verdict == TETUNE_WARN);
  tetune_criteria_destroy(criteria);

  CHECK(tetune_criteria_create(NULL, &criteria) == TETUNE_OK);
  CHECK(tetune_criteria_add(criteria, "min_dihedral_deg", NAN, 20, 0) == TETUNE_OK);
  CHECK(tetune_mesh_check(mesh, criteria, &verdict) == TETUNE_OK && verdict == TETUNE_FAIL);
  CHECK(tetune_optimize_towards(mesh, criteria, NULL, NULL, NULL, &report, &verdict) == TETUNE_OK);
  CHECK(verdict == TETUNE_PASS && tetune_report_energy(report, 1) < tetune_report_energy(report, 0));
  CHECK(tetune_mesh_check(mesh, criteria, &verdict) == TETUNE_OK && verdict == TETUNE_PASS);
  CHECK(tetune_criteria_add(criteria, "mean_ration", NAN, 1, 0) == TETUNE_OPTION_ERROR);
  CHECK(tetune_criteria_add(criteria, "mean_ratio", NAN, NAN, 0) == TETUNE_OPTION_ERROR);
  CHECK(tetune_optimize_towards(mesh, NULL, NULL, NULL, NULL, NULL, NULL) == TETUNE_INVALID_ARGUMENT);
  tetune_report_destroy(report);
  tetune_criteria_destroy(criteria);
  CHECK(tetune_criteria_create("abacus", &criteria) == TETUNE_OPTION_ERROR && criteria == NULL);
  tetune_criteria_destroy(NULL);
  tetune_mesh_destroy(mesh);
}

static void test_errors(void) {
  tetune_mesh* mesh = cube();
  tetune_mesh* none = mesh;
  tetune_options* options = NULL;
  tetune_quality quality;
  CHECK(tetune_mesh_read("absent.mesh", &none) == TETUNE_FILE_ERROR && none == NULL);
  CHECK(strstr(tetune_last_error(), "absent.mesh") != NULL);
  CHECK(tetune_mesh_read(NULL, &none) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_create(points, VERTICES, NULL, 1, &none) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_create(points, -1, tetrahedra, 1, &none) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_create(points, VERTICES, tetrahedra, 1, NULL) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_quality(NULL, &quality) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_set_elements(mesh, TETUNE_TETRAHEDRA, tetrahedra, 1) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_mesh_set_tags(mesh, TETUNE_TETRAHEDRA, tetrahedra, 3) == TETUNE_INVALID_ARGUMENT);
  CHECK(tetune_optimize(NULL, NULL, NULL, NULL, NULL) == TETUNE_INVALID_ARGUMENT);
  tetune_report* unset = (tetune_report*)mesh; /* any value: a failure leaves null */
  CHECK(tetune_optimize(NULL, NULL, NULL, NULL, &unset) == TETUNE_INVALID_ARGUMENT && unset == NULL);
  unset = (tetune_report*)mesh;
  CHECK(tetune_optimize_towards(mesh, NULL, NULL, NULL, NULL, &unset, NULL) == TETUNE_INVALID_ARGUMENT &&
        unset == NULL);
  CHECK(tetune_mesh_count(NULL, TETUNE_VERTICES) == 0 && tetune_mesh_points(NULL) == NULL);

  CHECK(tetune_options_create(&options) == TETUNE_OK);
  CHECK(tetune_options_set(options, "efort", "best") == TETUNE_OPTION_ERROR);
  CHECK(strstr(tetune_last_error(), "'efort'") != NULL);
  CHECK(tetune_options_set(options, "effort", "worst") == TETUNE_OPTION_ERROR);
  CHECK(strstr(tetune_last_error(), "fast, standard, best") != NULL);
  CHECK(tetune_options_set(options, "max_growth", "a lot") == TETUNE_OPTION_ERROR);
  CHECK(tetune_options_set(options, "max_growth", "1000") == TETUNE_OK);
  CHECK(tetune_optimize(mesh, options, NULL, NULL, NULL) == TETUNE_OPTION_ERROR);
  tetune_options_destroy(options);

  const int32_t first[4] = {0, 1, 2, 3};
  CHECK(tetune_mesh_create(points, 3, first, 1, &none) == TETUNE_OK);
  CHECK(tetune_mesh_validate(none) == TETUNE_MESH_ERROR);
  CHECK(tetune_optimize(none, NULL, NULL, NULL, NULL) == TETUNE_MESH_ERROR);
  CHECK(strlen(tetune_last_error()) > 0);
  tetune_mesh_destroy(none);
  tetune_mesh_destroy(NULL);
  tetune_mesh_destroy(mesh);
}

int main(void) {
  make_cube();
  CHECK(strcmp(tetune_version(), "") != 0);
  test_run();
  test_file();
  test_stop();
  test_criteria();
  test_errors();
  return 0;
}
