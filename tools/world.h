/* world.h - a scene made traceable: EPGeometries (or tessellations of them) in a committed RTCScene.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_WORLD_H
#define EPATCH_WORLD_H

#include "embree_patch/rtc/rtc_compat.h"
#include "tools/scene.h"

#include <stdint.h>

/* What a tessellation is made of. The other two are for scenes of cages (cage_embree.h). */
typedef enum world_form {
    WORLD_TRIANGLES,
    WORLD_GRIDS,      /* Embree's grids, one a chart                     */
    WORLD_SUBDIVISION /* Embree's subdivision geometry, at a rate of its own */
} world_form;

typedef struct world_options {
    unsigned threads;      /* 0: all */
    unsigned tessellation; /* 0: exact patches; N: every chart N x N quadrilaterals or pairs of triangles */
    world_form form;       /* of a tessellation */
    double ray_distance;   /* the farthest |origin| of rays that will be traced, scene units; 0: unknown */
    EPBuildSettings build;
} world_options;

typedef struct world {
    const scene *scene;
    RTCDevice device;
    RTCScene rtc;           /* the committed top-level scene */
    EPGeometry *geometries; /* one per scene geometry (built with --as triangles too: they evaluate) */
    float bounds[6];        /* lower, upper corner of everything, world space */
    bool instances;         /* there are any                                  */
    double build_seconds;   /* from parsed input to committed scene */
    size_t bytes_patches, bytes_embree, leaves; /* of world_measure, then */
    /* private: tessellation buffers, instance scenes */
    struct world_private *p;
} world;

/* Builds and commits. On failure prints one line to standard error and returns NULL. */
world *world_new(const scene *s, const world_options *o);
void world_free(world *w);

/* What there is now: on demand, it gets more. */
typedef struct world_size {
    size_t bytes_patches; /* our own allocations, or the tessellation's buffers */
    size_t bytes_embree;  /* Embree's memory monitor                            */
    size_t leaves;
} world_size;
world_size world_measure(const world *w);

/* Whether a packet of coherent rays may be said to be coherent. Embree 3.13.5 does not return from some packets of 16
 * occlusion rays at instanced user geometries: it expects a vector register back that a callback need not keep. */
static inline bool world_takes_coherent(const world *w, bool occluded)
{
    return EP_EMBREE != 3 || !occluded || !w->instances;
}

/* What a hit means in the terms of CONTRACT.md. An object without a transform is attached to the top-level scene
 * directly; one that scene_place() has left transformed is an Embree instance. */
typedef struct world_hit {
    float t, u, v;
    uint32_t geomID, primID; /* object index, patch index; ~0 both: a miss */
    float Ng[3];             /* world space, dP/du x dP/dv */
} world_hit;

/* Reads lane `lane` of a traced RTCRayHit (width 1) or RTCRayHit4/8/16. */
world_hit world_read_hit(const world *w, const void *rayhit, unsigned width, unsigned lane);

#endif
