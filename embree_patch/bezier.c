/* bezier.c - de Casteljau's algorithm and blossoms. See bezier.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/bezier.h"

#include <math.h>
#include <string.h>

/* Half of a point; compilers do not find out by themselves that `out` may be a or b. */
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));

static inline void lerp(ep_point out, const ep_point a, const ep_point b, double t)
{
    const pair *x = (const pair *)a, *y = (const pair *)b;
    const pair low = (1 - t) * x[0] + t * y[0], high = (1 - t) * x[1] + t * y[1];
    ((pair *)out)[0] = low;
    ((pair *)out)[1] = high;
}

/* The last three points of de Casteljau's scheme for the curve of degree n >= 2 with points p[0], p[stride], ...; the
 * points themselves for a lower one. */
static inline void last_points(const ep_point *p, size_t stride, unsigned n, double t, ep_point out[3])
{
    ep_point q[EP_NET_DEGREE + 1];
    if (n <= 3) {
        for (unsigned i = 0; i < 3 && i <= n; ++i) {
            if (n == 3) lerp(out[i], p[i * stride], p[(i + 1) * stride], t);
            else memcpy(out[i], p[i * stride], sizeof *out);
        }
        return;
    }
    for (unsigned i = 0; i < n; ++i) lerp(q[i], p[i * stride], p[(i + 1) * stride], t);
    for (unsigned k = n - 1; k > 2; --k)
        for (unsigned i = 0; i < k; ++i) lerp(q[i], q[i], q[i + 1], t);
    memcpy(out, q, 3 * sizeof *out);
}

/* Value, first and second derivative of a curve of degree n >= 1 from its last points: n(n-1) times their second
 * difference, n times the first of what is next. */
static inline void last_jet(const ep_point p[3], unsigned n, double t, ep_point d0, ep_point d1, ep_point d2)
{
    ep_point a, b;
    memcpy(a, p[0], sizeof a);
    memcpy(b, p[1], sizeof b);
    for (int c = 0; c < 4; ++c) d2[c] = n < 2 ? 0 : n * (n - 1.0) * (p[2][c] - 2 * p[1][c] + p[0][c]);
    if (n > 1) {
        lerp(a, p[0], p[1], t);
        lerp(b, p[1], p[2], t);
    }
    for (int c = 0; c < 4; ++c) d1[c] = n * (b[c] - a[c]);
    lerp(d0, a, b, t);
}

void ep_tensor_eval(const ep_point *net, unsigned m, unsigned n, double u, double v, ep_jet *jet)
{
    const unsigned across = m < 2 ? m : 2;
    ep_point row[(EP_NET_DEGREE + 1) * 3], column[3], a[3], b[3], c[3], unused;
    for (unsigned j = 0; j <= n; ++j) last_points(net + j * (m + 1), 1, m, u, row + 3 * j);
    for (unsigned i = 0; i <= across; ++i) {
        last_points(row + i, 3, n, v, column);
        last_jet(column, n, v, a[i], b[i], c[i]);
    }
    last_jet(a, m, u, jet->p, jet->pu, jet->puu);
    last_jet(b, m, u, jet->pv, jet->puv, unused);
    last_jet(c, m, u, jet->pvv, unused, unused);
}

/* One step of the triangular algorithm in place: a net of degree n becomes one of degree n-1. (u, v, w) adds up to one
 * at a point, to zero along a direction. */
static void tri_blossom(ep_point *p, unsigned n, double u, double v, double w)
{
    size_t to = 0;
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i < n - j; ++i, ++to) {
            const double *pw = p[ep_tri_index(n, i, j)], *pu = p[ep_tri_index(n, i + 1, j)],
                         *pv = p[ep_tri_index(n, i, j + 1)];
            ep_point q;
            for (int c = 0; c < 4; ++c) q[c] = u * pu[c] + v * pv[c] + w * pw[c];
            memcpy(p[to], q, sizeof q);
        }
}

static void tri_step(ep_point *p, unsigned n, double u, double v)
{
    tri_blossom(p, n, u, v, 1 - u - v);
}

void ep_tri_eval(const ep_point *net, unsigned n, double u, double v, ep_jet *jet)
{
    ep_point p[(EP_NET_DEGREE + 1) * (EP_NET_DEGREE + 2) / 2];
    memcpy(p, net, ep_tri_count(n) * sizeof(ep_point));
    memset(jet, 0, sizeof *jet);
    for (unsigned k = n; k > 0; --k) {
        if (k == 2) { /* order of points: ww, uw, uu, vw, uv, vv */
            const double f = n * (n - 1.0);
            for (int c = 0; c < 4; ++c) {
                jet->puu[c] = f * (p[2][c] - 2 * p[1][c] + p[0][c]);
                jet->puv[c] = f * (p[4][c] - p[1][c] - p[3][c] + p[0][c]);
                jet->pvv[c] = f * (p[5][c] - 2 * p[3][c] + p[0][c]);
            }
        }
        if (k == 1)
            for (int c = 0; c < 4; ++c) {
                jet->pu[c] = n * (p[1][c] - p[0][c]);
                jet->pv[c] = n * (p[2][c] - p[0][c]);
            }
        tri_step(p, k, u, v);
    }
    memcpy(jet->p, p[0], sizeof(ep_point));
}

/* The part [t0,t1] of the Bézier curve of degree n with points p[0], p[stride], ...: cut at t1, keep the left, cut that
 * at t0/t1, keep the right. */
static void curve_restrict(ep_point *p, unsigned n, size_t stride, double t0, double t1)
{
    if (t1 != 1)
        for (unsigned k = 1; k <= n; ++k)
            for (unsigned i = n; i >= k; --i) lerp(p[i * stride], p[(i - 1) * stride], p[i * stride], t1);
    if (t0 != 0) {
        const double t = t0 / t1;
        for (unsigned k = n; k > 0; --k)
            for (unsigned i = 0; i < k; ++i) lerp(p[i * stride], p[i * stride], p[(i + 1) * stride], t);
    }
}

void ep_tensor_restrict(const ep_point *net, unsigned m, unsigned n, double u0, double u1, double v0, double v1,
                        ep_point *out)
{
    if (out != net) memcpy(out, net, (size_t)(m + 1) * (n + 1) * sizeof(ep_point));
    for (unsigned j = 0; j <= n; ++j) curve_restrict(out + j * (m + 1), m, 1, u0, u1);
    for (unsigned i = 0; i <= m; ++i) curve_restrict(out + i, n, m + 1, v0, v1);
}

/* Point (i, j) of the new net is the blossom of the old one at U i times, V j times and W the remaining times. The
 * steps with U are shared by all points of equal i, those with V by all of equal i and j. */
void ep_tri_restrict(const ep_point *net, unsigned n, const double U[2], const double V[2], const double W[2],
                     ep_point *out)
{
    enum { MAX_POINTS = (EP_NET_DEGREE + 1) * (EP_NET_DEGREE + 2) / 2 };
    ep_point a[MAX_POINTS], b[MAX_POINTS], c[MAX_POINTS];
    memcpy(a, net, ep_tri_count(n) * sizeof(ep_point));
    for (unsigned i = 0; i <= n; ++i) {
        const unsigned after_u = n - i;
        memcpy(b, a, ep_tri_count(after_u) * sizeof(ep_point));
        for (unsigned j = 0; j <= after_u; ++j) {
            const unsigned after_v = after_u - j;
            memcpy(c, b, ep_tri_count(after_v) * sizeof(ep_point));
            for (unsigned k = after_v; k > 0; --k) tri_step(c, k, W[0], W[1]);
            memcpy(out[ep_tri_index(n, i, j)], c[0], sizeof(ep_point));
            if (after_v) tri_step(b, after_v, V[0], V[1]);
        }
        if (after_u) tri_step(a, after_u, U[0], U[1]);
    }
}

/* The curve of degree n with points p[0], p[stride], ... as a polynomial in s, t = t0 + s h, in place. Its i-th
 * coefficient is binomial(n, i) h^i times the i-th difference of de Casteljau's level n-i at t0. Differences lose i
 * bits, which h^i gives back in a small part of the curve; for a large one see twofold.h. */
static void curve_series(ep_point *p, unsigned n, size_t stride, double t0, double h)
{
    ep_point level[EP_NET_DEGREE + 1];
    for (unsigned i = 0; i <= n; ++i) memcpy(level[i], p[i * stride], sizeof(ep_point));
    for (unsigned i = n;; --i) {
        double *to = p[i * stride], factor = ep_binomial(n, i) * ep_power(h, i);
        for (int c = 0; c < 4; ++c) to[c] = 0;
        for (unsigned k = 0; k <= i; ++k, factor = -factor * (i - k + 1) / k)
            for (int c = 0; c < 4; ++c) to[c] += factor * level[i - k][c];
        if (i == 0) return;
        for (unsigned k = 0; k < i; ++k) lerp(level[k], level[k], level[k + 1], t0);
    }
}

void ep_tensor_series(const ep_point *net, unsigned m, unsigned n, double u0, double du, double v0, double dv,
                      ep_point *out)
{
    if (out != net) memcpy(out, net, (size_t)(m + 1) * (n + 1) * sizeof(ep_point));
    for (unsigned j = 0; j <= n; ++j) curve_series(out + j * (m + 1), m, 1, u0, du);
    for (unsigned i = 0; i <= m; ++i) curve_series(out + i, n, m + 1, v0, dv);
}

/* The coefficient of s^i t^j is n!/(i! j! k!) times the blossom at U i times, V j times and X the remaining k. */
void ep_tri_series(const ep_point *net, unsigned n, const double X[2], const double U[2], const double V[2],
                   ep_point *out)
{
    ep_point a[EP_NET_POINTS], b[EP_NET_POINTS], c[EP_NET_POINTS];
    memcpy(a, net, ep_tri_count(n) * sizeof(ep_point));
    for (unsigned d = n;; --d) { /* i + j = d */
        memcpy(b, a, ep_tri_count(d) * sizeof(ep_point));
        for (unsigned i = 0; i <= d; ++i) {
            memcpy(c, b, ep_tri_count(d - i) * sizeof(ep_point));
            for (unsigned k = d - i; k > 0; --k) tri_blossom(c, k, V[0], V[1], -V[0] - V[1]);
            const double factor = ep_binomial(n, d) * ep_binomial(d, i);
            for (int e = 0; e < 4; ++e) out[ep_tri_index(n, i, d - i)][e] = factor * c[0][e];
            if (i < d) tri_blossom(b, d - i, U[0], U[1], -U[0] - U[1]);
        }
        if (d == 0) return;
        tri_step(a, d, X[0], X[1]);
    }
}
