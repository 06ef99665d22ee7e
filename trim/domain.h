/* domain.h - a convex part of the parameter domain, and which curves enter it.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Whatever is said of a domain holds for all points nearer to it than its margin, too. A negative margin leaves a seam
 * of that width along the border out of the account, so that a curve which only follows the border from inside or
 * outside does not enter the domain: then points in the seam may be told wrong that are nearer than it to such a curve.
 * In a corner the seam is as wide as its two sides make it. */
#ifndef EP_TRIM_DOMAIN_H
#define EP_TRIM_DOMAIN_H

#include "trim/piece.h"

enum { EP_DOMAIN_CORNERS = 8 };

typedef struct ep_trim_domain {
    unsigned count; /* of corners, counter-clockwise */
    ep_point2 corner[EP_DOMAIN_CORNERS];
    double margin;
} ep_trim_domain;

/* A convex polygon of 3 or 4 corners, in either sense; it may have no area. */
ep_trim_domain ep_domain_polygon(unsigned count, const ep_point2 *corners, double margin);
ep_trim_domain ep_domain_rectangle(double u0, double u1, double v0, double v1, double margin);

/* The largest coordinate of a corner. */
double ep_domain_scale(const ep_trim_domain *d);
/* More than evaluating curves and edges rounds, for curves and a domain with coordinates up to `scale`. */
double ep_domain_rounding(const ep_trim_domain *d, double scale);
/* With the margin that decides: rounding added, and a seam no wider than a sixteenth of the domain's height. */
ep_trim_domain ep_domain_settle(const ep_trim_domain *d, double scale);

void ep_domain_bounds(const ep_trim_domain *d, ep_point2 lo, ep_point2 hi);
void ep_domain_centre(const ep_trim_domain *d, ep_point2 out);

/* The domain as half-planes, made once for any number of questions: functions that are negative inside and reach 0 at
 * the margin. Edges of no length have none. */
typedef struct ep_trim_edge {
    double x, y, nx, ny, offset;
} ep_trim_edge;
typedef struct ep_trim_edges {
    const ep_trim_domain *domain;
    ep_trim_edge edge[EP_DOMAIN_CORNERS];
    unsigned count;
    ep_point2 lo, hi; /* the box of the domain with its margin */
    double size;      /* the larger side of the domain's box, with a margin or seam on either end */
} ep_trim_edges;
/* They refer to the domain. */
ep_trim_edges ep_domain_edges(const ep_trim_domain *d);

/* The part of the domain where coordinate `axis` is at most (at least) c. False when that has no area. */
bool ep_domain_clip(const ep_trim_domain *d, int axis, double c, bool above, ep_trim_domain *out);

/* How a piece that enters the domain is to count for points beyond one of its ends (part.c). */
typedef enum ep_beyond {
    EP_BEYOND_NEVER,  /* the end lies on the left of the domain                                     */
    EP_BEYOND_ALWAYS, /* on the right                                                               */
    EP_BEYOND_LEFT_OF /* below or above all of it: for points on the left of the end, as if it went
                         on straight up or down; only points in a seam or margin are there          */
} ep_beyond;
/* For an end in the domain one of the first two, and always the same. */
ep_beyond ep_edges_beyond(const ep_trim_edges *e, const ep_point2 end);

/* Can the piece enter the domain or its margin? Never false when it does. */
bool ep_edges_meet(const ep_trim_edges *e, const ep_piece *p, const ep_point2h *points);

/* Points whose convex hull holds all of the piece that is in the domain or its margin. They are appended to the `count`
 * points in `out`; false when there is no room for them in `room`. */
bool ep_edges_arcs(const ep_trim_edges *e, const ep_piece *p, const ep_point2h *points, ep_point2 *out, unsigned room,
                   unsigned *count);

#endif
