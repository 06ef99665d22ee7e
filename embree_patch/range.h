/* range.h - intervals of doubles.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_RANGE_H
#define EP_RANGE_H

#include <math.h>

typedef struct ep_range {
    double lo, hi;
} ep_range;

/* Contains nothing; what ep_include starts from. */
#define EP_NOTHING ((ep_range){INFINITY, -INFINITY})

static inline void ep_include(ep_range *r, double x)
{
    if (x < r->lo) r->lo = x;
    if (x > r->hi) r->hi = x;
}
static inline double ep_mid(ep_range r)
{
    return r.lo / 2 + r.hi / 2;
}
static inline double ep_half(ep_range r)
{
    return r.hi / 2 - r.lo / 2;
}
/* The largest magnitude in a range. */
static inline double ep_mag(ep_range r)
{
    return -r.lo > r.hi ? -r.lo : r.hi;
}

#endif
