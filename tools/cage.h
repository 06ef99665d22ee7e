/* cage.h - the control cage of a subdivision surface, and what hits on that mean.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A face of the cage is a face of the limit surface, in the sense of embree_patch.h: its index is the primID, and u, v
 * are those of Embree's own subdivision geometry. A quadrilateral has (0,0) at its first corner, (1,0) at the second,
 * (0,1) at the last. Any other polygon is first divided into one quadrilateral a corner; number 4 h + l of them, with
 * (0,0) at its corner and (1,0) in the middle of the side that begins there, takes u from 2 l + 1/2 to 2 l + 3/2 and v
 * from 2 h + 1/2 to 2 h + 3/2. With Loop's scheme u, v are as those of a Bézier triangle: (0,0), (1,0), (0,1) at the
 * corners. */
#ifndef EPATCH_CAGE_H
#define EPATCH_CAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum cage_scheme { CAGE_CATMULL_CLARK, CAGE_LOOP } cage_scheme;

/* What the surface does at the border of an open cage. */
typedef enum cage_boundary {
    CAGE_EDGE_ONLY,       /* follows the border as a curve, rounded at corners */
    CAGE_EDGE_AND_CORNER, /* and goes through corners of a single face         */
    CAGE_NO_BOUNDARY      /* faces at the border only shape the others         */
} cage_boundary;

/* A sharpness of CAGE_SHARP or more is infinite: the surface has an edge or a corner there. */
#define CAGE_SHARP 10.0f

typedef struct cage_crease {
    uint32_t vertex[2];
    float sharpness;
} cage_crease;

typedef struct cage_corner {
    uint32_t vertex;
    float sharpness;
} cage_corner;

enum {
    CAGE_LEVEL_DEFAULT = 0, /* until what is left in the middle is as good as flat */
    CAGE_LEVEL_MAX = 16     /* what is left then is as small as floats tell apart */
};

/* All arrays are malloc'ed and the cage's; capacities are for array_grow. */
typedef struct cage {
    cage_scheme scheme;
    cage_boundary boundary;
    bool chaikin;          /* sharpness of creases is averaged by Chaikin's rule             */
    bool smooth_triangles; /* Catmull and Clark's scheme takes triangles by weights of their own */
    unsigned level;        /* how deep extraordinary points are isolated, 1..CAGE_LEVEL_MAX, or the default */
    double (*vertices)[3];
    uint32_t *sizes;   /* of each face: its number of corners, at least 3 */
    uint32_t *corners; /* the faces' vertices, one face after the other    */
    cage_crease *creases;
    cage_corner *sharp;
    uint32_t *holes; /* faces that only shape the others */
    size_t vertex_count, face_count, corner_count, crease_count, sharp_count, hole_count;
    size_t vertex_capacity, face_capacity, corner_capacity, crease_capacity, sharp_capacity, hole_capacity;
} cage;

/* A cage is malloc'ed, too; NULL is fine. */
void cage_free(cage *c);

#endif
