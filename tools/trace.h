/* trace.h - answering many rays: packing them for Embree, timing the queries, unpacking the hits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_TRACE_H
#define EPATCH_TRACE_H

#include "tools/world.h"

/* A record of a file of rays, 32 bytes, little-endian. */
typedef struct trace_ray {
    float org[3], tnear, dir[3], tfar;
} trace_ray;

typedef struct trace_options {
    unsigned width;   /* rays a packet: 1, 4, 8 or 16 */
    unsigned threads; /* 0: all */
    bool coherent, occluded;
} trace_options;

typedef struct trace_result {
    size_t hits;
    double seconds;  /* of the queries alone */
    EPCounters cost; /* of the queries alone */
} trace_result;

/* All rays of a file ("-": standard input), malloc'ed. NULL after a message. */
trace_ray *trace_read_rays(const char *path, size_t *count);

/* The farthest origin of a ray that can hit anything, for world_options.ray_distance. */
double trace_farthest_origin(const trace_ray *rays, size_t count);

/* Answers rays[0..count) into answers[0..count): world_hit each, or with `occluded` one byte each, 1 or 0. NULL: only
 * counts. Consecutive rays share a packet. Rays that hold NaN, have no direction or no interval miss; tnear < 0 counts
 * as 0. False after a message (no memory). */
bool trace_rays(const world *w, const trace_ray *rays, size_t count, const trace_options *o, void *answers,
                trace_result *result);

/* How many threads `threads` means. */
unsigned trace_threads(unsigned threads);

#endif
