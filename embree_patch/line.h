/* line.h - a ray next to a patch, in double: where it is in a leaf.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_LINE_H
#define EP_LINE_H

#include "embree_patch/leaf.h"

/* A ray with its origin moved next to the patch: o + (t - t0) d, relative to the patch's centre. */
typedef struct ep_line {
    ep_vec3 o, d;
    double t0;
} ep_line;

/* False if org and dir make no line: a direction of zero, or numbers that are no longer finite. */
bool ep_line_of(const ep_patch *patch, const float org[3], const float dir[3], ep_line *line);

/* Where the line is in the leaf's prism, within [*lo, *hi], which it narrows; false: nowhere. A leaf without a prism
 * leaves them as they are: false where the line passes it by. */
bool ep_line_clip(const ep_patch *patch, const ep_leaf *leaf, const ep_line *line, double *lo, double *hi);

/* A part of the leaf's unit domain with all points that the line meets from `lo` to `hi`; `local` is
 * ep_patch_local's. */
ep_domain ep_line_part(const ep_patch *patch, const ep_leaf *leaf, const ep_point *local, const ep_line *line,
                       double lo, double hi);

static inline ep_domain ep_leaf_domain(const ep_leaf *leaf)
{
    const float *f = leaf->domain;
    return (ep_domain){f[0], f[1], f[2], f[4], f[5], f[3]};
}

/* How far the leaf's coordinates may be off because its corners are rounded to floats. */
double ep_leaf_corners(const ep_leaf *leaf);

/* How far (s, t) is outside the unit domain; negative inside. */
static inline double ep_outside(bool triangle, double s, double t)
{
    return fmax(fmax(-s, -t), triangle ? s + t - 1 : fmax(s, t) - 1);
}

/* Moves (s, t) into the unit domain. */
void ep_clamp(bool triangle, double *s, double *t);

#endif
