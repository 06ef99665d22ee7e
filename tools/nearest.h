/* nearest.h - the point of the exact surfaces that is nearest to a given one, in double precision.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_NEAREST_H
#define EPATCH_NEAREST_H

#include "tools/world.h"

/* A patch where an object puts it. */
typedef struct placed_patch {
    EPGeometry geometry;
    uint32_t index;
    patch_kind kind;
    double m[12]; /* as Embree got it: rounded to float */
} placed_patch;

placed_patch place_patch(const world *w, size_t object, size_t patch);

/* A point S(u,v) of a patch, seen from another point P. */
typedef struct foot {
    double u, v, r[3], du[3], dv[3]; /* r = S(u,v) - P, in the world */
    double r2;                       /* |r|² */
    bool border;                     /* u,v is at the border of the domain */
} foot;

foot foot_at(const placed_patch *p, const double point[3], double u, double v);

/* The foot of `point` on the patch: a local minimum of the distance within the domain, reached from u, v. */
foot foot_near(const placed_patch *p, const double point[3], double u, double v);

/* The distance from `point` to the nearest of all patches, if it is less than `within`; else `within`. */
double nearest_distance(const world *w, const double point[3], double within);

#endif
