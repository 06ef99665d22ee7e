/* test_hits.c - is every hit found, and none invented, on patches of all kinds?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/hits.h"

#define ALL_STYLES {STYLE_GENTLE, STYLE_WILD, STYLE_FLAT, STYLE_COLLAPSED}, 4

static void triangles(void **state)
{
    (void)state;
    check_hits(&(hits_case){1, 48, 480, true, false, {9, 1}, ALL_STYLES, 1, {0, 0, 0}, 0, 0});
}

static void tensors(void **state)
{
    (void)state;
    check_hits(&(hits_case){2, 64, 480, false, true, {7, 1}, ALL_STYLES, 1, {0, 0, 0}, 0, 0});
}

static void mild_weights(void **state)
{
    (void)state;
    check_hits(&(hits_case){3, 80, 320, true, true, {5, 3}, ALL_STYLES, 1, {0, 0, 0}, 0, 0});
}

static void weights_of_a_fiftieth_to_fifty(void **state)
{
    (void)state;
    check_hits(&(hits_case){4, 24, 320, true, true, {4, 50}, {STYLE_GENTLE, STYLE_COLLAPSED}, 2, 1, {0, 0, 0}, 0, 0});
}

static void bilinear_and_flat(void **state)
{
    (void)state;
    check_hits(&(hits_case){5, 120, 320, true, true, {1, 1}, ALL_STYLES, 1, {0, 0, 0}, 0, 0});
    check_hits(&(hits_case){6, 60, 320, true, true, {3, 1}, {STYLE_FLAT}, 1, 1, {0, 0, 0}, 0, 0});
}

static void degenerate(void **state)
{
    (void)state;
    check_hits(&(hits_case){8, 96, 160, true, true, {4, 2}, {STYLE_DEGENERATE}, 1, 1, {0, 0, 0}, 0, 0});
}

static void folds_of_high_degree(void **state)
{
    (void)state;
    check_hits(&(hits_case){7, 4, 160, true, true, {15, 1}, {STYLE_GENTLE, STYLE_WILD}, 2, 1, {0, 0, 0}, 0, 0});
}

/* Flat enough for whole patches to be leaves. */
static void large_pieces_of_high_degree(void **state)
{
    (void)state;
    check_hits(&(hits_case){9, 16, 160, true, true, {25, 1}, {STYLE_FLAT}, 1, 1, {0, 0, 0}, 0, 0});
}

/* As where few rays come. */
static void coarse(void **state)
{
    (void)state;
    check_hits(&(hits_case){10, 48, 320, true, true, {6, 2}, ALL_STYLES, 1, {0, 0, 0}, 0, 5});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles),
        cmocka_unit_test(tensors),
        cmocka_unit_test(mild_weights),
        cmocka_unit_test(weights_of_a_fiftieth_to_fifty),
        cmocka_unit_test(bilinear_and_flat),
        cmocka_unit_test(degenerate),
        cmocka_unit_test(folds_of_high_degree),
        cmocka_unit_test(large_pieces_of_high_degree),
        cmocka_unit_test(coarse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
