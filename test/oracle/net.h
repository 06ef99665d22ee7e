/* net.h - Bézier nets for the oracle: evaluate and cut, written to be read.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A net has four numbers a point and the order of points of embree_patch.h; its domain is the unit square, or the unit
 * triangle with the corners W = (0,0), U = (1,0) and V = (0,1). Nothing here comes from the library, so that an error
 * there cannot hide behind the same error here. */
#ifndef ORACLE_NET_H
#define ORACLE_NET_H

#include <stdbool.h>
#include <stddef.h>

enum { NET_DEGREE = 25, NET_POINTS = (NET_DEGREE + 1) * (NET_DEGREE + 1) };

typedef double net_point[4];

typedef struct net_shape {
    bool triangle;
    unsigned m, n; /* degrees; equal for a triangle */
} net_shape;

static inline size_t net_count(net_shape s)
{
    return s.triangle ? (size_t)(s.n + 1) * (s.n + 2) / 2 : (size_t)(s.m + 1) * (s.n + 1);
}

static inline bool net_has(net_shape s, unsigned i, unsigned j)
{
    return s.triangle ? i + j <= s.n : i <= s.m && j <= s.n;
}

/* Where the point with i steps in u and j in v stands: in a triangle after j rows of n+1, n, ... points. */
static inline size_t net_index(net_shape s, unsigned i, unsigned j)
{
    return (s.triangle ? (size_t)j * (2 * s.n + 3 - j) / 2 : (size_t)j * (s.m + 1)) + i;
}

/* Value and first derivatives at (a, b), which may lie outside of the domain. */
void net_evaluate(net_shape s, const net_point *net, double a, double b, net_point p, net_point pa, net_point pb);

/* The net over a larger domain: [-e, 1+e]², or the triangle whose sides are moved outwards by e. */
void net_extend(net_shape s, const net_point *net, double e, net_point *out);

/* Cuts a square across u (edge 0) or v (edge 1), or a triangle from the middle of its edge WU, WV or UV (0, 1, 2) to the
 * corner opposite. */
void net_cut(net_shape s, const net_point *net, unsigned edge, net_point *first, net_point *second);

/* A part of a domain: origin, and the images of the two unit steps. */
typedef struct net_part {
    double at[2], a[2], b[2];
} net_part;
void net_cut_part(net_shape s, const net_part *part, unsigned edge, net_part *first, net_part *second);

#endif
