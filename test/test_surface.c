/* test_surface.c - does epEvaluate give the surface that the header defines?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <string.h>

static double largest(const test_patch *p)
{
    double most = 0;
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 3; ++c) most = fmax(most, fabs(p->points[k][c]));
    return most;
}

static void domain_point(rng *r, bool triangle, double *u, double *v)
{
    *u = rng_unit(r), *v = rng_unit(r);
    if (triangle && *u + *v > 1) *u = 1 - *u, *v = 1 - *v;
}

static test_patch any_patch(rng *r, uint64_t k, unsigned degree, double weight)
{
    test_patch p;
    random_patch(r, (patch_style)(k % STYLES), k / STYLES % 2, (patch_limits){degree, weight}, &p);
    return p;
}

/* The sums of the definition, term by term. */
static void by_definition(const test_patch *p, double u, double v, double x[3])
{
    const unsigned m = p->shape.m, n = p->shape.n;
    double sum[4] = {0, 0, 0, 0};
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; net_has(p->shape, i, j); ++i) {
            double b;
            if (p->shape.triangle) {
                const unsigned k = n - i - j;
                b = exp(lgamma(n + 1.0) - lgamma(i + 1.0) - lgamma(j + 1.0) - lgamma(k + 1.0)) * pow(u, i) * pow(v, j) *
                    pow(1 - u - v, k);
            } else {
                b = exp(lgamma(m + 1.0) - lgamma(i + 1.0) - lgamma(m - i + 1.0) + lgamma(n + 1.0) - lgamma(j + 1.0) -
                        lgamma(n - j + 1.0)) *
                    pow(u, i) * pow(1 - u, m - i) * pow(v, j) * pow(1 - v, n - j);
            }
            const double *q = p->points[net_index(p->shape, i, j)];
            for (int c = 0; c < 4; ++c) sum[c] += b * q[3] * (c < 3 ? q[c] : 1);
        }
    for (int c = 0; c < 3; ++c) x[c] = sum[c] / sum[3];
}

static void the_definition(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 400; ++k) {
        rng r = rng_split(1, 0, k);
        test_patch p = any_patch(&r, k, k % 7 ? 9 : 25, k % 3 ? 1 : 50);
        EPGeometry g = new_geometry(&p, 1, &(EPBuildSettings){sizeof(EPBuildSettings), .thickness = 1, .threads = 1});
        for (int i = 0; i < 10; ++i) {
            double u, v, x[3], want[3];
            domain_point(&r, p.shape.triangle, &u, &v);
            by_definition(&p, u, v, want);
            assert_int_equal(epEvaluate(g, 0, u, v, x, NULL, NULL, NULL), EP_OK);
            for (int c = 0; c < 3; ++c)
                CHECK(fabs(x[c] - want[c]) <= 1e-12 * largest(&p), "patch %d at %.17g %.17g: %.17g, not %.17g", (int)k, u,
                      v, x[c], want[c]);
        }
        epReleaseGeometry(g);
    }
}

/* First and second derivatives against differences of the function below them. */
static void derivatives(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 300; ++k) {
        rng r = rng_split(2, 0, k);
        test_patch p = any_patch(&r, k, 6, k % 3 ? 1 : 5);
        EPGeometry g = new_geometry(&p, 1, &(EPBuildSettings){sizeof(EPBuildSettings), .thickness = 1, .threads = 1});
        const double h = 1e-5;
        double u, v, x[2][2][3], du[2][2][3], dv[2][2][3], pu[3], pv[3], d2[9], size = 0;
        domain_point(&r, p.shape.triangle, &u, &v);
        for (int side = 0; side < 2; ++side) {
            const double s = side ? h : -h;
            assert_int_equal(epEvaluate(g, 0, u + s, v, x[0][side], du[0][side], dv[0][side], NULL), EP_OK);
            assert_int_equal(epEvaluate(g, 0, u, v + s, x[1][side], du[1][side], dv[1][side], NULL), EP_OK);
        }
        assert_int_equal(epEvaluate(g, 0, u, v, NULL, pu, pv, d2), EP_OK);
        for (int c = 0; c < 9; ++c) size = fmax(size, fabs(d2[c]));
        for (int c = 0; c < 3; ++c) {
            const double slope = 1e-6 * (1 + largest(&p)) + 1e-3 * h * size, bend = 1e-3 * (1 + size);
            const double want[5] = {x[0][1][c] - x[0][0][c], x[1][1][c] - x[1][0][c], du[0][1][c] - du[0][0][c],
                                    dv[0][1][c] - dv[0][0][c], dv[1][1][c] - dv[1][0][c]};
            const double got[5] = {pu[c], pv[c], d2[c], d2[3 + c], d2[6 + c]};
            for (int i = 0; i < 5; ++i)
                CHECK(fabs(got[i] - want[i] / (2 * h)) <= (i < 2 ? slope : bend), "patch %d, derivative %d: %.9g, not %.9g",
                      (int)k, i, got[i], want[i] / (2 * h));
        }
        epReleaseGeometry(g);
    }
}

static void homogeneous(const test_patch *p, net_point *net)
{
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 4; ++c) net[k][c] = p->points[k][3] * (c < 3 ? p->points[k][c] : 1);
}

static void euclidean(const net_point *net, test_patch *p)
{
    for (size_t k = 0; k < net_count(p->shape); ++k)
        for (int c = 0; c < 4; ++c) p->points[k][c] = c < 3 ? net[k][c] / net[k][3] : net[k][3];
}

/* The same surface in one degree more, by the textbook. */
static test_patch raised(const test_patch *p)
{
    const unsigned m = p->shape.m, n = p->shape.n;
    net_point net[NET_POINTS], up[NET_POINTS];
    test_patch q = {.shape = {p->shape.triangle, m + 1, p->shape.triangle ? n + 1 : n}};
    homogeneous(p, net);
    for (unsigned j = 0; j <= q.shape.n; ++j)
        for (unsigned i = 0; net_has(q.shape, i, j); ++i) {
            double *to = up[net_index(q.shape, i, j)];
            for (int c = 0; c < 4; ++c) {
                double sum = 0;
                if (p->shape.triangle) {
                    const unsigned k = n + 1 - i - j;
                    if (i) sum += i * net[net_index(p->shape, i - 1, j)][c];
                    if (j) sum += j * net[net_index(p->shape, i, j - 1)][c];
                    if (k) sum += k * net[net_index(p->shape, i, j)][c];
                    to[c] = sum / (n + 1);
                } else {
                    if (i) sum += i * net[net_index(p->shape, i - 1, j)][c];
                    if (i <= m) sum += (m + 1 - i) * net[net_index(p->shape, i, j)][c];
                    to[c] = sum / (m + 1);
                }
            }
        }
    euclidean(up, &q);
    return q;
}

static void same_point(const EPGeometry g, uint32_t a, double ua, double va, uint32_t b, double ub, double vb, double slack)
{
    double x[3], y[3];
    assert_int_equal(epEvaluate(g, a, ua, va, x, NULL, NULL, NULL), EP_OK);
    assert_int_equal(epEvaluate(g, b, ub, vb, y, NULL, NULL, NULL), EP_OK);
    for (int c = 0; c < 3; ++c)
        CHECK(fabs(x[c] - y[c]) <= slack, "%.17g %.17g: %.17g and %.17g", ua, va, x[c], y[c]);
}

/* Raising the degree and cutting change the points, not the surface. */
static void other_nets_of_the_same_surface(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 200; ++k) {
        rng r = rng_split(3, 0, k);
        test_patch p[4];
        p[0] = any_patch(&r, k, 8, k % 3 ? 1 : 20);
        p[1] = raised(&p[0]);
        net_point net[NET_POINTS], first[NET_POINTS], second[NET_POINTS];
        net_part whole = {{0, 0}, {1, 0}, {0, 1}}, part[2];
        const unsigned edge = rng_below(&r, p[0].shape.triangle ? 3 : 2);
        homogeneous(&p[0], net);
        net_cut(p[0].shape, net, edge, first, second);
        net_cut_part(p[0].shape, &whole, edge, &part[0], &part[1]);
        p[2].shape = p[3].shape = p[0].shape;
        euclidean(first, &p[2]);
        euclidean(second, &p[3]);
        EPGeometry g = new_geometry(p, 4, &(EPBuildSettings){sizeof(EPBuildSettings), .thickness = 1, .threads = 1});
        for (int i = 0; i < 10; ++i) {
            double u, v;
            domain_point(&r, p[0].shape.triangle, &u, &v);
            same_point(g, 0, u, v, 1, u, v, 1e-12 * largest(&p[0]));
            for (uint32_t h = 0; h < 2; ++h)
                same_point(g, 0, part[h].at[0] + u * part[h].a[0] + v * part[h].b[0],
                           part[h].at[1] + u * part[h].a[1] + v * part[h].b[1], 2 + h, u, v, 1e-12 * largest(&p[0]));
        }
        epReleaseGeometry(g);
    }
}

/* All four formats say the same, with any stride. */
static void formats(void **state)
{
    (void)state;
    static const double xyz[4][4] = {{0, 0, 0, 1}, {1, 0, 0.25, 1}, {0, 1, 0.5, 1}, {1, 1, -1, 1}};
    for (int format = EP_FORMAT_FLOAT3; format <= EP_FORMAT_DOUBLE4; ++format)
        for (size_t gap = 0; gap < 3; ++gap) {
            const bool is_float = format <= EP_FORMAT_FLOAT4, weighted = format & 1;
            const size_t each = is_float ? sizeof(float) : sizeof(double), stride = (weighted ? 4 : 3) * each + gap * each;
            char bytes[4 * 6 * sizeof(double)] = {0};
            for (size_t i = 0; i < 4; ++i)
                for (size_t c = 0; c < (weighted ? 4u : 3u); ++c) {
                    const float f = (float)xyz[i][c];
                    memcpy(bytes + i * stride + c * each, is_float ? (const void *)&f : &xyz[i][c], each);
                }
            EPGeometry g = epNewGeometry();
            assert_int_equal(epAddBezierPatches(g, 1, 1, 1, (EPFormat)format, bytes, stride), EP_OK);
            for (size_t i = 0; i < 4; ++i) {
                double p[3];
                assert_int_equal(epEvaluate(g, 0, (double)(i & 1), (double)(i >> 1), p, NULL, NULL, NULL), EP_OK);
                for (int c = 0; c < 3; ++c) CHECK(p[c] == xyz[i][c], "format %d, gap %zu, point %zu", format, gap, i);
            }
            epReleaseGeometry(g);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_definition),
        cmocka_unit_test(derivatives),
        cmocka_unit_test(other_nets_of_the_same_surface),
        cmocka_unit_test(formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
