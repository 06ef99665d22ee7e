/* arcs.h - the curves of a part as points, and the narrowest strips around them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_TRIM_ARCS_H
#define EP_TRIM_ARCS_H

#include "trim/trim.h"

enum { EP_ARC_PIECES = 256, EP_ARC_POINTS = 2048 };

/* The hulls of a part's pieces within a domain (ep_edges_arcs()); piece i has points first[i] to first[i+1]. */
typedef struct ep_arcs {
    unsigned pieces, count;
    uint32_t piece[EP_ARC_PIECES];
    unsigned first[EP_ARC_PIECES + 1];
    ep_point2 point[EP_ARC_POINTS];
} ep_arcs;

/* False when there are too many. */
bool ep_arcs_find(const ep_trim *t, const ep_trim_part *part, const ep_trim_domain *d, ep_arcs *a);

/* Between the lines n·p = lo and n·p = hi; n has unit length. */
typedef struct ep_strip {
    double n[2], lo, hi;
} ep_strip;

/* Around the points, across their principal axis. */
ep_strip ep_strip_around(const ep_point2 *p, unsigned count);
void ep_strip_extent(const double n[2], const ep_point2 *p, unsigned count, double *lo, double *hi);

#endif
