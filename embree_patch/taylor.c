/* taylor.c - see taylor.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/taylor.h"

ep_taylor ep_taylor_add(const ep_taylor *a, double k, const ep_taylor *b)
{
    ep_taylor r;
    for (unsigned n = 0; n < EP_TAYLOR_TERMS; ++n) r.c[n] = a->c[n] + k * b->c[n];
    r.rest = a->rest + fabs(k) * b->rest;
    return r;
}

/* Bounds on the terms of each degree together. */
static void degrees(const ep_taylor *a, const ep_monomials *m, double sum[EP_TAYLOR_DEGREE + 1])
{
    for (unsigned d = 0, n = 0; d <= EP_TAYLOR_DEGREE; ++d) {
        sum[d] = 0;
        for (unsigned j = 0; j <= d; ++j, ++n) sum[d] += fabs(a->c[n]) * m->max[n];
    }
}

ep_taylor ep_taylor_multiply(const ep_taylor *a, const ep_taylor *b, const ep_monomials *m)
{
    ep_taylor r = {{0}, 0};
    for (unsigned d = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned e = 0; d + e <= EP_TAYLOR_DEGREE; ++e)
            for (unsigned j = 0; j <= d; ++j)
                for (unsigned l = 0; l <= e; ++l)
                    r.c[ep_taylor_index(d + e - j - l, j + l)] +=
                        a->c[ep_taylor_index(d - j, j)] * b->c[ep_taylor_index(e - l, l)];
    double x[EP_TAYLOR_DEGREE + 1], y[EP_TAYLOR_DEGREE + 1], all = b->rest;
    degrees(a, m, x);
    degrees(b, m, y);
    for (unsigned d = 0; d <= EP_TAYLOR_DEGREE; ++d) {
        for (unsigned e = EP_TAYLOR_DEGREE + 1 - d; e <= EP_TAYLOR_DEGREE; ++e) r.rest += x[d] * y[e];
        r.rest += x[d] * b->rest;
        all += y[d];
    }
    r.rest += a->rest * all;
    return r;
}

ep_taylor ep_taylor_divide(const ep_taylor *a, const ep_taylor *b, double low, const ep_monomials *m)
{
    /* term by term from a = q b, in the order of their degrees */
    ep_taylor q = {{0}, 0};
    for (unsigned d = 0, n = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned j = 0; j <= d; ++j, ++n) {
            double left = a->c[n];
            for (unsigned e = 0; e < d; ++e)
                for (unsigned l = 0; l <= e && l <= j; ++l)
                    if (j - l <= d - e)
                        left -= q.c[ep_taylor_index(e - l, l)] * b->c[ep_taylor_index(d - e - (j - l), j - l)];
            q.c[n] = left / b->c[0];
        }
    /* what that leaves of a, divided by b */
    const ep_taylor product = ep_taylor_multiply(&q, b, m), left = ep_taylor_add(a, -1, &product);
    q.rest = ep_mag(ep_taylor_range(&left, m)) / low;
    return q;
}

/* The blossom of the cubic terms: their Bernstein coefficients on the side from p to q are its values at p's and q's.
 */
static double blossom(const double c[4], const double x[2], const double y[2], const double z[2])
{
    return c[0] * x[0] * y[0] * z[0] + c[1] * (x[0] * y[0] * z[1] + x[0] * y[1] * z[0] + x[1] * y[0] * z[0]) / 3 +
           c[2] * (x[0] * y[1] * z[1] + x[1] * y[0] * z[1] + x[1] * y[1] * z[0]) / 3 + c[3] * x[1] * y[1] * z[1];
}

/* Includes l k + c k³, 0 <= k <= 1, for the l in `linear` and the c in `both` less `linear`: at k = 1 that is what is
 * in `both`; before, it may have been (2/3) l sqrt(l / 3|c|), where c is opposite to l, but not more than l. */
static void include_line(ep_range *r, ep_range linear, ep_range both)
{
    ep_include(r, both.lo);
    ep_include(r, both.hi);
    const double up = linear.hi, against_up = linear.lo - both.hi;
    if (up > 0) ep_include(r, 27 * against_up > 4 * up ? 2 * up / 3 * sqrt(up / (3 * against_up)) : up);
    const double down = -linear.lo, against_down = both.lo - linear.hi;
    if (down > 0) ep_include(r, 27 * against_down > 4 * down ? -2 * down / 3 * sqrt(down / (3 * against_down)) : -down);
}

/* `b`: Bernstein coefficients of the cubic terms on a part of the border; `l`: the linear ones at its ends. */
static void include_border(ep_range *r, const double b[4], const double l[2], int halvings)
{
    if (!halvings) {
        ep_range linear = EP_NOTHING, both = EP_NOTHING;
        for (int k = 0; k < 2; ++k) ep_include(&linear, l[k]);
        for (int k = 0; k < 4; ++k) ep_include(&both, b[k] + l[0] + (l[1] - l[0]) * k / 3);
        include_line(r, linear, both);
        return;
    }
    const double c01 = (b[0] + b[1]) / 2, c12 = (b[1] + b[2]) / 2, c23 = (b[2] + b[3]) / 2;
    const double d0 = (c01 + c12) / 2, d1 = (c12 + c23) / 2, middle = (d0 + d1) / 2, l_middle = (l[0] + l[1]) / 2;
    include_border(r, (const double[4]){b[0], c01, d0, middle}, (const double[2]){l[0], l_middle}, halvings - 1);
    include_border(r, (const double[4]){middle, d1, c23, b[3]}, (const double[2]){l_middle, l[1]}, halvings - 1);
}

/* The linear and cubic terms are most of what our callers have left, and of opposite signs. So they are bounded
 * together, on every line from (0, 0) to a point of the border. */
ep_range ep_taylor_range(const ep_taylor *a, const ep_monomials *m)
{
    double even = a->rest;
    for (unsigned d = 2; d <= EP_TAYLOR_DEGREE; d += 2)
        for (unsigned j = 0; j <= d; ++j) {
            const unsigned n = ep_taylor_index(d - j, j);
            even += fabs(a->c[n]) * m->max[n];
        }
    const double *linear = &a->c[ep_taylor_index(1, 0)], *c = &a->c[ep_taylor_index(3, 0)];
    ep_range odd = {0, 0};
    for (unsigned k = 0; k < m->corners; ++k) {
        const double *p = m->corner[k], *q = m->corner[(k + 1) % m->corners];
        const double b[4] = {blossom(c, p, p, p), blossom(c, p, p, q), blossom(c, p, q, q), blossom(c, q, q, q)};
        const double l[2] = {linear[0] * p[0] + linear[1] * p[1], linear[0] * q[0] + linear[1] * q[1]};
        include_border(&odd, b, l, 3);
    }
    const double rounding = 0x1p-40 * (even + fabs(a->c[0]) + ep_mag(odd));
    return (ep_range){a->c[0] + odd.lo - even - rounding, a->c[0] + odd.hi + even + rounding};
}
