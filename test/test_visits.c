/* test_visits.c - are leaves cut where too many rays come to their boxes, and only there?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Counted by lines through the geometry's box and slab tests against those of its leaves: how many boxes a line
 * visits. */
#include "test/support.h"

static const double thin = 1.0 / 64;

/* A flat strip from the origin to `along`, `thin` wide, across it and `beside`. */
static test_patch strip(const double along[3], const double beside[3])
{
    test_patch p = {.shape = {false, 1, 1}};
    for (int c = 0; c < 3; ++c) {
        const double across =
            thin * (along[(c + 1) % 3] * beside[(c + 2) % 3] - along[(c + 2) % 3] * beside[(c + 1) % 3]);
        p.points[1][c] = along[c];
        p.points[2][c] = across;
        p.points[3][c] = along[c] + across;
    }
    for (int k = 0; k < 4; ++k) p.points[k][3] = 1;
    return p;
}

/* A square in z = -1. */
static test_patch ground(double size)
{
    test_patch p = strip((const double[3]){size, 0, 0}, (const double[3]){0, 0, -1 / thin});
    for (int k = 0; k < 4; ++k) p.points[k][2] = -1;
    return p;
}

static EPGeometry build(const test_patch *patches, size_t count)
{
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.rayDistance = 1e-30f; /* boxes as tight as they come */
    return new_geometry(patches, count, &settings);
}

static size_t leaves_of(EPGeometry g, uint32_t patch)
{
    size_t count = 0;
    for (size_t i = 0; i < g->hierarchy.leaf_count; ++i) count += g->hierarchy.leaves[i].patch == patch;
    return count;
}

static bool meets(const double org[3], const double dir[3], const float lower[3], const float upper[3])
{
    double from = -INFINITY, to = INFINITY;
    for (int c = 0; c < 3; ++c) {
        const double a = (lower[c] - org[c]) / dir[c], b = (upper[c] - org[c]) / dir[c];
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return from <= to;
}

/* How many boxes a line visits that crosses the geometry's, on average over lines from everywhere. */
static double visits_of(EPGeometry g)
{
    const float *b = g->hierarchy.bounds;
    rng r = rng_split(11, 0, 0);
    unsigned long lines = 0, visits = 0;
    for (int k = 0; k < 400000; ++k) {
        double org[3], dir[3], radius = 0, far = 0, off = 0;
        rng_direction(&r, dir);
        rng_direction(&r, org);
        for (int c = 0; c < 3; ++c) radius += 0.25 * ((double)b[3 + c] - b[c]) * ((double)b[3 + c] - b[c]);
        /* in the plane across dir, and there uniformly on a disc as wide as the box */
        for (int c = 0; c < 3; ++c) far += org[c] * dir[c];
        for (int c = 0; c < 3; ++c) org[c] -= far * dir[c];
        for (int c = 0; c < 3; ++c) off += org[c] * org[c];
        const double at = sqrt(rng_unit(&r) * radius / off);
        for (int c = 0; c < 3; ++c) org[c] = at * org[c] + 0.5 * ((double)b[c] + b[3 + c]);
        if (!meets(org, dir, b, b + 3)) continue;
        ++lines;
        for (size_t i = 0; i < g->hierarchy.leaf_count; ++i)
            visits += meets(org, dir, g->hierarchy.boxes[i].lower, g->hierarchy.boxes[i].upper);
    }
    return (double)visits / (double)lines;
}

static const double diagonal[3] = {1, 1, 1}, level[3] = {1, 1, 0}, axis[3] = {1, 0, 0}, up[3] = {0, 0, 1};

/* A whole box is visited by all lines that cross it. */
static void askew(void **state)
{
    (void)state;
    const test_patch strips[2] = {strip(diagonal, up), strip(level, up)};
    for (int k = 0; k < 2; ++k) {
        EPGeometry g = build(&strips[k], 1);
        const double visits = visits_of(g);
        CHECK(visits < 0.25, "strip %d: %zu leaves, %.3g visits", k, g->hierarchy.leaf_count, visits);
        assert_in_range(g->hierarchy.leaf_count, 8, 16);
        epReleaseGeometry(g);
    }
}

/* Nothing is to be gained along an axis, and none of a square. */
static void straight(void **state)
{
    (void)state;
    test_patch patches[2] = {strip(axis, up), strip(diagonal, up)};
    for (int c = 0; c < 3; ++c) { /* as wide as it is long, nearly */
        patches[1].points[2][c] /= thin;
        patches[1].points[3][c] = patches[1].points[1][c] + patches[1].points[2][c];
    }
    for (int k = 0; k < 2; ++k) {
        EPGeometry g = build(&patches[k], 1);
        assert_int_equal(g->hierarchy.leaf_count, 1);
        epReleaseGeometry(g);
    }
}

/* What few rays come to stays as it is. */
static void seldom_met(void **state)
{
    (void)state;
    for (int k = 0; k < 2; ++k) {
        const test_patch patches[2] = {strip(diagonal, up), ground(k ? 1000 : 4)};
        EPGeometry g = build(patches, 2);
        assert_int_equal(leaves_of(g, 1), 1);
        if (k) assert_int_equal(leaves_of(g, 0), 1);
        else assert_true(leaves_of(g, 0) >= 8);
        epReleaseGeometry(g);
    }
}

/* Poles that hardly any come to are cut less finely, and what bends as always. */
static void poles(void **state)
{
    (void)state;
    static const patch_style styles[2] = {STYLE_GENTLE, STYLE_COLLAPSED};
    for (int k = 0; k < 2; ++k) {
        rng r = rng_split(12, 0, (uint64_t)k);
        test_patch patches[2];
        do random_patch(&r, styles[k], false, (patch_limits){3, 1}, &patches[0]);
        while (patches[0].shape.m < 3 || patches[0].shape.n < 3);
        size_t leaves[2];
        for (int size = 0; size < 2; ++size) {
            patches[1] = ground(size ? 30000 : 1);
            EPGeometry g = build(patches, 2);
            leaves[size] = leaves_of(g, 0);
            epReleaseGeometry(g);
        }
        CHECK(k ? leaves[1] < leaves[0] : leaves[1] == leaves[0],
              "%zu leaves, and %zu of style %d beside a large patch", leaves[0], leaves[1], k);
    }
}

/* The same of leaves that a trim curve crosses: there are the fewer of them the fewer rays come by. */
static void crossed(void **state)
{
    (void)state;
    EPRegion disc = epNewRegion();
    static const double to[6] = {0.4, 0, 0, 0.4, 0.5, 0.5};
    assert_int_equal(epAddRegionCircle(disc, to), EP_OK);
    size_t last = SIZE_MAX;
    static const double sizes[4] = {1, 8, 64, 512};
    for (int k = 0; k < 4; ++k) {
        const test_patch patches[2] = {ground(1), ground(sizes[k])};
        EPGeometry g = build(patches, 2);
        assert_int_equal(epSetPatchTrim(g, 0, 1, disc), EP_OK);
        assert_int_equal(epCommitGeometry(g), EP_OK);
        const size_t leaves = leaves_of(g, 0);
        CHECK(leaves < last, "%zu leaves beside a ground of %g, %zu beside a smaller one", leaves, sizes[k], last);
        last = leaves;
        epReleaseGeometry(g);
    }
    assert_int_equal(last, 1);
    epReleaseRegion(disc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(askew), cmocka_unit_test(straight), cmocka_unit_test(seldom_met),
        cmocka_unit_test(poles), cmocka_unit_test(crossed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
