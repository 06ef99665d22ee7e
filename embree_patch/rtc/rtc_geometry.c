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

/* Roots found so far, in the patch's parameters: several cells find the same one. What there is no room for may be
 * offered twice. */
typedef struct known_roots {
    unsigned count;
    struct {
        float u, v, radius;
    } root[16];
} known_roots;

/* How exact the parameters of a root found in double are: a float's last place. */
static const float exact_radius = 0x1p-24f;

/* Adds the candidate unless it is known. */
static bool is_new(const query *q, unsigned lane, const candidates *c, float radius, known_roots *known)
{
    const float u = c->hit[EP_HIT_U * q->n + lane], v = c->hit[EP_HIT_V * q->n + lane];
    for (unsigned i = 0; i < known->count; ++i) {
        const float near = known->root[i].radius + radius;
        if (fabsf(u - known->root[i].u) <= near && fabsf(v - known->root[i].v) <= near) return false;
    }
    if (known->count < EP_ARRAY_LEN(known->root)) {
        known->root[known->count].u = u;
        known->root[known->count].v = v;
        known->root[known->count++].radius = radius;
    }
    return true;
}

/* Which of several roots that floats cannot tell apart is found depends on where the search goes, so it must not go by
 * what the ray has met before. */
static bool solve_by_subdivision(const query *q, unsigned lane, const float *ray, double lo, double hi,
                                 known_roots *known, candidates *c)
{
    const float tfar = q->ray[EP_RAY_TFAR * q->n + lane];
    ep_root r;
    while (ep_solve(patch_of(q), q->leaf, ray + EP_RAY_ORG, ray + EP_RAY_DIR, lo, hi, &r)) {
        /* the next one is told apart from this by more than the rounding of both */
        lo = r.t + 0x1p-40 * fabs(r.t);
        const float t = (float)r.t;
        const float field[5] = {(float)r.ng[0], (float)r.ng[1], (float)r.ng[2], (float)r.u, (float)r.v};
        put_root(q, lane, t, field, c);
        if (!is_new(q, lane, c, exact_radius, known)) continue;
        if (in_front(q, lane, c)) {
            if (is_inside(q, lane, c) && offer(q, 1u << lane, c)) return true;
        } else if (t >= tfar) {
            return false; /* and so are all others */
        }
    }
    return false;
}

/* Finds the vague roots of cells again. A cell answers for roots with a t of its own, so what ends elsewhere has not
 * found it: such cells are returned, and those whose root is outside the patch are hits no more. */
static uint32_t polish_cells(const query *q, unsigned lane, double lo, double length, ep_cells *cells, candidates *c)
{
    uint32_t lost = 0;
    for (uint32_t rest = cells->hit & cells->vague; rest; rest &= rest - 1) {
        const unsigned k = (unsigned)__builtin_ctz(rest);
        float field[5];
        for (unsigned f = 0; f < 5; ++f) field[f] = cells->fields[f * EP_PACKET + k];
        put_root(q, lane, cells->t[k], field, c);
        const ep_polished found = polish(q, lane, c);
        const double t = c->t[lane], from = lo + length * (k - 1.0), to = lo + length * (k + 2.0);
        if (found == EP_POLISHED_LOST || !(from <= t && t <= to)) lost |= 1u << k;
        if (found != EP_POLISHED || lost >> k & 1) cells->hit &= ~(1u << k);
        cells->t[k] = c->t[lane];
        for (unsigned f = 0; f < 5; ++f) cells->fields[f * EP_PACKET + k] = c->hit[f * q->n + lane];
    }
    return lost;
}

/* Rounds of cells before subdivision; each looks sixteen times closer. */
enum { CELL_ROUNDS = 5 };

/* The ray between lo and hi, cell by cell; a run of undecided cells is cut into cells again. */
static bool solve_by_cells(const query *q, unsigned lane, const float *ray, double lo, double hi, unsigned round,
                           known_roots *known, candidates *c, EPCounters *counters)
{
    ep_cells cells;
    q->geometry->kernels->cells[q->leaf->shape](q->leaf, q->net, ray, lo, hi, &cells);
    const double length = (hi - lo) / EP_PACKET;
    const float *d = q->leaf->domain;
    const float extent = fmaxf(fabsf(d[2]) + fabsf(d[4]), fabsf(d[3]) + fabsf(d[5]));
    const uint32_t lost = polish_cells(q, lane, lo, length, &cells, c), open = cells.open | lost;
    bool accepted = false;
    for (unsigned k = 0; k < EP_PACKET && !(accepted && q->occluded); ++k) {
        if (open >> k & 1) {
            unsigned end = k + 1;
            bool last = round + 1 == CELL_ROUNDS;
            while (end < EP_PACKET && open >> end & 1) ++end;
            last = last || end - k == EP_PACKET || (lost >> k & ((1u << (end - k)) - 1)) != 0;
            const double from = lo + length * k, to = lo + length * end;
            k = end - 1;
            /* what it may find is at most a cell in front of it */
            if (from - length > nextafterf(q->ray[EP_RAY_TFAR * q->n + lane], INFINITY)) continue;
            if (last) {
                ++counters->slow;
                accepted |= solve_by_subdivision(q, lane, ray, from - 0x1p-8 * length, to + 0x1p-8 * length, known, c);
            } else {
                accepted |= solve_by_cells(q, lane, ray, from, to, round + 1, known, c, counters);
            }
        } else if (cells.hit >> k & 1) {
            float field[5];
            for (unsigned f = 0; f < 5; ++f) field[f] = cells.fields[f * EP_PACKET + k];
            put_root(q, lane, cells.t[k], field, c);
            const float radius = cells.vague >> k & 1 ? exact_radius : extent * cells.radius[k];
            if (is_new(q, lane, c, radius, known))
                accepted |= in_front(q, lane, c) && is_inside(q, lane, c) && offer(q, 1u << lane, c);
        }
    }
    return accepted;
}

/* A ray that the certificate of the whole leaf did not decide: cell by cell along its way through the prism, and by
 * subdivision where that does not do either. */
static bool solve_lane(const query *q, unsigned lane, candidates *c, EPCounters *counters)
{
    float ray[EP_RAY_FIELDS];
    load_ray(q, lane, ray);
    /* Neither the search nor what it finds depends on tnear and tfar, or the bits would on what the ray met before. */
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    double lo = ray[EP_RAY_TNEAR] = -INFINITY, hi = ray[EP_RAY_TFAR] = INFINITY;
    if (!ep_clip(patch_of(q), q->leaf, ray + EP_RAY_ORG, ray + EP_RAY_DIR, &lo, &hi)) return false;
    if (!(lo <= nextafterf(tfar, INFINITY) && hi >= tnear)) return false;
    /* where the parametrisation folds or collapses, cells cannot decide either */
    known_roots known = {0};
    if (q->leaf->height < INFINITY && q->leaf->bend_st < 2) {
        ++counters->cells;
        return solve_by_cells(q, lane, ray, lo, hi, 0, &known, c, counters);
    }
    ++counters->slow;
    return solve_by_subdivision(q, lane, ray, lo, hi, &known, c);
}

/* One or two rays of a packet, each by the single-ray kernel, which is cheaper then; the bits are the same. */
static ep_outcome run_sparse(const query *q, uint32_t active, candidates *c, EPCounters *counters)
{
    ep_outcome all = {0, 0, 0, 0};
    const unsigned n = q->n;
    for (unsigned i = 0; i < n; ++i) {
        if (!(active >> i & 1)) continue;
        float ray[EP_RAY_FIELDS], hit[5];
        load_ray(q, i, ray);
        const ep_outcome o =
            q->geometry->kernels->single[q->leaf->shape](q->leaf, q->net, ray, 1, 1, &c->t[i], hit, counters);
        all.slow |= o.slow << i;
        if (!o.hit) continue;
        all.hit |= 1u << i;
        all.tie |= o.tie << i;
        all.vague |= o.vague << i;
        for (unsigned f = 0; f < 5; ++f) c->hit[f * n + i] = hit[f];
    }
    return all;
}

static void run(const query *q, int *valid)
{
    const ep_kernels *kernels = q->geometry->kernels;
    EPCounters *counters = ep_counters();
    candidates c;
    const uint32_t active = q->n == 1 ? 1 : kernels->active(valid, q->n);
    const uint32_t beyond = active & (active - 1); /* all but the first */
    uint32_t accepted = 0;
    if (!valid[0] && q->n == 1) return;
    ep_outcome o;
    if (q->n == 1) o = kernels->single[q->leaf->shape](q->leaf, q->net, q->ray, 1, 1, c.t, c.hit, counters);
    else if (!(beyond & (beyond - 1))) o = run_sparse(q, active, &c, counters);
    else o = kernels->packet[q->leaf->shape](q->leaf, q->net, q->ray, q->n, active, c.t, c.hit, counters);
    uint32_t front = settle(q, &o, &c);
    if (q->leaf->trim && front) front = inside(q, front, &c);
    if (front) accepted = offer(q, front, &c);
    for (uint32_t slow = o.slow; slow; slow &= slow - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(slow);
        accepted |= (uint32_t)solve_lane(q, lane, &c, counters) << lane;
    }
    for (unsigned i = 0; i < q->n; ++i)
        if (active >> i & 1) ep_rtc_report(valid, i, accepted >> i & 1);
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
