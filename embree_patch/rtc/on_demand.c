/* on_demand.c - see on_demand.h and embree_patch/demand.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Behind each patch there is an RTCScene of its leaves. The callback of the patch sends the packet that it was given,
 * in place, through that scene; the leaves' callbacks find what was asked in the context of this inner query, and
 * answer as if Embree had called them from outside: filters are those of the outer geometry and of the outer context,
 * and ids are the outer ones. */
#include "embree_patch/rtc/on_demand.h"
#include "embree_patch/counters.h"
#include "embree_patch/rtc/search.h"

#include <fenv.h>
#include <string.h>

/* The query of a patch's scene. */
typedef struct inner {
    ep_rtc_context context; /* first: what leaves are given is its address */
    ep_query query;         /* the outer one, of the leaf that is visited */
    uint32_t accepted;      /* lanes that have a new hit */
} inner;

static void visit_leaf(ep_rtc_context *context, const ep_built *b, unsigned index, float *ray, unsigned n, int *valid)
{
    inner *in = (inner *)context;
    ep_query *q = &in->query;
    q->leaf = &b->hierarchy.leaves[index];
    q->net = b->hierarchy.nets + q->leaf->net;
    q->ray = ray;
    q->n = n;
    in->accepted |= ep_visit(q, valid);
}

static void intersect_leaf(const struct RTCIntersectFunctionNArguments *args)
{
    visit_leaf(args->context, args->geometryUserPtr, args->primID, (float *)args->rayhit, args->N, args->valid);
}

static void occluded_leaf(const struct RTCOccludedFunctionNArguments *args)
{
    visit_leaf(args->context, args->geometryUserPtr, args->primID, (float *)args->ray, args->N, args->valid);
}

static void bounds_of_leaf(const struct RTCBoundsFunctionArguments *args)
{
    const ep_built *b = args->geometryUserPtr;
    ep_give_box(&b->hierarchy.boxes[args->primID], args->bounds_o);
}

/* A committed scene of the leaves; NULL when Embree has failed. A commit that fails leaves no bounds. */
static RTCScene new_scene(RTCDevice device, ep_built *b)
{
    static const ep_callbacks callbacks = {bounds_of_leaf, intersect_leaf, occluded_leaf};
    RTCGeometry leaves = ep_new_user_geometry(device, b->hierarchy.leaf_count, b, &callbacks);
    RTCScene scene = leaves ? rtcNewScene(device) : NULL;
    if (scene) {
        struct RTCBounds box = {.lower_x = INFINITY, .upper_x = -INFINITY};
        rtcAttachGeometry(scene, leaves);
        rtcCommitScene(scene);
        rtcGetSceneBounds(scene, &box);
        if (!(box.lower_x <= box.upper_x)) {
            rtcReleaseScene(scene);
            scene = NULL;
        }
    }
    if (leaves) rtcReleaseGeometry(leaves);
    return scene;
}

/* Leaves have the same bits whatever the floating-point mode of the thread that traces. */
static EPStatus build_leaves(EPGeometry g, uint32_t patch, ep_built *b)
{
    fenv_t mode;
    fegetenv(&mode);
    fesetenv(FE_DFL_ENV);
    const EPStatus status = ep_build_one(&g->hierarchy, patch, &g->settings, &b->hierarchy, &b->error);
    fesetenv(&mode);
    return status;
}

/* NULL: no memory. */
static const ep_built *build(ep_demand *d, uint32_t patch)
{
    ep_built *b = ep_alloc(1, sizeof *b);
    if (!b) return NULL;
    memset(b, 0, sizeof *b);
    bool done = build_leaves(d->geometry, patch, b) == EP_OK;
    if (done && b->hierarchy.leaf_count) {
        b->scene = new_scene(d->device, b);
        done = b->scene != NULL;
    }
    if (done) return ep_demand_put(d, patch, b);
    ep_built_free(d, b);
    return NULL;
}

/* Without memory: the patch as one leaf that has neither prism nor certificate, which is subdivided along the ray. */
static uint32_t search_patch(const ep_query *outer, uint32_t patch, uint32_t active)
{
    const ep_hierarchy *all = &outer->geometry->hierarchy;
    const ep_trim *trim = all->trims[patch];
    ep_leaf whole = {.domain = {0, 0, 1, 1, 0, 0}, .height = INFINITY, .rim = INFINITY, .patch = patch};
    ep_hierarchy only = {.patches = all->patches, .trims = all->trims, .leaves = &whole, .boxes = &all->boxes[patch]};
    if (trim) {
        whole.trim = 1; /* the trim's first node decides any point */
        only.crossed = trim->cells.words;
    }
    ep_query q = *outer;
    q.hierarchy = &only;
    q.leaf = &whole;
    return ep_search(&q, active, 0, NULL, ep_counters());
}

/* A packet that has entered a patch's box. */
static void visit_patch(ep_demand *d, uint32_t patch, const ep_query *outer, int *valid)
{
    alignas(64) int mask[EP_PACKET];
    uint32_t active = 0;
    for (unsigned i = 0; i < outer->n; ++i) {
        mask[i] = valid[i];
        active |= (uint32_t)(valid[i] != 0) << i;
    }
    if (!active) return;
    inner in = {.query = *outer, .accepted = 0};
    const ep_built *b = ep_demand_get(d, patch);
    if (!b) b = build(d, patch);
    if (!b) {
        in.accepted = search_patch(outer, patch, active);
    } else if (b->scene) {
        in.query.hierarchy = &b->hierarchy;
        ep_rtc_init_context(&in.context);
        /* Never as coherent rays: Embree 3.13.5 does not always return from rtcOccluded16 with such rays when one scene
         * of user geometry is entered from within another, as by an instance. */
        if (outer->intersect) ep_rtc_intersect_in(&in.context, b->scene, outer->n, mask, outer->ray, false);
        else ep_rtc_occluded_in(&in.context, b->scene, outer->n, mask, outer->ray, false);
    }
    for (; active; active &= active - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(active);
        ep_rtc_report(valid, lane, in.accepted >> lane & 1);
    }
}

static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    ep_demand *d = args->geometryUserPtr;
    const ep_query q = {.intersect = args,
                        .geometry = d->geometry,
                        .context = args->context,
                        .ray = (float *)args->rayhit,
                        .n = args->N,
                        .geom_id = args->geomID};
    visit_patch(d, args->primID, &q, args->valid);
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    ep_demand *d = args->geometryUserPtr;
    const ep_query q = {.occluded = args,
                        .geometry = d->geometry,
                        .context = args->context,
                        .ray = (float *)args->ray,
                        .n = args->N,
                        .geom_id = args->geomID};
    visit_patch(d, args->primID, &q, args->valid);
}

static void bounds(const struct RTCBoundsFunctionArguments *args)
{
    const ep_demand *d = args->geometryUserPtr;
    ep_give_box(&d->geometry->hierarchy.boxes[args->primID], args->bounds_o);
}

const ep_callbacks ep_on_demand = {bounds, intersect, occluded};
