/* solve.h - a ray against a leaf by subdivision, in double: for rays that no bound stored in the leaf decides.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_SOLVE_H
#define EP_SOLVE_H

#include "embree_patch/leaf.h"

typedef struct ep_root {
    double t, u, v;
    double ng[3];  /* dP/du x dP/dv; at a collapsed edge its limit from inside */
    bool crossing; /* certified to be the only root near it; otherwise a tangency or a pole, or the ray lies there */
} ep_root;

/* Where the ray is in the leaf's prism, within [*lo, *hi], which it narrows; false: nowhere. A leaf without a prism
 * leaves them as they are. */
bool ep_clip(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], double *lo,
             double *hi);

typedef enum ep_polished { EP_POLISHED, EP_POLISHED_AWAY, EP_POLISHED_LOST } ep_polished;

/* A root that doubles find no farther than this outside a patch, or outside what its trim keeps, is in: a thousand
 * times what they err by. Neighbours that share a border, or that are trimmed along one curve, leave nothing between
 * them. */
#define EP_BORDER 0x1p-36

/* A leaf's root found in float, found again in double: *t and field = Ng, u, v are replaced, and `exact` is u, v as
 * they are. AWAY: it is outside the patch, or another leaf's, at *t. LOST: Newton leaves its neighbourhood of 2^-8. */
ep_polished ep_polish(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], float *t,
                      float field[5], double exact[2]);

/* The nearest root with after < t < before; false: there is none. Call again with after = root->t for the next. */
bool ep_solve(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], double after,
              double before, ep_root *root);

#endif
