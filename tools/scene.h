/* scene.h - what a scene file or a model file says, as data; scene_json.c and model_*.c read it, scene_place.c puts
 * objects in their places.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_SCENE_H
#define EPATCH_SCENE_H

#include "embree_patch/embree_patch.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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

/* What a user sees as one surface over a rectangle, or (PATCH_TRIANGLE) over the half of it next to its first corner:
 * a patch, or the part of a face that several patches make. */
typedef struct chart {
    patch_kind kind;
    uint32_t face;         /* the primID of hits                */
    double u0, v0, du, dv; /* the rectangle, in the face's parameters */
    size_t first, count;   /* its patches                       */
} chart;

typedef struct scene_geometry {
    const struct scene_geometry *original; /* of a copy: what it shares all with but the points; else NULL */
    char *name;
    double *points; /* 4 * point_count: of the patches, then a cage's vertices */
    size_t point_count;
    patch *patches;
    size_t patch_count;
    double (*places)[6]; /* of each patch in its face, see epJoinPatches; NULL: patches are faces by themselves */
    chart *charts;       /* of the faces in their order; NULL with `places` */
    size_t chart_count;
    struct cage *cage;          /* NULL, or what the faces come from, but for its vertices */
    size_t cage_first;          /* the first of its vertices among the points */
    double cage_seconds;        /* that it took to become patches */
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
    char *path;  /* as given; "<stdin>" for "-" */
    unsigned up; /* the axis that is up by the custom of the file's format: 1 or 2 */
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

/* The charts of a geometry: one a patch where patches are faces by themselves. */
size_t chart_count(const scene_geometry *g);
chart chart_at(const scene_geometry *g, size_t i);
/* Where chart i's parameters s, t in [0,1] are in its face. */
void chart_place(const chart *c, double s, double t, double *u, double *v);

uint32_t face_of(const scene_geometry *g, size_t patch);

/* The chart of a face that has (u, v), or is nearest to it. */
size_t chart_of(const scene_geometry *g, uint32_t face, double u, double v);
/* The patch that has (u, v), or is nearest to it; u, v become the patch's own. */
size_t patch_of(const scene_geometry *g, uint32_t face, double *u, double *v);

/* How many of the geometries are no copies: what the file has. */
size_t scene_originals(const scene *s);

/* NULL when the camera can see, else what is wrong with it. */
const char *camera_problem(const camera *c);

#endif
