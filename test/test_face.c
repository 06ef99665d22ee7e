/* test_face.c - patches joined to faces: are hits and points theirs, in the face's parameters?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The same patches, joined and not, are traced side by side: a hit on a face is the hit on its patch, to the bit, but
 * for what a transform in double makes of u, v and Ng. */
#include "test/support.h"

#include <float.h>
#include <string.h>

enum { PATCHES = 12, FACES = 6 };

/* Patches per face: single ones, joined ones, and two faces without any. */
static const size_t face_sizes[FACES] = {1, 4, 0, 5, 2, 0};

typedef struct surface {
    test_patch patches[PATCHES];
    double transforms[PATCHES][6];
    uint32_t face[PATCHES];
} surface;

static void random_surface(uint64_t seed, surface *s)
{
    rng r = rng_split(seed, 0, 0);
    for (size_t i = 0; i < PATCHES; ++i) {
        random_patch(&r, STYLE_GENTLE, i % 3 == 1, (patch_limits){3, i % 2 ? 1 : 2}, &s->patches[i]);
        const double offset[3] = {rng_in(&r, -1, 1), rng_in(&r, -1, 1), rng_in(&r, -1, 1)};
        move_patch(&s->patches[i], 1, offset);
        for (int k = 0; k < 6; ++k) s->transforms[i][k] = rng_in(&r, -3, 3);
    }
    for (size_t f = 0, i = 0; f < FACES; ++f)
        for (size_t k = 0; k < face_sizes[f]; ++k) s->face[i++] = (uint32_t)f;
}

static EPStatus add(EPGeometry g, const test_patch *p)
{
    return p->shape.triangle
               ? epAddBezierTriangles(g, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, sizeof p->points[0])
               : epAddBezierPatches(g, p->shape.m, p->shape.n, 1, EP_FORMAT_DOUBLE4, p->points, sizeof p->points[0]);
}

static const double (*transforms_of(const surface *s, size_t first))[6]
{
    return (const double(*)[6])(s->transforms + first);
}

/* Face by face; a step that runs out of memory must have changed nothing and is repeated. Returns how many did. */
static int fill(EPGeometry g, const surface *s)
{
    int failures = 0;
    for (size_t f = 0, first = 0; f < FACES; first += face_sizes[f++]) {
        EPStatus status;
        for (size_t i = 0; i < face_sizes[f]; ++i)
            while ((status = add(g, &s->patches[first + i])) != EP_OK) {
                assert_int_equal(status, EP_NO_MEMORY);
                ++failures;
            }
        if (f == 0) continue; /* not joined at all */
        while ((status = epJoinPatches(g, (uint32_t)first, face_sizes[f], transforms_of(s, first))) != EP_OK) {
            CHECK(status == EP_NO_MEMORY, "%s", epGetGeometryMessage(g));
            ++failures;
        }
    }
    return failures;
}

static EPGeometry new_joined(const surface *s, const EPBuildSettings *settings)
{
    EPGeometry g = epNewGeometry();
    fill(g, s);
    if (settings) assert_int_equal(epSetGeometryBuildSettings(g, settings), EP_OK);
    CHECK(epCommitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
    return g;
}

/* What a face makes of a hit on its patch. */
static judge_answer placed(const surface *s, judge_answer a)
{
    static const double none[6] = {1, 0, 0, 1, 0, 0};
    if (!(a.t < (double)INFINITY)) return a;
    const uint32_t face = s->face[a.patch];
    const double *m = face ? s->transforms[a.patch] : none, u = a.u, v = a.v;
    const double scale = 1 / (m[0] * m[3] - m[1] * m[2]);
    a.u = (double)(float)(m[0] * u + m[2] * v + m[4]);
    a.v = (double)(float)(m[1] * u + m[3] * v + m[5]);
    for (int c = 0; c < 3; ++c) a.normal[c] = (double)(float)(scale * a.normal[c]);
    a.patch = face;
    return a;
}

static void trace(RTCScene scene, unsigned n, bool occluded, test_packet *p)
{
    ep_rtc_context context;
    ep_rtc_init_context(&context);
    if (occluded) ep_rtc_occluded_in(&context, scene, n, p->valid, p->f, false);
    else ep_rtc_intersect_in(&context, scene, n, p->valid, p->f, false);
}

static void compare_hits(const surface *s, const EPBuildSettings *settings, uint64_t seed)
{
    oracle *o = new_oracle(s->patches, PATCHES);
    test_scene apart = new_scene(s->patches, PATCHES, settings), joined = scene_of(new_joined(s, settings));
    size_t hits = 0;
    for (unsigned k = 0; k < 4000 / TEST_STEP; ++k) {
        const unsigned n = (unsigned[]){1, 4, 8, 16}[k % 4];
        rng r = rng_split(seed, 1, k);
        test_packet a, b;
        for (unsigned lane = 0; lane < n; ++lane) {
            float org[3], dir[3];
            aim(o, lane % 2 ? AIM_GRAZING : AIM_AT, &r, org, dir);
            set_ray(&a, n, lane, org, dir, 0, INFINITY);
        }
        b = a;
        trace(apart.scene, n, false, &a);
        trace(joined.scene, n, false, &b);
        for (unsigned lane = 0; lane < n; ++lane) {
            const judge_answer want = placed(s, answer_of(&a, n, lane)), got = answer_of(&b, n, lane);
            hits += got.t < (double)INFINITY;
            CHECK(same_answer(&want, &got), "packet %u, lane %u: t %.9g face %u u %.9g v %.9g, not %.9g %u %.9g %.9g",
                  k, lane, got.t, got.patch, got.u, got.v, want.t, want.patch, want.u, want.v);
        }
    }
    CHECK(hits > 4000 / TEST_STEP, "%zu", hits);
    free_scene(&apart);
    free_scene(&joined);
    oracle_free(o);
}

static void hits_are_those_of_patches_in_their_places(void **state)
{
    (void)state;
    static surface s;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        random_surface(seed, &s);
        compare_hits(&s, NULL, seed);
    }
}

static void hits_on_demand_are_too(void **state)
{
    (void)state;
    static surface s;
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.onDemand = 1;
    random_surface(5, &s);
    compare_hits(&s, &settings, 5);
}

/* Ties at one t: the face's own u decides, whichever patch is met first. */
static void common_borders_have_one_answer(void **state)
{
    (void)state;
    /* a plane square in two halves, of which the second is turned around: (s, t) -> (1 - s/2, 1 - t) */
    static const float points[2][4][3] = {{{0, 0, 0}, {0.5f, 0, 0}, {0, 1, 0}, {0.5f, 1, 0}},
                                          {{1, 1, 0}, {0.5f, 1, 0}, {1, 0, 0}, {0.5f, 0, 0}}};
    static const double transforms[2][6] = {{0.5, 0, 0, 1, 0, 0}, {-0.5, 0, 0, -1, 1, 1}};
    EPGeometry g = epNewGeometry();
    assert_int_equal(epAddBezierPatches(g, 1, 1, 2, EP_FORMAT_FLOAT3, points, 3 * sizeof(float)), EP_OK);
    assert_int_equal(epJoinPatches(g, 0, 2, transforms), EP_OK);
    assert_int_equal(epCommitGeometry(g), EP_OK);
    test_scene s = scene_of(g);
    for (int i = 0; i <= 64; ++i) {
        const float org[3] = {0.5f, (float)i / 64, 1}, dir[3] = {0, 0, -1};
        const judge_answer a = trace_one(s.scene, org, dir, 0, INFINITY);
        CHECK(a.t == 1 && a.patch == 0 && a.u == 0.5 && a.v == (double)org[1], "t %g u %.9g v %.9g", a.t, a.u, a.v);
        CHECK(fabs(a.normal[2] - 1) < 1e-6, "Ng %.9g", a.normal[2]);
    }
    free_scene(&s);
}

/* Where patches lie on one another the lesser u of the face wins, whichever of them is met first. */
static void ties_are_broken_in_the_face(void **state)
{
    (void)state;
    static surface s;
    random_surface(10, &s);
    for (int order = 0; order < 2; ++order) {
        double transforms[2][6] = {{1, 0, 0, 1, 0, 0}, {1, 0, 0, 1, 0, 0}};
        transforms[order][0] = -1, transforms[order][4] = -2;
        EPGeometry g = epNewGeometry();
        for (int i = 0; i < 2; ++i) assert_int_equal(add(g, &s.patches[0]), EP_OK);
        assert_int_equal(epJoinPatches(g, 0, 2, (const double(*)[6])transforms), EP_OK);
        assert_int_equal(epCommitGeometry(g), EP_OK);
        test_scene t = scene_of(g);
        rng r = rng_split(10, 2, 0);
        oracle *o = new_oracle(s.patches, 1);
        for (int i = 0; i < 500; ++i) {
            float org[3], dir[3];
            aim(o, AIM_AT, &r, org, dir);
            const judge_answer a = trace_one(t.scene, org, dir, 0, INFINITY);
            CHECK(!(a.t < (double)INFINITY) || a.u <= -2, "order %d, ray %d: u %g", order, i, a.u);
        }
        oracle_free(o);
        free_scene(&t);
    }
}

static void near(const double a[3], const double b[3], double tolerance, const char *what)
{
    for (int c = 0; c < 3; ++c)
        CHECK(fabs(a[c] - b[c]) <= tolerance * (1 + fabs(b[c])), "%s: %.17g, not %.17g", what, a[c], b[c]);
}

/* The patch's point, and derivatives that are those of the face by differences. */
static void points_are_those_of_patches(void **state)
{
    (void)state;
    static surface s;
    random_surface(6, &s);
    EPGeometry g = new_joined(&s, NULL);
    for (size_t i = 1; i < PATCHES; ++i) {
        const double *m = s.transforms[i], at[2] = {0.3, 0.25}, h = 1e-5;
        const double u = m[0] * at[0] + m[2] * at[1] + m[4], v = m[1] * at[0] + m[3] * at[1] + m[5];
        /* which patch of the face answers is not said where several have the point: these do not overlap there */
        double p[3], pu[3], pv[3], d2[9], x[3], xs[3], xt[3];
        assert_int_equal(epEvaluate(g, s.face[i], u, v, p, pu, pv, d2), EP_OK);
        evaluate_patch(&s.patches[i], at[0], at[1], x, xs, xt);
        if (fabs(p[0] - x[0]) > 1e-9) continue; /* another one has it, too */
        near(p, x, 1e-12, "point");
        double back[3];
        for (int c = 0; c < 3; ++c) back[c] = m[0] * pu[c] + m[1] * pv[c];
        near(back, xs, 1e-11, "dP/ds");
        for (int c = 0; c < 3; ++c) back[c] = m[2] * pu[c] + m[3] * pv[c];
        near(back, xt, 1e-11, "dP/dt");
        double pu1[3], pv1[3], pu0[3], pv0[3];
        epEvaluate(g, s.face[i], u + h, v, NULL, pu1, pv1, NULL);
        epEvaluate(g, s.face[i], u - h, v, NULL, pu0, pv0, NULL);
        for (int c = 0; c < 3; ++c) back[c] = (pu1[c] - pu0[c]) / (2 * h);
        near(d2, back, 1e-5, "d²P/du²");
        for (int c = 0; c < 3; ++c) back[c] = (pv1[c] - pv0[c]) / (2 * h);
        near(d2 + 3, back, 1e-5, "d²P/dudv");
        epEvaluate(g, s.face[i], u, v + h, NULL, NULL, pv1, NULL);
        epEvaluate(g, s.face[i], u, v - h, NULL, NULL, pv0, NULL);
        for (int c = 0; c < 3; ++c) back[c] = (pv1[c] - pv0[c]) / (2 * h);
        near(d2 + 6, back, 1e-5, "d²P/dv²");
    }
    assert_int_equal(epEvaluate(g, 2, 0, 0, NULL, NULL, NULL, NULL), EP_INVALID); /* has no patches */
    assert_int_equal(epEvaluate(g, FACES, 0, 0, NULL, NULL, NULL, NULL), EP_INVALID);
    EPStatistics statistics;
    epGetGeometryStatistics(g, &statistics);
    assert_int_equal(statistics.faces, FACES);
    assert_int_equal(statistics.patches, PATCHES);
    epReleaseGeometry(g);
}

static void error_bounds_are_those_of_all_patches(void **state)
{
    (void)state;
    static surface s;
    random_surface(7, &s);
    static const double far[3] = {1000, 0, 0};
    move_patch(&s.patches[3], 1, far); /* one of face 1 */
    EPGeometry g = new_joined(&s, NULL), apart = new_geometry(s.patches, PATCHES, NULL);
    const float org[3] = {0, 0, 0}, dir[3] = {0, 0, 0};
    for (uint32_t f = 0; f < FACES; ++f) {
        float want = 0;
        for (uint32_t i = 0; i < PATCHES; ++i)
            if (s.face[i] == f) want = fmaxf(want, epGetHitError(apart, i, org, dir, 0));
        const float got = epGetHitError(g, f, org, dir, 0);
        CHECK(got == want, "face %u: %g, not %g", f, (double)got, (double)want);
    }
    epReleaseGeometry(apart);
    epReleaseGeometry(g);
}

/* A disc in the parameters of all faces keeps of each what is in it. */
static void trims_are_in_the_faces_parameters(void **state)
{
    (void)state;
    static surface s;
    unsigned kept = 0, gone = 0;
    for (uint64_t seed = 11; seed <= 14; ++seed) {
        random_surface(seed, &s);
        oracle *o = new_oracle(s.patches, PATCHES);
        EPGeometry disc = new_joined(&s, NULL);
        EPRegion region = epNewRegion();
        const double radius = 2, band = 1e-4;
        assert_int_equal(epAddRegionCircle(region, (const double[6]){radius, 0, 0, radius, 0.5, 0.5}), EP_OK);
        assert_int_equal(epSetPatchTrim(disc, 0, PATCHES, region), EP_OK);
        assert_int_equal(epCommitGeometry(disc), EP_OK);
        epReleaseRegion(region);
        test_scene whole = scene_of(new_joined(&s, NULL)), trimmed = scene_of(disc);
        for (unsigned k = 0; k < 4000 / TEST_STEP; ++k) {
            rng r = rng_split(seed, 5, k);
            float org[3], dir[3];
            aim(o, AIM_AT, &r, org, dir);
            const judge_answer a = trace_one(whole.scene, org, dir, 0, INFINITY),
                               b = trace_one(trimmed.scene, org, dir, 0, INFINITY);
            if (!(a.t < (double)INFINITY)) continue;
            const double out = hypot(a.u - 0.5, a.v - 0.5) - radius;
            CHECK(!(b.t < (double)INFINITY) || hypot(b.u - 0.5, b.v - 0.5) < radius + band, "%g %g", b.u, b.v);
            if (fabs(out) < band) continue;
            ++*(out < 0 ? &kept : &gone);
            const bool met = a.patch == b.patch && fabs(a.t - b.t) < 1e-5; /* its leaves are others */
            CHECK(met == (out < 0), "face %u, u %.9g v %.9g", a.patch, a.u, a.v);
        }
        free_scene(&whole);
        free_scene(&trimmed);
        oracle_free(o);
    }
    CHECK(kept > 1000 / TEST_STEP && gone > 1000 / TEST_STEP, "%u, %u", kept, gone);
}

static void wrong_joins_are_refused(void **state)
{
    (void)state;
    static surface s;
    random_surface(8, &s);
    double bad[2][6] = {{1, 0, 0, 1, 0, 0}, {1, 2, 2, 4, 0, 0}};
    EPGeometry g = epNewGeometry();
    EPRegion square = epNewRegion();
    epAddRegionSquare(square, NULL);
    for (int i = 0; i < 4; ++i) assert_int_equal(add(g, &s.patches[i]), EP_OK);
    assert_int_equal(epJoinPatches(g, 0, 2, transforms_of(&s, 0)), EP_INVALID); /* not the last */
    assert_int_equal(epJoinPatches(g, 2, 3, transforms_of(&s, 0)), EP_INVALID); /* more than there are */
    assert_int_equal(epJoinPatches(g, 5, 0, NULL), EP_INVALID);
    assert_int_equal(epJoinPatches(g, 2, 2, NULL), EP_INVALID);
    assert_int_equal(epJoinPatches(g, 2, 2, (const double(*)[6])bad), EP_INVALID); /* no inverse */
    bad[1][3] = (double)NAN;
    assert_int_equal(epJoinPatches(g, 2, 2, (const double(*)[6])bad), EP_INVALID);
    assert_int_equal(epSetPatchTrim(g, 3, 1, square), EP_OK);
    assert_int_equal(epJoinPatches(g, 2, 2, transforms_of(&s, 2)), EP_INVALID); /* trimmed */
    assert_int_equal(epSetPatchTrim(g, 3, 1, NULL), EP_OK);
    EPStatistics statistics;
    epGetGeometryStatistics(g, &statistics);
    assert_int_equal(statistics.faces, 4);
    assert_int_equal(epJoinPatches(g, 2, 2, transforms_of(&s, 2)), EP_OK);
    assert_int_equal(epJoinPatches(g, 1, 3, transforms_of(&s, 1)), EP_INVALID); /* of another face */
    assert_int_equal(epJoinPatches(g, 3, 1, transforms_of(&s, 3)), EP_INVALID);
    assert_int_equal(epSetPatchTrim(g, 3, 1, square), EP_OK);
    assert_int_equal(epSetPatchTrim(g, 1, 1, square), EP_OK);
    assert_int_equal(epJoinPatches(g, 4, 0, NULL), EP_OK);
    assert_int_equal(epJoinPatches(g, 2, 2, transforms_of(&s, 2)), EP_INVALID); /* an empty face has come since */
    epGetGeometryStatistics(g, &statistics);
    assert_int_equal(statistics.faces, 4);
    epReleaseRegion(square);
    epReleaseGeometry(g);
}

static void every_allocation_fails_once(void **state)
{
    (void)state;
    static surface s;
    random_surface(9, &s);
    int failures = 1;
    for (long n = 0; failures; ++n) {
        EPGeometry g = epNewGeometry();
        EPStatistics statistics;
        ep_alloc_fail_at(n);
        failures = fill(g, &s);
        ep_alloc_fail_at(-1);
        assert_true(failures <= 1);
        epGetGeometryStatistics(g, &statistics);
        assert_int_equal(statistics.faces, FACES);
        assert_int_equal(statistics.patches, PATCHES);
        assert_int_equal(epCommitGeometry(g), EP_OK);
        epReleaseGeometry(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_patches_in_their_places),
        cmocka_unit_test(hits_on_demand_are_too),
        cmocka_unit_test(common_borders_have_one_answer),
        cmocka_unit_test(ties_are_broken_in_the_face),
        cmocka_unit_test(points_are_those_of_patches),
        cmocka_unit_test(error_bounds_are_those_of_all_patches),
        cmocka_unit_test(trims_are_in_the_faces_parameters),
        cmocka_unit_test(wrong_joins_are_refused),
        cmocka_unit_test(every_allocation_fails_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
