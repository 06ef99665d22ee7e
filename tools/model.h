/* model.h - model files: one reader a format, one line a format in the table of scene.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_MODEL_H
#define EPATCH_MODEL_H

#include "tools/cage.h"
#include "tools/scene.h"

/* What becomes of polygons in a file that can have free-form surfaces, too. */
typedef enum model_polygons {
    POLYGONS_ALONE,  /* they are a cage when there are no surfaces */
    POLYGONS_WANTED, /* they are a cage, and surfaces are left out */
    POLYGONS_REFUSED /* only surfaces are read                     */
} model_polygons;

/* How to take what a format leaves open. */
typedef struct model_options {
    model_polygons polygons;
    cage_scheme scheme;
    unsigned level;                /* of cages */
    const cage_boundary *boundary; /* NULL: as the file says */
} model_options;

/* Appends what the file holds to an empty geometry, by the reader that the name's extension picks. False after a
 * message. */
bool model_read(const char *path, const model_options *o, scene_geometry *g);

/* One reader a format, called by model_read. */
bool model_read_bpt(const char *path, const model_options *o, scene_geometry *g);
bool model_read_obj(const char *path, const model_options *o, scene_geometry *g);
bool model_read_step(const char *path, const model_options *o, scene_geometry *g);
bool model_read_iges(const char *path, const model_options *o, scene_geometry *g);
bool model_read_brep(const char *path, const model_options *o, scene_geometry *g);

/* Fills an empty geometry with the patches of a cage's limit surface and takes the cage over, also on failure. Indices
 * have to be in range. False after a message, which names `path`. */
bool cage_to_geometry(const char *path, cage *c, scene_geometry *g);

/* For readers: appends a patch with room for its points. NULL when there is no memory, else 4 doubles a point to fill;
 * they move with the next call. */
double *geometry_add_patch(scene_geometry *g, patch_kind kind, unsigned degree_u, unsigned degree_v);
/* ... and with room for points of none. */
double *geometry_add_points(scene_geometry *g, size_t count);
/* Where the patch that was added last lies in its face; all patches have a place, or none has. False without memory. */
bool geometry_place_patch(scene_geometry *g, const double place[6]);
/* Appends a chart. False without memory. */
bool geometry_add_chart(scene_geometry *g, const chart *at);
/* The geometry takes the shape of a trim over. False without memory. */
bool geometry_add_shape(scene_geometry *g, struct trim_shape *shape);
/* Frees all that a geometry holds; what a copy shares is the original's. */
void geometry_free(scene_geometry *g);
size_t patch_point_count(patch_kind kind, unsigned degree_u, unsigned degree_v);

/* NULL when p is a point that can be traced, else what is wrong with it. */
const char *point_problem(const double p[4]);

#endif
