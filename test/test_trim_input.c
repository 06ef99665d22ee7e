/* test_trim_input.c - bad, degenerate, tiny and far-away regions; every allocation failed once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/test_trim.h"

#include <string.h>

static ep_region *polygon(ep_message *m)
{
    ep_region *r = ep_region_new();
    assert_int_equal(ep_region_begin(r, EP_REGION_POLYGON, NULL, m), EP_OK);
    return r;
}

/* The call fails with a sentence that holds `words`, and what was there before is as it was. */
#define REFUSED(call, status, words)                                                                                   \
    do {                                                                                                               \
        ep_message m = {""};                                                                                           \
        ep_region *r = polygon(&m);                                                                                    \
        assert_int_equal(ep_region_line(r, 3, corner, &m), EP_OK);                                                     \
        CHECK((call) == (status) && strstr(m.text, words), "%s", m.text);                                              \
        assert_int_equal(ep_region_end(r, &m), EP_OK);                                                                 \
        ep_trim *t;                                                                                                    \
        assert_int_equal(ep_trim_new(r, &t, &m), EP_OK);                                                               \
        assert_true(ep_trim_has_point(t, 0.25, 0.25) && !ep_trim_has_point(t, 0.75, 0.75));                            \
        assert_int_equal(t->piece_count, 3);                                                                           \
        ep_trim_free(t);                                                                                               \
        ep_region_free(r);                                                                                             \
    } while (0)

static const ep_point2 corner[3] = {{0, 0}, {1, 0}, {0, 1}};

static void meaningless(void **state)
{
    (void)state;
    const double nan = NAN;
    const ep_point2w good[30] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const ep_point2w zero[2] = {{0, 0, 1}, {1, 0, 0}}, negative[2] = {{0, 0, -1}, {1, 0, 1}};
    const ep_point2w no_weight[2] = {{0, 0, 1}, {1, 0, nan}}, no_x[2] = {{0, 0, 1}, {nan, 0, 1}};
    const ep_point2w far[2] = {{0, 0, 1}, {1, INFINITY, 1}}, uneven[2] = {{0, 0, 1e-90}, {1, 0, 1}};
    const ep_point2 bad_line[2] = {{0, 0}, {0, nan}}, too_far[2] = {{0, 0}, {0, 1e200}};
    REFUSED(ep_region_bezier(r, 2, zero, &m), EP_BAD_DATA, "weight of point 2 is 0");
    REFUSED(ep_region_bezier(r, 2, negative, &m), EP_BAD_DATA, "weight of point 1 is -1");
    REFUSED(ep_region_bezier(r, 2, no_weight, &m), EP_BAD_DATA, "weight of point 2");
    REFUSED(ep_region_bezier(r, 2, no_x, &m), EP_BAD_DATA, "x of point 2");
    REFUSED(ep_region_bezier(r, 2, far, &m), EP_BAD_DATA, "y of point 2 is inf");
    REFUSED(ep_region_bezier(r, 2, uneven, &m), EP_BAD_DATA, "differ too much");
    REFUSED(ep_region_bezier(r, 0, NULL, &m), EP_BAD_DATA, "2 to 26 points, not 0");
    REFUSED(ep_region_bezier(r, 1, good, &m), EP_BAD_DATA, "2 to 26 points, not 1");
    REFUSED(ep_region_bezier(r, 27, good, &m), EP_BAD_DATA, "2 to 26 points, not 27");
    REFUSED(ep_region_line(r, 0, NULL, &m), EP_BAD_DATA, "at least two points");
    REFUSED(ep_region_line(r, 2, bad_line, &m), EP_BAD_DATA, "y of point 2");
    REFUSED(ep_region_line(r, 2, too_far, &m), EP_BAD_DATA, "too far out");

#define KNOTS(degree, points, words, ...)                                                                              \
    do {                                                                                                               \
        const double k[] = {__VA_ARGS__};                                                                              \
        REFUSED(ep_region_nurbs(r, degree, sizeof k / sizeof k[0], k, points, good, &m), EP_BAD_DATA, words);          \
    } while (0)
    KNOTS(2, 3, "go with 6 knots, not 5", 0, 0, 0, 1, 1);
    KNOTS(2, 4, "below the one before", 0, 0, 0, 2, 1, 2, 2);
    KNOTS(2, 3, "knot 4 is nan", 0, 0, 0, nan, 1, 1);
    KNOTS(2, 3, "knot 6 is inf", 0, 0, 0, 1, 1, INFINITY);
    KNOTS(0, 3, "degree 0", 0, 0, 1, 1);
    KNOTS(26, 27, "degree 26", 0, 0, 1, 1);
    KNOTS(3, 3, "needs 4 points", 0, 0, 0, 0, 1, 1, 1);
    KNOTS(2, 3, "no extent", 1, 1, 1, 1, 1, 1);
    KNOTS(1, 4, "repeats more than 1 times", 0, 0, 1, 1, 2, 2);
#undef KNOTS
}

static void out_of_place(void **state)
{
    (void)state;
    ep_message m;
    ep_trim *t;
    ep_region *r = ep_region_new();
    const double bad[6] = {1, 0, 0, NAN, 0, 0};
    assert_int_equal(ep_trim_new(r, &t, &m), EP_INVALID);
    assert_int_equal(ep_region_end(r, &m), EP_INVALID);
    assert_int_equal(ep_region_line(r, 3, corner, &m), EP_INVALID);
    assert_int_equal(ep_region_begin(r, EP_REGION_CIRCLE, NULL, &m), EP_INVALID);
    assert_int_equal(ep_region_circle(r, bad, &m), EP_BAD_DATA);
    assert_int_equal(ep_region_begin(r, EP_REGION_DIFFERENCE, bad, &m), EP_BAD_DATA);
    assert_int_equal(ep_region_begin(r, EP_REGION_DIFFERENCE, NULL, &m), EP_OK);
    assert_int_equal(ep_region_line(r, 3, corner, &m), EP_INVALID);
    assert_int_equal(ep_region_square(r, NULL, &m), EP_OK);
    assert_int_equal(ep_region_end(r, &m), EP_BAD_DATA);
    assert_int_equal(ep_region_begin(r, EP_REGION_LOOPS, NULL, &m), EP_OK);
    assert_int_equal(ep_region_circle(r, NULL, &m), EP_INVALID);
    assert_int_equal(ep_region_end(r, &m), EP_BAD_DATA);
    assert_int_equal(ep_region_begin(r, EP_REGION_POLYGON, NULL, &m), EP_OK);
    assert_int_equal(ep_region_square(r, NULL, &m), EP_INVALID);
    assert_int_equal(ep_region_end(r, &m), EP_BAD_DATA);
    assert_int_equal(ep_region_line(r, 3, corner, &m), EP_OK);
    assert_int_equal(ep_region_end(r, &m), EP_OK);
    assert_int_equal(ep_region_end(r, &m), EP_OK);
    assert_int_equal(ep_region_square(r, NULL, &m), EP_BAD_DATA);
    assert_int_equal(ep_trim_new(r, &t, &m), EP_INVALID);
    assert_int_equal(ep_region_end(r, &m), EP_OK);
    assert_int_equal(ep_region_square(r, NULL, &m), EP_INVALID);
    assert_int_equal(ep_trim_new(r, &t, &m), EP_OK);
    assert_true(ep_trim_has_point(t, 0.75, 0.75) && !ep_trim_has_point(t, 0.25, 0.25));
    ep_trim_free(t);
    ep_region_free(r);

    r = ep_region_new();
    for (int i = 0; i < EP_REGION_DEPTH; ++i) assert_int_equal(ep_region_begin(r, EP_REGION_UNION, NULL, &m), EP_OK);
    assert_int_equal(ep_region_circle(r, NULL, &m), EP_BAD_DATA);
    ep_region_free(r);
}

static ep_trim *finish(ep_region *r)
{
    ep_message m;
    ep_trim *t = NULL;
    if (ep_region_end(r, &m) || ep_trim_new(r, &t, &m)) FAIL("%s", m.text);
    ep_region_free(r);
    return t;
}

/* Points of no area, twice the same way, figures of eight, cusps: the even-odd answer. */
static void degenerate(void **state)
{
    (void)state;
    ep_message m;
    ep_region *r = polygon(&m);
    const ep_point2 point[4] = {{0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}};
    ep_region_line(r, 4, point, &m);
    ep_trim *t = finish(r);
    assert_int_equal(t->root.state, EP_TRIM_OUTSIDE);
    assert_false(ep_trim_has_point(t, 0.5, 0.5));
    ep_trim_free(t);

    r = polygon(&m); /* there and back */
    ep_region_line(r, 2, (const ep_point2[]){{0, 0}, {1, 1}}, &m);
    t = finish(r);
    for (int i = -4; i <= 12; ++i)
        for (int j = -4; j <= 12; ++j) assert_false(ep_trim_has_point(t, i * 0.125, j * 0.125));
    ep_trim_free(t);

    r = polygon(&m); /* the triangle once more over the square: what both hold is out */
    ep_region_line(r, 4, (const ep_point2[]){{0, 0}, {1, 0}, {1, 1}, {0, 1}}, &m);
    ep_region_line(r, 5, (const ep_point2[]){{0, 0}, {0, 0}, {1, 0}, {0, 1}, {0, 0}}, &m);
    t = finish(r);
    assert_true(ep_trim_has_point(t, 0.75, 0.75) && !ep_trim_has_point(t, 0.25, 0.25));
    ep_trim_free(t);

    r = polygon(&m); /* a figure of eight */
    ep_region_line(r, 4, (const ep_point2[]){{0, 0}, {1, 1}, {1, 0}, {0, 1}}, &m);
    t = finish(r);
    assert_true(ep_trim_has_point(t, 0.25, 0.5) && ep_trim_has_point(t, 0.75, 0.5));
    assert_false(ep_trim_has_point(t, 0.5, 0.25) || ep_trim_has_point(t, 0.5, 0.75));
    ep_trim_free(t);

    r = polygon(&m); /* a cusp */
    ep_region_bezier(r, 4, (const ep_point2w[]){{0, 0, 1}, {1, 1, 1}, {0, 1, 1}, {1, 0, 1}}, &m);
    t = finish(r); /* at t = 1/2, (0.5, 0.75) */
    assert_true(ep_trim_has_point(t, 0.5, 0.749999) && !ep_trim_has_point(t, 0.5, 0.750001));
    assert_false(ep_trim_has_point(t, 0.5, -0.000001));
    assert_false(ep_trim_has_point(t, NAN, 0.5) || ep_trim_has_point(t, 0.5, NAN));
    assert_false(ep_trim_has_point(t, INFINITY, 0.5) || ep_trim_has_point(t, 0.5, -INFINITY));
    ep_trim_free(t);
}

/* The circle that a point is nearly on: right to a few roundings, at any size and place. */
static void near_the_border(void **state)
{
    (void)state;
    const double sizes[][3] = {{1, 0, 0}, {1e-4, 1e4, -1e4}, {1e6, 3e5, 0}, {1e-30, 0, 0}};
    for (size_t k = 0; k < EP_ARRAY_LEN(sizes); ++k) {
        ep_message m;
        ep_region *r = ep_region_new();
        const double f = sizes[k][0], x = sizes[k][1], y = sizes[k][2];
        const double transform[6] = {f, 0, 0, f, x, y};
        assert_int_equal(ep_region_circle(r, transform, &m), EP_OK);
        ep_trim *t;
        assert_int_equal(ep_trim_new(r, &t, &m), EP_OK);
        const double ulps = 0x1p-48 * (f + fabs(x) + fabs(y));
        for (int i = 0; i < 1000; ++i) {
            const double c = cos(i * 0.1), s = sin(i * 0.1), in = f - ulps, out = f + ulps;
            CHECK(ep_trim_has_point(t, x + in * c, y + in * s), "size %zu, %d", k, i);
            CHECK(!ep_trim_has_point(t, x + out * c, y + out * s), "size %zu, %d", k, i);
        }
        ep_trim_free(t);
        ep_region_free(r);
    }
}

/* The two sides of one curve, which the two regions run through in opposite directions: every point is in one. */
static void no_gap(void **state)
{
    (void)state;
    rng g = rng_split(5, 0, 0);
    for (int k = 0; k < 100; ++k) {
        ep_message m;
        ep_point2w p[5], q[5];
        for (int i = 0; i < 5; ++i) p[i][0] = i * 0.25, p[i][1] = rng_in(&g, 0.2, 0.8), p[i][2] = rng_scale(&g, 0.3, 3);
        for (int i = 0; i < 5; ++i) memcpy(q[i], p[4 - i], sizeof q[i]);
        ep_region *r = polygon(&m);
        ep_region_bezier(r, 5, p, &m);
        ep_region_line(r, 2, (const ep_point2[]){{1, 2}, {0, 2}}, &m);
        ep_trim *above = finish(r);
        r = polygon(&m);
        ep_region_bezier(r, 5, q, &m);
        ep_region_line(r, 2, (const ep_point2[]){{0, -2}, {1, -2}}, &m);
        ep_trim *below = finish(r);
        for (int i = 0; i < 2000; ++i) {
            ep_point2h h[5];
            ep_point2 c;
            for (int j = 0; j < 5; ++j) h[j][0] = p[j][0] * p[j][2], h[j][1] = p[j][1] * p[j][2], h[j][2] = p[j][2];
            ep_curve_eval(h, 4, rng_unit(&g), c); /* on the curve, as far as it can be */
            if (!(c[0] > 0 && c[0] < 1)) continue;
            assert_int_equal(ep_trim_has_point(above, c[0], c[1]) + ep_trim_has_point(below, c[0], c[1]), 1);
        }
        ep_trim_free(above);
        ep_trim_free(below);
    }
}

/* All that a session does; false when memory ran out, which must leave nothing behind. */
static bool session(const trim_shape *s)
{
    ep_message m = {""};
    ep_trim *t = NULL;
    ep_trim_part part = {0};
    ep_trim_store store = {0};
    ep_region *r = ep_region_new();
    EPStatus status = r ? build_shape(r, s, &m) : EP_NO_MEMORY;
    if (!status) status = ep_trim_new(r, &t, &m);
    const ep_trim_domain d = ep_domain_rectangle(0, 0.75, 0, 0.5, 0);
    if (!status) status = ep_trim_cut(t, &t->root, &d, &part, &m);
    uint32_t node;
    if (!status) status = ep_trim_keep(t, &part, &d, &store, &node, &m);
    CHECK(status == EP_OK || status == EP_NO_MEMORY, "%d: %s", status, m.text);
    CHECK(status == EP_OK || r == NULL || m.text[0], "no message");
    ep_free(store.words);
    ep_trim_part_free(&part);
    ep_trim_free(t);
    ep_region_free(r);
    return status == EP_OK;
}

static void every_allocation_fails_once(void **state)
{
    (void)state;
    for (unsigned k = 0; k < 8; ++k) {
        rng g = rng_split(6, 0, k);
        trim_shape *s = random_shape(&g, 3, (trim_style){0, 3, 4});
        bool complete = false;
        for (long n = 0; !complete; ++n) {
            ep_alloc_fail_at(n);
            complete = session(s);
            ep_alloc_fail_at(-1);
            CHECK(n < 100000, "case %u", k);
        }
        shape_free(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meaningless), cmocka_unit_test(out_of_place),
        cmocka_unit_test(degenerate),  cmocka_unit_test(near_the_border),
        cmocka_unit_test(no_gap),      cmocka_unit_test(every_allocation_fails_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
