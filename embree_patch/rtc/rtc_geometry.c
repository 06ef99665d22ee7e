/* rtc_geometry.c - an RTCGeometry whose user primitives are the leaves of an EPGeometry.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A callback is one leaf and a packet of 1, 4, 8 or 16 rays. The kernel answers for most lanes; lanes that it cannot
 * decide are solved one by one by subdivision. Every root is a candidate: the ray's tfar is set to it, filters are
 * asked, and a refusal restores tfar and, where a leaf may hold another root, tries the next. Embree passes structures
 * larger than the public ones, so the pointer that came in is the one handed on. */
#include "embree_patch/counters.h"
#include "embree_patch/geometry.h"
#include "embree_patch/rtc/rtc_compat.h"
#include "embree_patch/solve.h"

#include <string.h>

#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
enum { HIT_FIELDS = 7 + 2 * RTC_MAX_INSTANCE_LEVEL_COUNT };
#else
enum { HIT_FIELDS = 7 + RTC_MAX_INSTANCE_LEVEL_COUNT };
#endif
enum { HIT_PRIM = 5, HIT_GEOM = 6, HIT_INST = 7 };

/* Below this many active rays, a packet goes ray by ray: the single-ray kernel costs about as much as this many lanes
 * of the packet kernel. */
enum { SPARSE = 2 };

/* One query of one leaf, intersection or occlusion; exactly one of the argument pointers is set. */
typedef struct query {
    const struct RTCIntersectFunctionNArguments *intersect;
    const struct RTCOccludedFunctionNArguments *occluded;
    EPGeometry geometry;
    const ep_leaf *leaf;
    const ep_patch *patch;
    ep_rtc_context *context;
    float *ray; /* Embree's packet of n rays, hits behind it for an intersection */
    unsigned n, geom_id;
} query;

/* Candidate hits in the layout of an RTCHit<n>. */
typedef struct candidates {
    alignas(64) float t[EP_PACKET];
    alignas(64) float hit[HIT_FIELDS * EP_PACKET];
} candidates;

static void fill_row(float *hit, unsigned row, unsigned n, unsigned value)
{
    float bits;
    memcpy(&bits, &value, sizeof bits);
    for (unsigned i = 0; i < n; ++i) hit[row * n + i] = bits;
}

static void fill_ids(const query *q, float *hit)
{
    fill_row(hit, HIT_PRIM, q->n, q->leaf->patch);
    fill_row(hit, HIT_GEOM, q->n, q->geom_id);
    for (unsigned l = 0; l < RTC_MAX_INSTANCE_LEVEL_COUNT; ++l) {
        fill_row(hit, HIT_INST + l, q->n, q->context->instID[l]);
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
        fill_row(hit, HIT_INST + RTC_MAX_INSTANCE_LEVEL_COUNT + l, q->n, q->context->instPrimID[l]);
#endif
    }
}

/* Offers the candidates in `mask` to the filters; accepted ones become the rays' hits. Returns the accepted lanes. */
static uint32_t offer(const query *q, uint32_t mask, candidates *c)
{
    alignas(64) int valid[EP_PACKET];
    alignas(64) float before[EP_PACKET];
    float *tfar = q->ray + EP_RAY_TFAR * q->n;
    fill_ids(q, c->hit);
    for (unsigned i = 0; i < q->n; ++i) {
        valid[i] = mask >> i & 1 ? -1 : 0;
        before[i] = tfar[i];
        if (valid[i]) tfar[i] = c->t[i];
    }
    const struct RTCFilterFunctionNArguments filter = { valid,
                                                        q->geometry,
                                                        q->context,
                                                        (struct RTCRayN *)q->ray,
                                                        (struct RTCHitN *)c->hit,
                                                        q->n };
    if (q->intersect) ep_rtc_filter_intersection(q->intersect, &filter);
    else ep_rtc_filter_occlusion(q->occluded, &filter);
    uint32_t accepted = 0;
    for (unsigned i = 0; i < q->n; ++i) {
        if (valid[i]) accepted |= mask & 1u << i;
        else if (mask >> i & 1) tfar[i] = before[i];
    }
    if (q->intersect) q->geometry->kernels->commit(q->ray, q->n, accepted, c->t, c->hit, HIT_FIELDS);
    else
        for (unsigned i = 0; i < q->n; ++i)
            if (accepted >> i & 1) tfar[i] = -INFINITY;
    return accepted;
}

/* One ray by subdivision, nearest root first. */
static uint32_t solve_lane(const query *q, unsigned lane, candidates *c)
{
    const unsigned n = q->n;
    float org[3], dir[3];
    for (unsigned k = 0; k < 3; ++k) {
        org[k] = q->ray[(EP_RAY_ORG + k) * n + lane];
        dir[k] = q->ray[(EP_RAY_DIR + k) * n + lane];
    }
    const float tnear = q->ray[EP_RAY_TNEAR * n + lane], tfar = q->ray[EP_RAY_TFAR * n + lane];
    double after = tnear;
    ep_root root;
    while (ep_solve(q->patch, q->leaf, org, dir, after, tfar, &root)) {
        /* the next one is told apart from this by more than the rounding of both */
        after = root.t + 0x1p-40 * fabs(root.t);
        const float t = (float)root.t;
        if (!(tnear < t && t < tfar)) continue;
        c->t[lane] = t;
        for (unsigned k = 0; k < 3; ++k) c->hit[(EP_HIT_NG + k) * n + lane] = (float)root.ng[k];
        c->hit[EP_HIT_U * n + lane] = (float)root.u;
        c->hit[EP_HIT_V * n + lane] = (float)root.v;
        if (offer(q, 1u << lane, c)) return 1u << lane;
    }
    return 0;
}

/* Few rays of a packet, each by the single-ray kernel; the bits are the same. */
static ep_outcome run_sparse(const query *q, uint32_t active, candidates *c, EPCounters *counters)
{
    ep_outcome all = { 0, 0 };
    const unsigned n = q->n;
    for (unsigned i = 0; i < n; ++i) {
        if (!(active >> i & 1)) continue;
        float ray[EP_RAY_FIELDS], hit[5];
        for (unsigned f = 0; f < EP_RAY_FIELDS; ++f) ray[f] = q->ray[f * n + i];
        const ep_outcome o =
            q->geometry->kernels->single[q->patch->shape](q->leaf, q->patch, ray, 1, 1, &c->t[i], hit, counters);
        all.slow |= o.slow << i;
        if (!o.hit) continue;
        all.hit |= 1u << i;
        for (unsigned f = 0; f < 5; ++f) c->hit[f * n + i] = hit[f];
    }
    return all;
}

static void run(const query *q, int *valid)
{
    const ep_kernels *kernels = q->geometry->kernels;
    EPCounters *counters = ep_counters();
    candidates c;
    uint32_t active = 0, accepted = 0;
    for (unsigned i = 0; i < q->n; ++i) active |= (uint32_t)(valid[i] == -1) << i;
    if (!active) return;
    ep_outcome o;
    if (q->n == 1) o = kernels->single[q->patch->shape](q->leaf, q->patch, q->ray, 1, 1, c.t, c.hit, counters);
    else if (__builtin_popcount(active) <= SPARSE) o = run_sparse(q, active, &c, counters);
    else o = kernels->packet[q->patch->shape](q->leaf, q->patch, q->ray, q->n, active, c.t, c.hit, counters);
    if (o.hit) accepted = offer(q, o.hit, &c);
    counters->slow += (unsigned)__builtin_popcount(o.slow);
    for (uint32_t slow = o.slow; slow; slow &= slow - 1)
        accepted |= solve_lane(q, (unsigned)__builtin_ctz(slow), &c);
    for (unsigned i = 0; i < q->n; ++i)
        if (active >> i & 1) ep_rtc_report(valid, i, accepted >> i & 1);
}

static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    const query q = { .intersect = args, .geometry = g, .leaf = leaf, .patch = &g->hierarchy.patches[leaf->patch],
                      .context = args->context, .ray = (float *)args->rayhit, .n = args->N, .geom_id = args->geomID };
    run(&q, args->valid);
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    const query q = { .occluded = args, .geometry = g, .leaf = leaf, .patch = &g->hierarchy.patches[leaf->patch],
                      .context = args->context, .ray = (float *)args->ray, .n = args->N, .geom_id = args->geomID };
    run(&q, args->valid);
}

static void bounds(const struct RTCBoundsFunctionArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    const ep_box *b = &g->hierarchy.boxes[args->primID];
    struct RTCBounds *o = args->bounds_o;
    o->lower_x = b->lower[0], o->lower_y = b->lower[1], o->lower_z = b->lower[2];
    o->upper_x = b->upper[0], o->upper_y = b->upper[1], o->upper_z = b->upper[2];
}

RTCGeometry epNewRTCGeometry(EPGeometry g, RTCDevice device)
{
    if (!g->committed) {
        ep_fail(&g->message, EP_INVALID, "epNewRTCGeometry before epCommitGeometry");
        return NULL;
    }
    RTCGeometry rtc = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!rtc) {
        ep_fail(&g->message, EP_FOREIGN, "rtcNewGeometry: Embree's error %d", (int)rtcGetDeviceError(device));
        return NULL;
    }
    rtcSetGeometryUserPrimitiveCount(rtc, (unsigned)g->hierarchy.leaf_count);
    rtcSetGeometryUserData(rtc, g);
    rtcSetGeometryBoundsFunction(rtc, bounds, NULL);
    rtcSetGeometryIntersectFunction(rtc, intersect);
    rtcSetGeometryOccludedFunction(rtc, occluded);
    rtcSetGeometryMask(rtc, 0xFFFFFFFFu); /* Embree 4 would start with 1 */
    rtcCommitGeometry(rtc);
    return rtc;
}
