/* test_trim_methods.c - every way to test a point gives the same answer.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/test_trim.h"
#include "trim/costs.h"
#include "trim/svg.h"

#include <string.h>

static void agree(void **state)
{
    (void)state;
    static const trim_style styles[] = {{0, 1, 3}, {0, 20, 5}, {0.125, 1, 3}, {0.125, 4, 4}};
    for (unsigned k = 0; k < 200; ++k) {
        rng r = rng_split(8, 0, k);
        trim_shape *s = random_shape(&r, k / 4 % 4, styles[k % 4]);
        ep_message m;
        ep_region *region = ep_region_new();
        ep_trim *trim = NULL;
        ep_trim_tester *tester[EP_TRIM_METHODS];
        if (build_shape(region, s, &m) || ep_trim_new(region, &trim, &m)) FAIL("%s", m.text);
        for (int i = 0; i < EP_TRIM_METHODS; ++i)
            if (ep_trim_tester_new(region, trim, (ep_trim_method)i, &tester[i], &m)) FAIL("%s", m.text);
        bool prepared = false;
        for (int i = 0; i < 500; ++i) {
            double x = rng_in(&r, -0.3, 1.3), y = rng_in(&r, -0.3, 1.3);
            if (i % 3 == 0) y = floor(y * 16) / 16;
            if (i % 5 == 0) x = floor(x * 16) / 16;
            const bool want = ep_trim_tester_has_point(tester[0], x, y);
            for (int j = 1; j < EP_TRIM_METHODS; ++j) {
                if (ep_trim_tester_has_point(tester[j], x, y) == want) continue;
                prepared = prepared || shape_prepare(s);
                CHECK(shape_at(s, x, y, 2e-5) == SHAPE_NEAR, "case %u: (%.17g, %.17g) is not %d by %s", k, x, y, want,
                      ep_trim_method_name[j]);
            }
        }
        for (int i = 0; i < EP_TRIM_METHODS; ++i) ep_trim_tester_free(tester[i]);
        ep_trim_free(trim);
        ep_region_free(region);
        shape_free(s);
    }
}

static void allocations(void **state)
{
    (void)state;
    rng r = rng_split(8, 1, 0);
    trim_shape *s = random_shape(&r, 3, (trim_style){0, 3, 4});
    ep_message m;
    ep_region *region = ep_region_new();
    ep_trim *trim = NULL;
    if (build_shape(region, s, &m) || ep_trim_new(region, &trim, &m)) FAIL("%s", m.text);
    EPStatus status = EP_NO_MEMORY;
    for (long n = 0; status == EP_NO_MEMORY; ++n) {
        ep_trim_tester *t;
        ep_alloc_fail_at(n);
        status = ep_trim_tester_new(region, trim, EP_TRIM_STRIP_TREES, &t, &m);
        ep_alloc_fail_at(-1);
        ep_trim_tester_free(t);
    }
    assert_int_equal(status, EP_OK);
    ep_trim_free(trim);
    ep_region_free(region);
    shape_free(s);
}

static void costs(void **state)
{
    (void)state;
    ep_message m;
    ep_trim_costs c;
    ep_trim_cost_row rows[EP_TRIM_COST_ROWS];
    assert_int_equal(ep_trim_measure(&c, &m), EP_OK);
    assert_true(c.strip > 0 && c.straight > 0 && c.cut > 0);
    assert_int_equal(ep_trim_measure_rows(rows, &m), EP_OK);
    for (int i = 0; i < EP_TRIM_COST_ROWS; ++i)
        for (int j = 0; j < EP_TRIM_METHODS; ++j)
            assert_true(rows[i].object && rows[i].ns[j] > 0 && rows[i].bytes[j] > 0);
}

static void picture(void **state)
{
    (void)state;
    ep_message m;
    ep_region *region = ep_region_new();
    ep_trim *trim = NULL;
    assert_int_equal(ep_region_circle(region, NULL, &m), EP_OK);
    assert_int_equal(ep_trim_new(region, &trim, &m), EP_OK);
    FILE *f = tmpfile();
    const ep_point2 corner[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    ep_svg_begin(f, corner[0], corner[2]);
    ep_svg_leaf(f, EP_TRIM_CROSSED, 4, corner);
    ep_svg_curves(f, trim);
    assert_true(ep_svg_end(f));
    char text[8192] = "";
    rewind(f);
    assert_true(fread(text, 1, sizeof text - 1, f) > 0);
    assert_non_null(strstr(text, "<polygon class=\"x\" points=\"-1,-1 1,-1 1,1 -1,1\"/>"));
    assert_non_null(strstr(text, "</g>\n</svg>\n"));
    size_t paths = 0;
    for (const char *p = text; (p = strstr(p, "<path")); ++p) ++paths;
    assert_int_equal(paths, trim->piece_count);
    fclose(f);
    ep_trim_free(trim);
    ep_region_free(region);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(agree), cmocka_unit_test(allocations), cmocka_unit_test(costs),
                                       cmocka_unit_test(picture)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
