/* demand.c - see demand.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/geometry.h"

#include <string.h>

static size_t bytes_of(EPGeometry g)
{
    return sizeof(ep_demand) + g->hierarchy.patch_count * sizeof(_Atomic(ep_built *));
}

ep_demand *ep_demand_for(EPGeometry g, RTCDevice device, const ep_embree *embree)
{
    for (ep_demand *d = g->demands; d; d = d->next)
        if (d->device == device) return d;
    ep_demand *d = ep_alloc(1, bytes_of(g));
    if (!d) return NULL;
    d->geometry = g;
    d->device = device;
    d->embree = embree;
    embree->retain_device(device);
    d->next = g->demands;
    for (size_t i = 0; i < g->hierarchy.patch_count; ++i) atomic_init(&d->built[i], NULL);
    return g->demands = d;
}

void ep_built_free(const ep_demand *d, ep_built *b)
{
    if (!b) return;
    if (b->scene) d->embree->release_scene(b->scene);
    b->hierarchy.patches = NULL;
    b->hierarchy.trims = NULL;
    ep_hierarchy_free(&b->hierarchy);
    ep_free(b);
}

const ep_built *ep_demand_put(ep_demand *d, uint32_t patch, ep_built *built)
{
    ep_built *there = NULL;
    if (atomic_compare_exchange_strong_explicit(&d->built[patch], &there, built, memory_order_acq_rel,
                                                memory_order_acquire))
        return built;
    ep_built_free(d, built);
    return there;
}

void ep_demand_clear(EPGeometry g)
{
    for (ep_demand *d = g->demands; d; d = d->next)
        for (size_t i = 0; i < g->hierarchy.patch_count; ++i)
            ep_built_free(d, atomic_exchange_explicit(&d->built[i], NULL, memory_order_relaxed));
}

void ep_demand_free(EPGeometry g)
{
    ep_demand_clear(g);
    for (ep_demand *d = g->demands, *next; d; d = next) {
        next = d->next;
        d->embree->release_device(d->device);
        ep_free(d);
    }
    g->demands = NULL;
}

double ep_demand_error(EPGeometry g, uint32_t patch)
{
    double error = 0;
    for (const ep_demand *d = g->demands; d; d = d->next) {
        const ep_built *b = ep_demand_get(d, patch);
        if (b) error = fmax(error, b->error);
    }
    return error;
}

void ep_demand_statistics(EPGeometry g, EPStatistics *s)
{
    if (!g->on_demand) return;
    double depth = 0, thickness = 0;
    for (const ep_demand *d = g->demands; d; d = d->next) {
        s->bytes += bytes_of(g);
        for (size_t i = 0; i < g->hierarchy.patch_count; ++i) {
            const ep_built *b = ep_demand_get(d, (uint32_t)i);
            if (!b) continue;
            const ep_hierarchy *h = &b->hierarchy;
            s->bytes += sizeof *b + ep_hierarchy_bytes(h);
            s->leaves += h->leaf_count;
            s->uncertified += h->uncertified;
            depth += h->average_depth * (double)h->leaf_count;
            thickness += h->average_thickness * (double)(h->leaf_count - h->uncertified);
            if (h->maximum_depth > s->maximumDepth) s->maximumDepth = h->maximum_depth;
        }
    }
    if (s->leaves) s->averageDepth = depth / (double)s->leaves;
    if (s->leaves > s->uncertified) s->averageThickness = thickness / (double)(s->leaves - s->uncertified);
}
