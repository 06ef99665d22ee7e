/* model.h - model files: one reader a format, one line a format in the table of scene.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_MODEL_H
#define EPATCH_MODEL_H

#include "tools/scene.h"

/* Appends what the file holds to an empty geometry, by the reader that the name's extension picks. False after a
 * message. */
bool model_read(const char *path, scene_geometry *g);

/* One reader a format, called by model_read. */
bool model_read_bpt(const char *path, scene_geometry *g);

/* For readers: appends a patch with room for its points. NULL when there is no memory, else 4 doubles a point to fill;
 * they move with the next call. */
double *geometry_add_patch(scene_geometry *g, patch_kind kind, unsigned degree_u, unsigned degree_v);
size_t patch_point_count(patch_kind kind, unsigned degree_u, unsigned degree_v);

/* NULL when p is a point that can be traced, else what is wrong with it. */
const char *point_problem(const double p[4]);

#endif
