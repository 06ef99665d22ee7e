/* rtc_geometry.h - what the callbacks of leaves and those of patches that are cut on demand share.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_RTC_GEOMETRY_H
#define EP_RTC_GEOMETRY_H

#include "embree_patch/rtc/offer.h"

/* A leaf and a packet of rays. Tells Embree by `valid` what became of them; returns the lanes that have a new hit. */
uint32_t ep_visit(const ep_query *q, int *valid);

typedef struct ep_callbacks {
    RTCBoundsFunction bounds;
    RTCIntersectFunctionN intersect;
    RTCOccludedFunctionN occluded;
} ep_callbacks;

/* A committed geometry of `count` user primitives; NULL when Embree has failed. */
RTCGeometry ep_new_user_geometry(RTCDevice device, size_t count, void *user, const ep_callbacks *callbacks);

static inline void ep_give_box(const ep_box *b, struct RTCBounds *o)
{
    o->lower_x = b->lower[0], o->lower_y = b->lower[1], o->lower_z = b->lower[2];
    o->upper_x = b->upper[0], o->upper_y = b->upper[1], o->upper_z = b->upper[2];
}

#endif
