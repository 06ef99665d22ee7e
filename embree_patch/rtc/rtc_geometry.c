/* rtc_geometry.c - an RTCGeometry whose user primitives are the leaves of an EPGeometry.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A callback is one leaf and a packet of 1, 4, 8 or 16 rays. The kernel answers for most lanes (kernels.h), search.h
 * for those that it cannot decide; what is found is offered to filters (offer.h). */
#include "embree_patch/counters.h"
#include "embree_patch/rtc/on_demand.h"
#include "embree_patch/rtc/search.h"

/* Those of the kernel's candidates that are to be offered. Lanes whose vague root is lost are slow. */
static uint32_t settle(const ep_query *q, ep_outcome *o, ep_candidates *c)
{
    const uint32_t again = ep_to_polish(q, o->hit, o->vague);
    uint32_t front = o->hit | again;
    for (uint32_t rest = o->tie | again; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        const ep_polished found = again >> lane & 1 ? ep_polish_candidate(q, lane, c) : EP_POLISHED;
        o->slow |= (uint32_t)(found == EP_POLISHED_LOST) << lane;
        if (found != EP_POLISHED || !ep_in_front(q, lane, c)) front &= ~(1u << lane);
    }
    return front;
}

/* What the kernel found is offered, and what it left undecided looked at more closely. Not inline: most visits end with
 * a kernel that has found nothing. Returns the lanes that have a new hit. */
static __attribute__((noinline)) uint32_t answer(const ep_query *q, ep_outcome o, ep_candidates *c,
                                                 EPCounters *counters)
{
    const uint32_t front = o.tie | o.vague ? settle(q, &o, c) : o.hit;
    if (o.slow) return ep_search(q, o.slow, front, c, counters);
    return front ? ep_offer(q, front, c) : 0;
}

static inline bool is_open(ep_outcome o)
{
    return (o.hit | o.vague | o.slow) != 0;
}

/* What a single ray meets. */
typedef struct found {
    ep_outcome outcome;
    float t;
    alignas(16) float hit[HIT_FIELDS];
} found;

static inline void meet(EPGeometry g, const ep_leaf *leaf, const float *net, const float *ray, EPCounters *counters,
                        found *f)
{
    f->outcome = g->kernels->single[leaf->shape](leaf, net, ray, &f->t, f->hit, counters);
}

/* Most visits that end with a hit have a certain one, and ask no trim. */
static inline bool is_plain(const ep_leaf *leaf, ep_outcome o)
{
    return o.hit && !(o.tie | o.vague | o.slow) && !leaf->trim;
}

static __attribute__((noinline)) uint32_t answer_single(const ep_query *q, const found *f, EPCounters *counters)
{
    ep_candidates c;
    c.t[0] = f->t;
    for (unsigned k = 0; k < HIT_PRIM; ++k) c.hit[k] = f->hit[k];
    return answer(q, f->outcome, &c, counters);
}

static inline uint32_t take(const ep_query *q, found *f, EPCounters *counters)
{
    if (is_plain(q->leaf, f->outcome)) return ep_offer_one(q, f->t, f->hit);
    return answer_single(q, f, counters);
}

static uint32_t run_single(const ep_query *q, EPCounters *counters)
{
    found f;
    meet(q->geometry, q->leaf, q->net, q->ray, counters, &f);
    return is_open(f.outcome) ? take(q, &f, counters) : 0;
}

/* A packet's few active rays, one at a time: for up to two that is cheaper, and gives the same bits. */
static uint32_t run_sparse(const ep_query *q, uint32_t active, EPCounters *counters)
{
    uint32_t accepted = 0;
    for (; active; active &= active - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(active);
        ep_lane one;
        found f;
        ep_gather(q, lane, one.ray);
        meet(q->geometry, q->leaf, q->net, one.ray, counters, &f);
        if (!is_open(f.outcome)) continue;
        ep_ask_for_one(q, &one);
        if (!is_plain(q->leaf, f.outcome)) ep_take_hit(q, lane, &one);
        if (!take(&one.query, &f, counters)) continue;
        accepted |= 1u << lane;
        ep_put_lane(&one, q, lane);
    }
    return accepted;
}

static uint32_t run_packet(const ep_query *q, uint32_t active, EPCounters *counters)
{
    ep_candidates c;
    const ep_outcome o =
        q->geometry->kernels->packet[q->leaf->shape](q->leaf, q->net, q->ray, q->n, active, c.t, c.hit, counters);
    return is_open(o) ? answer(q, o, &c, counters) : 0;
}

uint32_t ep_visit(const ep_query *q, int *valid)
{
    EPCounters *counters = ep_counters();
    if (q->n == 1) {
        if (!valid[0]) return 0;
        const uint32_t accepted = run_single(q, counters);
        ep_rtc_report(valid, 0, accepted);
        return accepted;
    }
    const uint32_t active = q->geometry->kernels->active(valid, q->n);
    const uint32_t beyond = active & (active - 1); /* all but the first */
    const uint32_t accepted = beyond & (beyond - 1) ? run_packet(q, active, counters) : run_sparse(q, active, counters);
    for (uint32_t rest = active; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        ep_rtc_report(valid, lane, accepted >> lane & 1);
    }
    return accepted;
}

/* Filled in place: a copy of what has just been written in smaller pieces would wait for them. */
static inline void make_query(ep_query *q, EPGeometry g, unsigned prim, ep_rtc_context *context, void *ray, unsigned n,
                              unsigned geom_id)
{
    const ep_leaf *leaf = &g->hierarchy.leaves[prim];
    q->geometry = g;
    q->hierarchy = &g->hierarchy;
    q->leaf = leaf;
    q->net = g->hierarchy.nets + leaf->net;
    q->context = context;
    q->ray = ray;
    q->n = n;
    q->geom_id = geom_id;
}

static inline void intersect_query(ep_query *q, const struct RTCIntersectFunctionNArguments *a)
{
    make_query(q, a->geometryUserPtr, a->primID, a->context, a->rayhit, a->N, a->geomID);
    q->intersect = a;
    q->occluded = NULL;
}

static inline void occluded_query(ep_query *q, const struct RTCOccludedFunctionNArguments *a)
{
    make_query(q, a->geometryUserPtr, a->primID, a->context, a->ray, a->N, a->geomID);
    q->intersect = NULL;
    q->occluded = a;
}

/* Single rays mostly end with a kernel that has found nothing: they have no query until it has. */
static __attribute__((noinline)) void intersect_packet(const struct RTCIntersectFunctionNArguments *args)
{
    ep_query q;
    intersect_query(&q, args);
    ep_visit(&q, args->valid);
}

static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    if (args->N != 1) {
        intersect_packet(args);
        return;
    }
    if (!args->valid[0]) return;
    const EPGeometry g = args->geometryUserPtr;
    EPCounters *counters = ep_counters();
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    found f;
    meet(g, leaf, g->hierarchy.nets + leaf->net, (const float *)args->rayhit, counters, &f);
    if (!is_open(f.outcome)) {
        ep_rtc_report(args->valid, 0, 0);
        return;
    }
    ep_query q;
    intersect_query(&q, args);
    ep_rtc_report(args->valid, 0, take(&q, &f, counters));
}

static __attribute__((noinline)) void occluded_packet(const struct RTCOccludedFunctionNArguments *args)
{
    ep_query q;
    occluded_query(&q, args);
    ep_visit(&q, args->valid);
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    if (args->N != 1) {
        occluded_packet(args);
        return;
    }
    if (!args->valid[0]) return;
    const EPGeometry g = args->geometryUserPtr;
    EPCounters *counters = ep_counters();
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    found f;
    meet(g, leaf, g->hierarchy.nets + leaf->net, (const float *)args->ray, counters, &f);
    if (!is_open(f.outcome)) {
        ep_rtc_report(args->valid, 0, 0);
        return;
    }
    ep_query q;
    occluded_query(&q, args);
    ep_rtc_report(args->valid, 0, take(&q, &f, counters));
}

static void bounds(const struct RTCBoundsFunctionArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    ep_give_box(&g->hierarchy.boxes[args->primID], args->bounds_o);
}

RTCGeometry ep_new_user_geometry(RTCDevice device, size_t count, void *user, const ep_callbacks *callbacks)
{
    RTCGeometry rtc = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!rtc) return NULL;
    rtcSetGeometryUserPrimitiveCount(rtc, (unsigned)count);
    rtcSetGeometryUserData(rtc, user);
    rtcSetGeometryBoundsFunction(rtc, callbacks->bounds, NULL);
    rtcSetGeometryIntersectFunction(rtc, callbacks->intersect);
    rtcSetGeometryOccludedFunction(rtc, callbacks->occluded);
    rtcSetGeometryMask(rtc, 0xFFFFFFFFu); /* Embree 4 would start with 1 */
    rtcCommitGeometry(rtc);
    return rtc;
}

RTCGeometry epNewRTCGeometry(EPGeometry g, RTCDevice device)
{
    if (!g->committed || g->moved) {
        ep_fail(&g->message, EP_INVALID, "epNewRTCGeometry before %s",
                g->committed ? "epRefitGeometry or epCommitGeometry" : "epCommitGeometry");
        return NULL;
    }
    static const ep_embree embree = {rtcRetainDevice, rtcReleaseDevice, rtcReleaseScene};
    void *user = g;
    if (g->on_demand && !(user = ep_demand_for(g, device, &embree))) {
        ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", g->hierarchy.patch_count);
        return NULL;
    }
    static const ep_callbacks leaves = {bounds, intersect, occluded};
    RTCGeometry rtc =
        ep_new_user_geometry(device, g->hierarchy.box_count, user, g->on_demand ? &ep_on_demand : &leaves);
    if (!rtc) ep_fail(&g->message, EP_FOREIGN, "rtcNewGeometry: Embree's error %d", (int)rtcGetDeviceError(device));
    return rtc;
}
