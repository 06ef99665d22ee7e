/* test_oracle.c - is the reference itself right? Surfaces whose roots are known in closed form.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <stdlib.h>

static void to_double(const float a[3], double b[3])
{
    for (int c = 0; c < 3; ++c) b[c] = a[c];
}

/* A closed unit sphere: two roots where the quadratic has two, at its t, none else. */
static void sphere(const char *model)
{
    size_t count;
    test_patch *patches = read_model(model, &count);
    oracle *o = new_oracle(patches, count);
    unsigned checked = 0;
    for (uint64_t k = 0; k < 2000; ++k) {
        rng r = rng_split(1, 0, k);
        float of[3], df[3];
        double org[3], dir[3];
        aim(o, (aim_kind)(k % AIM_KINDS), &r, of, df);
        to_double(of, org);
        to_double(df, dir);
        oracle_root roots[ORACLE_ROOTS];
        const size_t n = oracle_intersect(o, org, dir, 0, INFINITY, roots);
        double a = 0, b = 0, c = -1;
        for (int x = 0; x < 3; ++x) a += dir[x] * dir[x], b += org[x] * dir[x], c += org[x] * org[x];
        const double disc = b * b - a * c;
        /* cosine² = disc / a; and a sphere of weights in decimals is one to 1e-15 */
        if (fabs(disc) < 1e-4 * a) continue;
        size_t sure = 0, doubtful = 0;
        double want[2], got[2] = {0, 0};
        size_t expected = 0;
        for (int side = 0; side < 2 && disc > 0; ++side) {
            want[expected] = (-b + (side ? 1 : -1) * sqrt(disc)) / a;
            if (want[expected] > 0) ++expected;
        }
        for (size_t i = 0; i < n; ++i) {
            if (roots[i].doubtful) ++doubtful;
            else if (sure < 2) got[sure++] = roots[i].t_low;
        }
        if (doubtful) continue;
        CHECK(sure == expected && n == sure, "ray %d: %s: %zu roots, not %zu", (int)k, ray_text(of, df), n, expected);
        for (size_t i = 0; i < sure; ++i)
            CHECK(fabs(got[i] - want[i]) < 1e-9 * (1 + want[i]), "ray %d: %s: t %.15g, not %.15g", (int)k,
                  ray_text(of, df), got[i], want[i]);
        ++checked;
    }
    assert_true(checked > 1000);
    oracle_free(o);
    free(patches);
}

static void sphere_of_patches(void **state)
{
    (void)state;
    sphere("sphere.json");
}

static void sphere_of_triangles(void **state)
{
    (void)state;
    sphere("sphere_triangles.json");
}

/* A ray through a point of a patch has a root there, whatever the patch; and every root is a point of both. */
static void planted_roots(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 1500; ++k) {
        rng r = rng_split(2, 0, k);
        const patch_style style = (patch_style)(k % STYLES);
        const patch_limits limits = {1 + rng_below(&r, 9), rng_below(&r, 2) ? 50 : 1};
        test_patch p;
        random_patch(&r, style, k / STYLES % 2, limits, &p);
        oracle *o = new_oracle(&p, 1);
        double u, v, x[3], org[3], dir[3];
        aim_domain(o, 0, &r, &u, &v);
        oracle_evaluate(o, 0, u, v, x, NULL, NULL);
        rng_direction(&r, dir);
        const double t = rng_scale(&r, 0.1, 10);
        for (int c = 0; c < 3; ++c) org[c] = x[c] - t * dir[c];
        oracle_root roots[ORACLE_ROOTS];
        const size_t n = oracle_intersect(o, org, dir, 0, INFINITY, roots);
        bool found = false;
        for (size_t i = 0; i < n; ++i) {
            found = found || (roots[i].t_low - 1e-9 <= t && t <= roots[i].t_high + 1e-9);
            if (roots[i].doubtful) continue;
            double y[3], off = 0;
            oracle_evaluate(o, 0, roots[i].u, roots[i].v, y, NULL, NULL);
            for (int c = 0; c < 3; ++c) off = fmax(off, fabs(y[c] - org[c] - roots[i].t_low * dir[c]));
            CHECK(off < 1e-9, "patch %d (%s): root %zu is %g off", (int)k, style_name(style), i, off);
        }
        /* a point is smaller than the rounding of the origin */
        found = found || oracle_radius(o, 0) < 1e-15;
        CHECK(found, "patch %d (%s, degree %u %u): no root at u %.17g v %.17g t %.17g", (int)k, style_name(style),
              p.shape.m, p.shape.n, u, v, t);
        oracle_free(o);
    }
}

/* A fold with three layers: x = u, y = v, z = a cubic in v with two turns, seen along y and z mixed. */
static void all_layers_of_a_fold(void **state)
{
    (void)state;
    test_patch p = {.shape = {false, 1, 3}};
    static const double y[4] = {0, 1.5, -0.5, 1};
    for (unsigned j = 0; j < 4; ++j)
        for (unsigned i = 0; i < 2; ++i) {
            double *to = p.points[net_index(p.shape, i, j)];
            to[0] = i, to[1] = y[j], to[2] = j / 3.0, to[3] = 1;
        }
    oracle *o = new_oracle(&p, 1);
    const double org[3] = {0.3, 0.5, -1}, dir[3] = {0, 0, 1};
    oracle_root roots[ORACLE_ROOTS];
    assert_int_equal(oracle_intersect(o, org, dir, 0, INFINITY, roots), 3);
    for (int k = 0; k < 3; ++k) {
        const double v = roots[k].v, x = 4.5 * v * (1 - v) * (1 - v) - 1.5 * v * v * (1 - v) + v * v * v;
        CHECK(fabs(x - 0.5) < 1e-12 && fabs(roots[k].u - 0.3) < 1e-12, "v %.17g", v);
    }
    oracle_free(o);
}

/* Tangency, borders and near misses are reported as doubtful, and only they. */
static void doubt(void **state)
{
    (void)state;
    test_patch p = {.shape = {false, 2, 1}}; /* z = (2u-1)^2 over the unit square */
    for (unsigned j = 0; j < 2; ++j)
        for (unsigned i = 0; i < 3; ++i) {
            double *to = p.points[net_index(p.shape, i, j)];
            to[0] = i / 2.0, to[1] = j, to[2] = i == 1 ? -1 : 1, to[3] = 1;
        }
    oracle *o = new_oracle(&p, 1);
    static const struct {
        double z, y;
        size_t count;
        bool doubtful;
    } rays[] = {{1e-3, 0.5, 2, false}, {0, 0.5, 1, true},     {-1e-6, 0.5, 1, true},  {-1e-4, 0.5, 0, false},
                {0.5, 0, 2, true},     {0.5, -2e-6, 2, true}, {0.5, -1e-4, 0, false}, {0.5, 1e-4, 2, false}};
    for (size_t k = 0; k < EP_ARRAY_LEN(rays); ++k) {
        const double org[3] = {-1, rays[k].y, rays[k].z}, dir[3] = {1, 0, 0};
        oracle_root roots[ORACLE_ROOTS];
        const size_t n = oracle_intersect(o, org, dir, 0, INFINITY, roots);
        CHECK((n >= 1) == (rays[k].count >= 1) && (rays[k].doubtful || n == rays[k].count), "ray %zu: %zu roots", k, n);
        for (size_t i = 0; i < n; ++i) CHECK(roots[i].doubtful == rays[k].doubtful, "ray %zu, root %zu", k, i);
    }
    oracle_free(o);
}

/* Of more roots than there is room for the nearest are kept, and nothing is said of the others. */
static void too_many_roots(void **state)
{
    (void)state;
    enum { PLANES = 3 * ORACLE_ROOTS };
    static test_patch planes[PLANES];
    for (unsigned k = 0; k < PLANES; ++k) {
        planes[k].shape = (net_shape){false, 1, 1};
        for (unsigned i = 0; i < 4; ++i) {
            double *to = planes[k].points[net_index(planes[k].shape, i % 2, i / 2)];
            to[0] = i % 2, to[1] = i / 2, to[2] = 1 + k * 7 % PLANES, to[3] = 1;
        }
    }
    oracle *o = new_oracle(planes, PLANES);
    const double org[3] = {0.3, 0.6, 0}, dir[3] = {0, 0, 1};
    oracle_root roots[ORACLE_ROOTS];
    assert_int_equal(oracle_intersect(o, org, dir, 0, INFINITY, roots), ORACLE_ROOTS);
    for (int k = 0; k + 1 < ORACLE_ROOTS; ++k)
        CHECK(!roots[k].doubtful && fabs(roots[k].t_low - (k + 1)) < 1e-9, "root %d: %.17g", k, roots[k].t_low);
    const oracle_root *last = &roots[ORACLE_ROOTS - 1];
    CHECK(last->doubtful && last->t_low <= ORACLE_ROOTS && last->t_high == INFINITY, "the rest: from %g", last->t_low);
    oracle_free(o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_of_patches),    cmocka_unit_test(sphere_of_triangles), cmocka_unit_test(planted_roots),
        cmocka_unit_test(all_layers_of_a_fold), cmocka_unit_test(too_many_roots),      cmocka_unit_test(doubt),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
