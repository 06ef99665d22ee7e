/* offer.h - one query of one leaf, and what becomes of the roots that are found for it.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Every root is a candidate: the ray's tfar is set to it, filters are asked, and a refusal restores tfar. Embree passes
 * structures larger than the public ones, so the pointer that came in is the one handed on. */
#ifndef EP_OFFER_H
#define EP_OFFER_H

#include "embree_patch/geometry.h"
#include "embree_patch/rtc/rtc_compat.h"
#include "embree_patch/solve.h"

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

/* Takes one ray out of a packet, and puts what it has met back. */
void ep_take_lane(const ep_query *packet, unsigned lane, ep_lane *one);
void ep_put_lane(const ep_lane *one, const ep_query *packet, unsigned lane);

static inline const ep_patch *ep_patch_of(const ep_query *q)
{
    return &q->hierarchy->patches[q->leaf->patch];
}

/* Is a candidate in front of what the ray has? Neighbouring leaves both find a root on their common border; where
 * their t is the same float, the smaller primID, then u, v and Ng decide, not which leaf came first. */
bool ep_in_front(const ep_query *q, unsigned lane, const ep_candidates *c);

/* Finds a vague candidate again in double. */
ep_polished ep_polish_candidate(const ep_query *q, unsigned lane, ep_candidates *c);

/* Offers those of the candidates in `mask` that the leaf's trim keeps to the filters; accepted ones become the rays'
 * hits. Returns the accepted lanes. */
uint32_t ep_offer(const ep_query *q, uint32_t mask, ep_candidates *c);

#endif
