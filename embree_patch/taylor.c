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

double ep_taylor_bound(const ep_taylor *a, const ep_monomials *m)
{
    double sum[EP_TAYLOR_DEGREE + 1], all = a->rest;
    degrees(a, m, sum);
    for (unsigned d = 0; d <= EP_TAYLOR_DEGREE; ++d) all += sum[d];
    return all;
}
