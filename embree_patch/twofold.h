/* twofold.h - power series of Bézier nets in twice the digits of a double.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Differences of a high degree over a large part of the domain lose as many bits as there are degrees. Here points are
 * sums of two doubles, so that what is lost are bits of the second one; each coefficient of the series is rounded to
 * a double in the end. The same numbers as bezier.h's, at three (tensor) to fifteen (triangle) times the cost. */
#ifndef EP_TWOFOLD_H
#define EP_TWOFOLD_H

#include "embree_patch/bezier.h"

/* ep_tensor_series and ep_tri_series. */
void ep_twofold_tensor_series(const ep_point *net, unsigned m, unsigned n, double u0, double du, double v0, double dv,
                              ep_point *out);
void ep_twofold_tri_series(const ep_point *net, unsigned n, const double X[2], const double U[2], const double V[2],
                           ep_point *out);

#endif
