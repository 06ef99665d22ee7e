/* test_refit.c - are leaves that are fitted anew as good as those of a build?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"
#include "test/hits.h"

#include <stdlib.h>
#include <string.h>

static EPStatus set_points(EPGeometry g, uint32_t first, const test_patch *p, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const EPStatus s =
            epSetPatchPoints(g, first + (uint32_t)i, 1, EP_FORMAT_DOUBLE4, p[i].points, sizeof p[i].points[0]);
        if (s != EP_OK) return s;
    }
    return EP_OK;
}

static void refit(EPGeometry g, const test_patch *p, size_t count)
{
    CHECK(set_points(g, 0, p, count) == EP_OK, "%s", epGetGeometryMessage(g));
    CHECK(epRefitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
}

/* Embree is told about it. */
static void refit_scene(const test_scene *s, const test_patch *p, size_t count)
{
    refit(s->geometry, p, count);
    rtcCommitGeometry(rtcGetGeometry(s->scene, 0));
    rtcCommitScene(s->scene);
}

static void same_hierarchy(const ep_hierarchy *a, const ep_hierarchy *b)
{
    assert_int_equal(a->leaf_count, b->leaf_count);
    assert_int_equal(a->net_floats, b->net_floats);
    assert_int_equal(a->trim_words, b->trim_words);
    assert_int_equal(a->exact_count, b->exact_count);
    assert_int_equal(a->uncertified, b->uncertified);
    assert_memory_equal(a->leaves, b->leaves, a->leaf_count * sizeof *a->leaves);
    assert_memory_equal(a->boxes, b->boxes, a->leaf_count * sizeof *a->boxes);
    assert_memory_equal(a->nets, b->nets, a->net_floats * sizeof *a->nets);
    assert_memory_equal(a->crossed, b->crossed, a->trim_words * sizeof *a->crossed);
    assert_memory_equal(a->exact, b->exact, a->exact_count * sizeof *a->exact);
    assert_memory_equal(a->bounds, b->bounds, sizeof a->bounds);
    assert_true(a->average_depth == b->average_depth && a->maximum_depth == b->maximum_depth);
    assert_true(a->average_thickness == b->average_thickness);
    for (size_t i = 0; i < a->patch_count; ++i) assert_true(a->patches[i].error == b->patches[i].error);
}

enum { PATCHES = 20 };

static void random_patches(uint64_t seed, test_patch p[PATCHES])
{
    for (uint64_t k = 0; k < PATCHES; ++k) {
        rng r = rng_split(seed, 0, k);
        random_patch(&r, (patch_style)(k % STYLES), k % 2, (patch_limits){5, k % 3 ? 1 : 3}, &p[k]);
    }
}

static EPRegion disc(void)
{
    EPRegion region = epNewRegion();
    assert_int_equal(epAddRegionCircle(region, (const double[6]){0.31, 0.1, 0, 0.23, 0.4, 0.3}), EP_OK);
    return region;
}

/* Points scaled by two are divided in the same way, so that all has to be equal to the bit: also of leaves whose domain
 * is no float, which cuts of triangles along trim curves make. */
static void as_committed(void **state)
{
    (void)state;
    test_patch p[PATCHES], twice[PATCHES];
    random_patches(31, p);
    memcpy(twice, p, sizeof p);
    for (int i = 0; i < PATCHES; ++i) move_patch(&twice[i], 2, (const double[3]){0, 0, 0});
    for (int trimmed = 0; trimmed < 2; ++trimmed)
        for (unsigned threads = 1; threads < 4; threads += 2) {
            EPBuildSettings settings = epDefaultBuildSettings();
            settings.threads = threads;
            EPRegion region = trimmed ? disc() : NULL;
            EPGeometry moved = new_geometry(p, PATCHES, &settings), fresh = new_geometry(twice, PATCHES, &settings);
            assert_int_equal(epSetPatchTrim(moved, 0, PATCHES, region), EP_OK);
            assert_int_equal(epSetPatchTrim(fresh, 0, PATCHES, region), EP_OK);
            epReleaseRegion(region);
            assert_int_equal(epCommitGeometry(moved), EP_OK);
            assert_int_equal(epCommitGeometry(fresh), EP_OK);
            assert_int_equal(fresh->hierarchy.exact_count > 0, trimmed);
            refit(moved, twice, PATCHES);
            same_hierarchy(&moved->hierarchy, &fresh->hierarchy);
            EPStatistics a, b;
            epGetGeometryStatistics(moved, &a);
            epGetGeometryStatistics(fresh, &b);
            assert_int_equal(a.bytes, b.bytes);
            epReleaseGeometry(moved);
            epReleaseGeometry(fresh);
        }
}

/* A patch becomes quite another one, of its degrees; its hits are judged by the oracle. */
static void other_points(void **state)
{
    (void)state;
    unsigned long rays = 0, hits = 0, faults = 0;
    static const enum RTCBuildQuality quality[] = {RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_REFIT};
    for (uint64_t k = 0; k < 60; k += TEST_STEP) {
        rng r = rng_split(32, 0, k);
        test_patch before, after;
        const bool triangle = k % 2;
        const patch_limits limits = {4, k % 3 ? 1 : 3};
        random_patch(&r, (patch_style)(k / 2 % 3), triangle, limits, &before);
        do random_patch(&r, (patch_style)(k / 6 % 3), triangle, (patch_limits){4, k % 4 ? 1 : 3}, &after);
        while (after.shape.m != before.shape.m || after.shape.n != before.shape.n);
        test_scene s = new_scene(&before, 1, NULL);
        rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_DYNAMIC);
        rtcSetGeometryBuildQuality(rtcGetGeometry(s.scene, 0), quality[k / 2 % 2]);
        rtcCommitGeometry(rtcGetGeometry(s.scene, 0));
        rtcCommitScene(s.scene);
        refit_scene(&s, &after, 1);
        oracle *o = new_oracle(&after, 1);
        for (unsigned packet = 0; packet < 20; ++packet) {
            test_ray ray[16];
            hits_answer answer[16];
            for (unsigned i = 0; i < 16; ++i) aim(o, (aim_kind)((packet + i) % AIM_KINDS), &r, ray[i].org, ray[i].dir);
            judge_rays(o, s.scene, ray, 16, answer);
            for (unsigned i = 0; i < 16; ++i) {
                ++rays;
                hits += answer[i].alone.t < INFINITY;
                if (!answer[i].fault || faults++ >= 5) continue;
                print_error("patch %d: %s: %s\n", (int)k, answer[i].fault, ray_text(ray[i].org, ray[i].dir));
            }
        }
        oracle_free(o);
        free_scene(&s);
    }
    print_message("%lu rays, %lu hits, %lu faults\n", rays, hits, faults);
    assert_int_equal(faults, 0);
    assert_true(hits > rays / 10);
}

/* A map of space that bends it more with every frame; patches that share points before share them after. */
static void bend(test_patch *p, const test_patch *rest, double amount)
{
    *p = *rest;
    for (size_t k = 0; k < net_count(p->shape); ++k) {
        double *x = p->points[k];
        const double turn = amount * x[2], c = cos(turn), s = sin(turn), swell = 1 + 0.5 * amount * sin(3 * x[2]);
        const double a = x[0], b = x[1];
        x[0] = swell * (c * a - s * b);
        x[1] = swell * (s * a + c * b);
        x[2] += 0.3 * amount * a;
    }
}

/* No ray from the middle of a closed model escapes, anywhere or at the borders of patches. */
static void watertight(const char *model)
{
    size_t count, escaped = 0;
    test_patch *rest = read_model(model, &count), *now = malloc(count * sizeof *now);
    assert_non_null(now);
    test_scene s = new_scene(rest, count, NULL);
    for (int frame = 1; frame <= 4; ++frame) {
        for (size_t i = 0; i < count; ++i) bend(&now[i], &rest[i], 0.25 * frame);
        refit_scene(&s, now, count);
        oracle *o = new_oracle(now, count);
        for (uint64_t k = 0; k < 20000; k += TEST_STEP) {
            rng r = rng_split(33, (uint64_t)frame, k);
            test_packet p;
            float org[3], dir[3];
            for (int c = 0; c < 3; ++c) org[c] = (float)rng_in(&r, -0.02, 0.02);
            for (unsigned i = 0; i < 4; ++i) {
                double u, v, x[3], d[3];
                const uint32_t at = rng_below(&r, (unsigned)count);
                aim_border(o, at, &r, &u, &v);
                oracle_evaluate(o, at, u, v, x, NULL, NULL);
                rng_direction(&r, d);
                for (int c = 0; c < 3; ++c) dir[c] = i % 2 ? (float)d[c] : (float)(x[c] - org[c]);
                set_ray(&p, 4, i, org, dir, 0, INFINITY);
            }
            ep_rtc_intersect(s.scene, 4, p.valid, p.f, false);
            for (unsigned i = 0; i < 4; ++i)
                if (get_id(&p, 4, HIT_GEOM, i) == RTC_INVALID_GEOMETRY_ID) ++escaped;
        }
        oracle_free(o);
    }
    assert_int_equal(escaped, 0);
    free_scene(&s);
    free(rest);
    free(now);
}

static void animation(void **state)
{
    (void)state;
    watertight("sphere.json");
    watertight("sphere_triangles.json");
}

/* Of a refit too, any one allocation may fail: the leaves are as they were, and the next refit succeeds. */
static void every_allocation_fails_once(void **state)
{
    (void)state;
    enum { FEW = 6 };
    test_patch p[PATCHES], other[PATCHES];
    random_patches(34, p);
    memcpy(other, p, sizeof p);
    for (int i = 0; i < FEW; ++i) move_patch(&other[i], 2, (const double[3]){0, 0, 0});
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = 3;
    EPGeometry want = new_geometry(p, FEW, &settings), fresh = new_geometry(other, FEW, &settings);
    bool failed = true;
    long n = 0;
    for (; failed; ++n) {
        EPGeometry g = new_geometry(p, FEW, &settings);
        ep_alloc_fail_at(n);
        assert_int_equal(set_points(g, 0, other, FEW), EP_OK); /* allocates nothing */
        const EPStatus s = epRefitGeometry(g);
        ep_alloc_fail_at(-1);
        failed = s != EP_OK;
        if (failed) {
            CHECK(s == EP_NO_MEMORY && epGetGeometryMessage(g)[0], "status %d", s);
            same_hierarchy(&g->hierarchy, &want->hierarchy);
            assert_int_equal(epRefitGeometry(g), EP_OK);
        }
        same_hierarchy(&g->hierarchy, &fresh->hierarchy);
        epReleaseGeometry(g);
    }
    assert_true(n > 10);
    epReleaseGeometry(want);
    epReleaseGeometry(fresh);
}

static void refuses(EPGeometry g, EPStatus got, EPStatus want, const char *word)
{
    CHECK(got == want, "%d, not %d: %s", got, want, epGetGeometryMessage(g));
    CHECK(strstr(epGetGeometryMessage(g), word), "'%s' does not say '%s'", epGetGeometryMessage(g), word);
}

static void wrong_calls(void **state)
{
    (void)state;
    static const float flat[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const size_t float3 = 3 * sizeof(float);
    EPGeometry g = epNewGeometry();
    refuses(g, epRefitGeometry(g), EP_INVALID, "epCommitGeometry");
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, flat, float3), EP_OK);
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, flat, float3), EP_OK);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    refuses(g, epSetPatchPoints(g, 3, 0, EP_FORMAT_FLOAT3, flat, float3), EP_INVALID, "no 0 patches from 3");
    refuses(g, epSetPatchPoints(g, 1, 2, EP_FORMAT_FLOAT3, flat, float3), EP_INVALID, "no 2 patches from 1");
    refuses(g, epSetPatchPoints(g, 0, 1, EP_FORMAT_DOUBLE3, flat, float3), EP_INVALID, "stride");
    refuses(g, epSetPatchPoints(g, 0, 1, (EPFormat)7, flat, float3), EP_INVALID, "format");
    refuses(g, epSetPatchPoints(g, 0, 1, EP_FORMAT_FLOAT3, NULL, float3), EP_INVALID, "points");
    assert_int_equal(epSetPatchPoints(g, 0, 0, EP_FORMAT_FLOAT3, NULL, float3), EP_OK);

    double points[8][4] = {{0}};
    for (int k = 0; k < 8; ++k) memcpy(points[k], (const double[4]){k, k % 2, 7, 2}, sizeof points[k]);
    points[6][3] = -1;
    refuses(g, epSetPatchPoints(g, 0, 2, EP_FORMAT_DOUBLE4, points, sizeof points[0]), EP_BAD_DATA, "patch 1, point 2");
    double x[3];
    epEvaluate(g, 0, 1, 1, x, NULL, NULL, NULL);
    assert_true(x[0] == 1 && x[1] == 1 && x[2] == 0); /* nothing was replaced */
    assert_int_equal(epRefitGeometry(g), EP_OK);

    /* what was polynomial becomes rational */
    points[6][3] = 3;
    assert_int_equal(epSetPatchPoints(g, 0, 2, EP_FORMAT_DOUBLE4, points, sizeof points[0]), EP_OK);
    RTCDevice device = rtcNewDevice("threads=1");
    assert_null(epNewRTCGeometry(g, device));
    refuses(g, EP_INVALID, EP_INVALID, "epRefitGeometry");
    assert_int_equal(epRefitGeometry(g), EP_OK);
    assert_true(!!g->hierarchy.patches[1].rational);
    RTCGeometry rtc = epNewRTCGeometry(g, device);
    assert_non_null(rtc);
    rtcReleaseGeometry(rtc);
    rtcReleaseDevice(device);
    float bounds[6];
    epGetGeometryBounds(g, bounds);
    assert_true(bounds[2] <= 7 && bounds[2] > 6.99f && bounds[5] >= 7);

    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, flat, float3), EP_OK);
    refuses(g, epRefitGeometry(g), EP_INVALID, "epCommitGeometry");
    epReleaseGeometry(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_committed), cmocka_unit_test(other_points),
        cmocka_unit_test(animation),    cmocka_unit_test(every_allocation_fails_once),
        cmocka_unit_test(wrong_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
