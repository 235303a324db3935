/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TETUNE_TETUNE_H
#define TETUNE_TETUNE_H

/* The C interface: meshes, options and reports behind opaque pointers. docs/c.md has a program.
 *
 * Ids are zero-based. A function that can fail returns a tetune_status; tetune_last_error() has the sentence. A null
 * pointer where an object is expected is TETUNE_INVALID_ARGUMENT, or a null pointer or 0 as the result. Pointers into
 * an object are valid until the object is changed or destroyed. Different objects may be used by different threads at
 * the same time. */

#include <stddef.h>
#include <stdint.h>

#include "tetune/export.hpp"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tetune_mesh tetune_mesh;
typedef struct tetune_options tetune_options;
typedef struct tetune_criteria tetune_criteria;
typedef struct tetune_report tetune_report;

/* The values are stable. */
typedef enum tetune_status {
  TETUNE_OK = 0,
  TETUNE_INVALID_ARGUMENT = 1, /* a null pointer, a negative size, an unknown enumerator */
  TETUNE_FILE_ERROR = 2,
  TETUNE_MESH_ERROR = 3, /* the mesh breaks the contract of tetune_mesh_validate() */
  TETUNE_OPTION_ERROR = 4,
  TETUNE_DEVICE_ERROR = 5,
  TETUNE_OUT_OF_MEMORY = 6,
  TETUNE_INTERNAL_ERROR = 7
} tetune_status;

/* Every int is a valid value in C++, so that the library can refuse one that is no kind, from any language. */
#ifdef __cplusplus
typedef enum tetune_kind : int {
#else
typedef enum tetune_kind {
#endif
  TETUNE_VERTICES = 0,
  TETUNE_EDGES = 1,
  TETUNE_TRIANGLES = 2,
  TETUNE_TETRAHEDRA = 3
} tetune_kind;

/* "0.2.0": of the library that is loaded. */
TETUNE_API const char* tetune_version(void);

/* The error of the last call of this thread that failed; empty if none did. Valid until the next failure. */
TETUNE_API const char* tetune_last_error(void);

/* ---- Meshes. tetune_mesh_destroy() frees them, and takes null. */

/* `points` has 3 * vertices coordinates, `tetrahedra` 4 * count ids with positive volumes (v0, v1, v2, v3):
 * det(v1 - v0, v2 - v0, v3 - v0) > 0. The arrays are copied; their content is checked by tetune_optimize(). */
TETUNE_API tetune_status tetune_mesh_create(const double* points, int64_t vertices, const int32_t* tetrahedra,
                                            int64_t count, tetune_mesh** mesh);
TETUNE_API void tetune_mesh_destroy(tetune_mesh* mesh);

/* Files in the format of their ending, as the command line has them. Paths are UTF-8 on Windows. A file is written
 * under a temporary name and renamed. */
TETUNE_API tetune_status tetune_mesh_read(const char* path, tetune_mesh** mesh);
TETUNE_API tetune_status tetune_mesh_write(const tetune_mesh* mesh, const char* path);
/* Warnings of the last of these two calls of this thread: sentences on contents of the file that were skipped, or that
 * its format cannot hold. Valid until the next one. */
TETUNE_API int64_t tetune_last_warnings(void);
TETUNE_API const char* tetune_last_warning(int64_t position);

/* The listed edges (2 ids each) or triangles (3): feature lines, boundary patches, interfaces. All have the tag 0. */
TETUNE_API tetune_status tetune_mesh_set_elements(tetune_mesh* mesh, tetune_kind kind, const int32_t* ids,
                                                  int64_t count);
/* One tag per entity of the kind: regions of tetrahedra, patches of triangles. */
TETUNE_API tetune_status tetune_mesh_set_tags(tetune_mesh* mesh, tetune_kind kind, const int32_t* tags, int64_t count);
/* Entities, by their positions, that must stay as they are. */
TETUNE_API tetune_status tetune_mesh_set_required(tetune_mesh* mesh, tetune_kind kind, const int32_t* positions,
                                                  int64_t count);

TETUNE_API int64_t tetune_mesh_count(const tetune_mesh* mesh, tetune_kind kind);
/* 3 coordinates per vertex. */
TETUNE_API const double* tetune_mesh_points(const tetune_mesh* mesh);
/* 2, 3 or 4 ids per edge, triangle or tetrahedron. */
TETUNE_API const int32_t* tetune_mesh_elements(const tetune_mesh* mesh, tetune_kind kind);
TETUNE_API const int32_t* tetune_mesh_tags(const tetune_mesh* mesh, tetune_kind kind);

/* TETUNE_OK for a mesh that tetune_optimize() takes, else TETUNE_MESH_ERROR; the error names the first offenders. */
TETUNE_API tetune_status tetune_mesh_validate(const tetune_mesh* mesh);

typedef struct tetune_quality {
  double min_dihedral, max_dihedral; /* degrees */
  double dihedral_p5;                /* 5 % of the angles are as small as this, or smaller; degrees */
  double mean_ratio, min_mean_ratio; /* mean and smallest; 1 for a regular tetrahedron */
  double volume;
  int64_t worst; /* the tetrahedron of the smallest angle, or -1 */
} tetune_quality;
TETUNE_API tetune_status tetune_mesh_quality(const tetune_mesh* mesh, tetune_quality* quality);

/* ---- Options. tetune_options_destroy() frees them, and takes null. */

TETUNE_API tetune_status tetune_options_create(tetune_options** options);
TETUNE_API void tetune_options_destroy(tetune_options* options);
/* Sets an option by the name and the values of docs/options.md: ("boundary", "slide"), ("max_growth", "1.5"). Ranges of
   numbers are checked where the options are used. */
TETUNE_API tetune_status tetune_options_set(tetune_options* options, const char* name, const char* value);

/* ---- Optimization. */

typedef struct tetune_progress {
  const char* phase;
  double fraction; /* of the run that is done, an estimate: 0 to 1 */
  double seconds;
  double min_dihedral; /* degrees; possibly of some passes ago */
} tetune_progress;
/* Returns 0 to stop: the mesh is then the best so far, and as valid as any result. It must not jump out of the call. */
typedef int (*tetune_progress_function)(const tetune_progress* progress, void* user);

/* Improves a mesh in place. `options` null: the defaults; `progress` null: no calls; `report` null: no report. If it
 * fails, the mesh is unchanged and `*report` null. */
TETUNE_API tetune_status tetune_optimize(tetune_mesh* mesh, const tetune_options* options,
                                         tetune_progress_function progress, void* user, tetune_report** report);
TETUNE_API void tetune_report_destroy(tetune_report* report);

/* ---- Acceptance (docs/quality.md). tetune_criteria_destroy() frees criteria, and takes null. */

typedef enum tetune_verdict { TETUNE_PASS = 0, TETUNE_WARN = 1, TETUNE_FAIL = 2 } tetune_verdict;

/* `preset`: "abaqus", "ansys", "calculix", "fluent", "nastran", "openfoam"; null: no criterion yet. */
TETUNE_API tetune_status tetune_criteria_create(const char* preset, tetune_criteria** criteria);
TETUNE_API void tetune_criteria_destroy(tetune_criteria* criteria);
/* Adds limits of a measure by its name; a limit that is not a number is none. `allowed_percent` of the tetrahedra, or
 * faces, may miss them. */
TETUNE_API tetune_status tetune_criteria_add(tetune_criteria* criteria, const char* measure, double warn, double fail,
                                             double allowed_percent);
/* The worst verdict of all criteria. */
TETUNE_API tetune_status tetune_mesh_check(const tetune_mesh* mesh, const tetune_criteria* criteria,
                                           tetune_verdict* verdict);
/* As tetune_optimize(), then works on the tetrahedra that fail. `verdict`, on the result, may be null. */
TETUNE_API tetune_status tetune_optimize_towards(tetune_mesh* mesh, const tetune_criteria* criteria,
                                                 const tetune_options* options, tetune_progress_function progress,
                                                 void* user, tetune_report** report, tetune_verdict* verdict);

/* ---- The report. */

/* "converged", "cancelled", ... */
TETUNE_API const char* tetune_report_stop(const tetune_report* report);
TETUNE_API double tetune_report_seconds(const tetune_report* report);
/* The energy before (0) and after (1), summed over the mesh: flips and sweeps lower it; work on the worst elements,
 * inserted and removed vertices and untangling may raise it. */
TETUNE_API double tetune_report_energy(const tetune_report* report, int after);
/* For each entity of the result that of the input, -1 for an inserted vertex: tetune_mesh_count() of the result
 * entries. Null if all were kept in their order, and if the result has none. */
TETUNE_API const int32_t* tetune_report_original(const tetune_report* report, tetune_kind kind);
/* Sentences on options without effect. */
TETUNE_API int64_t tetune_report_warnings(const tetune_report* report);
TETUNE_API const char* tetune_report_warning(const tetune_report* report, int64_t position);

#ifdef __cplusplus
}
#endif

#endif
