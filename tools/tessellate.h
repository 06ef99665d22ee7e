/* tessellate.h - a geometry as a grid of points a chart: what everybody else renders, to compare with.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_TESSELLATE_H
#define EPATCH_TESSELLATE_H

#include "tools/world.h"

typedef struct tessellation {
    world_form form;
    unsigned n; /* steps along each edge of a chart */
    float *vertices;
    uint32_t *triangles;            /* NULL: grids, or Embree subdivides by itself and nothing is here */
    uint32_t *first, *first_vertex; /* of each chart, its first triangle and vertex; one more at the end */
    size_t vertex_count, triangle_count;
    size_t bytes; /* of the arrays */
} tessellation;

/* Every rectangle becomes n^2 quadrilaterals, or twice as many triangles, every triangular chart n^2. Vertices are
 * evaluated in double, rounded to float and shared within a chart. Of a trimmed patch the triangles whose middle is
 * outside are left out, so that its border is a saw with teeth of the grid's size. False after a message, which names
 * `path`. */
bool tessellate(const char *path, const scene_geometry *g, EPGeometry surface, world_form form, unsigned n, int threads,
                tessellation *t);
void tessellation_free(tessellation *t);

/* An uncommitted RTCGeometry over the arrays of t, which must outlive it. */
RTCGeometry tessellation_geometry(const tessellation *t, const scene_geometry *g, RTCDevice device);

/* Turns a hit on a triangle or grid (primID, u, v, Ng) into one on the face it belongs to. Of the normals of grids and
 * of Embree's subdivision geometry only the direction is right. */
void tessellation_hit(const tessellation *t, const scene_geometry *g, world_hit *hit);

#endif
