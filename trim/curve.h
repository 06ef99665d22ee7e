/* curve.h - rational Bézier curves in the plane: evaluate, cut, find extrema.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A curve of degree n is n+1 homogeneous points (wx, wy, w) with w > 0. Evaluating and cutting form only convex
 * combinations of the points and round about 3n times, so a coordinate is wrong by at most 3n 2^-53 of the largest
 * coordinate of the curve, whatever the weights. */
#ifndef EP_TRIM_CURVE_H
#define EP_TRIM_CURVE_H

#include "embree_patch/base.h"

typedef double ep_point2[2];  /* x, y           */
typedef double ep_point2h[3]; /* wx, wy, w      */
typedef double ep_point2w[3]; /* x, y, weight w */

enum { EP_CURVE_POINTS = EP_MAX_DEGREE + 1 };

void ep_curve_eval(const ep_point2h *p, unsigned n, double t, ep_point2 out);

/* The halves [0,1/2] and [1/2,1]. Either may be p. */
void ep_curve_halve(const ep_point2h *p, unsigned n, ep_point2h *left, ep_point2h *right);

/* The part [t0,t1] of the curve; `out` may be p. */
void ep_curve_restrict(const ep_point2h *p, unsigned n, double t0, double t1, ep_point2h *out);

/* The parameters in (0,1), ascending, where x or y turns round; between two of them both are monotone to within the
 * rounding of the points. `cuts` holds EP_CURVE_CUTS. Returns their number. */
enum { EP_CURVE_CUTS = 4 * EP_MAX_DEGREE };
unsigned ep_curve_turns(const ep_point2w *p, unsigned n, double *cuts);

#endif
