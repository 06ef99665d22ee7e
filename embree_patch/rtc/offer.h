/* offer.h - one query of one leaf, and what becomes of the roots that are found for it.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Every root is a candidate: the ray's tfar is set to it, filters are asked, and a refusal restores tfar. Embree passes
 * structures larger than the public ones, so the pointer that came in is the one handed on. */
#ifndef EP_OFFER_H
#define EP_OFFER_H

#include "embree_patch/geometry.h"
#include "embree_patch/polish.h"
#include "embree_patch/rtc/rtc_compat.h"

#include <math.h>
#include <string.h>

#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
enum { HIT_FIELDS = 7 + 2 * RTC_MAX_INSTANCE_LEVEL_COUNT };
#else
enum { HIT_FIELDS = 7 + RTC_MAX_INSTANCE_LEVEL_COUNT };
#endif
enum { HIT_PRIM = 5, HIT_GEOM = 6, HIT_INST = 7 };

/* Intersection or occlusion; exactly one of the argument pointers is set. */
typedef struct ep_query {
    const struct RTCIntersectFunctionNArguments *intersect;
    const struct RTCOccludedFunctionNArguments *occluded;
    EPGeometry geometry;
    const ep_hierarchy *hierarchy; /* the geometry's, or that of one patch */
    const ep_leaf *leaf;
    const float *net;
    ep_rtc_context *context;
    float *ray; /* a packet of n rays in Embree's layout, hits behind it for an intersection */
    unsigned n, geom_id;
} ep_query;

/* Roots in the layout of an RTCHit<n>. */
typedef struct ep_candidates {
    alignas(64) float t[EP_PACKET];
    alignas(64) float hit[HIT_FIELDS * EP_PACKET];
} ep_candidates;

/* A ray and its hit, as a packet of one. */
typedef struct ep_lane {
    ep_query query;
    alignas(16) float ray[EP_RAY_FIELDS + HIT_FIELDS];
} ep_lane;

/* Ids of what is hit, as they stand in a hit from HIT_PRIM on. */
enum { HIT_IDS = HIT_FIELDS - HIT_PRIM };

/* Where the leaf's patch lies in its face; NULL when patches are faces by themselves. */
static inline const ep_place *ep_place_of(const ep_query *q)
{
    const ep_place *places = q->geometry->faces.places;
    return places ? &places[q->leaf->patch] : NULL;
}

static inline void ep_ids_of(const ep_query *q, uint32_t id[HIT_IDS])
{
    const ep_place *place = ep_place_of(q);
    id[0] = place ? place->face : q->leaf->patch;
    id[HIT_GEOM - HIT_PRIM] = q->geom_id;
    uint32_t *inst = &id[HIT_INST - HIT_PRIM];
    for (unsigned l = 0; l < RTC_MAX_INSTANCE_LEVEL_COUNT; ++l) {
        inst[l] = q->context->instID[l];
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
        inst[RTC_MAX_INSTANCE_LEVEL_COUNT + l] = q->context->instPrimID[l];
#endif
    }
}

/* Gives hit `lane` of `n` the parameters of the face. */
static inline void ep_place_hit(const ep_place *place, float *hit, unsigned n, unsigned lane)
{
    double u, v;
    ep_place_apply(place, hit[EP_HIT_U * n + lane], hit[EP_HIT_V * n + lane], &u, &v);
    hit[EP_HIT_U * n + lane] = (float)u;
    hit[EP_HIT_V * n + lane] = (float)v;
    for (unsigned k = EP_HIT_NG; k < EP_HIT_NG + 3; ++k) hit[k * n + lane] = (float)(place->scale * hit[k * n + lane]);
}

/* Asks the filters about the hits that `valid` names; `hit` is an RTCHit<n> with its ids. */
static inline void ep_ask_filters(const ep_query *q, int *valid, float *hit)
{
    const struct RTCFilterFunctionNArguments args = {
        valid, q->geometry, q->context, (struct RTCRayN *)q->ray, (struct RTCHitN *)hit, q->n};
    if (q->intersect) ep_rtc_filter_intersection(q->intersect, &args);
    else ep_rtc_filter_occlusion(q->occluded, &args);
}

/* Loads wait for stores that they overlap but in part: what is loaded at once is stored at once. */
typedef float ep_quad __attribute__((vector_size(16), aligned(4), may_alias));

/* The kernel stores Ng and u at once, and everything else comes word by word. */
static inline void ep_copy_hit(const float *hit, float *to)
{
    *(ep_quad *)to = *(const ep_quad *)hit;
    for (unsigned k = EP_HIT_V; k < HIT_FIELDS; ++k) {
        uint32_t word;
        memcpy(&word, &hit[k], sizeof word);
        __asm__("" : "+r"(word)); /* a word, not a part of four */
        memcpy(&to[k], &word, sizeof word);
    }
}

/* ep_offer for a packet of one that the trim, if any, keeps. In line, because that is how most rays end. */
static inline bool ep_offer_one(const ep_query *q, float t, float hit[HIT_FIELDS])
{
    int valid = -1;
    float *tfar = q->ray + EP_RAY_TFAR;
    const float before = *tfar;
    const ep_place *place = ep_place_of(q);
    uint32_t id[HIT_IDS];
    if (place) ep_place_hit(place, hit, 1, 0);
    ep_ids_of(q, id);
    memcpy(hit + HIT_PRIM, id, sizeof id);
    *tfar = t;
    ep_ask_filters(q, &valid, hit);
    if (!valid) *tfar = before;
    else if (q->intersect) ep_copy_hit(hit, q->ray + EP_RAY_FIELDS);
    else *tfar = -INFINITY;
    return valid;
}

/* A ray of a packet, its fields side by side, as the single-ray kernel loads them. */
static inline void ep_gather(const ep_query *packet, unsigned lane, float ray[EP_RAY_FIELDS])
{
    const unsigned n = packet->n;
    const float *from = packet->ray + lane;
    for (unsigned f = 0; f < EP_RAY_FIELDS; f += 4, from += 4 * n)
        *(ep_quad *)(ray + f) = (ep_quad){from[0], from[n], from[2 * n], from[3 * n]};
}

/* The packet's query, for the ray that was gathered. */
static inline void ep_ask_for_one(const ep_query *packet, ep_lane *one)
{
    one->query = *packet;
    one->query.ray = one->ray;
    one->query.n = 1;
}

/* Takes one ray out of a packet; its hit, too, which only ep_in_front looks at; puts what it has met back. */
void ep_take_lane(const ep_query *packet, unsigned lane, ep_lane *one);
void ep_take_hit(const ep_query *packet, unsigned lane, ep_lane *one);
void ep_put_lane(const ep_lane *one, const ep_query *packet, unsigned lane);

static inline const ep_patch *ep_patch_of(const ep_query *q)
{
    return &q->hierarchy->patches[q->leaf->patch];
}

/* Is a candidate in front of what the ray has? Neighbouring leaves both find a root on their common border; where
 * their t is the same float, the smaller primID, then u, v and Ng decide, not which leaf came first. */
bool ep_in_front(const ep_query *q, unsigned lane, const ep_candidates *c);

/* Which vague candidates have to be found again: for an occlusion query it is enough that there is a root, unless a
 * trim asks where. */
static inline uint32_t ep_to_polish(const ep_query *q, uint32_t hit, uint32_t vague)
{
    return q->intersect || q->leaf->trim ? vague : vague & ~hit;
}

/* Finds a vague candidate again in double. */
ep_polished ep_polish_candidate(const ep_query *q, unsigned lane, ep_candidates *c);

/* Offers those of the candidates in `mask` that the leaf's trim keeps to the filters; accepted ones become the rays'
 * hits. Returns the accepted lanes. */
uint32_t ep_offer(const ep_query *q, uint32_t mask, ep_candidates *c);

#endif
