/* piece.h - a leaf's piece of a surface in the leaf's coordinates, in double; and surfaces made for a leaf.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_PIECE_H
#define TEST_PIECE_H

#include "test/support.h"

typedef struct piece {
    const test_patch *patch;
    const ep_leaf *leaf;
    double far; /* sum norm of what its coordinates are computed from */
} piece;

piece piece_of(const test_patch *patch, const ep_hierarchy *h, size_t leaf);

/* The rounding of coordinate `row` in this arithmetic. */
double piece_noise(const piece *p, int row);

/* Where the piece's corner of least s and t is in both of its coordinates; and how far (s, t) is inside of its border,
 * negative outside. */
double piece_corner(const piece *p);
double piece_inside(const piece *p, double s, double t);

/* S and its derivatives by s and t, in space and in leaf coordinates. */
typedef struct piece_jet {
    double p[3], ps[3], pt[3];
    double at[3], ds[3], dt[3];
} piece_jet;
piece_jet piece_at(const piece *p, double s, double t);

/* A patch of the shape's degrees that is all zero, and one more term of it: x s^i t^j, with (s, t) as in a leaf that
 * covers it all. */
void zero_patch(net_shape shape, test_patch *p);
void add_power(test_patch *p, unsigned i, unsigned j, const double x[3]);

/* Three directions of space, at most so skew that their determinant is `least` of what it would be at right angles. */
void skew_axes(rng *r, double least, double axes[3][3]);

#endif
