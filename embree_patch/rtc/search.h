/* search.h - rays that a kernel leaves undecided.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_SEARCH_H
#define EP_SEARCH_H

#include "embree_patch/rtc/offer.h"

/* Solves the lanes in `slow`: by the tangent kernel, cell by cell along their way through the leaf's prism where that
 * does not do, and by subdivision in double where that does not either. Returns the lanes that have a new hit. */
uint32_t ep_search(const ep_query *q, uint32_t slow, EPCounters *counters);

#endif
