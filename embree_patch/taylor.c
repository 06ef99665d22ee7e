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
    q.rest = ep_taylor_bound(&left, m) / low;
    return q;
}

/* The largest Bernstein coefficient of a cubic, halved so many times: no value is larger. */
static double cubic_bound(const double b[4], int halvings)
{
    if (!halvings) return fmax(fmax(fabs(b[0]), fabs(b[1])), fmax(fabs(b[2]), fabs(b[3])));
    const double c01 = (b[0] + b[1]) / 2, c12 = (b[1] + b[2]) / 2, c23 = (b[2] + b[3]) / 2;
    const double d0 = (c01 + c12) / 2, d1 = (c12 + c23) / 2, middle = (d0 + d1) / 2;
    return fmax(cubic_bound((const double[4]){b[0], c01, d0, middle}, halvings - 1),
                cubic_bound((const double[4]){middle, d1, c23, b[3]}, halvings - 1));
}

/* The blossom of the cubic terms: their Bernstein coefficients on the side from p to q are its values at p's and q's.
 */
static double blossom(const double c[4], const double x[2], const double y[2], const double z[2])
{
    return c[0] * x[0] * y[0] * z[0] + c[1] * (x[0] * y[0] * z[1] + x[0] * y[1] * z[0] + x[1] * y[0] * z[0]) / 3 +
           c[2] * (x[0] * y[1] * z[1] + x[1] * y[0] * z[1] + x[1] * y[1] * z[0]) / 3 + c[3] * x[1] * y[1] * z[1];
}

/* The cubic terms are most of what our callers have left. They grow along every line from (0, 0), so they are largest
 * on the border; the sum of their magnitudes may be twice that. */
double ep_taylor_bound(const ep_taylor *a, const ep_monomials *m)
{
    double all = a->rest, cubic = 0;
    for (unsigned n = 0; n < EP_TAYLOR_TERMS; ++n)
        if (n < ep_taylor_index(3, 0) || n > ep_taylor_index(0, 3)) all += fabs(a->c[n]) * m->max[n];
    const double *c = &a->c[ep_taylor_index(3, 0)];
    for (unsigned k = 0; k < m->corners; ++k) {
        const double *p = m->corner[k], *q = m->corner[(k + 1) % m->corners];
        const double b[4] = {blossom(c, p, p, p), blossom(c, p, p, q), blossom(c, p, q, q), blossom(c, q, q, q)};
        cubic = fmax(cubic, cubic_bound(b, 2));
    }
    return (all + cubic) * (1 + 0x1p-40); /* and the rounding of all this */
}
