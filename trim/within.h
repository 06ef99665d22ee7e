/* within.h - a region as it is seen from a part of the plane, in that part's own coordinates.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A face that consists of many patches has one region. Each patch gets what of it can be seen from its own domain: the
 * curves that may enter that, and in place of the others as few straight lines. */
#ifndef EP_TRIM_WITHIN_H
#define EP_TRIM_WITHIN_H

#include "trim/region.h"

/* The region under a transform that takes the part to [0,1]², or to the triangle s, t >= 0, s + t <= 1. Inside of that
 * the new region has the points of the old one; outside it may have others. EP_BAD_DATA: curves that then lie too far
 * out. EP_NO_MEMORY. */
EPStatus ep_region_within(const ep_region *region, const double transform[6], bool triangle, ep_region **out,
                          ep_message *m);

#endif
