/* tessellate.h - a geometry as a grid of triangles a patch: what everybody else renders, to compare with.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_TESSELLATE_H
#define EPATCH_TESSELLATE_H

#include "tools/world.h"

typedef struct tessellation {
    unsigned n; /* steps along each edge of a patch */
    float *vertices;
    uint32_t *triangles;
    uint32_t *first; /* of each patch, its first triangle; one more at the end */
    size_t vertex_count, triangle_count;
    size_t bytes; /* of the three arrays */
} tessellation;

/* Every tensor patch becomes 2 n^2 triangles, every triangular one n^2. Vertices are evaluated in double, rounded to
 * float and shared within a patch. Of a trimmed patch the triangles whose middle is outside are left out, so that its
 * border is a saw with teeth of the grid's size. False after a message, which names `path`. */
bool tessellate(const char *path, const scene_geometry *g, EPGeometry surface, unsigned n, int threads,
                tessellation *t);
void tessellation_free(tessellation *t);

/* An uncommitted RTCGeometry over the arrays of t, which must outlive it. */
RTCGeometry tessellation_geometry(const tessellation *t, RTCDevice device);

/* Turns a hit on a triangle (primID, u, v, Ng) into one on the patch it belongs to. */
void tessellation_hit(const tessellation *t, const scene_geometry *g, world_hit *hit);

#endif
