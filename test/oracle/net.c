/* net.c - de Casteljau's algorithm, for curves and triangles. See net.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/net.h"

#include <string.h>

enum { W, U, V };

static net_shape triangle(unsigned n)
{
    return (net_shape){true, n, n};
}

/* Cuts a curve of degree n at t: the part before it, and after it. */
static void cut_curve(const net_point *p, unsigned n, double t, net_point *before, net_point *after)
{
    net_point q[NET_DEGREE + 1];
    memcpy(q, p, (n + 1) * sizeof *q);
    for (unsigned k = 0; k <= n; ++k) {
        memcpy(before[k], q[0], sizeof *q);
        memcpy(after[n - k], q[n - k], sizeof *q);
        for (unsigned i = 0; i < n - k; ++i)
            for (int c = 0; c < 4; ++c) q[i][c] = (1 - t) * q[i][c] + t * q[i + 1][c];
    }
}

static void evaluate_curve(const net_point *p, unsigned n, double t, net_point value, net_point derivative)
{
    net_point q[NET_DEGREE + 1];
    memcpy(q, p, (n + 1) * sizeof *q);
    for (unsigned k = n; k > 0; --k) {
        if (k == 1)
            for (int c = 0; c < 4; ++c) derivative[c] = n * (q[1][c] - q[0][c]);
        for (unsigned i = 0; i < k; ++i)
            for (int c = 0; c < 4; ++c) q[i][c] = (1 - t) * q[i][c] + t * q[i + 1][c];
    }
    memcpy(value, q[0], sizeof *q);
}

/* One level of the algorithm at weights w of the corners: a net of degree n becomes one of degree n-1. */
static void step(net_point *p, unsigned n, const double w[3])
{
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i + j < n; ++i) {
            const double *at_w = p[net_index(triangle(n), i, j)], *at_u = p[net_index(triangle(n), i + 1, j)],
                         *at_v = p[net_index(triangle(n), i, j + 1)];
            double *to = p[net_index(triangle(n - 1), i, j)]; /* never behind what is still to be read */
            for (int c = 0; c < 4; ++c) to[c] = w[W] * at_w[c] + w[U] * at_u[c] + w[V] * at_v[c];
        }
}

void net_evaluate(net_shape s, const net_point *net, double a, double b, net_point p, net_point pa, net_point pb)
{
    if (s.triangle) {
        const double w[3] = {1 - a - b, a, b};
        net_point q[NET_POINTS];
        memcpy(q, net, net_count(s) * sizeof *q);
        for (unsigned k = s.n; k > 0; --k) {
            if (k == 1)
                for (int c = 0; c < 4; ++c) {
                    pa[c] = s.n * (q[1][c] - q[0][c]);
                    pb[c] = s.n * (q[2][c] - q[0][c]);
                }
            step(q, k, w);
        }
        memcpy(p, q[0], sizeof *q);
        return;
    }
    net_point column[NET_DEGREE + 1], slope[NET_DEGREE + 1], unused;
    for (unsigned j = 0; j <= s.n; ++j) evaluate_curve(net + net_index(s, 0, j), s.m, a, column[j], slope[j]);
    evaluate_curve(column, s.n, b, p, pb);
    evaluate_curve(slope, s.n, b, pa, unused);
}

/* The net of the triangle whose corner `corner` has moved to the point with weights w. Its point with r times that
 * corner is what r steps at w leave of those points that had it not at all. */
static void move_corner(unsigned n, const net_point *net, int corner, const double w[3], net_point *out)
{
    net_point p[NET_POINTS];
    memcpy(p, net, net_count(triangle(n)) * sizeof *p);
    for (unsigned r = 0; r <= n; ++r) {
        const unsigned left = n - r;
        for (unsigned k = 0; k <= left; ++k) {
            const unsigned from_i = corner == U ? 0 : k, from_j = corner == U ? k : corner == V ? 0 : left - k;
            const unsigned to_i = corner == U ? r : from_i, to_j = corner == V ? r : from_j;
            memcpy(out[net_index(triangle(n), to_i, to_j)], p[net_index(triangle(left), from_i, from_j)], sizeof *p);
        }
        if (left) step(p, left, w);
    }
}

/* Cuts all curves in one direction of a square net. */
static void cut_square(net_shape s, const net_point *net, bool along_v, double t, net_point *first, net_point *second)
{
    const unsigned n = along_v ? s.n : s.m, curves = along_v ? s.m : s.n;
    for (unsigned k = 0; k <= curves; ++k) {
        net_point p[NET_DEGREE + 1], a[NET_DEGREE + 1], b[NET_DEGREE + 1];
        for (unsigned i = 0; i <= n; ++i) memcpy(p[i], net[along_v ? net_index(s, k, i) : net_index(s, i, k)], sizeof *p);
        cut_curve(p, n, t, a, b);
        for (unsigned i = 0; i <= n; ++i) {
            const size_t to = along_v ? net_index(s, k, i) : net_index(s, i, k);
            memcpy(first[to], a[i], sizeof *p);
            memcpy(second[to], b[i], sizeof *p);
        }
    }
}

void net_extend(net_shape s, const net_point *net, double e, net_point *out)
{
    net_point a[NET_POINTS], unused[NET_POINTS];
    if (s.triangle) {
        /* One corner after the other, each in terms of the corners that the triangle has by then:
         * W to (-e,-e), U to (1+2e,-e), V to (-e,1+2e). */
        const double w[3] = {1 + 2 * e, -e, -e};
        const double u_w = -e / (1 + 2 * e), u[3] = {u_w, 1 + 2 * e + e * u_w, -e + e * u_w};
        const double v_v = (1 + 3 * e) / (1 + e), v_u = -e / (1 + e), v[3] = {1 - v_u - v_v, v_u, v_v};
        move_corner(s.n, net, W, w, out);
        move_corner(s.n, out, U, u, a);
        move_corner(s.n, a, V, v, out);
        return;
    }
    cut_square(s, net, false, 1 + e, a, unused);
    cut_square(s, a, false, -e / (1 + e), unused, out);
    cut_square(s, out, true, 1 + e, a, unused);
    cut_square(s, a, true, -e / (1 + e), unused, out);
}

void net_cut(net_shape s, const net_point *net, unsigned edge, net_point *first, net_point *second)
{
    static const int end[3][2] = {{W, U}, {W, V}, {U, V}};
    if (!s.triangle) {
        cut_square(s, net, edge == 1, 0.5, first, second);
        return;
    }
    double middle[3] = {0, 0, 0};
    middle[end[edge][0]] = middle[end[edge][1]] = 0.5;
    move_corner(s.n, net, end[edge][1], middle, first);
    move_corner(s.n, net, end[edge][0], middle, second);
}

void net_cut_part(net_shape s, const net_part *part, unsigned edge, net_part *first, net_part *second)
{
    *first = *second = *part;
    for (int c = 0; c < 2; ++c) {
        const double a = part->a[c] / 2, b = part->b[c] / 2;
        if (edge == 0) {
            first->a[c] = second->a[c] = a;
            second->at[c] += a;
            if (s.triangle) second->b[c] -= a;
        } else if (edge == 1) {
            first->b[c] = second->b[c] = b;
            second->at[c] += b;
            if (s.triangle) second->a[c] -= b;
        } else {
            first->b[c] = second->a[c] = a + b;
        }
    }
}
