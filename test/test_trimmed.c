/* test_trimmed.c - do rays hit of trimmed patches what is inside, and nothing else?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/region.h"
#include "test/support.h"
#include "test/test_trim.h"

#include <string.h>

/* A geometry of trimmed patches, traced by a scene of its own. */
static test_scene new_trimmed(const test_patch *patches, size_t count, EPRegion region, EPTrimSplit split)
{
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.trimSplit = split;
    EPGeometry g = new_geometry(patches, count, &settings);
    assert_int_equal(epSetPatchTrim(g, 0, count, region), EP_OK);
    CHECK(epCommitGeometry(g) == EP_OK, "%s", epGetGeometryMessage(g));
    return scene_of(g);
}

/* Which hits near a border count is left open this far from it. */
static const double border = 2e-5;

/* The roots that the region keeps; those at its border are doubtful. */
static size_t trim_roots(const trim_shape *shape, oracle_root *roots, size_t count)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        oracle_root r = roots[i];
        const shape_side side = shape_at(shape, r.u, r.v, border);
        if (side == SHAPE_OUT && !r.doubtful) continue;
        r.doubtful = r.doubtful || side == SHAPE_NEAR;
        roots[kept++] = r;
    }
    return kept;
}

typedef struct tally {
    unsigned long rays, hits, faults;
} tally;

static void judge_rays(const oracle *o, const trim_shape *shape, RTCScene scene, rng *r, unsigned packet, int index,
                       tally *t)
{
    static const unsigned widths[] = {16, 8, 4, 1};
    float org[16][3], dir[16][3];
    judge_answer answer[16];
    for (unsigned i = 0; i < 16; ++i) aim(o, (aim_kind)((16 * packet + i) % AIM_KINDS), r, org[i], dir[i]);
    for (unsigned i = 0; i < 16; ++i) answer[i] = trace_one(scene, org[i], dir[i], 0, INFINITY);
    for (unsigned k = 0; k < 4; ++k) {
        const unsigned n = widths[k];
        for (unsigned first = 0; first < 16; first += n) {
            test_packet p;
            for (unsigned i = 0; i < n; ++i) set_ray(&p, n, i, org[first + i], dir[first + i], 0, INFINITY);
            ep_rtc_intersect(scene, (int)n, p.valid, p.f, false);
            for (unsigned i = 0; i < n; ++i) {
                const judge_answer *a = &answer[first + i];
                const bool hit = get_id(&p, n, HIT_GEOM, i) != RTC_INVALID_GEOMETRY_ID;
                const bool same =
                    hit == (a->t < INFINITY) &&
                    (!hit || (get_float(&p, n, EP_RAY_TFAR, i) == (float)a->t &&
                              get_float(&p, n, HIT_U, i) == (float)a->u && get_float(&p, n, HIT_V, i) == (float)a->v));
                if (same || ++t->faults > 5) continue;
                print_error("patch %d: other bits in packets of %u, %s: t %.9g u %.9g v %.9g, not %.9g %.9g %.9g\n",
                            index, n, ray_text(org[first + i], dir[first + i]), get_float(&p, n, EP_RAY_TFAR, i),
                            get_float(&p, n, HIT_U, i), get_float(&p, n, HIT_V, i), a->t, a->u, a->v);
            }
        }
    }
    for (unsigned i = 0; i < 16; ++i) {
        double od[3], dd[3];
        oracle_root roots[ORACLE_ROOTS];
        for (int x = 0; x < 3; ++x) od[x] = org[i][x], dd[x] = dir[i][x];
        size_t count = oracle_intersect(o, od, dd, 0, INFINITY, roots);
        count = trim_roots(shape, roots, count);
        const judge_verdict v = judge(o, od, dd, roots, count, &answer[i], &judge_usual, NULL);
        ++t->rays;
        t->hits += answer[i].t < INFINITY;
        if (v < JUDGE_MISSED) continue;
        if (++t->faults > 5) continue;
        print_error("patch %d: %s, %s, t %.9g u %.9g v %.9g\n", index, judge_names[v], ray_text(org[i], dir[i]),
                    answer[i].t, answer[i].u, answer[i].v);
        for (size_t k = 0; k < count; ++k)
            print_error("    root t %.9g u %.9g v %.9g%s cosine %.3g\n", roots[k].t_low, roots[k].u, roots[k].v,
                        roots[k].doubtful ? " perhaps" : "", roots[k].cosine);
    }
}

/* The rest of the domain: random regions are small. */
static trim_shape *without(trim_shape *shape)
{
    trim_shape *rest = shape_new(SHAPE_DIFFERENCE);
    assert_true(shape_add(rest, shape_new(SHAPE_SQUARE)) && shape_add(rest, shape));
    return rest;
}

static void try_regions(uint64_t seed, int count, EPTrimSplit split)
{
    /* not collapsed ones: of the parameters that meet in a pole any may be inside */
    static const patch_style styles[] = {STYLE_GENTLE, STYLE_WILD, STYLE_FLAT};
    tally t = {0};
    for (int k = 0; k < count; ++k) {
        rng r = rng_split(seed, 0, (uint64_t)k);
        test_patch p;
        trim_shape *shape = random_shape(&r, 1 + (unsigned)k % 4, (trim_style){0, 5, 4});
        if (k % 2) shape = without(shape);
        assert_true(shape_prepare(shape));
        random_patch(&r, styles[k / 8 % 3], k / 2 % 2, (patch_limits){5, k % 3 ? 1 : 3}, &p);
        EPRegion region = new_region(shape);
        oracle *o = new_oracle(&p, 1);
        test_scene s = new_trimmed(&p, 1, region, split);
        epReleaseRegion(region);
        for (unsigned packet = 0; packet < 12; ++packet) judge_rays(o, shape, s.scene, &r, packet, k, &t);
        free_scene(&s);
        oracle_free(o);
        shape_free(shape);
    }
    print_message("%lu rays, %lu hits, %lu faults\n", t.rays, t.hits, t.faults);
    assert_true(t.hits > t.rays / 10);
    assert_int_equal(t.faults, 0);
}

static void random_regions(void **state)
{
    (void)state;
    try_regions(11, 64, EP_TRIM_SPLIT_CURVES);
}

static void every_way_to_split(void **state)
{
    (void)state;
    for (EPTrimSplit split = EP_TRIM_SPLIT_COST; split <= EP_TRIM_SPLIT_NONE; ++split) try_regions(16, 12, split);
}

/* A disc, or what is left of the square beside it. */
static EPRegion disc(const double transform[6], bool inverse)
{
    EPRegion region = epNewRegion();
    if (inverse) {
        assert_int_equal(epBeginRegion(region, EP_DIFFERENCE, NULL), EP_OK);
        assert_int_equal(epAddRegionSquare(region, NULL), EP_OK);
    }
    assert_int_equal(epAddRegionCircle(region, transform), EP_OK);
    if (inverse) assert_int_equal(epEndRegion(region), EP_OK);
    return region;
}

/* The same patch twice, trimmed by the same curve on either side: a ray at the curve hits exactly one. */
static void no_gap_along_a_curve(void **state)
{
    (void)state;
    static const double transform[6] = {0.21, 0.03, -0.04, 0.17, 0.33, 0.35};
    for (int k = 0; k < 8; ++k) {
        rng r = rng_split(12, 0, (uint64_t)k);
        test_patch p;
        random_patch(&r, STYLE_GENTLE, k % 2, (patch_limits){4, k % 4 < 2 ? 1 : 3}, &p);
        EPRegion region[2] = {disc(transform, false), disc(transform, true)};
        test_scene s[2];
        for (int i = 0; i < 2; ++i) {
            s[i] = new_trimmed(&p, 1, region[i], EP_TRIM_SPLIT_CURVES);
            epReleaseRegion(region[i]);
        }
        for (int i = 0; i < 4000; ++i) {
            const double a = rng_in(&r, 0, 6.2831853), f = 1 + (i % 2 ? 0 : rng_in(&r, -1e-6, 1e-6));
            const double x = f * cos(a), y = f * sin(a);
            const double u = transform[0] * x + transform[2] * y + transform[4];
            const double v = transform[1] * x + transform[3] * y + transform[5];
            double at[3], pu[3], pv[3];
            evaluate_patch(&p, u, v, at, pu, pv);
            float org[3], dir[3];
            for (int c = 0; c < 3; ++c) {
                const int d = (c + 1) % 3, e = (c + 2) % 3;
                const double normal = pu[d] * pv[e] - pu[e] * pv[d];
                dir[c] = (float)(normal + 0.3 * rng_in(&r, -1, 1) * pu[c]);
            }
            for (int c = 0; c < 3; ++c) org[c] = (float)(at[c] - 0.5 * dir[c]);
            const bool hit[2] = {trace_one(s[0].scene, org, dir, 0, 1).t < INFINITY,
                                 trace_one(s[1].scene, org, dir, 0, 1).t < INFINITY};
            CHECK(hit[0] || hit[1], "patch %d: a gap at %g %g, %s", k, u, v, ray_text(org, dir));
        }
        for (int i = 0; i < 2; ++i) free_scene(&s[i]);
    }
}

static void parts_inside_never_test(void **state)
{
    (void)state;
    rng r = rng_split(13, 0, 0);
    for (int triangle = 0; triangle < 2; ++triangle) {
        test_patch p;
        random_patch(&r, STYLE_GENTLE, triangle, (patch_limits){4, 1}, &p);
        EPGeometry plain = new_geometry(&p, 1, NULL);
        EPRegion square = epNewRegion(), far = disc((const double[6]){0.1, 0, 0, 0.1, 3, 3}, false);
        assert_int_equal(epAddRegionSquare(square, NULL), EP_OK);
        test_scene whole = new_trimmed(&p, 1, square, EP_TRIM_SPLIT_CURVES);
        test_scene none = new_trimmed(&p, 1, far, EP_TRIM_SPLIT_CURVES);
        const ep_hierarchy *h = &whole.geometry->hierarchy;
        assert_int_equal(h->leaf_count, plain->hierarchy.leaf_count);
        for (size_t i = 0; i < h->leaf_count; ++i) assert_int_equal(h->leaves[i].trim, 0);
        assert_int_equal(none.geometry->hierarchy.leaf_count, 0);
        free_scene(&whole);
        free_scene(&none);
        epReleaseGeometry(plain);
        epReleaseRegion(square);
        epReleaseRegion(far);
    }
}

static void threads_change_nothing(void **state)
{
    (void)state;
    enum { PATCHES = 12 };
    test_patch p[PATCHES];
    EPGeometry g[2];
    rng r = rng_split(14, 0, 0);
    for (int i = 0; i < PATCHES; ++i) random_patch(&r, STYLE_GENTLE, i % 2, (patch_limits){4, 1}, &p[i]);
    for (unsigned i = 0; i < 2; ++i) {
        EPBuildSettings settings = epDefaultBuildSettings();
        settings.threads = 1 + 2 * i;
        g[i] = new_geometry(p, PATCHES, &settings);
        for (uint32_t k = 0; k < PATCHES; k += 2) {
            EPRegion region = disc((const double[6]){0.3, 0, 0, 0.2, 0.1 * k, 0.4}, k % 4);
            assert_int_equal(epSetPatchTrim(g[i], k, 2, region), EP_OK);
            epReleaseRegion(region);
        }
        assert_int_equal(epCommitGeometry(g[i]), EP_OK);
    }
    const ep_hierarchy *a = &g[0]->hierarchy, *b = &g[1]->hierarchy;
    assert_int_equal(a->leaf_count, b->leaf_count);
    assert_int_equal(a->trim_words, b->trim_words);
    assert_memory_equal(a->leaves, b->leaves, a->leaf_count * sizeof *a->leaves);
    assert_memory_equal(a->crossed, b->crossed, a->trim_words * sizeof *a->crossed);
    for (unsigned i = 0; i < 2; ++i) epReleaseGeometry(g[i]);
}

/* A geometry is charged for each of its regions, once. */
static void bytes_of_regions(void **state)
{
    (void)state;
    enum { PATCHES = 4 };
    test_patch p[PATCHES];
    EPRegion region[2];
    size_t bytes[2];
    rng r = rng_split(17, 0, 0);
    for (int i = 0; i < PATCHES; ++i) random_patch(&r, STYLE_GENTLE, i % 2, (patch_limits){3, 1}, &p[i]);
    for (int i = 0; i < 2; ++i) region[i] = disc((const double[6]){0.3, 0, 0, 0.2, 0.4, 0.4}, false);
    for (uint32_t distinct = 0; distinct < 2; ++distinct) {
        EPGeometry g = new_geometry(p, PATCHES, NULL);
        for (uint32_t i = 0; i < PATCHES; ++i)
            assert_int_equal(epSetPatchTrim(g, i, 1, region[i % 2 * distinct]), EP_OK);
        assert_int_equal(epCommitGeometry(g), EP_OK);
        EPStatistics statistics;
        epGetGeometryStatistics(g, &statistics);
        bytes[distinct] = statistics.bytes;
        epReleaseGeometry(g);
    }
    assert_int_equal(bytes[1] - bytes[0], ep_region_object_bytes(region[1]));
    assert_true(ep_region_object_bytes(region[1]) > 4 * 3 * sizeof(double[3])); /* four arcs */
    for (int i = 0; i < 2; ++i) epReleaseRegion(region[i]);
}

static void wrong_calls(void **state)
{
    (void)state;
    rng r = rng_split(15, 0, 0);
    test_patch p;
    random_patch(&r, STYLE_GENTLE, true, (patch_limits){3, 1}, &p);
    EPGeometry g = new_geometry(&p, 1, NULL);
    EPRegion region = epNewRegion();
    assert_int_equal(epSetPatchTrim(g, 0, 1, region), EP_INVALID); /* empty */
    assert_int_equal(epAddRegionLine(region, 2, (const double[4]){0, 0, 1, 1}), EP_INVALID);
    assert_int_equal(epBeginRegion(region, (EPRegionKind)(EP_POLYGON + 1), NULL), EP_INVALID);
    assert_int_equal(epBeginRegion(region, EP_POLYGON, NULL), EP_OK);
    assert_int_equal(epSetPatchTrim(g, 0, 1, region), EP_INVALID); /* open */
    assert_int_equal(epAddRegionBezier(region, 2, (const double[6]){0, 0, 1, 1, 1, -1}), EP_BAD_DATA);
    assert_int_equal(epAddRegionLine(region, 3, (const double[6]){0, 0, 1, 0, 0, 1}), EP_OK);
    assert_int_equal(epEndRegion(region), EP_OK);
    assert_int_equal(epAddRegionSquare(region, NULL), EP_INVALID);
    assert_int_equal(epSetPatchTrim(g, 0, 2, region), EP_INVALID);
    assert_int_equal(epSetPatchTrim(g, 2, 0, region), EP_INVALID);
    assert_int_equal(epSetPatchTrim(g, 0, 1, region), EP_OK);
    assert_int_equal(epSetPatchTrim(g, 0, 1, NULL), EP_OK);
    assert_true(epIsInRegion(region, 0.2, 0.2) && !epIsInRegion(region, 0.6, 0.6));
    epReleaseRegion(region);
    epReleaseGeometry(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_regions),
        cmocka_unit_test(every_way_to_split),
        cmocka_unit_test(no_gap_along_a_curve),
        cmocka_unit_test(parts_inside_never_test),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(bytes_of_regions),
        cmocka_unit_test(wrong_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
