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

/* One query of one leaf, intersection or occlusion; exactly one of the argument pointers is set. */
typedef struct query {
    const struct RTCIntersectFunctionNArguments *intersect;
    const struct RTCOccludedFunctionNArguments *occluded;
    EPGeometry geometry;
    const ep_leaf *leaf;
    const float *net;
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
    hit += row * n;
    for (unsigned i = 0; i < n; ++i) hit[i] = bits;
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

static void filter(const query *q, int *valid, candidates *c)
{
    const struct RTCFilterFunctionNArguments args = {
        valid, q->geometry, q->context, (struct RTCRayN *)q->ray, (struct RTCHitN *)c->hit, q->n};
    fill_ids(q, c->hit);
    if (q->intersect) ep_rtc_filter_intersection(q->intersect, &args);
    else ep_rtc_filter_occlusion(q->occluded, &args);
}

/* Offers the candidates in `mask` to the filters; accepted ones become the rays' hits. Returns the accepted lanes. */
static uint32_t offer(const query *q, uint32_t mask, candidates *c)
{
    const ep_kernels *kernels = q->geometry->kernels;
    alignas(64) int valid[EP_PACKET];
    alignas(64) float before[EP_PACKET];
    float *tfar = q->ray + EP_RAY_TFAR * q->n;
    if (q->n == 1) {
        valid[0] = -1;
        before[0] = *tfar;
        *tfar = c->t[0];
        filter(q, valid, c);
        if (!valid[0]) {
            *tfar = before[0];
            return 0;
        }
        if (q->intersect) memcpy(q->ray + EP_RAY_FIELDS, c->hit, HIT_FIELDS * sizeof(float));
        else *tfar = -INFINITY;
        return 1;
    }
    kernels->offer(q->ray, q->n, mask, c->t, before, valid);
    filter(q, valid, c);
    const uint32_t accepted = kernels->settle(q->ray, q->n, mask, before, valid);
    if (q->intersect) kernels->commit(q->ray, q->n, accepted, c->hit, HIT_FIELDS);
    else
        for (uint32_t rest = accepted; rest; rest &= rest - 1) tfar[__builtin_ctz(rest)] = -INFINITY;
    return accepted;
}

/* Is a candidate in front of what the ray has? Neighbouring leaves both find a root on their common border; where
 * their t is the same float, the smaller primID, then u, v and Ng decide, not which leaf came first. */
static bool in_front(const query *q, unsigned lane, const candidates *c)
{
    const unsigned n = q->n;
    const float t = c->t[lane], tfar = q->ray[EP_RAY_TFAR * n + lane];
    if (!(q->ray[EP_RAY_TNEAR * n + lane] < t && t <= tfar)) return false;
    if (t < tfar) return true;
    if (!q->intersect) return false;
    const float *hit = q->ray + EP_RAY_FIELDS * n;
    uint32_t geom, prim;
    memcpy(&geom, &hit[HIT_GEOM * n + lane], sizeof geom);
    memcpy(&prim, &hit[HIT_PRIM * n + lane], sizeof prim);
    if (geom != q->geom_id || prim < q->leaf->patch) return false;
    if (prim > q->leaf->patch) return true;
    static const unsigned fields[] = {EP_HIT_U, EP_HIT_V, EP_HIT_NG, EP_HIT_NG + 1, EP_HIT_NG + 2};
    for (unsigned f = 0; f < EP_ARRAY_LEN(fields); ++f) {
        const unsigned at = fields[f] * n + lane;
        if (c->hit[at] != hit[at]) return c->hit[at] < hit[at];
    }
    return false;
}

static const ep_patch *patch_of(const query *q)
{
    return &q->geometry->hierarchy.patches[q->leaf->patch];
}

/* One lane's ray, as a packet of one. */
static void load_ray(const query *q, unsigned lane, float ray[EP_RAY_FIELDS])
{
    for (unsigned f = 0; f < EP_RAY_FIELDS; ++f) ray[f] = q->ray[f * q->n + lane];
}

/* Finds a vague candidate again in double. */
static ep_polished polish(const query *q, unsigned lane, candidates *c)
{
    const unsigned n = q->n;
    float ray[EP_RAY_FIELDS], field[5];
    load_ray(q, lane, ray);
    for (unsigned f = 0; f < 5; ++f) field[f] = c->hit[f * n + lane];
    const ep_polished found = ep_polish(patch_of(q), ray + EP_RAY_ORG, ray + EP_RAY_DIR, &c->t[lane], field);
    if (found == EP_POLISHED)
        for (unsigned f = 0; f < 5; ++f) c->hit[f * n + lane] = field[f];
    return found;
}

/* Those of the kernel's candidates that are to be offered. Lanes whose vague root is lost are slow. */
static uint32_t settle(const query *q, ep_outcome *o, candidates *c)
{
    uint32_t front = o->hit;
    for (uint32_t rest = o->tie | o->vague; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        const ep_polished found = o->vague >> lane & 1 ? polish(q, lane, c) : EP_POLISHED;
        o->slow |= (uint32_t)(found == EP_POLISHED_LOST) << lane;
        if (found != EP_POLISHED || !in_front(q, lane, c)) front &= ~(1u << lane);
    }
    return front;
}

/* Those of the candidates in `mask` that a leaf which trim curves cross keeps. */
static uint32_t inside(const query *q, uint32_t mask, const candidates *c)
{
    const ep_hierarchy *h = &q->geometry->hierarchy;
    return ep_trim_inside(h->trims[q->leaf->patch], h->crossed, q->leaf->trim, q->n, c->hit + EP_HIT_U * q->n,
                          c->hit + EP_HIT_V * q->n, mask);
}

/* The same for one lane; always true in a leaf that no trim curve crosses. */
static bool is_inside(const query *q, unsigned lane, const candidates *c)
{
    return !q->leaf->trim || inside(q, 1u << lane, c);
}

static void put_root(const query *q, unsigned lane, float t, const float field[5], candidates *c)
{
    c->t[lane] = t;
    for (unsigned f = 0; f < 5; ++f) c->hit[f * q->n + lane] = field[f];
}

/* Which of several roots that floats cannot tell apart is found depends on where the search goes, so it must not go by
 * what the ray has met before. */
static bool solve_by_subdivision(const query *q, unsigned lane, const float *ray, double lo, double hi, candidates *c)
{
    const float tfar = q->ray[EP_RAY_TFAR * q->n + lane];
    ep_root r;
    while (ep_solve(patch_of(q), q->leaf, ray + EP_RAY_ORG, ray + EP_RAY_DIR, lo, hi, &r)) {
        /* the next one is told apart from this by more than the rounding of both */
        lo = r.t + 0x1p-40 * fabs(r.t);
        const float t = (float)r.t;
        const float field[5] = {(float)r.ng[0], (float)r.ng[1], (float)r.ng[2], (float)r.u, (float)r.v};
        put_root(q, lane, t, field, c);
        if (in_front(q, lane, c)) {
            if (is_inside(q, lane, c) && offer(q, 1u << lane, c)) return true;
        } else if (t >= tfar) {
            return false; /* and so are all others */
        }
    }
    return false;
}

/* The root offered last, in leaf coordinates: neighbouring cells find the same one. */
typedef struct last_root {
    bool any;
    float s, r, radius;
} last_root;

/* Rounds of cells before subdivision. */
enum { CELL_ROUNDS = 5 };

/* A ray's way through the prism, its cells and what they are part of. */
typedef struct cell_walk {
    const query *q;
    unsigned lane;
    float ray[EP_RAY_FIELDS];
    last_root last;
    candidates *c;
    EPCounters *counters;
} cell_walk;

static bool look_closer(cell_walk *w, float from, float to, unsigned round);

static bool subdivide_cell(cell_walk *w, const ep_cells *cells, unsigned k)
{
    const double t = (double)cells->middle[k], rounding = 0x1p-22 * fabs(t); /* cells are given in float */
    const double reach = (double)cells->reach[k] + rounding;
    ++w->counters->slow;
    return solve_by_subdivision(w->q, w->lane, w->ray, t - reach, t + reach, w->c);
}

/* Offers the root of a cell; true if it is accepted. */
static bool take_root(cell_walk *w, const ep_cells *cells, unsigned k)
{
    const float near = w->last.radius + cells->radius[k];
    if (w->last.any && fabsf(cells->s[k] - w->last.s) <= near && fabsf(cells->r[k] - w->last.r) <= near) return false;
    w->last = (last_root){true, cells->s[k], cells->r[k], cells->radius[k]};
    float field[5];
    for (unsigned f = 0; f < 5; ++f) field[f] = cells->fields[f * EP_PACKET + k];
    put_root(w->q, w->lane, cells->t[k], field, w->c);
    const ep_polished found = cells->vague >> k & 1 ? polish(w->q, w->lane, w->c) : EP_POLISHED;
    if (found == EP_POLISHED_LOST) {
        /* it is near the cell, not necessarily in it */
        const double t = (double)cells->t[k], reach = 3 * (double)cells->reach[k] + 0x1p-22 * fabs(t);
        ++w->counters->slow;
        return solve_by_subdivision(w->q, w->lane, w->ray, t - reach, t + reach, w->c);
    }
    return found == EP_POLISHED && in_front(w->q, w->lane, w->c) && is_inside(w->q, w->lane, w->c) &&
           offer(w->q, 1u << w->lane, w->c);
}

/* Takes what was found in cells[first] to cells[first + EP_CELLS - 1] in order. Undecided ones are cut into cells
 * again, each by itself: where it is cut must not depend on what the ray has met before. */
static bool walk_cells(cell_walk *w, const ep_cells *cells, unsigned first, float from, float to, unsigned round)
{
    const float length = (to - from) / EP_CELLS;
    for (unsigned k = 0; k < EP_CELLS; ++k) {
        const unsigned at = first + k;
        if (cells->hit >> at & 1 && take_root(w, cells, at)) return true;
        if (!((cells->open | cells->more) >> at & 1)) continue;
        if (round + 1 < CELL_ROUNDS
                ? look_closer(w, from + length * (float)k, from + length * (float)(k + 1), round + 1)
                : subdivide_cell(w, cells, at))
            return true;
    }
    return false;
}

static bool look_closer(cell_walk *w, float from, float to, unsigned round)
{
    const query *q = w->q;
    static const unsigned only = 0;
    ep_cells cells;
    q->geometry->kernels->cells[q->leaf->shape](q->leaf, q->net, w->ray, 1, &only, 1, &from, &to, &cells);
    return walk_cells(w, &cells, 0, from, to, round);
}

static bool subdivide_leaf(cell_walk *w)
{
    double lo = -INFINITY, hi = INFINITY;
    ++w->counters->slow;
    return ep_clip(patch_of(w->q), w->q->leaf, w->ray + EP_RAY_ORG, w->ray + EP_RAY_DIR, &lo, &hi) &&
           solve_by_subdivision(w->q, w->lane, w->ray, lo, hi, w->c);
}

/* Rays that the certificate of the whole leaf did not decide: cell by cell along their way through the prism, and by
 * subdivision where that does not do either. Returns the accepted lanes. */
static uint32_t solve_lanes(const query *q, uint32_t slow, candidates *c, EPCounters *counters)
{
    enum { RAYS = EP_PACKET / EP_CELLS };
    static const float begin[RAYS] = {-1, -1, -1, -1}, end[RAYS] = {1, 1, 1, 1};
    uint32_t accepted = 0;
    /* where the parametrisation folds or collapses, cells cannot decide either */
    const bool cut = q->leaf->height < INFINITY && q->leaf->bend_st < 2;
    while (slow) {
        unsigned lanes[RAYS], count = 0;
        for (; slow && count < RAYS; slow &= slow - 1) lanes[count++] = (unsigned)__builtin_ctz(slow);
        ep_cells cells;
        if (cut)
            q->geometry->kernels->cells[q->leaf->shape](q->leaf, q->net, q->ray, q->n, lanes, count, begin, end,
                                                        &cells);
        for (unsigned r = 0; r < count; ++r) {
            cell_walk w = {.q = q, .lane = lanes[r], .c = c, .counters = counters};
            load_ray(q, lanes[r], w.ray);
            /* what is found does not depend on tnear and tfar, or the bits would on what the ray met before */
            w.ray[EP_RAY_TNEAR] = -INFINITY;
            w.ray[EP_RAY_TFAR] = INFINITY;
            bool done;
            if (cut && !(cells.hopeless >> r * EP_CELLS & 1)) {
                ++counters->cells;
                done = walk_cells(&w, &cells, r * EP_CELLS, -1, 1, 0);
            } else {
                done = subdivide_leaf(&w);
            }
            accepted |= (uint32_t)done << lanes[r];
        }
    }
    return accepted;
}

/* All rays of a packet of n: the kernel answers for most, the others are looked at more closely. */
static uint32_t run_packet(const query *q, uint32_t active, EPCounters *counters)
{
    candidates c;
    const ep_kernels *kernels = q->geometry->kernels;
    ep_outcome o = q->n == 1
                       ? kernels->single[q->leaf->shape](q->leaf, q->net, q->ray, 1, 1, c.t, c.hit, counters)
                       : kernels->packet[q->leaf->shape](q->leaf, q->net, q->ray, q->n, active, c.t, c.hit, counters);
    uint32_t front = o.tie | o.vague ? settle(q, &o, &c) : o.hit;
    if (q->leaf->trim && front) front = inside(q, front, &c);
    uint32_t accepted = front ? offer(q, front, &c) : 0;
    if (o.slow) accepted |= solve_lanes(q, o.slow, &c, counters);
    return accepted;
}

/* A packet's few active rays, one at a time: for up to two that is cheaper, and gives the same bits. */
static uint32_t run_sparse(const query *q, uint32_t active, EPCounters *counters)
{
    const unsigned n = q->n, fields = q->intersect ? EP_RAY_FIELDS + HIT_FIELDS : EP_RAY_FIELDS;
    uint32_t accepted = 0;
    for (; active; active &= active - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(active);
        alignas(64) float ray[EP_RAY_FIELDS + HIT_FIELDS];
        load_ray(q, lane, ray);
        if (q->intersect) /* what in_front looks at */
            for (unsigned f = EP_RAY_FIELDS + EP_HIT_U; f <= EP_RAY_FIELDS + HIT_GEOM; ++f)
                ray[f] = q->ray[f * n + lane];
        query one = *q;
        one.ray = ray;
        one.n = 1;
        if (!run_packet(&one, 1, counters)) continue;
        accepted |= 1u << lane;
        for (unsigned f = EP_RAY_TFAR; f < fields; ++f) q->ray[f * n + lane] = ray[f];
    }
    return accepted;
}

static void run(const query *q, int *valid)
{
    EPCounters *counters = ep_counters();
    if (q->n == 1) {
        if (valid[0]) ep_rtc_report(valid, 0, run_packet(q, 1, counters));
        return;
    }
    const uint32_t active = q->geometry->kernels->active(valid, q->n);
    const uint32_t beyond = active & (active - 1); /* all but the first */
    const uint32_t accepted = beyond & (beyond - 1) ? run_packet(q, active, counters) : run_sparse(q, active, counters);
    for (uint32_t rest = active; rest; rest &= rest - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(rest);
        ep_rtc_report(valid, lane, accepted >> lane & 1);
    }
}

static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    const query q = {.intersect = args,
                     .geometry = g,
                     .leaf = leaf,
                     .net = g->hierarchy.nets + leaf->net,
                     .context = args->context,
                     .ray = (float *)args->rayhit,
                     .n = args->N,
                     .geom_id = args->geomID};
    run(&q, args->valid);
}

static void occluded(const struct RTCOccludedFunctionNArguments *args)
{
    const EPGeometry g = args->geometryUserPtr;
    const ep_leaf *leaf = &g->hierarchy.leaves[args->primID];
    const query q = {.occluded = args,
                     .geometry = g,
                     .leaf = leaf,
                     .net = g->hierarchy.nets + leaf->net,
                     .context = args->context,
                     .ray = (float *)args->ray,
                     .n = args->N,
                     .geom_id = args->geomID};
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
