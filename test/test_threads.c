/* test_threads.c - are the leaves the same for any number of threads?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <stdlib.h>

static void same_leaves(const char *model)
{
    size_t count;
    test_patch *patches = read_model(model, &count);
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.threads = 1;
    EPGeometry one = new_geometry(patches, count, &settings);
    for (settings.threads = 0; settings.threads < 8; settings.threads += settings.threads ? 3 : 2) {
        EPGeometry many = new_geometry(patches, count, &settings);
        const ep_hierarchy *a = &one->hierarchy, *b = &many->hierarchy;
        CHECK(a->leaf_count == b->leaf_count, "%s, %u threads: %zu leaves, not %zu", model, settings.threads,
              b->leaf_count, a->leaf_count);
        assert_memory_equal(a->leaves, b->leaves, a->leaf_count * sizeof *a->leaves);
        assert_memory_equal(a->boxes, b->boxes, a->leaf_count * sizeof *a->boxes);
        assert_memory_equal(a->nets, b->nets, a->net_floats * sizeof *a->nets);
        assert_memory_equal(a->bounds, b->bounds, sizeof a->bounds);
        epReleaseGeometry(many);
    }
    epReleaseGeometry(one);
    free(patches);
}

static void teapot(void **state)
{
    (void)state;
    same_leaves("teapot.bpt");
}

static void knot(void **state)
{
    (void)state;
    same_leaves("knot.json");
}

static void sphere_of_triangles(void **state)
{
    (void)state;
    same_leaves("sphere_triangles.json");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(teapot),
        cmocka_unit_test(knot),
        cmocka_unit_test(sphere_of_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
