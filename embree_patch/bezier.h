/* bezier.h - the algebra of Bézier nets in double precision: evaluate, restrict to a part of the domain.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A net is an array of points of four doubles. What the four mean is the caller's business: homogeneous points
 * (wx, wy, wz, w) here, signed distances to a ray's planes in solve.c; everything below is linear in them.
 *
 * Tensor nets of degree (m, n) list their points for j in 0..n: for i in 0..m; the domain is [0,1]².
 * Triangular nets of degree n list them for j in 0..n: for i in 0..n-j; the domain is u, v >= 0, u+v <= 1, and
 * point (i, j) goes with u^i v^j w^(n-i-j). */
#ifndef EP_BEZIER_H
#define EP_BEZIER_H

#include "embree_patch/embree_patch.h"

typedef double ep_point[4];

/* The highest degree of a net: one more than a patch's, for products with a linear function (leaf.c). */
enum { EP_NET_DEGREE = EP_MAX_DEGREE + 1, EP_NET_POINTS = (EP_NET_DEGREE + 1) * (EP_NET_DEGREE + 1) };

/* Position in a triangular net of degree n, and its number of points. */
static inline size_t ep_tri_index(unsigned n, unsigned i, unsigned j)
{
    return (size_t)j * (2 * n + 3 - j) / 2 + i;
}
static inline size_t ep_tri_count(unsigned n)
{
    return (size_t)(n + 1) * (n + 2) / 2;
}

static inline double ep_power(double x, unsigned n)
{
    double r = 1;
    for (; n; --n) r *= x;
    return r;
}

/* A whole number while n is no more than EP_NET_DEGREE, and so are all on the way. */
static inline double ep_binomial(unsigned n, unsigned k)
{
    double b = 1;
    for (unsigned i = 1; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
}

/* A value with its first and second derivatives. */
typedef struct ep_jet {
    ep_point p, pu, pv, puu, puv, pvv;
} ep_jet;

void ep_tensor_eval(const ep_point *net, unsigned m, unsigned n, double u, double v, ep_jet *jet);
void ep_tri_eval(const ep_point *net, unsigned n, double u, double v, ep_jet *jet);

/* The net of the same surface over [u0,u1] x [v0,v1]. `out` may be `net`. */
void ep_tensor_restrict(const ep_point *net, unsigned m, unsigned n, double u0, double u1, double v0, double v1,
                        ep_point *out);

/* The net of the same surface over the triangle whose corners U (u=1), V (v=1), W (the origin) lie at the given
 * parameters {u, v} of the old one [Goldman 1983]. `out` may not be `net`. */
void ep_tri_restrict(const ep_point *net, unsigned n, const double U[2], const double V[2], const double W[2],
                     ep_point *out);

/* The same surface as a polynomial in (s, t), u = u0 + s du, v = v0 + t dv. Coefficient (i, j) of s^i t^j stands where
 * the net has point (i, j). */
void ep_tensor_series(const ep_point *net, unsigned m, unsigned n, double u0, double du, double v0, double dv,
                      ep_point *out);

/* The same surface as a polynomial in (s, t), (u, v) = X + s U + t V. `out` may not be `net`. */
void ep_tri_series(const ep_point *net, unsigned n, const double X[2], const double U[2], const double V[2],
                   ep_point *out);

#endif
