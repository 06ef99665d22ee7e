/* demand.h - patches that are cut into leaves when a ray first enters their box [Rubin and Whitted 1980].
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * One pointer a patch, NULL until its leaves are there. A thread that finds none builds them and publishes what it has
 * by compare-and-swap; one that comes second drops its own. Nobody waits: a callback that waits for another thread's
 * may wait for one that it has interrupted itself, where tasks are stolen. */
#ifndef EP_DEMAND_H
#define EP_DEMAND_H

#include "embree_patch/build.h"

#include <stdatomic.h>

/* Embree's handle, declared here as in embree_patch.h. */
typedef struct RTCSceneTy *RTCScene;

typedef struct ep_built {
    ep_hierarchy hierarchy; /* of one patch; patches and trims are the geometry's */
    double error;           /* as ep_patch.error */
    RTCScene scene;         /* over the leaves; NULL: the trim has left none */
} ep_built;

/* What this layer needs of Embree. */
typedef struct ep_embree {
    void (*retain_device)(RTCDevice);
    void (*release_device)(RTCDevice);
    void (*release_scene)(RTCScene);
} ep_embree;

/* What is built of a geometry for a device: Embree's scenes belong to one, which stays as long as this. */
typedef struct ep_demand {
    EPGeometry geometry;
    RTCDevice device;
    const ep_embree *embree;
    struct ep_demand *next; /* for another device */
    _Atomic(ep_built *) built[];
} ep_demand;

/* That of a geometry for a device, new or not; NULL: no memory. */
ep_demand *ep_demand_for(EPGeometry g, RTCDevice device, const ep_embree *embree);

/* What is there of a patch; NULL: nothing yet. */
static inline const ep_built *ep_demand_get(const ep_demand *d, uint32_t patch)
{
    return atomic_load_explicit(&d->built[patch], memory_order_acquire);
}

/* Publishes what was built, unless there is something already. Returns what there is. */
const ep_built *ep_demand_put(ep_demand *d, uint32_t patch, ep_built *built);
void ep_built_free(const ep_demand *d, ep_built *built);

/* Of all devices: forgets what was built; frees everything. Nothing may be traced meanwhile. */
void ep_demand_clear(EPGeometry g);
void ep_demand_free(EPGeometry g);

/* The error of hits on a patch, as far as it has been built. */
double ep_demand_error(EPGeometry g, uint32_t patch);
/* Adds what has been built. */
void ep_demand_statistics(EPGeometry g, EPStatistics *s);

#endif
