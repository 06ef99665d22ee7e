/* band.h - curved strips that hold what crosses a cell: one test for nearly all of its points.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * In a cell's own coordinates, from -1/2 to 1/2, let
 *
 *     q(x, y) = a x + b y + c bend (b x - a y)²,    a parabola's level lines;
 *
 * outside where q < lo and inside where q > hi. A band is two words: a, b in 12 bits, c in 8; hi, lo in 16 bits and
 * units of `fine`. Lines that are out of reach, |q| being below 4000, are at the ends of the range. */
#ifndef EP_TRIM_BAND_H
#define EP_TRIM_BAND_H

#include "trim/trim.h"

enum { EP_BAND_NORMAL = 2000, EP_BAND_MOST_BEND = 127 }; /* sqrt(a² + b²); the largest |c| */
#define EP_BAND_BEND 0x1p-17f
#define EP_BAND_FINE 0x1p-3f

/* What is told of a cell holds for points that are no further from it than this part of its sides. */
#define EP_BAND_MARGIN 0x1p-4

/* A cell that nothing crosses. */
void ep_band_even(bool inside, uint32_t words[2]);

/* Of what is in a cell, given with its margin. `side`: the number of rows or columns of the grid, whichever is larger:
 * in float the place of a point in its cell is that inexact. */
void ep_band_fit(const ep_trim *t, const ep_trim_part *part, const ep_trim_domain *cell, uint32_t side,
                 uint32_t words[2]);

#endif
