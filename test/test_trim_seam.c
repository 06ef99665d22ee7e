/* test_trim_seam.c - two patches of different shape, degree and parametrisation, trimmed by the same curve on either
 * side: does a ray near the curve hit one of them, and only one unless it is as near as hits are rounded?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The second patch is the first one's surface over another part of its domain: with an affine map L of its own domain
 * to the first's, a tensor patch of degree (m, n) is a triangle or a tensor patch of degree m + n. Its trim is the
 * first's under the inverse of L. */
#include "test/support.h"
#include "test/test_trim.h"

#include <string.h>

/* {a, b, c, d, e, f} as for regions. */
typedef double affine[6];

static void apply(const affine m, double x, double y, double out[2])
{
    out[0] = m[0] * x + m[2] * y + m[4];
    out[1] = m[1] * x + m[3] * y + m[5];
}

static void invert(const affine m, affine out)
{
    const double det = m[0] * m[3] - m[1] * m[2];
    out[0] = m[3] / det, out[1] = -m[1] / det, out[2] = -m[2] / det, out[3] = m[0] / det;
    out[4] = -(out[0] * m[4] + out[2] * m[5]);
    out[5] = -(out[1] * m[4] + out[3] * m[5]);
}

static double power(double x, unsigned n)
{
    double p = 1;
    while (n--) p *= x;
    return p;
}

static double choose(unsigned n, unsigned k)
{
    double c = 1;
    for (unsigned i = 1; i <= k; ++i) c *= (double)(n - k + i) / i;
    return c;
}

static double bernstein(net_shape s, unsigned i, unsigned j, double u, double v)
{
    if (!s.triangle)
        return choose(s.m, i) * power(u, i) * power(1 - u, s.m - i) * choose(s.n, j) * power(v, j) *
               power(1 - v, s.n - j);
    return choose(s.n, i) * choose(s.n - i, j) * power(u, i) * power(v, j) * power(1 - u - v, s.n - i - j);
}

enum { UNKNOWNS = 32 };

/* Gauss's elimination; the solution replaces the four right-hand sides. */
static void solve(size_t n, double a[UNKNOWNS][UNKNOWNS], double b[UNKNOWNS][4])
{
    for (size_t k = 0; k < n; ++k) {
        size_t pivot = k;
        for (size_t i = k; i < n; ++i)
            if (fabs(a[i][k]) > fabs(a[pivot][k])) pivot = i;
        for (size_t j = 0; j < n; ++j) {
            const double swapped = a[k][j];
            a[k][j] = a[pivot][j], a[pivot][j] = swapped;
        }
        for (int c = 0; c < 4; ++c) {
            const double swapped = b[k][c];
            b[k][c] = b[pivot][c], b[pivot][c] = swapped;
        }
        for (size_t i = 0; i < n; ++i) {
            const double f = i == k ? 0 : a[i][k] / a[k][k];
            for (size_t j = k; j < n; ++j) a[i][j] -= f * a[k][j];
            for (int c = 0; c < 4; ++c) b[i][c] -= f * b[k][c];
        }
    }
    for (size_t k = 0; k < n; ++k)
        for (int c = 0; c < 4; ++c) b[k][c] /= a[k][k];
}

/* p's surface where `map` leads, by interpolation at the nodes of the net: exact, but for the rounding. */
static void carry_over(const test_patch *p, const affine map, bool triangle, test_patch *q)
{
    static double a[UNKNOWNS][UNKNOWNS], b[UNKNOWNS][4];
    const unsigned degree = p->shape.m + p->shape.n;
    const net_shape s = {triangle, degree, degree};
    net_point net[NET_POINTS], hu, hv;
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 4; ++c) net[k][c] = p->points[k][3] * (c < 3 ? p->points[k][c] : 1);
    for (unsigned j = 0; j <= degree; ++j)
        for (unsigned i = 0; net_has(s, i, j); ++i) {
            const size_t row = net_index(s, i, j);
            const double u = (double)i / degree, v = (double)j / degree;
            double at[2];
            apply(map, u, v, at);
            net_evaluate(p->shape, net, at[0], at[1], b[row], hu, hv);
            for (unsigned l = 0; l <= degree; ++l)
                for (unsigned k = 0; net_has(s, k, l); ++k) a[row][net_index(s, k, l)] = bernstein(s, k, l, u, v);
        }
    assert_true(net_count(s) <= UNKNOWNS);
    solve(net_count(s), a, b);
    q->shape = s;
    for (size_t k = 0; k < net_count(s); ++k) {
        assert_true(b[k][3] > 0);
        for (int c = 0; c < 4; ++c) q->points[k][c] = c < 3 ? b[k][c] / b[k][3] : b[k][3];
    }
}

/* A closed curve about the middle of the domain: a rotated ellipse, rational cubics, a NURBS curve, or straight edges,
 * two of which are nearer than float tells to where a domain is halved. */
typedef enum curve { ELLIPSE, CUBICS, SPLINE, EDGES, CURVES } curve;
static const affine ellipse = {0.21, 0.05, -0.04, 0.17, 0.43, 0.44};
static const double cubic[3][4][3] = {{{0.25, 0.3, 1}, {0.4, 0.1, 2}, {0.6, 0.2, 0.7}, {0.65, 0.4, 1}},
                                      {{0.65, 0.4, 1}, {0.7, 0.6, 1}, {0.5, 0.7, 3}, {0.4, 0.6, 1}},
                                      {{0.4, 0.6, 1}, {0.3, 0.5, 1}, {0.1, 0.5, 0.5}, {0.25, 0.3, 1}}};
static const double knots[10] = {0, 0, 0, 1, 2, 3, 4, 5, 5, 5};
static const double control[7][3] = {{0.65, 0.42, 1},  {0.62, 0.7, 1}, {0.4, 0.55, 2}, {0.15, 0.6, 1},
                                     {0.25, 0.2, 0.6}, {0.6, 0.15, 1}, {0.65, 0.42, 1}};

static const double edge[4][2] = {{0.25 + 3e-8, 0.25 - 1e-8}, {0.7, 0.25 - 1e-8}, {0.5, 0.6}, {0.25 + 3e-8, 0.55}};

static trim_shape *shape_of(curve c)
{
    trim_shape *s = shape_new(c == ELLIPSE ? SHAPE_CIRCLE : SHAPE_POLYGON);
    if (c == ELLIPSE) {
        s->transformed = true;
        memcpy(s->transform, ellipse, sizeof ellipse);
    }
    for (int i = 0; i < 3 && c == CUBICS; ++i) {
        trim_segment *g = segment_new(SEGMENT_BEZIER, 3, 4);
        memcpy(g->points, cubic[i], sizeof cubic[i]);
        assert_true(shape_add_segment(s, g));
    }
    if (c == SPLINE) {
        trim_segment *g = segment_new(SEGMENT_NURBS, 2, 7);
        memcpy(g->points, control, sizeof control);
        memcpy(g->knots, knots, sizeof knots);
        assert_true(shape_add_segment(s, g));
    }
    if (c == EDGES) {
        trim_segment *g = segment_new(SEGMENT_LINE, 1, 4);
        for (int i = 0; i < 4; ++i) g->points[i][0] = edge[i][0], g->points[i][1] = edge[i][1], g->points[i][2] = 1;
        assert_true(shape_add_segment(s, g));
    }
    assert_true(shape_prepare(s));
    return s;
}

/* What is inside of the curve, or what is outside. */
static EPRegion region_of(curve c, bool inside, const affine transform)
{
    EPRegion r = epNewRegion();
    EPStatus s = epBeginRegion(r, inside ? EP_UNION : EP_DIFFERENCE, transform);
    if (!inside) s |= epAddRegionSquare(r, (const affine){20, 0, 0, 20, -10, -10});
    if (c == ELLIPSE) {
        s |= epAddRegionCircle(r, ellipse);
    } else {
        s |= epBeginRegion(r, EP_POLYGON, NULL);
        for (int i = 0; i < 3 && c == CUBICS; ++i) s |= epAddRegionBezier(r, 4, cubic[i][0]);
        if (c == SPLINE) s |= epAddRegionNURBS(r, 2, 10, knots, 7, control[0]);
        if (c == EDGES) s |= epAddRegionLine(r, 4, edge[0]);
        s |= epEndRegion(r);
    }
    s |= epEndRegion(r);
    CHECK(s == EP_OK, "%s", epGetRegionMessage(r));
    return r;
}

static test_scene trimmed(const test_patch *p, EPRegion region)
{
    EPGeometry g = new_geometry(p, 1, NULL);
    assert_int_equal(epSetPatchTrim(g, 0, 1, region), EP_OK);
    epReleaseRegion(region);
    CHECK(epCommitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
    return scene_of(g);
}

static double determinant(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Where the ray, as its floats say, meets the surface near (u, v): Newton's method in double. */
static void meet(const test_patch *p, const float org[3], const float dir[3], double uvt[3])
{
    for (int step = 0; step < 6; ++step) {
        double x[3], xu[3], xv[3], f[3], d[3];
        evaluate_patch(p, uvt[0], uvt[1], x, xu, xv);
        for (int c = 0; c < 3; ++c) d[c] = -(double)dir[c], f[c] = -(x[c] - org[c] - uvt[2] * dir[c]);
        const double det = determinant(xu, xv, d);
        uvt[0] += determinant(f, xv, d) / det;
        uvt[1] += determinant(xu, f, d) / det;
        uvt[2] += determinant(xu, xv, f) / det;
    }
}

/* How far from the ray's root in the domain a hit's u, v may be: the hit is off the surface by at most `error`, which
 * moves it along the surface by as much over the cosine, twice: once in the hit, once in its u, v; both are rounded to
 * float. */
static double band_of(const test_patch *p, double error, const double uvt[3], const float dir[3])
{
    double x[3], xu[3], xv[3], n[3], nn = 0, uu = 0, vv = 0, nd = 0, dd = 0;
    evaluate_patch(p, uvt[0], uvt[1], x, xu, xv);
    for (int c = 0; c < 3; ++c) {
        const int k = (c + 1) % 3, l = (c + 2) % 3;
        n[c] = xu[k] * xv[l] - xu[l] * xv[k];
        nn += n[c] * n[c], uu += xu[c] * xu[c], vv += xv[c] * xv[c];
        nd += n[c] * dir[c], dd += (double)dir[c] * dir[c];
    }
    const double cosine = fabs(nd) / sqrt(nn * dd), least_stretch = sqrt(nn / (uu + vv));
    return 2 * error / (cosine * least_stretch) + 0x1p-23;
}

typedef struct tally {
    unsigned rays, decided, twice;
} tally;

static void try_rays(const test_patch p[2], const affine map, const test_scene s[2], bool first_inside,
                     const trim_shape *shape, rng *r, tally *t)
{
    affine back;
    invert(map, back);
    for (int i = 0; i < 10000; ++i) {
        double uvt[3] = {0, 0, 0.5}, x[3], xu[3], xv[3], bands[2];
        float org[3], dir[3];
        assert_true(shape_border(shape, r, &uvt[0], &uvt[1]));
        const double off = i % 4 ? rng_scale(r, 1e-6, 1e-2) : 0;
        for (int c = 0; c < 2; ++c) uvt[c] += off * rng_in(r, -1, 1);
        evaluate_patch(&p[0], uvt[0], uvt[1], x, xu, xv);
        for (int c = 0; c < 3; ++c) {
            const int k = (c + 1) % 3, l = (c + 2) % 3;
            dir[c] = (float)(xu[k] * xv[l] - xu[l] * xv[k] + 0.3 * rng_in(r, -1, 1) * xu[c]);
            org[c] = (float)(x[c] - 0.5 * dir[c]);
        }
        meet(&p[0], org, dir, uvt);
        bool hit[2];
        for (int k = 0; k < 2; ++k) {
            const judge_answer a = trace_one(s[k].scene, org, dir, 0, 1);
            double own[3] = {uvt[0], uvt[1], uvt[2]};
            if (k) apply(back, uvt[0], uvt[1], own);
            const double error = epGetHitError(s[k].geometry, 0, org, dir, (float)uvt[2]);
            bands[k] = band_of(&p[k], error, own, dir);
            hit[k] = a.t < INFINITY;
        }
        /* a step in the second domain is at most so large in the first */
        const double scale = sqrt(map[0] * map[0] + map[1] * map[1] + map[2] * map[2] + map[3] * map[3]);
        const double band = fmax(bands[0], scale * bands[1]);
        const shape_side side = shape_at(shape, uvt[0], uvt[1], band);
        ++t->rays;
        CHECK(hit[0] || hit[1], "a gap at %.9g %.9g, %s", uvt[0], uvt[1], ray_text(org, dir));
        t->twice += hit[0] && hit[1];
        if (side == SHAPE_NEAR) continue;
        ++t->decided;
        const bool first = (side == SHAPE_IN) == first_inside;
        CHECK(hit[0] == first && hit[1] == !first, "%d and %d, not %d, at %.9g %.9g, band %.3g, %s", hit[0], hit[1],
              first, uvt[0], uvt[1], band, ray_text(org, dir));
    }
}

static void one_of_two(void **state)
{
    (void)state;
    static const affine to_triangle = {1.35, 0.05, 0.03, 1.3, -0.08, -0.06};
    static const affine to_tensor = {0.62, 0.35, -0.33, 0.66, 0.28, -0.07};
    for (unsigned k = 0; k < 4 * CURVES; ++k) {
        const curve c = (curve)(k % CURVES);
        const bool triangle = k / CURVES % 2, first_inside = k / CURVES / 2;
        const double *map = triangle ? to_triangle : to_tensor;
        rng r = rng_split(18, 0, k);
        test_patch p[2];
        affine back;
        random_patch(&r, STYLE_GENTLE, false, (patch_limits){2, k % 4 < 2 ? 1 : 1.3}, &p[0]);
        carry_over(&p[0], map, triangle, &p[1]);
        invert(map, back);
        test_scene s[2] = {trimmed(&p[0], region_of(c, first_inside, NULL)),
                           trimmed(&p[1], region_of(c, !first_inside, back))};
        trim_shape *shape = shape_of(c);
        tally t = {0};
        try_rays(p, map, s, first_inside, shape, &r, &t);
        print_message("%u rays, %u outside of the band; %u hit both\n", t.rays, t.decided, t.twice);
        assert_true(t.decided > t.rays / 4);
        shape_free(shape);
        for (int i = 0; i < 2; ++i) free_scene(&s[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(one_of_two)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
