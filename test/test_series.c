/* test_series.c - are the series of pieces as good as they say, so that high degrees need no smaller ones?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/piece.h"

/* Has digits to spare: of Bernstein's sum for any degree, and of the series' own. */
#ifdef __SIZEOF_FLOAT128__
typedef __float128 wide;
#else
typedef long double wide;
#endif

static double magnitude(wide x)
{
    return fabs((double)x);
}

static wide power(wide x, unsigned n)
{
    wide r = 1;
    for (; n; --n) r *= x;
    return r;
}

static wide binomial(unsigned n, unsigned k)
{
    wide b = 1;
    for (unsigned i = 1; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
}

/* Bernstein's polynomials. */
static wide weight(net_shape s, unsigned i, unsigned j, wide u, wide v)
{
    if (s.triangle)
        return binomial(s.n, i) * binomial(s.n - i, j) * power(u, i) * power(v, j) * power(1 - u - v, s.n - i - j);
    return binomial(s.m, i) * power(u, i) * power(1 - u, s.m - i) * binomial(s.n, j) * power(v, j) *
           power(1 - v, s.n - j);
}

/* The point at (s, t) of a piece, in its leaf's coordinates: by definition, and by its series. */
static void points_at(const ep_fit *f, net_shape shape, const ep_domain *d, const double x[2], wide right[3],
                      wide series[3])
{
    const wide s = (wide)x[0] + f->kind->middle, t = (wide)x[1] + f->kind->middle;
    const wide u = d->u0 + s * d->uu + t * d->uv, v = d->v0 + s * d->vu + t * d->vv;
    wide p[4] = {0}, q[4] = {0};
    for (unsigned j = 0; j <= shape.n; ++j)
        for (unsigned i = 0; net_has(shape, i, j); ++i)
            for (int c = 0; c < 4; ++c) {
                const size_t at = net_index(shape, i, j);
                p[c] += weight(shape, i, j, u, v) * f->patch->points[at][c];
                q[c] += power(x[0], i) * power(x[1], j) * f->series[at][c];
            }
    for (int row = 0; row < 3; ++row) {
        right[row] = 0;
        for (int c = 0; c < 3; ++c)
            right[row] += (wide)f->leaf.frame[c][row] * (p[c] / p[3] - f->leaf.centre[c] - f->leaf.centre_low[c]);
        series[row] = f->patch->rational ? q[row] / q[3] : q[row];
    }
}

/* A corner of a piece, a point on its border or anywhere in it, in leaf coordinates. */
static void sample(rng *r, bool triangle, double x[2])
{
    for (int c = 0; c < 2; ++c) x[c] = rng_below(r, 2) ? rng_unit(r) : rng_below(r, 2);
    if (triangle && x[0] + x[1] > 1) x[0] = 1 - x[0], x[1] = 1 - x[1];
    for (int c = 0; c < 2; ++c) x[c] -= triangle ? 1.0 / 3 : 0.5;
}

static EPGeometry one_leaf(const test_patch *p)
{
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = 0;
    return new_geometry(p, 1, &settings);
}

/* What errors are at most, of what `loss` allows. */
static double check_piece(const ep_fit *f, const test_patch *p, const ep_domain *d, rng *r)
{
    double most = 0, far = 0;
    for (int c = 0; c < 3; ++c) far += fabs(f->patch->centre[c]);
    for (int k = 0; k < 8; ++k) {
        double x[2];
        wide right[3], series[3];
        sample(r, p->shape.triangle, x);
        points_at(f, p->shape, d, x, right, series);
        for (int row = 0; row < 3; ++row) {
            const double off = magnitude(series[row] - right[row]) / ep_norm1(f->row[row]);
            CHECK(off <= f->loss * f->patch->radius + 16 * EP_EPS_D * far,
                  "%s of degree %u %u at %.17g %.17g: %g off, not %g", p->shape.triangle ? "triangle" : "tensor",
                  p->shape.m, p->shape.n, x[0], x[1], off, f->loss * f->patch->radius);
            most = fmax(most, off / (f->loss * f->patch->radius));
        }
    }
    return most;
}

static double check_losses(uint64_t seed, patch_limits limits, int count)
{
    double most = 0;
    ep_fit *f = ep_alloc(1, sizeof *f);
    assert_non_null(f);
    for (int k = 0; k < count; ++k) {
        rng r = rng_split(seed, 0, (uint64_t)k);
        test_patch p;
        random_patch(&r, k % 3 ? STYLE_WILD : STYLE_GENTLE, k % 2, limits, &p);
        EPGeometry g = one_leaf(&p);
        ep_domain d = {0, 0, 1, 0, 0, 1};
        ep_leaf_begin(&g->hierarchy.patches[0], f);
        for (int depth = 0; depth < 5; ++depth) {
            ep_domain parts[4];
            ep_leaf_fit(&d, f);
            if (f->regular) most = fmax(most, check_piece(f, &p, &d, &r));
            d = parts[rng_below(&r, f->kind->split(&d, rng_below(&r, 2), parts))];
        }
        epReleaseGeometry(g);
    }
    ep_free(f);
    return most;
}

static void losses(void **state)
{
    (void)state;
    double most = check_losses(1, (patch_limits){9, 1}, 100);
    most = fmax(most, check_losses(2, (patch_limits){9, 50}, 100));
    most = fmax(most, check_losses(3, (patch_limits){25, 1}, 30));
    most = fmax(most, check_losses(4, (patch_limits){25, 50}, 30));
    CHECK(most > 0x1p-7, "errors are no more than %g of what is allowed", most);
}

/* The same surface with one more degree in u, or (triangles) in all. */
static void raise(test_patch *p, bool along_v)
{
    const test_patch old = *p;
    const net_shape from = old.shape;
    net_shape to = from;
    if (from.triangle || !along_v) ++to.m;
    if (from.triangle || along_v) ++to.n;
    p->shape = to;
    const unsigned degree = along_v ? to.n : to.m;
    for (unsigned j = 0; j <= to.n; ++j)
        for (unsigned i = 0; net_has(to, i, j); ++i) {
            wide sum[4] = {0};
            const unsigned left[3] = {along_v && !to.triangle ? 0 : i, along_v || to.triangle ? j : 0,
                                      degree - (to.triangle ? i + j
                                                : along_v   ? j
                                                            : i)};
            const unsigned from_i[3] = {i - 1, i, i}, from_j[3] = {j, j - 1, j};
            for (int k = 0; k < 3; ++k)
                for (int c = 0; c < 4 && left[k] > 0; ++c) {
                    const double *q = old.points[net_index(from, from_i[k], from_j[k])];
                    sum[c] += (wide)left[k] / degree * q[3] * (c < 3 ? q[c] : 1);
                }
            for (int c = 0; c < 3; ++c) p->points[net_index(to, i, j)][c] = (double)(sum[c] / sum[3]);
            p->points[net_index(to, i, j)][3] = (double)sum[3];
        }
}

static size_t leaves_of(const test_patch *p)
{
    EPGeometry g = new_geometry(p, 1, NULL);
    const size_t count = g->hierarchy.leaf_count;
    epReleaseGeometry(g);
    return count;
}

/* Leaves are as many as the surface bends, whatever degree it is written with. */
static void degrees_that_are_raised(void **state)
{
    (void)state;
    for (int k = 0; k < 48; ++k) {
        rng r = rng_split(5, 0, (uint64_t)k);
        const bool triangle = k % 4 == 3;
        test_patch p;
        random_patch(&r, STYLE_GENTLE, triangle, (patch_limits){3, k / 4 % 2 ? 2 : 1}, &p);
        const unsigned m = p.shape.m, n = p.shape.n;
        const size_t before = leaves_of(&p);
        while (p.shape.n < 22) raise(&p, true);
        while (k % 4 == 1 && p.shape.m < 22) raise(&p, false);
        const size_t after = leaves_of(&p);
        CHECK(after <= before + before / 8, "patch %d, %s of degree %u %u: %zu leaves, as one of %u %u %zu", k,
              triangle ? "triangle" : "tensor", m, n, before, p.shape.m, p.shape.n, after);
    }
}

/* The long side is the straight one, and the other has the degree. */
static void slender_patches(void **state)
{
    (void)state;
    test_patch p = {.shape = {false, 1, 2}};
    for (unsigned j = 0; j <= 2; ++j)
        for (unsigned i = 0; i <= 1; ++i) {
            double *to = p.points[net_index(p.shape, i, j)];
            to[0] = 100 * i, to[1] = j, to[2] = j == 1, to[3] = 1;
        }
    const size_t before = leaves_of(&p);
    while (p.shape.n < 22) raise(&p, true);
    const size_t after = leaves_of(&p);
    CHECK(after == before, "%zu leaves, of degree 22 %zu", before, after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(losses),
        cmocka_unit_test(degrees_that_are_raised),
        cmocka_unit_test(slender_patches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
