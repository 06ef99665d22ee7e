/* knots.h - knot vectors: what one has to be, and the spans of a B-spline as Bézier curves.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A spline of degree p with n control points has knots t[0] <= ... <= t[n+p] and is defined from t[p] to t[n]. Its
 * spans are the intervals t[i] < t[i+1] in between; over each it is a polynomial, with weights a quotient of two. */
#ifndef EP_KNOTS_H
#define EP_KNOTS_H

#include "embree_patch/base.h"

/* Is that a knot vector for `count` points? A knot between the ends may repeat `most` times: as often as the degree,
 * for a curve that is in one piece, or once more, where it may be torn. EP_BAD_DATA if not. */
EPStatus ep_knots_check(unsigned degree, size_t knot_count, const double *knots, size_t count, unsigned most,
                        ep_message *m);

/* The next span from knot `i` on: its first knot's index, `count` when there is none. Begin with i = degree. */
size_t ep_knots_next_span(const double *knots, size_t count, size_t i);

/* The numbers of a point at most. */
enum { EP_KNOTS_NUMBERS = 4 };

/* Span i as a Bézier curve of degree p. Points have `numbers` doubles each and stand `stride` doubles apart, those of
 * the curve `out_stride`; points i-p to i are read. */
void ep_knots_bezier(const double *points, unsigned numbers, size_t stride, unsigned p, const double *knots, size_t i,
                     double *out, size_t out_stride);

#endif
