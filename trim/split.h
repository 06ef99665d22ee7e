/* split.h - how a hierarchy should divide a domain that trim curves cross, so that little of it stays crossed.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Proposals only: whatever a caller makes of them (rounded, say), ep_trim_cut() then tells the truth about. */
#ifndef EP_TRIM_SPLIT_H
#define EP_TRIM_SPLIT_H

#include "trim/trim.h"

enum { EP_SPLIT_MOST = 8 };

typedef struct ep_trim_triangles {
    unsigned count;
    ep_point2 corner[EP_SPLIT_MOST][3]; /* counter-clockwise; together they are the triangle */
} ep_trim_triangles;

/* Into four alike. */
void ep_trim_split_regular(const ep_point2 triangle[3], ep_trim_triangles *out);

/* Along the curves in the triangle [Stürzlinger 1998, appendix]: between two parallels that hold them all, or, when
 * these are far apart, that hold the piece that halves the triangle best; into four alike when that fails, or would
 * make a triangle thinner than `thinnest` (its height over its longest side). The space between the parallels is
 * widened to that, too. False when the split is regular. */
bool ep_trim_split_triangle(const ep_trim *trim, const ep_trim_part *part, const ep_point2 triangle[3], double thinnest,
                            ep_trim_triangles *out);

/* Across the rectangle, at coordinate `at` of `axis` (0: u): where it cuts off what no curve enters, unless that would
 * make a rectangle thinner than `thinnest` (one side over the other); or it halves the longer side. */
void ep_trim_split_rectangle(const ep_trim *trim, const ep_trim_part *part, const ep_point2 lo, const ep_point2 hi,
                             double thinnest, int *axis, double *at);

#endif
