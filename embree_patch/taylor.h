/* taylor.h - functions of (s, t) over a piece, as polynomials of the fourth degree and a bound on what these leave out.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Taylor models (Makino and Berz 1996): terms that cancel between functions do so in the polynomials, and what is
 * beyond them only has to be small. Fourth order, because a leaf's models are of the second: what is left of them is
 * mostly of the third, and a bound on the fourth is not yet a small part of that. */
#ifndef EP_TAYLOR_H
#define EP_TAYLOR_H

#include "embree_patch/range.h"

enum { EP_TAYLOR_DEGREE = 4, EP_TAYLOR_TERMS = 15 };

/* c[k] s^i t^j in the order of ep_taylor_index; whatever else there is has a magnitude of at most `rest`. */
typedef struct ep_taylor {
    double c[EP_TAYLOR_TERMS], rest;
} ep_taylor;

/* Where they are: the largest |s^i t^j| over the piece, for the terms; that of a product is at most the product of
 * theirs. And its corners, in turn; (0, 0) is inside. */
typedef struct ep_monomials {
    double max[EP_TAYLOR_TERMS];
    unsigned corners;
    double corner[4][2];
} ep_monomials;

/* By degree, and within one by that of t. */
static inline unsigned ep_taylor_index(unsigned i, unsigned j)
{
    return (i + j) * (i + j + 1) / 2 + j;
}

/* a + k b */
ep_taylor ep_taylor_add(const ep_taylor *a, double k, const ep_taylor *b);
ep_taylor ep_taylor_multiply(const ep_taylor *a, const ep_taylor *b, const ep_monomials *m);
/* `low` > 0 is no larger than any |b|. */
ep_taylor ep_taylor_divide(const ep_taylor *a, const ep_taylor *b, double low, const ep_monomials *m);
/* Contains a's range. */
ep_range ep_taylor_range(const ep_taylor *a, const ep_monomials *m);

#endif
