/* piece.c - see piece.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/piece.h"

#include <string.h>

piece piece_of(const test_patch *patch, const ep_hierarchy *h, size_t leaf)
{
    const ep_leaf *l = &h->leaves[leaf];
    const ep_patch *p = &h->patches[l->patch];
    piece r = {patch, l, p->radius};
    for (int c = 0; c < 3; ++c) r.far += fabs(p->centre[c]);
    return r;
}

double piece_noise(const piece *p, int row)
{
    double sum = 1e-15;
    for (int c = 0; c < 3; ++c) sum += 1e-13 * fabs((double)p->leaf->frame[c][row]) * p->far;
    return sum;
}

double piece_corner(const piece *p)
{
    return p->patch->shape.triangle ? -1.0 / 3 : -0.5;
}

double piece_inside(const piece *p, double s, double t)
{
    if (p->patch->shape.triangle) return fmin(fmin(s, t) + 1.0 / 3, 1.0 / 3 - s - t);
    return 0.5 - fmax(fabs(s), fabs(t));
}

piece_jet piece_at(const piece *p, double s, double t)
{
    const ep_leaf *leaf = p->leaf;
    const float *d = leaf->domain;
    const double uu = d[2], vv = d[3], uv = d[4], vu = d[5];
    const double x = s - piece_corner(p), y = t - piece_corner(p);
    double pu[3], pv[3];
    piece_jet j;
    evaluate_patch(p->patch, d[0] + uu * x + uv * y, d[1] + vu * x + vv * y, j.p, pu, pv);
    for (int c = 0; c < 3; ++c) {
        j.ps[c] = uu * pu[c] + vu * pv[c];
        j.pt[c] = uv * pu[c] + vv * pv[c];
    }
    for (int row = 0; row < 3; ++row) {
        j.at[row] = j.ds[row] = j.dt[row] = 0;
        for (int c = 0; c < 3; ++c) {
            const double m = leaf->frame[c][row];
            j.at[row] += m * (j.p[c] - leaf->centre[c] - leaf->centre_low[c]);
            j.ds[row] += m * j.ps[c];
            j.dt[row] += m * j.pt[c];
        }
    }
    return j;
}

void zero_patch(net_shape shape, test_patch *p)
{
    p->shape = shape;
    for (size_t k = 0; k < net_count(shape); ++k) {
        memset(p->points[k], 0, sizeof p->points[k]);
        p->points[k][3] = 1;
    }
}

static double binomial(unsigned n, unsigned k)
{
    double b = 1;
    for (unsigned i = 0; i < k; ++i) b = b * (n - i) / (i + 1);
    return b;
}

/* Of (1 + s X + t Y)^count times what is there, all coefficients up to X^i Y^j. */
static void multiply(double c[NET_DEGREE + 1][NET_DEGREE + 1], unsigned i, unsigned j, double s, double t,
                     unsigned count)
{
    for (; count > 0; --count)
        for (unsigned a = i + 1; a-- > 0;)
            for (unsigned b = j + 1; b-- > 0;) c[a][b] += (a > 0 ? s * c[a - 1][b] : 0) + (b > 0 ? t * c[a][b - 1] : 0);
}

/* A control point is the polar form at the corners that its index counts: the mean of the products of i of their s and
 * j of their t, each corner used once. */
void add_power(test_patch *p, unsigned i, unsigned j, const double x[3])
{
    const net_shape shape = p->shape;
    const unsigned m = shape.m, n = shape.n;
    assert_true(net_has(shape, i, j));
    const double low = shape.triangle ? -1.0 / 3 : -0.5, high = 1 + low;
    const double ways = shape.triangle ? binomial(n, i) * binomial(n - i, j) : binomial(m, i) * binomial(n, j);
    for (unsigned b = 0; b <= n; ++b)
        for (unsigned a = 0; net_has(shape, a, b); ++a) {
            double c[NET_DEGREE + 1][NET_DEGREE + 1] = {{1}};
            if (shape.triangle) {
                multiply(c, i, j, high, low, a);
                multiply(c, i, j, low, high, b);
                multiply(c, i, j, low, low, n - a - b);
            } else {
                multiply(c, i, j, high, 0, a);
                multiply(c, i, j, low, 0, m - a);
                multiply(c, i, j, 0, high, b);
                multiply(c, i, j, 0, low, n - b);
            }
            for (int k = 0; k < 3; ++k) p->points[net_index(shape, a, b)][k] += c[i][j] / ways * x[k];
        }
}

void skew_axes(rng *r, double least, double axes[3][3])
{
    double volume = 0;
    while (!(fabs(volume) >= least)) {
        for (int k = 0; k < 3; ++k) rng_direction(r, axes[k]);
        volume = 0;
        for (int c = 0; c < 3; ++c)
            volume += axes[0][c] *
                      (axes[1][(c + 1) % 3] * axes[2][(c + 2) % 3] - axes[1][(c + 2) % 3] * axes[2][(c + 1) % 3]);
    }
}
