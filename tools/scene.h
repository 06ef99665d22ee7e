/* scene.h - what a scene file or a model file says, as data; scene_json.c and model_*.c read it, scene_place.c puts
 * objects in their places.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_SCENE_H
#define EPATCH_SCENE_H

#include "embree_patch/embree_patch.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum patch_kind { PATCH_TRIANGLE, PATCH_TENSOR } patch_kind;

/* One patch: where its points begin in scene_geometry.points (4 doubles a point: x, y, z, w, Euclidean). */
typedef struct patch {
    patch_kind kind;
    unsigned degree_u, degree_v; /* equal for triangles */
    size_t first;                /* index of its first point */
    bool rational;               /* some weight differs from 1 */
    EPRegion trim;               /* NULL: untrimmed; holds a reference */
    struct trim_shape *shape;    /* the same as it is written, for the reference; the geometry's */
} patch;

typedef struct scene_geometry {
    const struct scene_geometry *original; /* of a copy: what it shares all with but the points; else NULL */
    char *name;
    double *points; /* 4 * point_count */
    size_t point_count;
    patch *patches;
    size_t patch_count;
    struct trim_shape **shapes; /* of the trims, see test/oracle/trim_reference.h */
    size_t shape_count;
} scene_geometry;

typedef struct scene_object {
    size_t geometry;      /* index into scene.geometries */
    double transform[12]; /* images of x, y, z axes, then the translation; see scene_place.h */
    bool identity;        /* the transform is none: the geometry is where the object is */
    char *material;       /* NULL: the default */
} scene_object;

typedef struct camera {
    double eye[3], target[3], up[3];
    double fov; /* vertical, degrees */
} camera;

typedef struct scene {
    char *path; /* as given; "<stdin>" for "-" */
    bool has_camera;
    camera camera;
    scene_geometry *geometries; /* those of the file in its order, then copies that objects have moved */
    size_t geometry_count;
    scene_object *objects; /* always filled: without "objects", each geometry once */
    size_t object_count;
} scene;

/* Reads a scene (.json, or no extension; "-" is standard input) or a model file. On failure prints one line, `epatch:
 * FILE:LINE:COLUMN: what is wrong`, to standard error and returns NULL. */
scene *scene_read(const char *path);
void scene_free(scene *s);

/* How many of the geometries are no copies: what the file has. */
size_t scene_originals(const scene *s);

/* NULL when the camera can see, else what is wrong with it. */
const char *camera_problem(const camera *c);

#endif
