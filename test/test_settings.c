/* test_settings.c - does the public object take what its header allows, refuse the rest, and say why?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <string.h>

static const float square[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1};
static const size_t float3 = 3 * sizeof(float);

static void refuses(EPGeometry g, EPStatus got, EPStatus want, const char *word)
{
    CHECK(got == want, "%d, not %d: %s", got, want, epGetGeometryMessage(g));
    CHECK(strstr(epGetGeometryMessage(g), word), "'%s' does not say '%s'", epGetGeometryMessage(g), word);
}

static void build_settings(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    const EPBuildSettings usual = epDefaultBuildSettings();
    EPBuildSettings s = usual;
    assert_int_equal(s.size, sizeof s);
    assert_int_equal(epSetGeometryBuildSettings(g, &s), EP_OK);
    static const float bad_thickness[] = {0, -1, 1.5f, NAN, INFINITY};
    for (size_t i = 0; i < EP_ARRAY_LEN(bad_thickness); ++i) {
        s = usual;
        s.thickness = bad_thickness[i];
        refuses(g, epSetGeometryBuildSettings(g, &s), EP_INVALID, "thickness");
    }
    static const float bad_distance[] = {-1, NAN, INFINITY};
    for (size_t i = 0; i < EP_ARRAY_LEN(bad_distance); ++i) {
        s = usual;
        s.rayDistance = bad_distance[i];
        refuses(g, epSetGeometryBuildSettings(g, &s), EP_INVALID, "distance");
    }
    s = usual;
    s.maxDepth = 41;
    refuses(g, epSetGeometryBuildSettings(g, &s), EP_INVALID, "41");
    s = usual;
    s.trimSplit = (EPTrimSplit)4;
    refuses(g, epSetGeometryBuildSettings(g, &s), EP_INVALID, "split");
    s = usual;
    s.isa = "abacus";
    refuses(g, epSetGeometryBuildSettings(g, &s), EP_UNSUPPORTED, "abacus");
    s = usual;
    s.size = 0;
    refuses(g, epSetGeometryBuildSettings(g, &s), EP_INVALID, "epDefaultBuildSettings");
    refuses(g, epSetGeometryBuildSettings(g, NULL), EP_INVALID, "epDefaultBuildSettings");
    for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
        EPStatistics t;
        s = usual;
        s.isa = *isa;
        assert_int_equal(epSetGeometryBuildSettings(g, &s), EP_OK);
        assert_int_equal(epCommitGeometry(g), EP_OK);
        epGetGeometryStatistics(g, &t);
        assert_string_equal(t.isa, *isa);
    }
    epReleaseGeometry(g);
}

static void patches(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    assert_string_equal(epGetGeometryMessage(g), "");
    refuses(g, epAddBezierPatches(g, 0, 1, 1, EP_FORMAT_FLOAT3, square, float3), EP_INVALID, "degree 0");
    refuses(g, epAddBezierPatches(g, 1, 26, 1, EP_FORMAT_FLOAT3, square, float3), EP_INVALID, "degree 26");
    refuses(g, epAddBezierTriangles(g, ~0u, 1, EP_FORMAT_FLOAT3, square, float3), EP_INVALID, "degree");
    refuses(g, epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, square, float3 - 1), EP_INVALID, "stride");
    refuses(g, epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_DOUBLE4, square, float3), EP_INVALID, "stride");
    refuses(g, epAddBezierPatches(g, 1, 1, 1, (EPFormat)17, square, float3), EP_INVALID, "format");
    refuses(g, epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, NULL, float3), EP_INVALID, "points");
    refuses(g, epAddBezierPatches(g, 1, 1, SIZE_MAX, EP_FORMAT_FLOAT3, square, float3), EP_INVALID, "too many");
    assert_int_equal(epAddBezierPatches(g, 1, 1, 0, EP_FORMAT_FLOAT3, NULL, float3), EP_OK);

    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
    for (size_t i = 0; i < EP_ARRAY_LEN(bad); ++i)
        for (int c = 0; c < 3; ++c) {
            double points[24] = {0};
            points[12 + 3 + c] = bad[i];
            refuses(g, epAddBezierPatches(g, 1, 1, 2, EP_FORMAT_DOUBLE3, points, 3 * sizeof(double)), EP_BAD_DATA,
                    "patch 1, point 1");
        }
    static const double bad_weight[] = {0, -1, NAN, INFINITY, 1e-300};
    for (size_t i = 0; i < EP_ARRAY_LEN(bad_weight); ++i) {
        double points[16] = {0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1, bad_weight[i]};
        refuses(g, epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_DOUBLE4, points, 4 * sizeof(double)), EP_BAD_DATA,
                "weight");
    }
    EPStatistics t;
    epGetGeometryStatistics(g, &t);
    assert_int_equal(t.patches, 0);
    epReleaseGeometry(g);
}

static void evaluation(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    double p[3];
    assert_int_equal(epEvaluate(g, 0, 0, 0, p, NULL, NULL, NULL), EP_INVALID);
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, square, float3), EP_OK);
    assert_int_equal(epEvaluate(g, 0, 0.5, 0.5, p, NULL, NULL, NULL), EP_OK);
    assert_true(p[0] == 0.5 && p[1] == 0.5 && p[2] == 0.25);
    assert_int_equal(epEvaluate(g, 0, 2, 3, p, NULL, NULL, NULL), EP_OK);
    assert_true(p[0] == 2 && p[1] == 3 && p[2] == 6);
    assert_int_equal(epEvaluate(g, 1, 0, 0, p, NULL, NULL, NULL), EP_INVALID);
    epReleaseGeometry(g);
}

static void empty(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    RTCDevice device = rtcNewDevice("threads=1");
    assert_null(epNewRTCGeometry(g, device));
    assert_true(strstr(epGetGeometryMessage(g), "epCommitGeometry") != NULL);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    float b[6];
    epGetGeometryBounds(g, b);
    assert_true(b[0] > b[3]);
    RTCGeometry rtc = epNewRTCGeometry(g, device);
    assert_non_null(rtc);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, rtc);
    rtcReleaseGeometry(rtc);
    rtcCommitScene(scene);
    const float org[3] = {0, 0, 0}, dir[3] = {0, 0, 1};
    assert_true(trace_one(scene, org, dir, 0, INFINITY).t == INFINITY);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    epReleaseGeometry(g);
}

/* Patches added after a commit count from the next one on. */
static void commit_again(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    EPStatistics t;
    float b[6];
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, square, float3), EP_OK);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    const size_t leaves = g->hierarchy.leaf_count;
    static const float above[12] = {0, 0, 5, 1, 0, 5, 0, 1, 5, 1, 1, 6};
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, above, float3), EP_OK);
    RTCDevice device = rtcNewDevice("threads=1");
    assert_null(epNewRTCGeometry(g, device));
    rtcReleaseDevice(device);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    epGetGeometryStatistics(g, &t);
    assert_true(t.patches == 2 && t.leaves == 2 * leaves);
    epGetGeometryBounds(g, b);
    assert_true(b[2] <= 0 && b[5] >= 6);
    epReleaseGeometry(g);
}

static void references(void **state)
{
    (void)state;
    EPGeometry g = epNewGeometry();
    epRetainGeometry(g);
    epReleaseGeometry(g);
    assert_int_equal(epAddBezierPatches(g, 1, 1, 1, EP_FORMAT_FLOAT3, square, float3), EP_OK);
    epReleaseGeometry(g);
    epReleaseGeometry(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(build_settings), cmocka_unit_test(patches),      cmocka_unit_test(evaluation),
        cmocka_unit_test(empty),          cmocka_unit_test(commit_again), cmocka_unit_test(references),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
