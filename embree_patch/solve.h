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

/* The nearest root with after < t < before; false: there is none. Call again with after = root->t for the next. */
bool ep_solve(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], double after,
              double before, ep_root *root);

#endif
