/* test_watertight.c - does a ray ever slip through between patches?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Rays from inside closed models, anywhere and exactly at edges, corners and poles: none may escape. Rays at the shared
 * edges of an open model, where the patches lie on both sides of the edge as the ray sees it: all hit.
 *
 *     test_watertight [RAYS [SEED]]       so many rays from inside each closed model */
#include "test/support.h"

#include <stdlib.h>

enum { EDGE_RAYS = 200000, ALONG_RAYS = 200000 };
static uint64_t closed_rays = 250000, closed_seed = 1;

static void cross(const double a[3], const double b[3], double r[3])
{
    for (int c = 0; c < 3; ++c) r[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A point just below (side -1) or above (1) the surface, as floats. */
static void beside(const oracle *o, rng *r, double side, float p[3])
{
    double u, v, x[3], xu[3], xv[3], n[3];
    const uint32_t patch = rng_below(r, (unsigned)oracle_patch_count(o));
    do {
        aim_domain(o, patch, r, &u, &v);
        oracle_evaluate(o, patch, u, v, x, xu, xv);
        cross(xu, xv, n);
    } while (!(dot(n, n) > 0));
    const double h = side * rng_scale(r, 1e-3, 2e-2) * oracle_radius(o, patch) / sqrt(dot(n, n));
    for (int c = 0; c < 3; ++c) p[c] = (float)(x[c] + h * n[c]);
}

/* Whether Ng points outwards, by a vote of rays: from inside, a ray crosses the surface an odd number of times. */
static bool normals_point_outwards(const oracle *o)
{
    int votes = 0;
    for (uint64_t k = 0; k < 40; ++k) {
        rng r = rng_split(99, 0, k);
        float p[3];
        double org[3], dir[3];
        beside(o, &r, 1, p);
        rng_direction(&r, dir);
        for (int c = 0; c < 3; ++c) org[c] = p[c];
        oracle_root roots[ORACLE_ROOTS];
        const size_t n = oracle_intersect(o, org, dir, 0, INFINITY, roots);
        bool clear = true;
        for (size_t i = 0; i < n; ++i) clear = clear && !roots[i].doubtful;
        if (clear) votes += n % 2 ? -1 : 1;
    }
    assert_true(abs(votes) > 10);
    return votes > 0;
}

/* Every second ray goes anywhere, the others to a border, from the same place inside. */
static void aim_out(const oracle *o, rng *r, double inwards, float org[3], float dir[16][3])
{
    beside(o, r, inwards, org);
    for (unsigned i = 0; i < 16; ++i) {
        double u, v, x[3], d[3];
        const uint32_t at = rng_below(r, (unsigned)oracle_patch_count(o));
        aim_border(o, at, r, &u, &v);
        oracle_evaluate(o, at, u, v, x, NULL, NULL);
        rng_direction(r, d);
        for (int c = 0; c < 3; ++c) dir[i][c] = i % 2 ? (float)d[c] : (float)(x[c] - org[c]);
    }
}

static void no_escape(const char *model)
{
    size_t count, escaped = 0;
    test_patch *patches = read_model(model, &count);
    oracle *o = new_oracle(patches, count);
    test_scene s = new_scene(patches, count, NULL);
    const double inwards = normals_point_outwards(o) ? -1 : 1;
#pragma omp parallel for schedule(dynamic, 1000) reduction(+ : escaped)
    for (uint64_t k = 0; k < closed_rays / 16; ++k) {
        rng r = rng_split(closed_seed, 0, k);
        test_packet p;
        float org[3], dir[16][3];
        aim_out(o, &r, inwards, org, dir);
        for (unsigned i = 0; i < 16; ++i) set_ray(&p, 16, i, org, dir[i], 0, INFINITY);
        ep_rtc_intersect(s.scene, 16, p.valid, p.f, false);
        for (unsigned i = 0; i < 16; ++i) {
            const bool packed = get_id(&p, 16, HIT_GEOM, i) != RTC_INVALID_GEOMETRY_ID;
            const bool alone = i != k % 16 || trace_one(s.scene, org, dir[i], 0, INFINITY).t < INFINITY;
            if (alone && packed) continue;
#pragma omp critical
            if (++escaped <= 5)
                print_error("%s: %s escapes%s\n", model, ray_text(org, dir[i]), alone ? " in a packet" : "");
        }
    }
    assert_int_equal(escaped, 0);
    free_scene(&s);
    oracle_free(o);
    free(patches);
}

static void sphere(void **state)
{
    (void)state;
    no_escape("sphere.json");
}

static void sphere_of_triangles(void **state)
{
    (void)state;
    no_escape("sphere_triangles.json");
}

static void torus(void **state)
{
    (void)state;
    no_escape("torus.json");
}

static void knot(void **state)
{
    (void)state;
    no_escape("knot.json");
}

/* Rays from inside that went out once: nearly tangent at a border, where a root that Newton's method lost in one cell
 * was taken for that of its neighbours. */
static void once_escaped(void **state)
{
    (void)state;
    static const struct {
        const char *model;
        float org[3], dir[3];
    } rays[] = {
        {"torus.json", {-1.3817699f, -0.1689668f, 0.071975112f}, {1.3817699f, -0.609829903f, -0.405245423f}},
    };
    for (size_t i = 0; i < EP_ARRAY_LEN(rays); ++i) {
        size_t count;
        test_patch *patches = read_model(rays[i].model, &count);
        test_scene s = new_scene(patches, count, NULL);
        CHECK(trace_one(s.scene, rays[i].org, rays[i].dir, 0, INFINITY).t < INFINITY, "%s: %s", rays[i].model,
              ray_text(rays[i].org, rays[i].dir));
        free_scene(&s);
        free(patches);
    }
}

/* From within the torus, nearly along its surface at borders of its patches: on its inner side such a ray is inside
 * before and behind the border. */
static void along_the_torus(void **state)
{
    (void)state;
    size_t count, escaped = 0, asked = 0;
    test_patch *patches = read_model("torus.json", &count);
    oracle *o = new_oracle(patches, count);
    test_scene s = new_scene(patches, count, NULL);
#pragma omp parallel for schedule(dynamic, 1000) reduction(+ : escaped, asked)
    for (uint64_t k = 0; k < ALONG_RAYS; ++k) {
        rng r = rng_split(3, 0, k);
        double u, v, x[3], xu[3], xv[3], n[3];
        const uint32_t at = rng_below(&r, (unsigned)count);
        aim_border(o, at, &r, &u, &v);
        oracle_evaluate(o, at, u, v, x, xu, xv);
        cross(xu, xv, n);
        const double angle = rng_in(&r, 0, 6.283185307179586), away = rng_in(&r, 0.05, 0.5);
        const double lift = rng_sign(&r) * rng_scale(&r, 1e-7, 1e-3);
        const double lu = sqrt(dot(xu, xu)), lv = sqrt(dot(xv, xv)), ln = sqrt(dot(n, n));
        float org[3], dir[3];
        for (int c = 0; c < 3; ++c) {
            const double d = cos(angle) * xu[c] / lu + sin(angle) * xv[c] / lv + lift * n[c] / ln;
            org[c] = (float)(x[c] - away * d);
            dir[c] = (float)(x[c] - org[c]);
        }
        const double axis = hypot(org[0], org[1]) - 1;
        if (!(hypot(axis, org[2]) < 0.4 - 1e-6)) continue;
        ++asked;
        if (trace_one(s.scene, org, dir, 0, INFINITY).t < INFINITY) continue;
#pragma omp critical
        if (++escaped <= 5) print_error("%s escapes\n", ray_text(org, dir));
    }
    assert_true(asked > ALONG_RAYS / 10);
    assert_int_equal(escaped, 0);
    free_scene(&s);
    oracle_free(o);
    free(patches);
}

/* Side k of a patch: parameters at x along it, and which derivative leads inwards. */
static void side_point(const test_patch *p, unsigned side, double x, double at[3], double along[3], double in[3])
{
    double u, v, pu[3], pv[3];
    if (p->shape.triangle) u = side == 0 ? 0 : x, v = side == 1 ? 0 : side == 0 ? x : 1 - x;
    else u = side < 2 ? side : x, v = side < 2 ? x : side - 2;
    evaluate_patch(p, u, v, at, pu, pv);
    for (int c = 0; c < 3; ++c) {
        if (p->shape.triangle) {
            along[c] = side == 0 ? pv[c] : side == 1 ? pu[c] : pu[c] - pv[c];
            in[c] = side == 0 ? pu[c] : side == 1 ? pv[c] : -pu[c] - pv[c];
        } else {
            along[c] = side < 2 ? pv[c] : pu[c];
            in[c] = (side < 2 ? pu[c] : pv[c]) * (side & 1 ? -1 : 1);
        }
    }
}

typedef struct shared_edge {
    size_t patch[2];
    unsigned side[2];
    bool flipped;
} shared_edge;

static bool same_curve(const test_patch *p, unsigned side, const test_patch *q, unsigned other, bool flipped)
{
    for (int k = 0; k <= 4; ++k) {
        double a[3], b[3], unused[3], unused2[3];
        side_point(p, side, k / 4.0, a, unused, unused2);
        side_point(q, other, flipped ? 1 - k / 4.0 : k / 4.0, b, unused, unused2);
        for (int c = 0; c < 3; ++c)
            if (fabs(a[c] - b[c]) > 1e-12) return false;
    }
    return true;
}

static size_t find_shared(const test_patch *p, size_t count, shared_edge *edges, size_t room)
{
    size_t n = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t j = i + 1; j < count; ++j)
            for (unsigned a = 0; a < (p[i].shape.triangle ? 3u : 4u); ++a)
                for (unsigned b = 0; b < (p[j].shape.triangle ? 3u : 4u); ++b)
                    for (int flipped = 0; flipped < 2; ++flipped) {
                        if (n == room || !same_curve(&p[i], a, &p[j], b, flipped)) continue;
                        double at[3], along[3], in[3];
                        side_point(&p[i], a, 0.5, at, along, in);
                        if (dot(along, along) > 0) edges[n++] = (shared_edge){{i, j}, {a, b}, flipped};
                    }
    return n;
}

static void shared_edges(void **state)
{
    (void)state;
    size_t count, escaped = 0, asked = 0;
    test_patch *patches = read_model("teapot.bpt", &count);
    shared_edge edges[400];
    const size_t n = find_shared(patches, count, edges, EP_ARRAY_LEN(edges));
    assert_true(n > 40);
    test_scene s = new_scene(patches, count, NULL);
#pragma omp parallel for schedule(dynamic, 1000) reduction(+ : escaped, asked)
    for (uint64_t k = 0; k < EDGE_RAYS; ++k) {
        rng r = rng_split(2, 0, k);
        const shared_edge *e = &edges[rng_below(&r, (unsigned)n)];
        const double x = rng_unit(&r), distance = rng_scale(&r, 0.1, 100);
        double at[3], along[3], in[2][3], d[3], side[2];
        side_point(&patches[e->patch[1]], e->side[1], e->flipped ? 1 - x : x, at, along, in[1]);
        side_point(&patches[e->patch[0]], e->side[0], x, at, along, in[0]);
        rng_direction(&r, d);
        for (int i = 0; i < 2; ++i) {
            double m[3];
            cross(along, in[i], m);
            side[i] = dot(m, d) / sqrt(dot(m, m));
        }
        /* on the same side: the edge is a silhouette, and a ray may pass it */
        if (!(side[0] * side[1] < 0 && fabs(side[0]) > 0.01 && fabs(side[1]) > 0.01)) continue;
        float org[3], dir[3];
        for (int c = 0; c < 3; ++c) {
            org[c] = (float)(at[c] - distance * d[c]);
            dir[c] = (float)(at[c] - org[c]);
        }
        const judge_answer a = trace_one(s.scene, org, dir, 0, INFINITY);
        ++asked;
        if (a.t <= 1 + 1e-4) continue;
#pragma omp critical
        if (++escaped <= 5)
            print_error("between patches %zu and %zu: %s: t %g\n", e->patch[0], e->patch[1], ray_text(org, dir), a.t);
    }
    assert_true(asked > EDGE_RAYS / 2);
    assert_int_equal(escaped, 0);
    free_scene(&s);
    free(patches);
}

int main(int argc, char **argv)
{
    if (argc > 1) closed_rays = strtoull(argv[1], NULL, 10);
    if (argc > 2) closed_seed = strtoull(argv[2], NULL, 10);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere),       cmocka_unit_test(sphere_of_triangles), cmocka_unit_test(torus),
        cmocka_unit_test(knot),         cmocka_unit_test(once_escaped),        cmocka_unit_test(along_the_torus),
        cmocka_unit_test(shared_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
