/* test_memory.c - what happens when any one allocation fails?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Leaks are for the address sanitizer to find; what is checked here is the status, and that the object is as it was. */
#include "test/support.h"

#include <string.h>

static EPStatus add(EPGeometry g, const test_patch *p)
{
    return p->shape.triangle
               ? epAddBezierTriangles(g, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, sizeof p->points[0])
               : epAddBezierPatches(g, p->shape.m, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, sizeof p->points[0]);
}

enum { PATCHES = 16 };

/* Adds all patches and commits; repeats a step that runs out of memory, which must have changed nothing. */
static int build(EPGeometry g, const test_patch *p, long fail_at)
{
    int failures = 0;
    EPStatistics before, after;
    ep_alloc_fail_at(fail_at);
    for (int i = 0; i < PATCHES; ++i) {
        epGetGeometryStatistics(g, &before);
        EPStatus s = add(g, &p[i]);
        if (s != EP_OK) {
            ++failures;
            CHECK(s == EP_NO_MEMORY && epGetGeometryMessage(g)[0], "status %d", s);
            epGetGeometryStatistics(g, &after);
            assert_int_equal(before.patches, after.patches);
            s = add(g, &p[i]);
        }
        assert_int_equal(s, EP_OK);
    }
    EPStatus s = epCommitGeometry(g);
    if (s != EP_OK) {
        ++failures;
        CHECK(s == EP_NO_MEMORY && epGetGeometryMessage(g)[0], "status %d", s);
        epGetGeometryStatistics(g, &after);
        assert_int_equal(after.leaves, 0);
        s = epCommitGeometry(g);
    }
    assert_int_equal(s, EP_OK);
    ep_alloc_fail_at(-1);
    return failures;
}

static void random_patches(test_patch *p)
{
    for (uint64_t k = 0; k < PATCHES; ++k) {
        rng r = rng_split(1, 0, k);
        random_patch(&r, (patch_style)(k % STYLES), k % 3 == 0, (patch_limits){4, k % 2 ? 1 : 3}, &p[k]);
    }
}

static void every_allocation_fails_once(void **state)
{
    (void)state;
    static test_patch p[PATCHES];
    random_patches(p);
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = 4;
    EPGeometry whole = new_geometry(p, PATCHES, &settings);
    EPStatistics want, got;
    epGetGeometryStatistics(whole, &want);
    int failures = 1;
    long n = 0;
    for (; failures; ++n) {
        EPGeometry g = epNewGeometry();
        assert_int_equal(epSetGeometryBuildSettings(g, &settings), EP_OK);
        failures = build(g, p, n);
        assert_true(failures <= 1);
        epGetGeometryStatistics(g, &got);
        CHECK(got.leaves == want.leaves && got.patches == want.patches, "after failure %ld: %zu leaves, not %zu", n,
              got.leaves, want.leaves);
        assert_int_equal(got.leaves, g->hierarchy.leaf_count);
        assert_memory_equal(g->hierarchy.leaves, whole->hierarchy.leaves, got.leaves * sizeof(ep_leaf));
        epReleaseGeometry(g);
    }
    assert_true(n > 10); /* a build that allocates nothing tests nothing */
    epReleaseGeometry(whole);
}

static void a_new_geometry(void **state)
{
    (void)state;
    ep_alloc_fail_at(0);
    assert_null(epNewGeometry());
    ep_alloc_fail_at(-1);
    epReleaseGeometry(NULL);
}

/* A committed geometry keeps its leaves, and its scene keeps working, when a later add or commit fails. */
static void a_committed_geometry(void **state)
{
    (void)state;
    static test_patch p[PATCHES];
    random_patches(p);
    oracle *o = new_oracle(p, 1);
    for (int what = 0; what < 3; ++what)
        for (long n = 0; n < 12; ++n) {
            test_scene s = new_scene(p, 1, NULL);
            judge_answer before[50];
            float org[50][3], dir[50][3];
            for (uint64_t k = 0; k < 50; ++k) {
                rng r = rng_split(2, 0, k);
                aim(o, (aim_kind)(k % AIM_KINDS), &r, org[k], dir[k]);
                before[k] = trace_one(s.scene, org[k], dir[k], 0, INFINITY);
            }
            bool failed = true;
            if (what == 0) {
                static double points[4 * 15 * 1000];
                ep_alloc_fail_at(n);
                failed =
                    epAddBezierTriangles(s.geometry, 4, 1000, EP_FORMAT_DOUBLE3, points, 3 * sizeof(double)) != EP_OK;
            } else if (what == 1) {
                static double points[3 * 4 * 1000];
                points[3 * 4 * 1000 - 1] = NAN; /* found last, when room has been made */
                assert_int_equal(
                    epAddBezierPatches(s.geometry, 1, 1, 1000, EP_FORMAT_DOUBLE3, points, 3 * sizeof(double)),
                    EP_BAD_DATA);
            } else {
                ep_alloc_fail_at(n);
                failed = epCommitGeometry(s.geometry) != EP_OK;
            }
            ep_alloc_fail_at(-1);
            for (uint64_t k = 0; failed && k < 50; ++k) {
                const judge_answer after = trace_one(s.scene, org[k], dir[k], 0, INFINITY);
                CHECK(after.t == before[k].t && after.u == before[k].u, "step %d, allocation %ld: %s: t %.9g, not %.9g",
                      what, n, ray_text(org[k], dir[k]), after.t, before[k].t);
            }
            free_scene(&s);
        }
    oracle_free(o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_fails_once),
        cmocka_unit_test(a_new_geometry),
        cmocka_unit_test(a_committed_geometry),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
