/* test_trim_within.c - is a region the same where a part of the plane sees it?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/test_trim.h"
#include "trim/within.h"

#include <math.h>
#include <string.h>

/* Points so near to a border, in the part's coordinates and in the region's, are left out. */
static const double band = 1e-6;

static ep_region *new_region(const trim_shape *s)
{
    ep_message m;
    ep_region *region = ep_region_new();
    CHECK(build_shape(region, s, &m) == EP_OK, "%s", m.text);
    return region;
}

/* Where (0,0), (1,0) and (0,1) of the part are: some parallelogram about the unit square, or in it. */
static void random_part(rng *r, bool grid, double place[6])
{
    const double size = rng_scale(r, 0.02, 1.5), a = grid ? 0 : rng_in(r, 0, 6.3),
                 b = a + (grid ? 1.5707963 : rng_in(r, 0.5, 2.5));
    const double other = size * rng_in(r, 0.3, 1);
    const double sides[4] = {size * cos(a), size * sin(a), other * cos(b), other * sin(b)};
    memcpy(place, sides, sizeof sides);
    if (grid) place[0] = 0.25 * rng_below(r, 4) + 0.25, place[1] = place[2] = 0, place[3] = 0.25;
    for (int k = 4; k < 6; ++k) place[k] = grid ? 0.25 * rng_below(r, 5) - 0.25 : rng_in(r, -0.3, 1.1);
}

static void invert(const double m[6], double out[6])
{
    const double det = m[0] * m[3] - m[1] * m[2];
    const double inverse[6] = {m[3] / det, -m[1] / det, -m[2] / det, m[0] / det, 0, 0};
    memcpy(out, inverse, sizeof inverse);
    out[4] = -(out[0] * m[4] + out[2] * m[5]);
    out[5] = -(out[1] * m[4] + out[3] * m[5]);
}

static size_t curves_of(const ep_region *region)
{
    ep_region_view view;
    ep_message m;
    assert_int_equal(ep_region_look(region, &view, &m), EP_OK);
    return view.curve_count;
}

/* Many random points of a random part of a random region. */
static void compare(uint64_t seed, bool grid, bool triangle)
{
    rng r = rng_split(seed, 0, 0);
    trim_shape *shape = random_shape(&r, rng_below(&r, 4), (trim_style){grid ? 0.25 : 0, 5, 4});
    double place[6], to_part[6];
    ep_region *whole = new_region(shape), *within;
    ep_message m;
    ep_trim *trim;
    random_part(&r, grid, place);
    invert(place, to_part);
    assert_true(shape_prepare(shape));
    CHECK(ep_region_within(whole, to_part, triangle, &within, &m) == EP_OK, "%s", m.text);
    CHECK(ep_trim_new(within, &trim, &m) == EP_OK, "%s", m.text);
    /* chains become lines, and a contour of nothing one */
    CHECK(curves_of(within) <= curves_of(whole) + 16, "%zu of %zu", curves_of(within), curves_of(whole));
    for (int k = 0; k < 300; ++k) {
        double s = rng_unit(&r), t = rng_unit(&r);
        if (triangle && s + t > 1) s = 1 - s, t = 1 - t;
        const double u = place[0] * s + place[2] * t + place[4], v = place[1] * s + place[3] * t + place[5];
        const shape_side side = shape_at(shape, u, v, band);
        if (side == SHAPE_NEAR) continue;
        CHECK(ep_trim_has_point(trim, s, t) == (side == SHAPE_IN), "seed %d: (%.17g, %.17g) of the part is %d",
              (int)seed, s, t, (int)side);
    }
    ep_trim_free(trim);
    ep_region_free(within);
    ep_region_free(whole);
    shape_free(shape);
}

static void points_stay_on_their_side(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 1500; ++seed) compare(seed, false, seed % 2);
}

/* Curves along the borders of parts, and through their corners. */
static void borders_may_be_borders(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 1500; ++seed) compare(seed, true, seed % 2);
}

/* A contour of many curves leaves each of many parts with what is there. */
static void parts_share_the_curves(void **state)
{
    (void)state;
    enum { CURVES = 1000, PARTS = 50 };
    ep_message m;
    ep_region *r = ep_region_new(), *within;
    assert_int_equal(ep_region_begin(r, EP_REGION_POLYGON, NULL, &m), EP_OK);
    for (int i = 0; i < CURVES; ++i) {
        const double a = 2 * 3.14159265358979323846 * i / CURVES, b = 2 * 3.14159265358979323846 * (i + 1) / CURVES;
        const ep_point2w p[3] = {{0.5 + 0.4 * cos(a), 0.5 + 0.4 * sin(a), 1},
                                 {0.5 + 0.41 * cos((a + b) / 2), 0.5 + 0.41 * sin((a + b) / 2), 1},
                                 {0.5 + 0.4 * cos(b), 0.5 + 0.4 * sin(b), 1}};
        assert_int_equal(ep_region_bezier(r, 3, p, &m), EP_OK);
    }
    assert_int_equal(ep_region_end(r, &m), EP_OK);
    size_t curves = 0;
    for (int i = 0; i < PARTS; ++i)
        for (int j = 0; j < PARTS; ++j) {
            const double to_part[6] = {PARTS, 0, 0, PARTS, -i, -j};
            assert_int_equal(ep_region_within(r, to_part, false, &within, &m), EP_OK);
            curves += curves_of(within);
            ep_region_free(within);
        }
    ep_region_free(r);
    /* those in a part, in two where it ends there, and a few lines around */
    CHECK(curves <= 2 * CURVES + 6 * PARTS * PARTS, "%zu", curves);
}

/* A region that is as deep as can be stays so. */
static void depth_stays(void **state)
{
    (void)state;
    const double to_part[6] = {2, 0, 0, 2, -0.5, -0.5};
    ep_message m;
    ep_region *r = ep_region_new(), *within;
    for (int k = 0; k < EP_REGION_DEPTH - 1; ++k)
        assert_int_equal(ep_region_begin(r, EP_REGION_UNION, NULL, &m), EP_OK);
    assert_int_equal(ep_region_circle(r, (const double[6]){0.3, 0, 0, 0.3, 0.5, 0.5}, &m), EP_OK);
    for (int k = 0; k < EP_REGION_DEPTH - 1; ++k) assert_int_equal(ep_region_end(r, &m), EP_OK);
    CHECK(ep_region_within(r, to_part, false, &within, &m) == EP_OK, "%s", m.text);
    ep_region_free(within);
    ep_region_free(r);
}

static void every_allocation_fails_once(void **state)
{
    (void)state;
    rng r = rng_split(3, 0, 0);
    trim_shape *shape = random_shape(&r, 3, (trim_style){0, 5, 4});
    ep_region *whole = new_region(shape), *within = NULL;
    const double to_part[6] = {2, 0, 0, 3, -0.5, -0.2};
    for (long n = 0; !within; ++n) {
        ep_message m;
        ep_alloc_fail_at(n);
        const EPStatus s = ep_region_within(whole, to_part, n % 2, &within, &m);
        ep_alloc_fail_at(-1);
        assert_true(s == EP_OK ? within != NULL : s == EP_NO_MEMORY && !within);
    }
    ep_region_free(within);
    ep_region_free(whole);
    shape_free(shape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_stay_on_their_side),   cmocka_unit_test(borders_may_be_borders),
        cmocka_unit_test(parts_share_the_curves),      cmocka_unit_test(depth_stays),
        cmocka_unit_test(every_allocation_fails_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
