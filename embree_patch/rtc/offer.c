/* offer.c - see offer.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/rtc/offer.h"

void ep_take_lane(const ep_query *packet, unsigned lane, ep_lane *one)
{
    ep_gather(packet, lane, one->ray);
    ep_ask_for_one(packet, one);
}

void ep_take_hit(const ep_query *packet, unsigned lane, ep_lane *one)
{
    if (!packet->intersect) return;
    for (unsigned f = EP_RAY_FIELDS; f < EP_RAY_FIELDS + HIT_FIELDS; ++f)
        one->ray[f] = packet->ray[f * packet->n + lane];
}

void ep_put_lane(const ep_lane *one, const ep_query *packet, unsigned lane)
{
    const unsigned n = packet->n, fields = packet->intersect ? EP_RAY_FIELDS + HIT_FIELDS : EP_RAY_FIELDS;
    for (unsigned f = EP_RAY_TFAR; f < fields; ++f) packet->ray[f * n + lane] = one->ray[f];
}

bool ep_in_front(const ep_query *q, unsigned lane, const ep_candidates *c)
{
    const unsigned n = q->n;
    const float t = c->t[lane], tfar = q->ray[EP_RAY_TFAR * n + lane];
    if (!(q->ray[EP_RAY_TNEAR * n + lane] < t && t <= tfar)) return false;
    if (t < tfar) return true;
    if (!q->intersect) return false;
    const float *hit = q->ray + EP_RAY_FIELDS * n;
    uint32_t own[HIT_IDS], met[HIT_IDS];
    ep_ids_of(q, own);
    for (unsigned k = 0; k < HIT_IDS; ++k) memcpy(&met[k], &hit[(HIT_PRIM + k) * n + lane], sizeof met[k]);
    if (met[HIT_GEOM - HIT_PRIM] == RTC_INVALID_GEOMETRY_ID) return false; /* tfar is the ray's own end */
    for (unsigned k = 0; k < HIT_IDS; ++k) {
        const unsigned at = k + 2 < HIT_IDS ? k + 2 : HIT_IDS - 1 - k; /* instances, geometry, primitive */
        if (own[at] != met[at]) return own[at] < met[at];
    }
    static const unsigned fields[] = {EP_HIT_U, EP_HIT_V, EP_HIT_NG, EP_HIT_NG + 1, EP_HIT_NG + 2};
    float candidate[HIT_PRIM];
    for (unsigned f = 0; f < HIT_PRIM; ++f) candidate[f] = c->hit[f * n + lane];
    const ep_place *place = ep_place_of(q);
    if (place) ep_place_hit(place, candidate, 1, 0);
    for (unsigned f = 0; f < EP_ARRAY_LEN(fields); ++f) {
        const float own_value = candidate[fields[f]], met_value = hit[fields[f] * n + lane];
        if (own_value != met_value) return own_value < met_value;
    }
    return false;
}

static ep_polished polish(const ep_query *q, unsigned lane, const ep_candidates *c, float *t, float field[5],
                          double exact[2])
{
    const unsigned n = q->n;
    float org[3], dir[3];
    for (unsigned k = 0; k < 3; ++k) {
        org[k] = q->ray[(EP_RAY_ORG + k) * n + lane];
        dir[k] = q->ray[(EP_RAY_DIR + k) * n + lane];
    }
    for (unsigned f = 0; f < 5; ++f) field[f] = c->hit[f * n + lane];
    *t = c->t[lane];
    return ep_polish(ep_patch_of(q), q->leaf, org, dir, t, field, exact);
}

ep_polished ep_polish_candidate(const ep_query *q, unsigned lane, ep_candidates *c)
{
    float field[5];
    double exact[2];
    const ep_polished found = polish(q, lane, c, &c->t[lane], field, exact);
    if (found == EP_POLISHED)
        for (unsigned f = 0; f < 5; ++f) c->hit[f * q->n + lane] = field[f];
    return found;
}

/* A candidate that is outside, but no farther from a trim curve than float may have moved it, is found again in double:
 * rounding must not lose it to both of two faces that are trimmed along one curve. */
static bool is_inside(const ep_query *q, unsigned lane, const ep_candidates *c)
{
    const ep_hierarchy *h = q->hierarchy;
    const ep_trim *trim = h->trims[q->leaf->patch];
    const uint32_t node = q->leaf->trim - 1;
    const double u = c->hit[EP_HIT_U * q->n + lane], v = c->hit[EP_HIT_V * q->n + lane];
    if (ep_trim_inside_one(trim, h->crossed, node, u, v)) return true;
    float t, field[5];
    double exact[2];
    if (polish(q, lane, c, &t, field, exact) == EP_POLISHED_LOST) return true;
    return ep_trim_reaches(trim, h->crossed, node, exact[0], exact[1], EP_BORDER);
}

/* Those of the candidates in `mask` that a leaf which trim curves cross keeps. Kernels are sure of u and v to within
 * EP_FLAT (isa/newton_tmpl.h) of the leaf, of its certificate as much again, and both add up in a triangle. */
static uint32_t inside(const ep_query *q, uint32_t mask, const ep_candidates *c)
{
    const ep_hierarchy *h = q->hierarchy;
    const double extent = ep_leaf_extent(q->leaf);
    uint32_t open,
        in = ep_trim_sift(h->trims[q->leaf->patch], h->crossed, q->leaf->trim - 1, q->n, c->hit + EP_HIT_U * q->n,
                          c->hit + EP_HIT_V * q->n, mask, 0x1p-14 * extent + 0x1p-23, &open);
    for (; open; open &= open - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(open);
        in |= (uint32_t)is_inside(q, lane, c) << lane;
    }
    return in;
}

static void fill_row(float *hit, unsigned row, unsigned n, unsigned value)
{
    float bits;
    memcpy(&bits, &value, sizeof bits);
    hit += row * n;
    for (unsigned i = 0; i < n; ++i) hit[i] = bits;
}

static void fill_ids(const ep_query *q, float *hit)
{
    uint32_t id[HIT_IDS];
    ep_ids_of(q, id);
    for (unsigned k = 0; k < HIT_IDS; ++k) fill_row(hit, HIT_PRIM + k, q->n, id[k]);
}

uint32_t ep_offer(const ep_query *q, uint32_t mask, ep_candidates *c)
{
    const ep_kernels *kernels = q->geometry->kernels;
    if (q->leaf->trim) mask = inside(q, mask, c);
    if (!mask) return 0;
    if (q->n == 1) return ep_offer_one(q, c->t[0], c->hit);
    alignas(64) int valid[EP_PACKET];
    alignas(64) float before[EP_PACKET];
    float *tfar = q->ray + EP_RAY_TFAR * q->n;
    kernels->offer(q->ray, q->n, mask, c->t, before, valid);
    const ep_place *place = ep_place_of(q);
    for (uint32_t rest = place ? mask : 0; rest; rest &= rest - 1)
        ep_place_hit(place, c->hit, q->n, (unsigned)__builtin_ctz(rest));
    fill_ids(q, c->hit);
    ep_ask_filters(q, valid, c->hit);
    const uint32_t accepted = kernels->settle(q->ray, q->n, mask, before, valid);
    if (q->intersect) kernels->commit(q->ray, q->n, accepted, c->hit, HIT_FIELDS);
    else
        for (uint32_t rest = accepted; rest; rest &= rest - 1) tfar[__builtin_ctz(rest)] = -INFINITY;
    return accepted;
}
