/* oracle.h - where a ray meets curved patches: by subdivision, in double, slowly and obviously.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Shares no code with the library. A part of a patch is dismissed only when the hull of its control points, seen along
 * the ray, does not hold the ray; a root is taken where the derivatives' hull allows at most one and Newton's method
 * finds it. What stays undecided when parts are tiny, and every root so close to tangency or to a border that float
 * may see it either way, is reported as doubtful: a program under test may count it as a hit or not. */
#ifndef ORACLE_H
#define ORACLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Bands within which hit or miss is a matter of rounding. */
#define ORACLE_TANGENT 2e-3 /* |cosine| between ray and normal               */
#define ORACLE_BORDER 1e-5  /* of the parameters, from the domain's border    */
#define ORACLE_NEAR 2e-6    /* of the patch's radius, past a silhouette        */

typedef struct oracle_patch {
    bool triangle;
    unsigned degree_u, degree_v; /* 1..25; equal for a triangle                                   */
    const double *points;        /* x, y, z, w each, Euclidean, in the order of embree_patch.h */
} oracle_patch;

typedef struct oracle oracle;

/* Copies the patches. NULL when there is no memory. */
oracle *oracle_new(const oracle_patch *patches, size_t count);
void oracle_free(oracle *o);

typedef struct oracle_root {
    double t_low, t_high; /* equal for a root that was found                        */
    double u, v;
    double normal[3]; /* dP/du x dP/dv, not normalised; may vanish              */
    double cosine;    /* |cosine| between ray and normal                        */
    double border;    /* parameter distance from the border, negative outside   */
    uint32_t patch;
    bool doubtful;
} oracle_root;

enum { ORACLE_ROOTS = 128 };

/* All roots with tnear < t < tfar, by t_low; returns their number, at most ORACLE_ROOTS. Where there are more, for a
 * ray in a surface, the last is doubtful and stands for all from it on. Any number of threads. */
size_t oracle_intersect(const oracle *o, const double org[3], const double dir[3], double tnear, double tfar,
                        oracle_root roots[ORACLE_ROOTS]);

/* Point and derivatives; the last two may be NULL. */
void oracle_evaluate(const oracle *o, uint32_t patch, double u, double v, double p[3], double pu[3], double pv[3]);

size_t oracle_patch_count(const oracle *o);
bool oracle_is_triangle(const oracle *o, uint32_t patch);
/* The largest half side of the patch's box. */
double oracle_radius(const oracle *o, uint32_t patch);
/* Box of everything. */
void oracle_bounds(const oracle *o, double lower[3], double upper[3]);

#endif
