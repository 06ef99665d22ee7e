/* test_rtc.c - does it behave like one of Embree's own geometries?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

#include <limits.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

static const unsigned widths[] = {1, 4, 8, 16};

/* A bed of three-layered folds: z over the unit square is hit three times by most rays along y. */
static test_patch fold(void)
{
    static const double y[4] = {0, 1.5, -0.5, 1};
    test_patch p = {.shape = {false, 1, 3}};
    for (unsigned j = 0; j < 4; ++j)
        for (unsigned i = 0; i < 2; ++i) {
            double *to = p.points[net_index(p.shape, i, j)];
            to[0] = i, to[1] = y[j], to[2] = j / 3.0, to[3] = 1;
        }
    return p;
}

/* The saddle z = x y over the unit square, moved. */
static test_patch saddle(double x, double y, double z)
{
    test_patch p = {.shape = {false, 1, 1}};
    for (unsigned k = 0; k < 4; ++k) {
        double *to = p.points[k];
        to[0] = x + (k & 1), to[1] = y + (k >> 1), to[2] = z + (k == 3), to[3] = 1;
    }
    return p;
}

/* The teapot, since everybody has one. */
static test_scene teapot(oracle **o)
{
    size_t count;
    test_patch *patches = read_model("teapot.bpt", &count);
    test_scene s = new_scene(patches, count, NULL);
    if (o) *o = new_oracle(patches, count);
    free(patches);
    return s;
}

/* All widths give the bits of width 1; lanes that are off come back untouched. */
static void widths_agree(void **state)
{
    (void)state;
    oracle *o;
    test_scene s = teapot(&o);
    for (uint64_t k = 0; k < 3000; ++k) {
        rng r = rng_split(1, 0, k);
        const unsigned n = widths[k % 4];
        test_packet p, before;
        float org[16][3], dir[16][3];
        memset(&p, 0, sizeof p);
        for (unsigned i = 0; i < n; ++i) {
            aim(o, (aim_kind)rng_below(&r, AIM_KINDS), &r, org[i], dir[i]);
            set_ray(&p, n, i, org[i], dir[i], 0, INFINITY);
            if (n > 1 && rng_below(&r, 3) == 0) p.valid[i] = 0;
        }
        before = p;
        ep_rtc_intersect(s.scene, n, p.valid, p.f, k / 4 % 2);
        for (unsigned i = 0; i < n; ++i) {
            if (!before.valid[i]) {
                for (unsigned f = 0; f < EP_RAY_FIELDS + 8; ++f)
                    CHECK(!memcmp(&p.f[f * n + i], &before.f[f * n + i], 4), "idle lane %u of %u, field %u", i, n, f);
                continue;
            }
            const judge_answer one = trace_one(s.scene, org[i], dir[i], 0, INFINITY), many = answer_of(&p, n, i);
            CHECK(same_answer(&one, &many), "width %u: %s: patch %d t %a u %a v %a, alone patch %d t %a u %a v %a", n,
                  ray_text(org[i], dir[i]), (int)many.patch, many.t, many.u, many.v, (int)one.patch, one.t, one.u,
                  one.v);
        }
    }
    free_scene(&s);
    oracle_free(o);
}

static void occluded_agrees(void **state)
{
    (void)state;
    oracle *o;
    test_scene s = teapot(&o);
    for (uint64_t k = 0; k < 4000; ++k) {
        rng r = rng_split(2, 0, k);
        const unsigned n = widths[k % 4];
        test_packet p;
        float org[16][3], dir[16][3], tfar[16];
        for (unsigned i = 0; i < n; ++i) {
            aim(o, (aim_kind)rng_below(&r, AIM_KINDS), &r, org[i], dir[i]);
            tfar[i] = rng_below(&r, 2) ? INFINITY : (float)rng_scale(&r, 1e-2, 10);
            set_ray(&p, n, i, org[i], dir[i], 0, tfar[i]);
        }
        ep_rtc_occluded(s.scene, n, p.valid, p.f, false);
        for (unsigned i = 0; i < n; ++i) {
            const bool hit = trace_one(s.scene, org[i], dir[i], 0, tfar[i]).t < INFINITY;
            const float after = get_float(&p, n, EP_RAY_TFAR, i);
            CHECK(hit ? after == -INFINITY : after == tfar[i], "width %u: %s: hit %d, tfar %g", n,
                  ray_text(org[i], dir[i]), hit, after);
        }
    }
    free_scene(&s);
    oracle_free(o);
}

/* What the filter below does and sees. */
static struct {
    int refuse; /* so many candidates of each ray */
    int asked[EP_PACKET];
    float t[EP_PACKET][16];
    float tfar_before;
} filter_log;

static void filter(const struct RTCFilterFunctionNArguments *args)
{
    const float *ray = (const float *)args->ray, *hit = (const float *)args->hit;
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        unsigned id, prim;
        memcpy(&id, &ray[10 * args->N + i], sizeof id);
        memcpy(&prim, &hit[5 * args->N + i], sizeof prim);
        assert_true(id < EP_PACKET && prim == 0);
        const float t = ray[EP_RAY_TFAR * args->N + i];
        if (filter_log.asked[id] < 16) filter_log.t[id][filter_log.asked[id]] = t;
        if (filter_log.asked[id]++ < filter_log.refuse) args->valid[i] = 0;
    }
}

static test_scene filtered(const test_patch *p, unsigned max_depth)
{
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = max_depth;
    settings.thickness = 1;
    test_scene s = {.device = rtcNewDevice("threads=1"), .geometry = new_geometry(p, 1, &settings)};
    s.scene = rtcNewScene(s.device);
    RTCGeometry g = epNewRTCGeometry(s.geometry, s.device);
    rtcSetGeometryIntersectFilterFunction(g, filter);
    rtcSetGeometryOccludedFilterFunction(g, filter);
    rtcAttachGeometry(s.scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(s.scene);
    return s;
}

/* Refusing the first k roots gives root k, or a miss with tfar as it was; within one leaf the roots come nearest first.
 */
static void filters(void **state)
{
    (void)state;
    const test_patch p = fold();
    oracle *o = new_oracle(&p, 1);
    for (unsigned depth = 0; depth < 8; depth += 7) {
        test_scene s = filtered(&p, depth);
        for (uint64_t k = 0; k < 200; ++k) {
            rng r = rng_split(3, 0, k);
            const unsigned n = widths[k % 4];
            float org[16][3], dir[16][3];
            oracle_root roots[16][ORACLE_ROOTS];
            size_t count[16];
            for (unsigned i = 0; i < n; ++i) {
                org[i][0] = (float)rng_in(&r, 0.1, 0.9), org[i][1] = (float)rng_in(&r, 0.46, 0.54), org[i][2] = -1;
                dir[i][0] = (float)rng_in(&r, -0.02, 0.02), dir[i][1] = (float)rng_in(&r, -0.02, 0.02), dir[i][2] = 1;
                const double od[3] = {org[i][0], org[i][1], org[i][2]}, dd[3] = {dir[i][0], dir[i][1], dir[i][2]};
                count[i] = oracle_intersect(o, od, dd, 0, INFINITY, roots[i]);
                assert_int_equal(count[i], 3);
            }
            for (int refuse = 0; refuse < 5; ++refuse)
                for (int occluded = 0; occluded < 2; ++occluded) {
                    test_packet packet;
                    memset(&filter_log, 0, sizeof filter_log);
                    filter_log.refuse = refuse;
                    for (unsigned i = 0; i < n; ++i) set_ray(&packet, n, i, org[i], dir[i], 0, 5);
                    if (occluded) ep_rtc_occluded(s.scene, n, packet.valid, packet.f, false);
                    else ep_rtc_intersect(s.scene, n, packet.valid, packet.f, false);
                    for (unsigned i = 0; i < n; ++i) {
                        const char *ray = ray_text(org[i], dir[i]);
                        const float t = get_float(&packet, n, EP_RAY_TFAR, i);
                        const int asked = filter_log.asked[i];
                        CHECK(asked >= 1 && asked <= 3, "%s: asked %d times", ray, asked);
                        if (refuse >= 3) CHECK(asked == 3 && t == 5, "%s: asked %d times, tfar %g", ray, asked, t);
                        else if (occluded) CHECK(t == -INFINITY, "%s: tfar %g", ray, t);
                        if (depth == 0) {
                            for (int a = 1; a < asked; ++a)
                                CHECK(filter_log.t[i][a - 1] < filter_log.t[i][a], "%s: root %d before root %d", ray, a,
                                      a - 1);
                            if (refuse < 3 && !occluded)
                                CHECK(fabs(t - roots[i][refuse].t_low) < 2e-5 * t, "%s: root %d is %.9g, not %.9g", ray,
                                      refuse, t, roots[i][refuse].t_low);
                        }
                    }
                }
        }
        free_scene(&s);
    }
    oracle_free(o);
}

/* How often a filter that refuses everything is asked. */
static int count_roots(RTCScene scene, bool occluded, const float org[3], const float dir[3])
{
    test_packet packet;
    memset(&filter_log, 0, sizeof filter_log);
    filter_log.refuse = INT_MAX;
    set_ray(&packet, 1, 0, org, dir, 0, INFINITY);
    if (occluded) ep_rtc_occluded(scene, 1, packet.valid, packet.f, false);
    else ep_rtc_intersect(scene, 1, packet.valid, packet.f, false);
    return filter_log.asked[0];
}

/* Of nearly tangent rays, whose two roots are close together, a filter is asked about both, whatever the query. */
static void filters_of_close_roots(void **state)
{
    (void)state;
    int twice = 0;
    for (uint64_t k = 0; k < 60; ++k) {
        rng r = rng_split(12, 0, k);
        test_patch p;
        random_patch(&r, STYLE_WILD, k % 2, (patch_limits){7, 1}, &p);
        test_scene s = filtered(&p, 7);
        for (int i = 0; i < 1500; ++i) {
            double u = rng_in(&r, 0.05, 0.95), v = rng_in(&r, 0.05, 0.95), x[3], xu[3], xv[3];
            if (p.shape.triangle && u + v > 0.95) u = 0.5 * u, v = 0.4 * v;
            evaluate_patch(&p, u, v, x, xu, xv);
            const double angle = rng_in(&r, 0, 6.283185307179586), a = cos(angle), b = sin(angle);
            const double away = rng_scale(&r, 1e-8, 1e-2) * (i % 2 ? 1 : -1);
            float org[3], dir[3];
            for (int c = 0; c < 3; ++c) {
                const int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
                const double along = a * xu[c] + b * xv[c], n = xu[c1] * xv[c2] - xu[c2] * xv[c1];
                dir[c] = (float)along;
                org[c] = (float)(x[c] + away * n - 0.5 * along);
            }
            const int roots = count_roots(s.scene, false, org, dir), shadows = count_roots(s.scene, true, org, dir);
            CHECK(roots == shadows, "patch %d: %s: %d roots, and %d of a shadow ray", (int)k, ray_text(org, dir), roots,
                  shadows);
            twice += roots > 1;
        }
        free_scene(&s);
    }
    assert_true(twice > 10000);
}

#if EP_EMBREE == 3
/* A filter of the query itself. */
static void query_filters(void **state)
{
    (void)state;
    const test_patch p = fold();
    EPGeometry geometry = new_geometry(&p, 1, NULL);
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    RTCGeometry g = epNewRTCGeometry(geometry, device);
    rtcAttachGeometry(scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene);
    const float org[3] = {0.5f, 0.52f, -1}, dir[3] = {0, 0, 1};
    for (int refuse = 0; refuse < 4; ++refuse) {
        struct RTCIntersectContext context;
        test_packet packet;
        memset(&filter_log, 0, sizeof filter_log);
        filter_log.refuse = refuse;
        rtcInitIntersectContext(&context);
        context.filter = filter;
        set_ray(&packet, 1, 0, org, dir, 0, 5);
        rtcIntersect1(scene, &context, (struct RTCRayHit *)packet.f);
        const bool hit = get_id(&packet, 1, HIT_GEOM, 0) != RTC_INVALID_GEOMETRY_ID;
        CHECK(hit == (refuse < 3) && filter_log.asked[0] >= 1 && filter_log.asked[0] <= 3,
              "refuse %d: hit %d, asked %d", refuse, hit, filter_log.asked[0]);
    }
    rtcReleaseScene(scene);
    epReleaseGeometry(geometry);
    rtcReleaseDevice(device);
}
#endif

/* tnear and tfar are not part of the interval. */
static void strict_interval(void **state)
{
    (void)state;
    const test_patch p = saddle(0, 0, 0);
    test_scene s = new_scene(&p, 1, NULL);
    const float org[3] = {0.5f, 0.5f, -0.75f}, dir[3] = {0, 0, 1}; /* hits at t = 1 exactly */
    assert_true(trace_one(s.scene, org, dir, 0, INFINITY).t == 1);
    assert_true(trace_one(s.scene, org, dir, 1, INFINITY).t == INFINITY);
    assert_true(trace_one(s.scene, org, dir, 0, 1).t == INFINITY);
    assert_true(trace_one(s.scene, org, dir, nextafterf(1, 0), nextafterf(1, 2)).t == 1);
    assert_true(trace_one(s.scene, org, dir, 2, INFINITY).t == INFINITY);
    free_scene(&s);
}

/* The same for rays that subdivision answers: along the fold, seen nearly edge-on. */
static void interval_of_all_roots(void **state)
{
    (void)state;
    const test_patch p = fold();
    test_scene s = new_scene(&p, 1, NULL);
    const float org[3] = {0.5f, 0.52f, -1}, dir[3] = {0, 0, 1};
    float t = 0;
    for (int k = 0; k < 3; ++k) {
        const judge_answer a = trace_one(s.scene, org, dir, t, INFINITY);
        CHECK(a.t > t && a.t < INFINITY, "root %d: %g", k, a.t);
        assert_true(trace_one(s.scene, org, dir, t, (float)a.t).t == INFINITY);
        t = (float)a.t;
    }
    assert_true(trace_one(s.scene, org, dir, t, INFINITY).t == INFINITY);
    free_scene(&s);
}

/* An instance answers in its own space: as the transformed patch itself does, even when it is stretched. */
static void instances(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 40; ++k) {
        rng r = rng_split(5, 0, k);
        test_patch p, moved;
        random_patch(&r, STYLE_GENTLE, k % 2, (patch_limits){4, k % 3 ? 1 : 4}, &p);
        float m[12]; /* columns */
        for (int c = 0; c < 12; ++c) m[c] = (float)rng_in(&r, -1, 1) + (c < 9 && c % 4 == 0 ? 2.5f : 0);
        m[4] *= 5; /* stretched */
        moved = p;
        for (size_t i = 0; i < net_count(p.shape); ++i)
            for (int c = 0; c < 3; ++c) {
                moved.points[i][c] = m[9 + c];
                for (int a = 0; a < 3; ++a) moved.points[i][c] += m[3 * a + c] * p.points[i][a];
            }
        test_scene inner = new_scene(&p, 1, NULL);
        RTCScene outer = rtcNewScene(inner.device);
        RTCGeometry instance = rtcNewGeometry(inner.device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, inner.scene);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(outer, instance, 7);
        rtcReleaseGeometry(instance);
        rtcCommitScene(outer);
        oracle *o = new_oracle(&moved, 1);
        for (int i = 0; i < 100; ++i) {
            float org[3], dir[3];
            aim(o, i % 2 ? AIM_AT : AIM_INSIDE, &r, org, dir);
            const unsigned n = widths[i % 4];
            test_packet packet;
            for (unsigned lane = 0; lane < n; ++lane) set_ray(&packet, n, lane, org, dir, 0, INFINITY);
            ep_rtc_intersect(outer, n, packet.valid, packet.f, false);
            double od[3], dd[3];
            for (int c = 0; c < 3; ++c) od[c] = org[c], dd[c] = dir[c];
            oracle_root roots[ORACLE_ROOTS];
            const size_t count = oracle_intersect(o, od, dd, 0, INFINITY, roots);
            /* embree rounds the ray into the instance's space; keep away from tangents and borders */
            bool clear = true;
            for (size_t q = 0; q < count; ++q) clear = clear && roots[q].cosine > 0.05 && roots[q].border > 1e-3;
            const bool hit = get_id(&packet, n, HIT_GEOM, n - 1) != RTC_INVALID_GEOMETRY_ID;
            if (!clear) continue;
            if (count == 0) {
                /* near misses aside */
                continue;
            }
            CHECK(hit, "patch %d: %s missed", (int)k, ray_text(org, dir));
            const float t = get_float(&packet, n, EP_RAY_TFAR, n - 1);
            CHECK(fabs(t - roots[0].t_low) < 1e-4 * (t + 1), "patch %d: %s: t %.9g, not %.9g", (int)k,
                  ray_text(org, dir), t, roots[0].t_low);
            assert_int_equal(get_id(&packet, n, HIT_INST, n - 1), 7);
            assert_int_equal(get_id(&packet, n, HIT_PRIM, n - 1), 0);
        }
        oracle_free(o);
        rtcReleaseScene(outer);
        free_scene(&inner);
    }
}

static void masks(void **state)
{
    (void)state;
    const test_patch p = saddle(0, 0, 0);
    EPGeometry geometry = new_geometry(&p, 1, NULL);
    RTCDevice device = rtcNewDevice("threads=1");
    if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED)) {
        epReleaseGeometry(geometry);
        rtcReleaseDevice(device);
        skip();
    }
    RTCScene scene = rtcNewScene(device);
    RTCGeometry g = epNewRTCGeometry(geometry, device);
    rtcSetGeometryMask(g, 6);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene);
    const float org[3] = {0.5f, 0.5f, -1}, dir[3] = {0, 0, 1};
    for (unsigned mask = 1; mask < 16; ++mask)
        for (unsigned w = 0; w < 4; ++w) {
            const unsigned n = widths[w];
            test_packet packet;
            for (unsigned i = 0; i < n; ++i) {
                set_ray(&packet, n, i, org, dir, 0, INFINITY);
                memcpy(&packet.f[9 * n + i], &mask, sizeof mask);
            }
            ep_rtc_intersect(scene, n, packet.valid, packet.f, false);
            for (unsigned i = 0; i < n; ++i)
                assert_true((get_id(&packet, n, HIT_GEOM, i) != RTC_INVALID_GEOMETRY_ID) == !!(mask & 6));
        }
    rtcReleaseScene(scene);
    epReleaseGeometry(geometry);
    rtcReleaseDevice(device);
}

/* Several geometries in one scene keep their ids, and the nearest wins. */
static void ids(void **state)
{
    (void)state;
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    EPGeometry g[3];
    for (unsigned k = 0; k < 3; ++k) {
        const test_patch p[2] = {saddle(0, 0, 3 - k), saddle(1, 0, 3 - k)};
        g[k] = new_geometry(p, 2, NULL);
        RTCGeometry rtc = epNewRTCGeometry(g[k], device);
        rtcAttachGeometryByID(scene, rtc, 10 + k);
        rtcReleaseGeometry(rtc);
    }
    rtcCommitScene(scene);
    for (unsigned k = 0; k < 3; ++k)
        for (unsigned patch = 0; patch < 2; ++patch) {
            const float z = 3 - k + 0.25f, org[3] = {patch + 0.5f, 0.5f, z - 0.5f}, dir[3] = {0, 0, 1};
            test_packet packet;
            set_ray(&packet, 1, 0, org, dir, 0, INFINITY);
            ep_rtc_intersect(scene, 1, packet.valid, packet.f, false);
            assert_int_equal(get_id(&packet, 1, HIT_GEOM, 0), 10 + k);
            assert_int_equal(get_id(&packet, 1, HIT_PRIM, 0), patch);
        }
    rtcReleaseScene(scene);
    for (unsigned k = 0; k < 3; ++k) epReleaseGeometry(g[k]);
    rtcReleaseDevice(device);
}

static RTCGeometry instance_of(RTCDevice device, RTCScene scene)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, scene);
    rtcCommitGeometry(g);
    return g;
}

/* Of coinciding surfaces the one with the smallest ids is hit, in every width, whichever Embree visits first. */
static void coinciding(void **state)
{
    (void)state;
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene inner = rtcNewScene(device), outer = rtcNewScene(device);
    const unsigned geometry_ids[3] = {5, 3, 9}, instance_ids[2] = {4, 2};
    test_patch p;
    rng r = rng_split(12, 0, 0);
    random_patch(&r, STYLE_WILD, false, (patch_limits){4, 1}, &p);
    EPGeometry g[3];
    for (unsigned k = 0; k < 3; ++k) {
        const test_patch twice[2] = {p, p};
        EPBuildSettings settings = epDefaultBuildSettings();
        settings.thickness *= k == 1 ? 1 : 0.5f; /* leaves of other sizes, which find other bits */
        g[k] = new_geometry(twice, 2, &settings);
        RTCGeometry rtc = epNewRTCGeometry(g[k], device);
        rtcAttachGeometryByID(inner, rtc, geometry_ids[k]);
        rtcReleaseGeometry(rtc);
    }
    rtcCommitScene(inner);
    for (unsigned k = 0; k < 2; ++k) {
        RTCGeometry instance = instance_of(device, inner);
        rtcAttachGeometryByID(outer, instance, instance_ids[k]);
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(outer);
    oracle *o = new_oracle(&p, 1);
    for (unsigned k = 0; k < 400; ++k) {
        float org[16][3], dir[16][3];
        for (unsigned i = 0; i < 16; ++i) aim(o, AIM_AT, &r, org[i], dir[i]);
        unsigned found[4][16][5];
        for (unsigned w = 0; w < 4; ++w)
            for (unsigned first = 0; first < 16; first += widths[w]) {
                const unsigned n = widths[w];
                test_packet packet;
                for (unsigned i = 0; i < n; ++i) set_ray(&packet, n, i, org[first + i], dir[first + i], 0, INFINITY);
                ep_rtc_intersect(outer, n, packet.valid, packet.f, false);
                for (unsigned i = 0; i < n; ++i) {
                    const unsigned fields[5] = {HIT_INST, HIT_GEOM, HIT_PRIM, HIT_U, EP_RAY_TFAR};
                    for (unsigned f = 0; f < 5; ++f) found[w][first + i][f] = get_id(&packet, n, fields[f], i);
                }
            }
        for (unsigned i = 0; i < 16; ++i) {
            if (found[0][i][1] == RTC_INVALID_GEOMETRY_ID) continue;
            assert_int_equal(found[0][i][0], 2);
            assert_int_equal(found[0][i][2], 0);
            for (unsigned w = 1; w < 4; ++w) assert_memory_equal(found[w][i], found[0][i], sizeof found[0][i]);
        }
    }
    oracle_free(o);
    rtcReleaseScene(outer);
    rtcReleaseScene(inner);
    for (unsigned k = 0; k < 3; ++k) epReleaseGeometry(g[k]);
    rtcReleaseDevice(device);
}

/* Directions of no length or nearly none, and origins as far as Embree takes them; what it does not take, such as NaN,
 * is asked of the kernels themselves in test_kernels.c. */
static void extreme_rays(void **state)
{
    (void)state;
    test_scene s = teapot(NULL);
    const float org[3] = {0, 0, 10}, none[3] = {0, 0, 0}, down[3] = {0, 0, -1};
    assert_true(trace_one(s.scene, org, none, 0, INFINITY).t == INFINITY);
    assert_true(trace_one(s.scene, org, down, 0, INFINITY).t < INFINITY);
    for (unsigned field = 0; field < 6; ++field)
        for (int power = -140; power <= 60; power += 20)
            for (int sign = -1; sign <= 1; sign += 2) {
                float o[3] = {0, 0, 10}, d[3] = {0, 0.01f, -1};
                (field < 3 ? o : d)[field % 3] = sign * ldexpf(1, power);
                trace_one(s.scene, o, d, 0, INFINITY);
                for (int c = 0; power < 0 && c < 3; ++c) d[c] = ldexpf(d[c], power / 2);
                trace_one(s.scene, o, d, 0, INFINITY);
            }
    free_scene(&s);
}

/* Any number of threads may trace; each gets what one alone gets. */
static void threads(void **state)
{
    (void)state;
    enum { RAYS = 20000 };
    oracle *o;
    test_scene s = teapot(&o);
    float(*org)[3] = malloc(RAYS * sizeof *org), (*dir)[3] = malloc(RAYS * sizeof *dir);
    judge_answer *want = malloc(RAYS * sizeof *want);
    assert_true(org && dir && want);
    for (uint64_t k = 0; k < RAYS; ++k) {
        rng r = rng_split(6, 0, k);
        aim(o, (aim_kind)(k % AIM_KINDS), &r, org[k], dir[k]);
        want[k] = trace_one(s.scene, org[k], dir[k], 0, INFINITY);
    }
    size_t different = 0;
#pragma omp parallel for num_threads(8) schedule(dynamic, 16) reduction(+ : different)
    for (size_t k = 0; k < RAYS; ++k) {
        const judge_answer got = trace_one(s.scene, org[k], dir[k], 0, INFINITY);
        different += !same_answer(&got, &want[k]);
    }
    assert_int_equal(different, 0);
    free(org);
    free(dir);
    free(want);
    free_scene(&s);
    oracle_free(o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(widths_agree),
        cmocka_unit_test(occluded_agrees),
        cmocka_unit_test(filters),
        cmocka_unit_test(filters_of_close_roots),
#if EP_EMBREE == 3
        cmocka_unit_test(query_filters),
#endif
        cmocka_unit_test(strict_interval),
        cmocka_unit_test(interval_of_all_roots),
        cmocka_unit_test(instances),
        cmocka_unit_test(masks),
        cmocka_unit_test(ids),
        cmocka_unit_test(coinciding),
        cmocka_unit_test(extreme_rays),
        cmocka_unit_test(threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
