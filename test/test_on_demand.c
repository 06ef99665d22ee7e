/* test_on_demand.c - do patches that are cut when rays meet them give the same bits as those that were cut before?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <fenv.h>
#include <stdlib.h>
#include <string.h>

static const unsigned widths[] = {1, 4, 8, 16};

/* A scene that shows a geometry: as it is, or as an instance; with a mask and a filter. */
typedef struct view {
    RTCDevice device;
    RTCScene scene, outer;
} view;

/* Refuses hits by their place, which is the same in every order of candidates. */
static void refuse(const struct RTCFilterFunctionNArguments *args)
{
    const float *hit = (const float *)args->hit;
    for (unsigned i = 0; i < args->N; ++i)
        if (args->valid[i] == -1 && (int)(1024 * (hit[3 * args->N + i] + hit[4 * args->N + i])) % 2) args->valid[i] = 0;
}

typedef enum look { PLAIN, FILTERED, INSTANCED, MASKED, LOOKS } look;

static view new_view(EPGeometry g, RTCDevice device, look how)
{
    view v = {.device = device, .scene = rtcNewScene(device)};
    RTCGeometry rtc = epNewRTCGeometry(g, device);
    CHECK(rtc, "%s", epGetGeometryMessage(g));
    if (how == FILTERED) {
        rtcSetGeometryIntersectFilterFunction(rtc, refuse);
        rtcSetGeometryOccludedFilterFunction(rtc, refuse);
    }
    if (how == MASKED) rtcSetGeometryMask(rtc, 2);
    rtcCommitGeometry(rtc);
    rtcAttachGeometryByID(v.scene, rtc, 5);
    rtcReleaseGeometry(rtc);
    rtcCommitScene(v.scene);
    v.outer = v.scene;
    if (how != INSTANCED) return v;
    static const float m[12] = {0.9f, 0.1f, 0, -0.2f, 1.1f, 0, 0, 0.3f, 1, 0.1f, 0, 0};
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, v.scene);
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcCommitGeometry(instance);
    v.outer = rtcNewScene(device);
    rtcAttachGeometryByID(v.outer, instance, 9);
    rtcReleaseGeometry(instance);
    rtcCommitScene(v.outer);
    return v;
}

static void free_view(view *v)
{
    if (v->outer != v->scene) rtcReleaseScene(v->outer);
    rtcReleaseScene(v->scene);
}

/* Packet k of a series: all kinds of rays, some lanes off, some short rays, some that a mask hides. */
static void make_packet(const oracle *o, uint64_t seed, uint64_t k, unsigned n, test_packet *p)
{
    rng r = rng_split(seed, 0, k);
    memset(p, 0, sizeof *p);
    for (unsigned i = 0; i < n; ++i) {
        float org[3], dir[3];
        aim(o, (aim_kind)rng_below(&r, AIM_KINDS), &r, org, dir);
        set_ray(p, n, i, org, dir, 0, rng_below(&r, 8) ? INFINITY : (float)rng_scale(&r, 1e-2, 10));
        const unsigned mask = 1 + rng_below(&r, 3);
        memcpy(&p->f[9 * n + i], &mask, sizeof mask);
        if (n > 1 && !rng_below(&r, 4)) p->valid[i] = 0;
    }
}

static void same_packets(const test_packet *a, const test_packet *b, uint64_t k, unsigned n)
{
    if (memcmp(a->f, b->f, sizeof a->f) == 0) return;
    for (unsigned i = 0; i < n; ++i)
        for (unsigned f = 0; f < EP_RTC_RAYHIT_FIELDS; ++f)
            CHECK(!memcmp(&a->f[f * n + i], &b->f[f * n + i], 4), "packet %d of %u, lane %u, field %u: %a, not %a",
                  (int)k, n, i, f, a->f[f * n + i], b->f[f * n + i]);
}

/* Packets through both scenes, of all widths, for hits and for occlusion. */
static void compare(const oracle *o, const view *want, const view *got, uint64_t packets)
{
    unsigned long hits = 0;
    for (uint64_t k = 0; k < packets; ++k) {
        const unsigned n = widths[k % 4];
        test_packet a, b;
        make_packet(o, 41, k, n, &a);
        b = a;
        if (k / 4 % 3) {
            ep_rtc_intersect(want->outer, n, a.valid, a.f, k / 12 % 2);
            ep_rtc_intersect(got->outer, n, b.valid, b.f, k / 12 % 2);
            for (unsigned i = 0; i < n; ++i) hits += get_id(&a, n, HIT_GEOM, i) == 5;
        } else {
            ep_rtc_occluded(want->outer, n, a.valid, a.f, false);
            ep_rtc_occluded(got->outer, n, b.valid, b.f, false);
        }
        same_packets(&a, &b, k, n);
    }
    assert_true(hits > packets / 2);
}

static EPBuildSettings on_demand(void)
{
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.onDemand = 1;
    return settings;
}

static EPRegion disc(void)
{
    EPRegion region = epNewRegion();
    assert_int_equal(epAddRegionCircle(region, (const double[6]){0.31, 0.1, 0, 0.23, 0.4, 0.3}), EP_OK);
    return region;
}

/* Every seventh patch of a model is trimmed. */
static EPGeometry geometry_of(const test_patch *patches, size_t count, bool demand)
{
    const EPBuildSettings settings = demand ? on_demand() : epDefaultBuildSettings();
    EPGeometry g = new_geometry(patches, count, &settings);
    EPRegion region = disc();
    for (uint32_t i = 0; i < count; i += 7) assert_int_equal(epSetPatchTrim(g, i, 1, region), EP_OK);
    epReleaseRegion(region);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    return g;
}

static void same_bits(const char *model)
{
    size_t count;
    test_patch *patches = read_model(model, &count);
    oracle *o = new_oracle(patches, count);
    RTCDevice device = rtcNewDevice("threads=1");
    EPGeometry all = geometry_of(patches, count, false);
    for (look how = PLAIN; how < LOOKS; ++how) {
        EPGeometry some = geometry_of(patches, count, true);
        view want = new_view(all, device, how), got = new_view(some, device, how);
        compare(o, &want, &got, 6000 / TEST_STEP);
        free_view(&want);
        free_view(&got);
        epReleaseGeometry(some);
    }
    epReleaseGeometry(all);
    rtcReleaseDevice(device);
    oracle_free(o);
    free(patches);
}

static void models(void **state)
{
    (void)state;
    same_bits("teapot.bpt");
    same_bits("sphere_triangles.json");
    same_bits("knot.json");
}

enum { PATCHES = 30 };

static void random_patches(uint64_t seed, test_patch p[PATCHES])
{
    for (uint64_t k = 0; k < PATCHES; ++k) {
        rng r = rng_split(seed, 0, k);
        random_patch(&r, (patch_style)(k % STYLES), k % 2, (patch_limits){5, k % 3 ? 1 : 3}, &p[k]);
        move_patch(&p[k], 1, (const double[3]){0.3 * (double)(k % 6), 0.3 * (double)(k / 6), 0});
    }
}

/* Poles, cusps and folds; patches that overlap. */
static void degenerate_patches(void **state)
{
    (void)state;
    test_patch p[PATCHES];
    random_patches(42, p);
    oracle *o = new_oracle(p, PATCHES);
    RTCDevice device = rtcNewDevice("threads=1");
    EPGeometry all = geometry_of(p, PATCHES, false), some = geometry_of(p, PATCHES, true);
    view want = new_view(all, device, PLAIN), got = new_view(some, device, PLAIN);
    compare(o, &want, &got, 4000 / TEST_STEP);
    free_view(&want);
    free_view(&got);
    epReleaseGeometry(all);
    epReleaseGeometry(some);
    rtcReleaseDevice(device);
    oracle_free(o);
}

#if EP_EMBREE == 3
/* The filter of the query, which sees the query's context. */
static ep_rtc_context *query;
static void refuse_in_query(const struct RTCFilterFunctionNArguments *args)
{
    assert_ptr_equal(args->context, query);
    refuse(args);
}

static void query_filter(void **state)
{
    (void)state;
    test_patch p[PATCHES];
    random_patches(43, p);
    oracle *o = new_oracle(p, PATCHES);
    RTCDevice device = rtcNewDevice("threads=1");
    EPGeometry all = geometry_of(p, PATCHES, false), some = geometry_of(p, PATCHES, true);
    view v[2] = {new_view(all, device, PLAIN), new_view(some, device, PLAIN)};
    for (int i = 0; i < 2; ++i) {
        rtcSetSceneFlags(v[i].scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
        rtcCommitScene(v[i].scene);
    }
    for (uint64_t k = 0; k < 600 / TEST_STEP; ++k) {
        const unsigned n = widths[k % 4];
        test_packet packet[2];
        make_packet(o, 44, k, n, &packet[0]);
        packet[1] = packet[0];
        for (int i = 0; i < 2; ++i) {
            ep_rtc_context context;
            ep_rtc_init_context(&context);
            context.filter = refuse_in_query;
            query = &context;
            if (k / 4 % 2) ep_rtc_intersect_in(&context, v[i].scene, n, packet[i].valid, packet[i].f, false);
            else ep_rtc_occluded_in(&context, v[i].scene, n, packet[i].valid, packet[i].f, false);
        }
        same_packets(&packet[0], &packet[1], k, n);
    }
    for (int i = 0; i < 2; ++i) free_view(&v[i]);
    epReleaseGeometry(all);
    epReleaseGeometry(some);
    rtcReleaseDevice(device);
    oracle_free(o);
}
#endif

/* Threads that meet the same patches of a fresh geometry at the same time. */
static void threads_race(void **state)
{
    (void)state;
    enum { RAYS = 400 };
    size_t count;
    test_patch *p = read_model("teapot.bpt", &count);
    oracle *o = new_oracle(p, count);
    RTCDevice device = rtcNewDevice("threads=2");
    EPGeometry all = geometry_of(p, count, false);
    view reference = new_view(all, device, PLAIN);
    float org[RAYS][3], dir[RAYS][3];
    judge_answer want[RAYS];
    for (uint64_t k = 0; k < RAYS; ++k) {
        rng r = rng_split(46, 0, k);
        aim(o, k % 2 ? AIM_AT : AIM_INSIDE, &r, org[k], dir[k]);
        want[k] = trace_one(reference.scene, org[k], dir[k], 0, INFINITY);
    }
    size_t different = 0;
    for (int round = 0; round < (TEST_STEP > 1 ? 3 : 20); ++round) {
        EPGeometry g = geometry_of(p, count, true);
        view v = new_view(g, device, PLAIN);
        EPStatistics before, after;
        epGetGeometryStatistics(g, &before);
#pragma omp parallel num_threads(8) reduction(+ : different)
        for (size_t k = 0; k < RAYS; ++k) {
            const judge_answer got = trace_one(v.scene, org[k], dir[k], 0, INFINITY);
            different += !same_answer(&got, &want[k]);
        }
        epGetGeometryStatistics(g, &after);
        assert_true(before.leaves == 0 && after.leaves > 0 && after.leaves <= all->hierarchy.leaf_count);
        free_view(&v);
        epReleaseGeometry(g);
    }
    assert_int_equal(different, 0);
    free_view(&reference);
    epReleaseGeometry(all);
    rtcReleaseDevice(device);
    oracle_free(o);
    free(p);
}

/* The leaves are those of a commit, to the bit, whatever the rounding mode of the thread that meets the patch. */
static void same_leaves(void **state)
{
    (void)state;
    size_t count;
    test_patch *patches = read_model("teapot.bpt", &count);
    EPGeometry all = geometry_of(patches, count, false), some = geometry_of(patches, count, true);
    RTCDevice device = rtcNewDevice("threads=1");
    view v = new_view(some, device, PLAIN);
    oracle *o = new_oracle(patches, count);
    fesetround(FE_UPWARD);
    for (uint64_t k = 0; k < 2000; ++k) {
        test_packet p;
        make_packet(o, 47, k, 16, &p);
        ep_rtc_intersect(v.scene, 16, p.valid, p.f, false);
    }
    assert_int_equal(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
    size_t built = 0;
    for (uint32_t i = 0, at = 0; i < count; ++i) {
        const ep_built *b = ep_demand_get(some->demands, i);
        size_t leaves = 0;
        while (at + leaves < all->hierarchy.leaf_count && all->hierarchy.leaves[at + leaves].patch == i) ++leaves;
        for (size_t k = 0; b && k < leaves; ++k) {
            ep_leaf x = b->hierarchy.leaves[k], y = all->hierarchy.leaves[at + k];
            x.net = y.net, x.trim = y.trim;
            assert_memory_equal(&x, &y, sizeof x);
        }
        assert_true(!b || b->hierarchy.leaf_count == leaves);
        assert_true(!b || b->error == all->hierarchy.patches[i].error);
        built += b != NULL;
        at += (uint32_t)leaves;
    }
    assert_int_equal(built, count);
    EPStatistics want, got;
    epGetGeometryStatistics(all, &want);
    epGetGeometryStatistics(some, &got);
    assert_int_equal(got.leaves, want.leaves);
    assert_int_equal(got.uncertified, want.uncertified);
    assert_int_equal(got.maximumDepth, want.maximumDepth);
    assert_true(fabs(got.averageDepth - want.averageDepth) < 1e-9);
    assert_true(fabs(got.averageThickness - want.averageThickness) < 1e-9);
    assert_true(got.bytes > want.bytes && got.bytes < want.bytes + count * 2048);
    free_view(&v);
    epReleaseGeometry(all);
    epReleaseGeometry(some);
    rtcReleaseDevice(device);
    oracle_free(o);
    free(patches);
}

static bool no_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    return bytes <= 0 || !*(const bool *)user;
}

/* When there is no memory for leaves, ours (the n-th allocation) or Embree's, hits are found all the same. */
static void no_memory_for_leaves(void **state)
{
    (void)state;
    size_t count;
    test_patch *patches = read_model("sphere_triangles.json", &count);
    oracle *o = new_oracle(patches, count);
    bool refused = false;
    RTCDevice device = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, no_memory, &refused);
    EPGeometry all = geometry_of(patches, count, false);
    view want = new_view(all, device, PLAIN);
    for (int embree = 0; embree < 2; ++embree)
        for (uint64_t k = 0; k < 120; ++k) {
            EPGeometry some = geometry_of(patches, count, true);
            view got = new_view(some, device, PLAIN);
            rng r = rng_split(48, 0, k);
            float org[3], dir[3];
            aim(o, AIM_INSIDE, &r, org, dir);
            const judge_answer a = trace_one(want.scene, org, dir, 0, INFINITY);
            EPStatistics s;
            refused = embree;
            if (!embree) ep_alloc_fail_at((long)(k / 3));
            const judge_answer b = trace_one(got.scene, org, dir, 0, INFINITY);
            ep_alloc_fail_at(-1);
            refused = false;
            CHECK((a.t < INFINITY) == (b.t < INFINITY) && (!(a.t < INFINITY) || fabs(a.t - b.t) < 1e-5 * a.t),
                  "%s: t %.9g, not %.9g", ray_text(org, dir), b.t, a.t);
            epGetGeometryStatistics(some, &s);
            assert_true(!embree || s.leaves == 0);
            const judge_answer c = trace_one(got.scene, org, dir, 0, INFINITY);
            assert_true(same_answer(&a, &c));
            free_view(&got);
            epReleaseGeometry(some);
        }
    free_view(&want);
    epReleaseGeometry(all);
    rtcReleaseDevice(device);
    oracle_free(o);
    free(patches);
}

/* Refitted on demand, patches are built anew; two devices have scenes of their own, which outlive them. */
static void refit_and_devices(void **state)
{
    (void)state;
    test_patch p[PATCHES];
    random_patches(49, p);
    oracle *o = new_oracle(p, PATCHES);
    EPGeometry all = geometry_of(p, PATCHES, false), some = geometry_of(p, PATCHES, true);
    RTCDevice device[2] = {rtcNewDevice("threads=1"), rtcNewDevice("threads=1")};
    view want = new_view(all, device[0], PLAIN),
         got[2] = {new_view(some, device[0], PLAIN), new_view(some, device[1], PLAIN)};
    for (int i = 0; i < 2; ++i) compare(o, &want, &got[i], 400);
    for (int i = 0; i < PATCHES; ++i) {
        move_patch(&p[i], 1.5, (const double[3]){0.1, 0.2, 0.3});
        for (int g = 0; g < 2; ++g)
            assert_int_equal(
                epSetPatchPoints(g ? some : all, (uint32_t)i, 1, EP_FORMAT_DOUBLE4, p[i].points, sizeof p[i].points[0]),
                EP_OK);
    }
    assert_int_equal(epCommitGeometry(all), EP_OK);
    free_view(&want);
    want = new_view(all, device[0], PLAIN);
    assert_int_equal(epRefitGeometry(some), EP_OK);
    oracle_free(o);
    o = new_oracle(p, PATCHES);
    for (int i = 0; i < 2; ++i) {
        rtcCommitGeometry(rtcGetGeometry(got[i].scene, 5));
        rtcCommitScene(got[i].scene);
        compare(o, &want, &got[i], 400);
        free_view(&got[i]);
    }
    free_view(&want);
    for (int i = 0; i < 2; ++i) rtcReleaseDevice(device[i]);
    oracle_free(o);
    epReleaseGeometry(some);
    epReleaseGeometry(all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(models),
        cmocka_unit_test(degenerate_patches),
#if EP_EMBREE == 3
        cmocka_unit_test(query_filter),
#endif
        cmocka_unit_test(threads_race),
        cmocka_unit_test(same_leaves),
        cmocka_unit_test(no_memory_for_leaves),
        cmocka_unit_test(refit_and_devices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
