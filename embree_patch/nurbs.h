/* nurbs.h - a NURBS surface as the Bézier patches that it consists of.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Each pair of spans, one of u and one of v, is a patch. Neighbours have equal borders, bit for bit. Everything is a
 * convex combination of control points, (1 - t) a + t b: weights stay positive, and those of 1 stay 1, for 1 - t is right
 * to 2^-54 and so its sum with t rounds to 1. */
#ifndef EP_NURBS_H
#define EP_NURBS_H

#include "embree_patch/bezier.h"
#include "embree_patch/knots.h"

typedef struct ep_nurbs {
    unsigned degree[2];     /* in u and in v     */
    size_t count[2];        /* of control points */
    size_t knot_count[2];   /* count + degree + 1 */
    const double *knots[2]; /* a knot may repeat degree + 1 times: the surface may be torn there */
} ep_nurbs;

/* EP_BAD_DATA: the knots are none. EP_INVALID: there are too many spans. */
EPStatus ep_nurbs_check(const ep_nurbs *n, ep_message *m);

/* The patches: spans of u times spans of v. Each has (degree u + 1) (degree v + 1) points. */
size_t ep_nurbs_patches(const ep_nurbs *n);

/* From count[0] * count[1] homogeneous points, u running fastest, the points of all patches, span by span of u for each
 * span of v, and where they lie (epJoinPatches). EP_NO_MEMORY. */
EPStatus ep_nurbs_split(const ep_nurbs *n, const ep_point *points, ep_point *out, double (*places)[6], ep_message *m);

#endif
