/* polish.h - a root that floats leave vague, found again in double.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_POLISH_H
#define EP_POLISH_H

#include "embree_patch/leaf.h"

typedef enum ep_polished { EP_POLISHED, EP_POLISHED_AWAY, EP_POLISHED_LOST } ep_polished;

/* A root that doubles find no farther than this outside a patch, or outside what its trim keeps, is in: a thousand
 * times what they err by. Neighbours that share a border, or that are trimmed along one curve, leave nothing between
 * them. */
#define EP_BORDER 0x1p-36

/* A leaf's root found in float, found again in double: *t and field = Ng, u, v are replaced, and `exact` is u, v as
 * they are. AWAY: it is outside the patch, or another leaf's, at *t. LOST: Newton leaves its neighbourhood of 2^-8. */
ep_polished ep_polish(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], float *t,
                      float field[5], double exact[2]);

#endif
