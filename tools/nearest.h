/* nearest.h - the point of the exact surfaces that is nearest to a given one, in double precision.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_NEAREST_H
#define EPATCH_NEAREST_H

#include "tools/world.h"

/* A chart where an object puts it. */
typedef struct placed_chart {
    EPGeometry geometry;
    struct chart chart;
    double m[12]; /* as Embree got it: rounded to float */
} placed_chart;

placed_chart place_chart(const world *w, size_t object, size_t index);

/* A point S(u,v) of a chart, u and v in [0,1], seen from another point P. */
typedef struct foot {
    double u, v, r[3], du[3], dv[3]; /* r = S(u,v) - P, in the world */
    double r2;                       /* |r|² */
    bool border;                     /* u,v is at the border of the domain */
} foot;

foot foot_at(const placed_chart *p, const double point[3], double u, double v);

/* The foot of `point` on the chart: a local minimum of the distance within the domain, reached from u, v. */
foot foot_near(const placed_chart *p, const double point[3], double u, double v);

/* The distance from `point` to the nearest of all charts, if it is less than `within`; else `within`. */
double nearest_distance(const world *w, const double point[3], double within);

#endif
