/* clip.c - iterative Bézier clipping [Pabst et al. 2006, section 5.3].
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The curve's signed height over the ray, d(t) = sum w_i (y_i - v) B_i(t), is clipped to where the convex hull of its
 * control points (i/n, d_i) meets the t axis. Only two intervals are kept, the one that is searched and what is left to
 * search behind it; the coefficients over an interval are formed from the curve again each time.
 *
 * The paper counts roots. Here the sign of d is followed instead, from the exact one at the beginning to the exact one
 * at the end: a crossing is a change of it, so tangents, roots at ends and rounding near a root cannot change the
 * parity of a closed contour. */
#include "trim/methods.h"

#include <string.h>

/* A root's interval this narrow is a point: the curve moves less there than float tells apart. */
static const double narrow = 0x1p-32;
/* A clip that leaves more than this is followed by a cut in half. */
static const double slow = 0.8;

/* The coefficients of d over [t0,t1]. */
static void restrict_to(const ep_point2h *p, unsigned n, double v, double t0, double t1, double *d)
{
    for (unsigned i = 0; i <= n; ++i) d[i] = p[i][1] - v * p[i][2];
    if (t1 != 1)
        for (unsigned k = 1; k <= n; ++k)
            for (unsigned i = n; i >= k; --i) d[i] = (1 - t1) * d[i - 1] + t1 * d[i];
    if (t0 != 0) {
        const double t = t0 / t1;
        for (unsigned k = n; k > 0; --k)
            for (unsigned i = 0; i < k; ++i) d[i] = (1 - t) * d[i] + t * d[i + 1];
    }
}

/* Where the hull of (i/n, d_i) first meets the axis, seen from coefficient `from` in steps of `step`: on its edge from
 * the steepest point of the other sign, as seen from the first, back to the point of the first's sign that is least
 * steep from there. */
static double hull_meets(const double *d, unsigned n, unsigned from, int step)
{
    const bool sign = d[from] > 0;
    double e[EP_CURVE_POINTS];
    bool same[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= n; ++i) {
        const double di = d[(int)from + step * (int)i];
        e[i] = sign ? di : -di;
        same[i] = (di > 0) == sign;
    }
    unsigned k = 0, l = 0;
    double steepest = INFINITY, least = -INFINITY;
    for (unsigned i = 1; i <= n; ++i) {
        const double slope = (e[i] - e[0]) / i;
        if (!same[i] && slope < steepest) steepest = slope, k = i;
    }
    for (unsigned i = 0; i < k; ++i) {
        const double slope = (e[k] - e[i]) / (k - i);
        if (same[i] && slope > least) least = slope, l = i;
    }
    return (l + (k - l) * (e[l] / (e[l] - e[k]))) / n;
}

/* Of one sign, or nothing but rounding. */
static bool is_settled(const double *d, unsigned n, double rounding)
{
    unsigned above = 0, large = 0;
    for (unsigned i = 0; i <= n; ++i) above += d[i] > 0, large += fabs(d[i]) > rounding;
    return above == 0 || above == n + 1 || large == 0;
}

bool ep_clip_crosses(const ep_region_curve *curve, const ep_point2h *p, bool left_only, double u, double v)
{
    const unsigned n = curve->degree;
    double d[EP_CURVE_POINTS], rounding = 0, t0 = 0, t1 = 1;
    for (unsigned i = 0; i <= n; ++i) rounding = fmax(rounding, fabs(p[i][1]) + fabs(v) * p[i][2]);
    rounding *= 3 * (n + 1) * EP_EPS_D;
    bool above = curve->end[0][1] > v, odd = false;
    while (t0 < 1) {
        restrict_to(p, n, v, t0, t1, d);
        const bool settled = is_settled(d, n, rounding);
        if (settled || t1 - t0 < narrow) {
            if ((d[n] > 0) != above) { /* at t0, if only rounding had hidden it there */
                ep_point2 c;
                ep_curve_eval(p, n, settled ? t0 : 0.5 * (t0 + t1), c);
                odd ^= c[0] > u;
                above = !above;
            }
            t0 = t1, t1 = 1;
            continue;
        }
        if ((d[0] > 0) != above) { /* rounding, at a root that was left behind */
            ep_point2 c;
            ep_curve_eval(p, n, t0, c);
            odd ^= c[0] > u;
            above = !above;
        }
        const double width = t1 - t0, from = hull_meets(d, n, 0, 1);
        const double to = left_only ? 1 : 1 - hull_meets(d, n, n, -1);
        const double next = fmax(t0, t0 + from * width);
        double end = fmin(t1, t0 + to * width);
        if (!(end > next)) end = t1; /* the hull is thinner than rounding */
        if (end - next > slow * width) end = next + 0.5 * (end - next);
        t0 = next, t1 = fmin(t1, fmax(end, next + 0.5 * narrow));
    }
    if ((curve->end[1][1] > v) != above) odd ^= curve->end[1][0] > u;
    return odd;
}
