/* region.h - what of a domain is kept: a tree of contours joined by union, intersection and difference.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Constructive planar geometry [Stürzlinger 1998, section 2.2]. A region is written down from the outside in:
 *
 *     ep_region_begin(r, EP_REGION_DIFFERENCE, NULL, &m);
 *     ep_region_square(r, NULL, &m);
 *     ep_region_begin(r, EP_REGION_POLYGON, NULL, &m);
 *     ep_region_bezier(r, 4, points, &m);
 *     ep_region_end(r, &m);
 *     ep_region_end(r, &m);
 *
 * A contour (square, circle, polygon, loops) is even-odd: a point is inside when a path from far away to it crosses
 * the contour an odd number of times. A polygon's segments follow one another; where one does not begin at the end of
 * the last, and where the last does not end at the first, a straight segment joins them. Segments may have no length,
 * overlap, touch and cross.
 *
 * A transform {a,b,c,d,e,f} maps (x,y) to (ax + cy + e, bx + dy + f); those of the nodes around it are applied after
 * it. NULL: none. A call that fails changes nothing. */
#ifndef EP_TRIM_REGION_H
#define EP_TRIM_REGION_H

#include "trim/curve.h"

typedef struct ep_region ep_region;

typedef enum ep_region_kind {
    EP_REGION_UNION,
    EP_REGION_INTERSECTION,
    EP_REGION_DIFFERENCE, /* of exactly two: in the first, not in the second      */
    EP_REGION_LOOPS,      /* of polygons: in an odd number of them                */
    EP_REGION_POLYGON,    /* of segments                                          */
    EP_REGION_SQUARE,     /* [0,1]²; has no begin, like EP_REGION_CIRCLE          */
    EP_REGION_CIRCLE      /* of radius 1 about the origin                         */
} ep_region_kind;

/* Regions nest no deeper than this. */
enum { EP_REGION_DEPTH = 256 };

ep_region *ep_region_new(void);
void ep_region_free(ep_region *r);
size_t ep_region_bytes(const ep_region *r);

/* EP_INVALID: there is a region already, or it has no place here (a circle among a polygon's segments).
 * EP_BAD_DATA: a number or a knot vector has no meaning. */
EPStatus ep_region_begin(ep_region *r, ep_region_kind kind, const double transform[6], ep_message *m);
EPStatus ep_region_end(ep_region *r, ep_message *m);
EPStatus ep_region_square(ep_region *r, const double transform[6], ep_message *m);
EPStatus ep_region_circle(ep_region *r, const double transform[6], ep_message *m);

/* Segments of the polygon that was begun last. `count` points; weights are positive. A Bézier curve has degree
 * count-1; a NURBS curve has count+degree+1 knots, which do not decrease and repeat at most `degree` times inside. */
EPStatus ep_region_line(ep_region *r, size_t count, const ep_point2 *points, ep_message *m);
EPStatus ep_region_bezier(ep_region *r, size_t count, const ep_point2w *points, ep_message *m);
EPStatus ep_region_nurbs(ep_region *r, unsigned degree, size_t knot_count, const double *knots, size_t count,
                         const ep_point2w *points, ep_message *m);

/* What the other files of the library read. Nodes stand in prefix order; `next` is the node after the subtree. */
typedef struct ep_region_node {
    ep_region_kind kind; /* never a polygon of loops: loops are one contour */
    uint32_t next;
    uint32_t curves, curve_count; /* of a contour */
} ep_region_node;

/* One Bézier curve in the domain's coordinates. Ends are kept as points: wx/w would round. Curves that meet have equal
 * ends, bit for bit. */
typedef struct ep_region_curve {
    ep_point2 end[2];
    size_t first; /* of its degree+1 points */
    uint32_t degree;
} ep_region_curve;

typedef struct ep_region_view {
    const ep_region_node *nodes;
    const ep_region_curve *curves;
    const ep_point2h *points;
    size_t node_count, curve_count, point_count;
    double scale; /* the largest coordinate of a point */
} ep_region_view;

/* EP_INVALID: something begun has not been ended, or there is nothing. */
EPStatus ep_region_look(const ep_region *r, ep_region_view *view, ep_message *m);

#endif
