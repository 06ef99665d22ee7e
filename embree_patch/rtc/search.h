/* search.h - rays that a kernel leaves undecided.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_SEARCH_H
#define EP_SEARCH_H

#include "embree_patch/rtc/offer.h"

/* Offers the kernel's candidates in `front`, and solves the lanes in `slow`: by the tangent kernel, whose first roots
 * go to `c`, too, cell by cell along their way through the leaf's prism where that does not do, and by subdivision in
 * double where that does not either. Returns the lanes that have a new hit. */
uint32_t ep_search(const ep_query *q, uint32_t slow, uint32_t front, ep_candidates *c, EPCounters *counters);

#endif
