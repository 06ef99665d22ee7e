/* twofold.c - see twofold.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Compensated arithmetic [Ogita, Rump, Oishi 2005]: the high parts are what plain double arithmetic makes of points;
 * the rounding of each of its operations is found exactly and carried along in the low parts, whose own roundings are
 * of the second order. */
#include "embree_patch/twofold.h"

#include <string.h>

/* A number, and a point, as high + low. */
typedef struct number {
    double high, low;
} number;

typedef struct point {
    ep_point high, low;
} point;

/* [Knuth 1969] */
static inline number sum(double a, double b)
{
    const double s = a + b, t = s - a;
    return (number){s, (a - (s - t)) + (b - t)};
}

/* The first 26 bits and the others [Veltkamp 1968]. */
static inline number halves(double a)
{
    const double c = 0x1.0000002p27 * a, high = c - (c - a);
    return (number){high, a - high};
}

/* [Dekker 1971] */
static inline number product(double a, double b)
{
    const double p = a * b;
    const number x = halves(a), y = halves(b);
    return (number){p, x.low * y.low - (((p - x.high * y.high) - x.low * y.high) - x.high * y.low)};
}

/* to += f p */
static void add(point *to, number f, const point *p)
{
    for (int c = 0; c < 4; ++c) {
        const number a = product(f.high, p->high[c]), b = sum(to->high[c], a.high);
        to->high[c] = b.high;
        to->low[c] += a.low + b.low + (f.high * p->low[c] + f.low * p->high[c]);
    }
}

static const point zero;

/* a - x - y */
static number less(double a, double x, double y)
{
    const number first = sum(a, -x), second = sum(first.high, -y);
    return (number){second.high, first.low + second.low};
}

static void load(const ep_point *net, size_t count, point *p)
{
    for (size_t k = 0; k < count; ++k) {
        memcpy(p[k].high, net[k], sizeof(ep_point));
        memset(p[k].low, 0, sizeof(ep_point));
    }
}

static void store(const point *p, double factor, ep_point out)
{
    for (int c = 0; c < 4; ++c) out[c] = factor * (p->high[c] + p->low[c]);
}

/* For the curve of degree n with points p[0], p[stride], ...: the i-th difference of de Casteljau's level n-i at t, in
 * place. */
static void differences(point *p, unsigned n, size_t stride, double t)
{
    const number rest = less(1, t, 0);
    point level[EP_NET_DEGREE + 1];
    for (unsigned i = 0; i <= n; ++i) level[i] = p[i * stride];
    for (unsigned i = n;; --i) {
        number times = {1, 0}; /* binomials: whole numbers */
        p[i * stride] = zero;
        for (unsigned k = 0; k <= i; ++k, times.high = -times.high * (i - k + 1) / k)
            add(&p[i * stride], times, &level[i - k]);
        if (i == 0) return;
        for (unsigned k = 0; k < i; ++k) {
            point q = zero;
            add(&q, rest, &level[k]);
            add(&q, (number){t, 0}, &level[k + 1]);
            level[k] = q;
        }
    }
}

void ep_twofold_tensor_series(const ep_point *net, unsigned m, unsigned n, double u0, double du, double v0, double dv,
                              ep_point *out)
{
    point p[EP_NET_POINTS];
    load(net, (size_t)(m + 1) * (n + 1), p);
    for (unsigned j = 0; j <= n; ++j) differences(p + j * (m + 1), m, 1, u0);
    for (unsigned i = 0; i <= m; ++i) differences(p + i, n, m + 1, v0);
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i)
            store(&p[j * (m + 1) + i], ep_binomial(m, i) * ep_power(du, i) * ep_binomial(n, j) * ep_power(dv, j),
                  out[j * (m + 1) + i]);
}

/* One step of the triangular algorithm in place, with weights that add up to `whole`: one at a point, zero along a
 * direction. */
static void blossom(point *p, unsigned n, const double x[2], double whole)
{
    const number u = {x[0], 0}, v = {x[1], 0}, w = less(whole, x[0], x[1]);
    size_t to = 0;
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i < n - j; ++i, ++to) {
            point q = zero;
            add(&q, u, &p[ep_tri_index(n, i + 1, j)]);
            add(&q, v, &p[ep_tri_index(n, i, j + 1)]);
            add(&q, w, &p[ep_tri_index(n, i, j)]);
            p[to] = q;
        }
}

void ep_twofold_tri_series(const ep_point *net, unsigned n, const double X[2], const double U[2], const double V[2],
                           ep_point *out)
{
    enum { POINTS = (EP_NET_DEGREE + 1) * (EP_NET_DEGREE + 2) / 2 };
    point a[POINTS], b[POINTS], c[POINTS];
    load(net, ep_tri_count(n), a);
    for (unsigned d = n;; --d) { /* i + j = d */
        memcpy(b, a, ep_tri_count(d) * sizeof *b);
        for (unsigned i = 0; i <= d; ++i) {
            memcpy(c, b, ep_tri_count(d - i) * sizeof *c);
            for (unsigned k = d - i; k > 0; --k) blossom(c, k, V, 0);
            store(c, ep_binomial(n, d) * ep_binomial(d, i), out[ep_tri_index(n, i, d - i)]);
            if (i < d) blossom(b, d - i, U, 0);
        }
        if (d == 0) return;
        blossom(a, d, X, 1);
    }
}
