/* test_triangles.c - do neighbours that curved triangles are made of have the same edge, bit for bit?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Two triangles with an edge in common, their corners in every order. What the points are, test_cli.py checks. */
#include "test/support.h"
#include "tools/triangles.h"

#include <string.h>

enum { MOST_POINTS = 10, PHONG = 2, PN = 3 };

static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};

/* Of any size and place. */
static mesh_vertex random_vertex(rng *r)
{
    mesh_vertex v;
    const double size = rng_scale(r, 1e-8, 1e8);
    for (int c = 0; c < 3; ++c) v.p[c] = size * rng_in(r, -1, 1), v.n[c] = rng_in(r, -1, 1);
    assert_true(normalise(v.n));
    return v;
}

/* The control points from corner a to corner b of a triangle of degree n. */
static void edge_points(const double (*points)[4], int n, int a, int b, double to[][4])
{
    for (int k = 0; k <= n; ++k) {
        int at[3] = {0, 0, 0}; /* exponents of w, u, v */
        at[a] = n - k;
        at[b] = k;
        const int j = at[2], index = j * (n + 1) - j * (j - 1) / 2 + at[1];
        memcpy(to[k], points[index], sizeof to[k]);
    }
}

/* ... of the triangle of v in this order, from v[0] to v[1]. */
static void edge_of(int degree, double alpha, const mesh_vertex *const v[3], const int order[3], double to[][4])
{
    double points[MOST_POINTS][4];
    const mesh_vertex *const at[3] = {v[order[0]], v[order[1]], v[order[2]]};
    int place[3];
    for (int i = 0; i < 3; ++i) place[order[i]] = i;
    if (degree == PHONG) phong_triangle(at, alpha, points);
    else pn_triangle(at, points);
    edge_points(points, degree, place[0], place[1], to);
}

static void meshes(void **state)
{
    (void)state;
    rng r = rng_split(1, 0, 0);
    for (int round = 0; round < 1000; ++round) {
        const double alpha = rng_in(&r, 0, 1);
        const mesh_vertex a = random_vertex(&r), b = random_vertex(&r), c = random_vertex(&r), d = random_vertex(&r);
        const mesh_vertex *const one[3] = {&a, &b, &c}, *const other[3] = {&a, &b, &d};
        for (int degree = PHONG; degree <= PN; ++degree)
            for (int i = 0; i < 36; ++i) {
                double x[4][4], y[4][4];
                edge_of(degree, alpha, one, orders[i / 6], x);
                edge_of(degree, alpha, other, orders[i % 6], y);
                CHECK(!memcmp(x, y, (size_t)(degree + 1) * sizeof x[0]), "degree %d, round %d, orders %d", degree,
                      round, i);
            }
    }
}

/* P1 to P6 of the triangle of v in this order; middle[i] is across from v[i]. */
static void quadratic_edge(const double v[3][4], const double middle[3][4], const int order[3], double to[][4])
{
    static const int corners[3] = {2, 0, 1}; /* P3 is at u = v = 0 */
    double on[6][4], points[6][4];
    int place[3];
    for (int i = 0; i < 3; ++i) {
        memcpy(on[i], v[order[i]], sizeof on[i]);
        memcpy(on[3 + i], middle[order[i]], sizeof on[i]);
    }
    for (int i = 0; i < 3; ++i) place[order[corners[i]]] = i;
    quadratic_triangle(on, points);
    edge_points(points, 2, place[0], place[1], to);
}

static void six_points(void **state)
{
    (void)state;
    rng r = rng_split(2, 0, 0);
    for (int round = 0; round < 1000; ++round) {
        double v[2][3][4], middle[2][3][4];
        for (int t = 0; t < 2; ++t)
            for (int i = 0; i < 3; ++i)
                for (int c = 0; c < 4; ++c)
                    v[t][i][c] = c < 3 ? rng_in(&r, -1, 1) : 1, middle[t][i][c] = c < 3 ? rng_in(&r, -1, 1) : 1;
        memcpy(v[1], v[0], 2 * sizeof v[0][0]);
        memcpy(middle[1][2], middle[0][2], sizeof middle[0][2]);
        for (int i = 0; i < 36; ++i) {
            double x[3][4], y[3][4];
            quadratic_edge(v[0], middle[0], orders[i / 6], x);
            quadratic_edge(v[1], middle[1], orders[i % 6], y);
            CHECK(!memcmp(x, y, sizeof x), "round %d, orders %d", round, i);
            CHECK(!memcmp(x[0], v[0][0], sizeof x[0]) && !memcmp(x[2], v[0][1], sizeof x[0]), "round %d, ends", round);
            for (int c = 0; c < 3; ++c)
                CHECK(fabs(x[0][c] / 4 + x[1][c] / 2 + x[2][c] / 4 - middle[0][2][c]) < 1e-15, "round %d", round);
        }
    }
}

static void normals(void **state)
{
    (void)state;
    double zero[3] = {0, -0.0, 0};
    assert_false(normalise(zero));
    for (int e = -1074; e < 1024; e += 7) {
        double n[3] = {ldexp(1, e), 0, -ldexp(1, e)};
        assert_true(normalise(n));
        CHECK(fabs(n[0] - sqrt(0.5)) < 2e-16 && n[1] == 0 && n[2] == -n[0], "2^%d: %g %g %g", e, n[0], n[1], n[2]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes),
        cmocka_unit_test(six_points),
        cmocka_unit_test(normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
