/* test_nurbs.c - NURBS surfaces: is what is traced the surface that the knots describe, in one piece, and its trim?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The reference is the sum of basis functions, by the recursion that defines them [Cox 1972, de Boor 1972]. */
#include "test/region.h"
#include "test/support.h"

#include <string.h>

enum { MOST_DEGREE = 6, MOST_COUNT = 14, MOST_KNOTS = MOST_COUNT + MOST_DEGREE + 1 };

typedef struct surface {
    unsigned degree[2];
    size_t count[2], knot_count[2];
    double knots[2][MOST_KNOTS];
    double points[MOST_COUNT * MOST_COUNT][4];
    bool torn; /* some knot repeats degree + 1 times */
} surface;

static void random_knots(rng *r, surface *s, int axis, unsigned most_repeats)
{
    const unsigned p = s->degree[axis];
    const size_t n = s->count[axis];
    double *k = s->knots[axis];
    const bool clamped = rng_below(r, 3) > 0;
    k[0] = rng_in(r, -3, 3);
    unsigned repeats = 1;
    for (size_t i = 1; i < n + p + 1; ++i) {
        const bool end = i <= p || i > n, between = i > p && i < n;
        const bool repeat =
            clamped && end ? true : i != n && rng_below(r, 3) == 0 && (!between || repeats < most_repeats);
        k[i] = k[i - 1] + (repeat ? 0 : rng_in(r, 0.05, 1));
        repeats = repeat ? repeats + 1 : 1;
        s->torn = s->torn || (between && repeats > p);
    }
    s->knot_count[axis] = n + p + 1;
}

/* A sheet over its parameters, bent by a few tenths of the distance of points. */
static void random_surface(rng *r, unsigned tear, surface *s)
{
    s->torn = false;
    for (int axis = 0; axis < 2; ++axis) {
        s->degree[axis] = 1 + rng_below(r, MOST_DEGREE);
        s->count[axis] = s->degree[axis] + 1 + rng_below(r, MOST_COUNT - s->degree[axis]);
        random_knots(r, s, axis, s->degree[axis] + tear);
    }
    const double most_weight = rng_below(r, 2) ? 1 : 3;
    for (size_t j = 0; j < s->count[1]; ++j)
        for (size_t i = 0; i < s->count[0]; ++i) {
            double *p = s->points[j * s->count[0] + i];
            p[0] = (double)i + rng_in(r, -0.2, 0.2);
            p[1] = (double)j + rng_in(r, -0.2, 0.2);
            p[2] = rng_in(r, -0.3, 0.3);
            p[3] = rng_scale(r, 1 / most_weight, most_weight);
        }
}

static EPStatus add(EPGeometry g, const surface *s)
{
    return epAddNURBSSurface(g, s->degree[0], s->degree[1], s->knot_count[0], s->knots[0], s->knot_count[1],
                             s->knots[1], EP_FORMAT_DOUBLE4, s->points, sizeof s->points[0]);
}

static double low(const surface *s, int axis)
{
    return s->knots[axis][s->degree[axis]];
}
static double high(const surface *s, int axis)
{
    return s->knots[axis][s->count[axis]];
}

/* N_i of degree p at x, and its derivative. The last span is closed. */
static double basis(const double *k, size_t i, unsigned p, double x, double end)
{
    if (p == 0) return k[i] < k[i + 1] && k[i] <= x && (x < k[i + 1] || (x == end && k[i + 1] == end));
    const double a = k[i + p] - k[i], b = k[i + p + 1] - k[i + 1];
    return (a > 0 ? (x - k[i]) / a * basis(k, i, p - 1, x, end) : 0) +
           (b > 0 ? (k[i + p + 1] - x) / b * basis(k, i + 1, p - 1, x, end) : 0);
}
static double basis_slope(const double *k, size_t i, unsigned p, double x, double end)
{
    const double a = k[i + p] - k[i], b = k[i + p + 1] - k[i + 1];
    return p * ((a > 0 ? basis(k, i, p - 1, x, end) / a : 0) - (b > 0 ? basis(k, i + 1, p - 1, x, end) / b : 0));
}

static void evaluate(const surface *s, double u, double v, double p[3], double pu[3], double pv[3])
{
    double h[3][4] = {{0}};
    for (size_t j = 0; j < s->count[1]; ++j)
        for (size_t i = 0; i < s->count[0]; ++i) {
            const double *x = s->points[j * s->count[0] + i];
            const double a = basis(s->knots[0], i, s->degree[0], u, high(s, 0)),
                         b = basis(s->knots[1], j, s->degree[1], v, high(s, 1));
            const double f[3] = {a * b, b * basis_slope(s->knots[0], i, s->degree[0], u, high(s, 0)),
                                 a * basis_slope(s->knots[1], j, s->degree[1], v, high(s, 1))};
            for (int d = 0; d < 3; ++d)
                for (int c = 0; c < 4; ++c) h[d][c] += f[d] * x[3] * (c < 3 ? x[c] : 1);
        }
    for (int c = 0; c < 3; ++c) {
        p[c] = h[0][c] / h[0][3];
        pu[c] = (h[1][c] - p[c] * h[1][3]) / h[0][3];
        pv[c] = (h[2][c] - p[c] * h[2][3]) / h[0][3];
    }
}

static void expect_near(const double a[3], const double b[3], double most, const char *what, uint64_t seed)
{
    for (int c = 0; c < 3; ++c) CHECK(fabs(a[c] - b[c]) <= most, "seed %d: %s %g, not %g", (int)seed, what, a[c], b[c]);
}

static void points_are_sums_of_basis_functions(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        rng r = rng_split(seed, 0, 0);
        static surface s;
        EPGeometry g = epNewGeometry();
        random_surface(&r, 1, &s);
        for (int twice = 0; twice < 2; ++twice) CHECK(add(g, &s) == EP_OK, "%s", epGetGeometryMessage(g));
        for (int k = 0; k < 40; ++k) {
            double want[3][3], got[3][3];
            const double u = rng_in(&r, low(&s, 0), high(&s, 0)), v = rng_in(&r, low(&s, 1), high(&s, 1));
            evaluate(&s, u, v, want[0], want[1], want[2]);
            assert_int_equal(epEvaluate(g, (uint32_t)k % 2, u, v, got[0], got[1], got[2], NULL), EP_OK);
            expect_near(got[0], want[0], 1e-12, "P", seed);
            expect_near(got[1], want[1], 1e-9, "dPdu", seed);
            expect_near(got[2], want[2], 1e-9, "dPdv", seed);
        }
        assert_int_equal(epEvaluate(g, 2, 0, 0, NULL, NULL, NULL, NULL), EP_INVALID);
        epReleaseGeometry(g);
    }
}

/* Patches that meet at a knot have equal points there, bit for bit; those of polynomial surfaces are polynomial. */
static void patches_meet(void **state)
{
    (void)state;
    size_t borders = 0, gaps = 0, polynomials = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        rng r = rng_split(seed, 1, 0);
        static surface s;
        EPGeometry g = epNewGeometry();
        random_surface(&r, seed % 3 == 0, &s);
        assert_int_equal(add(g, &s), EP_OK);
        bool polynomial = true;
        for (size_t i = 0; i < s.count[0] * s.count[1]; ++i) polynomial = polynomial && s.points[i][3] == 1;
        for (size_t i = 0; i < g->point_count && polynomial; ++i) assert_true(g->points[i][3] == 1);
        polynomials += polynomial;
        const unsigned m = s.degree[0], n = s.degree[1];
        for (size_t i = 0; i < g->added_count; ++i)
            for (size_t k = i + 1; k < g->added_count; ++k) {
                const double *a = g->faces.places[i].map, *b = g->faces.places[k].map;
                const ep_point *p = g->points + g->added[i].first, *q = g->points + g->added[k].first;
                bool same = true;
                if (a[5] == b[5] && b[4] == a[4] + a[0]) {
                    for (unsigned j = 0; j <= n; ++j)
                        same = same && !memcmp(p[j * (m + 1) + m], q[j * (m + 1)], sizeof *p);
                } else if (a[4] == b[4] && b[5] == a[5] + a[3]) {
                    same = !memcmp(p[n * (m + 1)], q[0], (m + 1) * sizeof *p);
                } else {
                    continue;
                }
                ++borders;
                gaps += !same;
                CHECK(same || s.torn, "seed %d: patches %zu and %zu", (int)seed, i, k);
            }
        epReleaseGeometry(g);
    }
    CHECK(borders > 1000 && gaps > 0 && polynomials > 10, "%zu, %zu, %zu", borders, gaps, polynomials);
}

/* A ray at a point of the surface, from a little above it. Returns the length of the normal that it comes along. */
static void ray_at(const double p[3], const double pu[3], const double pv[3], float org[3], float dir[3])
{
    double n[3], length = 0;
    for (int c = 0; c < 3; ++c) {
        n[c] = pu[(c + 1) % 3] * pv[(c + 2) % 3] - pu[(c + 2) % 3] * pv[(c + 1) % 3];
        length += n[c] * n[c];
    }
    for (int c = 0; c < 3; ++c) {
        dir[c] = (float)(-n[c] / sqrt(length));
        org[c] = (float)(p[c] - (double)dir[c] * 0.02);
    }
}

static test_scene scene_of_surface(const surface *s, EPRegion region, bool on_demand)
{
    EPGeometry g = epNewGeometry();
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.onDemand = on_demand;
    CHECK(add(g, s) == EP_OK, "%s", epGetGeometryMessage(g));
    EPStatistics statistics;
    epGetGeometryStatistics(g, &statistics);
    if (region) CHECK(epSetPatchTrim(g, 0, statistics.patches, region) == EP_OK, "%s", epGetGeometryMessage(g));
    assert_int_equal(epSetGeometryBuildSettings(g, &settings), EP_OK);
    CHECK(epCommitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
    return scene_of(g);
}

static void hits_are_in_the_faces_parameters(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20 / TEST_STEP + 1; ++seed) {
        rng r = rng_split(seed, 2, 0);
        static surface s;
        random_surface(&r, 0, &s);
        test_scene scene = scene_of_surface(&s, NULL, seed % 4 == 0);
        for (int k = 0; k < 300; ++k) {
            double p[3], pu[3], pv[3];
            float org[3], dir[3];
            evaluate(&s, rng_in(&r, low(&s, 0), high(&s, 0)), rng_in(&r, low(&s, 1), high(&s, 1)), p, pu, pv);
            ray_at(p, pu, pv, org, dir);
            const judge_answer a = trace_one(scene.scene, org, dir, 0, 0.04f);
            CHECK(a.t < 0.04, "seed %d: missed: %s", (int)seed, ray_text(org, dir));
            evaluate(&s, a.u, a.v, p, pu, pv);
            const double far = 1e-5;
            for (int c = 0; c < 3; ++c)
                CHECK(fabs((double)org[c] + a.t * (double)dir[c] - p[c]) <= far, "seed %d: u %g v %g", (int)seed, a.u,
                      a.v);
            double n2 = 0, off2 = 0;
            for (int c = 0; c < 3; ++c) {
                const double n = pu[(c + 1) % 3] * pv[(c + 2) % 3] - pu[(c + 2) % 3] * pv[(c + 1) % 3];
                n2 += n * n, off2 += (n - a.normal[c]) * (n - a.normal[c]);
            }
            CHECK(off2 <= 1e-6 * n2, "seed %d: Ng is off by %g", (int)seed, sqrt(off2 / n2));
        }
        free_scene(&scene);
    }
}

/* A random region, stretched over the surface's domain. */
static trim_shape *random_trim(rng *r, const surface *s)
{
    trim_shape *shape = shape_new(SHAPE_UNION);
    assert_true(shape_add(shape, random_shape(r, rng_below(r, 3), (trim_style){0, 3, 3})));
    const double over[6] = {high(s, 0) - low(s, 0), 0, 0, high(s, 1) - low(s, 1), low(s, 0), low(s, 1)};
    shape->transformed = true;
    memcpy(shape->transform, over, sizeof over);
    assert_true(shape_prepare(shape));
    return shape;
}

static void trims_are_in_the_faces_parameters(void **state)
{
    (void)state;
    unsigned long in = 0, out = 0;
    for (uint64_t seed = 1; seed <= 40 / TEST_STEP + 1; ++seed) {
        rng r = rng_split(seed, 3, 0);
        static surface s;
        random_surface(&r, seed % 5 == 0, &s);
        trim_shape *shape = random_trim(&r, &s);
        EPRegion region = new_region(shape);
        test_scene scene = scene_of_surface(&s, region, seed % 4 == 0);
        epReleaseRegion(region);
        for (int k = 0; k < 400; ++k) {
            double p[3], pu[3], pv[3], u = rng_in(&r, low(&s, 0), high(&s, 0)), v = rng_in(&r, low(&s, 1), high(&s, 1));
            float org[3], dir[3];
            if (k % 2 && shape_border(shape, &r, &u, &v)) {
                u += rng_sign(&r) * rng_scale(&r, 1e-4, 1e-1), v += rng_sign(&r) * rng_scale(&r, 1e-4, 1e-1);
                if (!(u > low(&s, 0) && u < high(&s, 0) && v > low(&s, 1) && v < high(&s, 1))) continue;
            }
            const shape_side side = shape_at(shape, u, v, 1e-5);
            if (side == SHAPE_NEAR) continue;
            evaluate(&s, u, v, p, pu, pv);
            ray_at(p, pu, pv, org, dir);
            const judge_answer a = trace_one(scene.scene, org, dir, 0.019f, 0.021f);
            ++*(side == SHAPE_IN ? &in : &out);
            CHECK((a.t < 1) == (side == SHAPE_IN), "seed %d: u %.9g v %.9g: %s", (int)seed, u, v, ray_text(org, dir));
        }
        free_scene(&scene);
        shape_free(shape);
    }
    CHECK(in > 2000 / TEST_STEP && out > 2000 / TEST_STEP, "%lu, %lu", in, out);
}

/* Nothing is lost where a curve crosses from one patch to the next: aim at such points. */
static void curves_cross_knots_without_a_gap(void **state)
{
    (void)state;
    rng r = rng_split(4, 4, 0);
    static surface s;
    do random_surface(&r, 0, &s);
    while (s.count[0] < 10 || s.count[1] < 10);
    /* both sides of a diagonal, in two geometries */
    const double lo[2] = {low(&s, 0), low(&s, 1)}, hi[2] = {high(&s, 0), high(&s, 1)};
    test_scene half[2];
    for (int side = 0; side < 2; ++side) {
        EPRegion region = epNewRegion();
        const double line[6] = {lo[0], lo[1], hi[0], hi[1], side ? hi[0] + 1 : lo[0] - 1, side ? lo[1] - 1 : hi[1] + 1};
        assert_int_equal(epBeginRegion(region, EP_POLYGON, NULL), EP_OK);
        assert_int_equal(epAddRegionLine(region, 3, line), EP_OK);
        assert_int_equal(epEndRegion(region), EP_OK);
        half[side] = scene_of_surface(&s, region, false);
        epReleaseRegion(region);
    }
    for (int k = 0; k < 20000; ++k) {
        const int axis = (int)rng_below(&r, 2);
        const double knot = s.knots[axis][s.degree[axis] + rng_below(&r, (unsigned)(s.count[axis] - s.degree[axis]))];
        const double f = k % 2 ? (knot - lo[axis]) / (hi[axis] - lo[axis]) : rng_unit(&r);
        const double u = lo[0] + f * (hi[0] - lo[0]), v = lo[1] + f * (hi[1] - lo[1]);
        double p[3], pu[3], pv[3];
        float org[3], dir[3];
        if (!(f > 0.001 && f < 0.999)) continue;
        evaluate(&s, u, v, p, pu, pv);
        ray_at(p, pu, pv, org, dir);
        const bool met =
            trace_one(half[0].scene, org, dir, 0, 0.04f).t < 1 || trace_one(half[1].scene, org, dir, 0, 0.04f).t < 1;
        CHECK(met, "u %.17g v %.17g: %s", u, v, ray_text(org, dir));
    }
    for (int side = 0; side < 2; ++side) free_scene(&half[side]);
}

/* A sphere of one surface, whose poles are whole sides: rays from inside that are aimed at a pole, or past it by less
 * than floats can tell. */
static void poles_have_no_hole(void **state)
{
    (void)state;
    const double w = sqrt(0.5), circle[9][3] = {{1, 0, 1},   {1, 1, w},  {0, 1, 1},  {-1, 1, w}, {-1, 0, 1},
                                                {-1, -1, w}, {0, -1, 1}, {1, -1, w}, {1, 0, 1}};
    const double half[5][3] = {{0, -1, 1}, {1, -1, w}, {1, 0, 1}, {1, 1, w}, {0, 1, 1}}, centre[3] = {0.25, 0.5, -1};
    static surface s = {.degree = {2, 2},
                        .count = {9, 5},
                        .knot_count = {12, 8},
                        .knots = {{0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, {0, 0, 0, 1, 1, 2, 2, 2}}};
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 9; ++i) {
            double *p = s.points[9 * j + i];
            for (int c = 0; c < 2; ++c) p[c] = centre[c] + half[j][0] * circle[i][c];
            p[2] = centre[2] + half[j][1];
            p[3] = half[j][2] * circle[i][2];
        }
    test_scene scene = scene_of_surface(&s, NULL, false);
    for (unsigned k = 0; k < 6000 / TEST_STEP; ++k) {
        rng r = rng_split(6, 6, k);
        double from[3], past[3];
        float org[3], dir[3];
        rng_direction(&r, from);
        rng_direction(&r, past);
        const double size = rng_scale(&r, 1e-10, 1e-5), pole = rng_sign(&r);
        for (int c = 0; c < 3; ++c) {
            org[c] = (float)(centre[c] + 0.8 * rng_unit(&r) * from[c]);
            dir[c] = (float)(centre[c] + (c == 2 ? pole : 0) + size * past[c] - (double)org[c]);
        }
        CHECK(trace_one(scene.scene, org, dir, 0, INFINITY).t < (double)INFINITY, "%s", ray_text(org, dir));
    }
    free_scene(&scene);
}

static void wrong_surfaces_are_refused(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    const double u[4] = {0, 0, 1, 1}, v[5] = {0, 0, 0.5, 1, 1}, down[5] = {0, 0, 1, 0.5, 1},
                 nan[4] = {0, 0, (double)NAN, 1};
    const double torn[6] = {0, 0, 0.5, 0.5, 1, 1}, more[8] = {0, 0, 0.5, 0.5, 0.5, 1, 1}, far[4] = {0, 0, 1e200, 1e200};
    const double none[4] = {0, 1, 1, 2};
    double p[16][4];
    for (int i = 0; i < 16; ++i) p[i][0] = i % 2, p[i][1] = i / 2, p[i][2] = 0, p[i][3] = 1;
#define ADD(m, n, knots_u, knots_v)                                                                                    \
    epAddNURBSSurface(g, m, n, EP_ARRAY_LEN(knots_u), knots_u, EP_ARRAY_LEN(knots_v), knots_v, EP_FORMAT_DOUBLE4, p,   \
                      sizeof p[0])
    assert_int_equal(ADD(0, 1, u, v), EP_INVALID);
    assert_int_equal(ADD(1, EP_MAX_DEGREE + 1, u, v), EP_INVALID);
    assert_int_equal(ADD(4, 1, u, v), EP_INVALID); /* fewer knots than that takes */
    assert_int_equal(ADD(2, 1, u, v), EP_BAD_DATA);
    assert_int_equal(ADD(1, 1, u, down), EP_BAD_DATA);
    assert_int_equal(ADD(1, 1, nan, v), EP_BAD_DATA);
    assert_int_equal(ADD(1, 1, u, none), EP_BAD_DATA);
    assert_non_null(strstr(epGetGeometryMessage(g), "in v: "));
    assert_int_equal(ADD(1, 1, u, more), EP_BAD_DATA);
    assert_int_equal(ADD(1, 1, far, v), EP_BAD_DATA);
    assert_int_equal(epAddNURBSSurface(g, 1, 1, 4, NULL, 5, v, EP_FORMAT_DOUBLE4, p, sizeof p[0]), EP_INVALID);
    assert_int_equal(epAddNURBSSurface(g, 1, 1, 4, u, 5, v, EP_FORMAT_DOUBLE4, NULL, sizeof p[0]), EP_INVALID);
    assert_int_equal(epAddNURBSSurface(g, 1, 1, 4, u, 5, v, EP_FORMAT_DOUBLE4, p, 8), EP_INVALID);
    p[3][3] = 0;
    assert_int_equal(ADD(1, 1, u, v), EP_BAD_DATA);
    p[3][3] = 1;
    EPStatistics statistics;
    epGetGeometryStatistics(g, &statistics);
    assert_int_equal(statistics.patches + statistics.faces, 0);
    assert_int_equal(ADD(1, 1, u, v), EP_OK);
    assert_int_equal(ADD(1, 1, u, torn), EP_OK);
    epGetGeometryStatistics(g, &statistics);
    assert_int_equal(statistics.patches, 4);
    assert_int_equal(statistics.faces, 2);
    epReleaseGeometry(g);
}

static void every_allocation_fails_once(void **state)
{
    (void)state;
    rng r = rng_split(5, 5, 0);
    static surface s;
    random_surface(&r, 0, &s);
    trim_shape *shape = random_trim(&r, &s);
    EPRegion region = new_region(shape);
    int failures = 1;
    for (long n = 0; failures; ++n) {
        EPGeometry g = epNewGeometry();
        EPStatistics statistics;
        EPStatus status;
        failures = 0;
        ep_alloc_fail_at(n);
        while ((status = add(g, &s)) != EP_OK && ++failures) assert_int_equal(status, EP_NO_MEMORY);
        epGetGeometryStatistics(g, &statistics);
        while ((status = epSetPatchTrim(g, 0, statistics.patches, region)) != EP_OK && ++failures)
            assert_int_equal(status, EP_NO_MEMORY);
        while ((status = epCommitGeometry(g)) != EP_OK && ++failures) assert_int_equal(status, EP_NO_MEMORY);
        ep_alloc_fail_at(-1);
        assert_true(failures <= 1);
        assert_int_equal(statistics.faces, 1);
        epReleaseGeometry(g);
    }
    epReleaseRegion(region);
    shape_free(shape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_sums_of_basis_functions), cmocka_unit_test(patches_meet),
        cmocka_unit_test(hits_are_in_the_faces_parameters),   cmocka_unit_test(trims_are_in_the_faces_parameters),
        cmocka_unit_test(curves_cross_knots_without_a_gap),   cmocka_unit_test(poles_have_no_hole),
        cmocka_unit_test(wrong_surfaces_are_refused),         cmocka_unit_test(every_allocation_fails_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
