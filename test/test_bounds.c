/* test_bounds.c - does every leaf hold its piece of the surface, and do the constants of the certificate hold?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Bounds are tight at corners and edges of a piece, so half of the samples are there. */
#include "test/support.h"

/* A point of the unit domain; every other one on its border. */
static void sample(rng *r, bool triangle, double x[2])
{
    for (int c = 0; c < 2; ++c) x[c] = rng_below(r, 2) ? rng_unit(r) : rng_below(r, 2);
    if (triangle && x[0] + x[1] > 1) {
        x[0] = 1 - x[0], x[1] = 1 - x[1];
        if (rng_below(r, 2)) x[1] = 1 - x[0];
    }
}

typedef struct where {
    const char *style;
    int patch;
    size_t leaf;
} where;

/* The piece's point at x in leaf coordinates, less (x, 0): r. And its derivatives along s and t. */
typedef struct remainder_at {
    double p[3]; /* in space */
    double r[3], rs[3], rt[3];
} remainder_at;

static remainder_at evaluate(const test_patch *p, const ep_patch *patch, const ep_leaf *leaf, const double x[2])
{
    const float *d = leaf->domain;
    const double uu = d[2], vv = d[3], uv = d[4], vu = d[5];
    double pu[3], pv[3];
    remainder_at e;
    evaluate_patch(p, d[0] + uu * x[0] + uv * x[1], d[1] + vu * x[0] + vv * x[1], e.p, pu, pv);
    for (int row = 0; row < 3; ++row) {
        e.r[row] = leaf->frame[3][row] - (row < 2 ? x[row] : 0);
        e.rs[row] = row == 0 ? -1 : 0;
        e.rt[row] = row == 1 ? -1 : 0;
        for (int c = 0; c < 3; ++c) {
            const double m = leaf->frame[c][row];
            e.r[row] += m * (e.p[c] - patch->centre[c] - patch->centre_low[c]);
            e.rs[row] += m * (uu * pu[c] + vu * pv[c]);
            e.rt[row] += m * (uv * pu[c] + vv * pv[c]);
        }
    }
    return e;
}

/* `row` of the frame: its rounding in this test */
#define HOLDS(value, limit, row)                                                                                       \
    CHECK((value) <= (limit) + noise[row], "%s patch %d, leaf %zu, at %.17g %.17g: %.9g > %.9g", w.style,   \
          w.patch, w.leaf, x[0], x[1], (double)(value), (double)(limit))

static void check_leaf(const test_patch *p, const ep_hierarchy *h, where w, rng *r)
{
    const ep_leaf *leaf = &h->leaves[w.leaf];
    const ep_box *box = &h->boxes[w.leaf];
    const ep_patch *patch = &h->patches[0];
    const bool triangle = patch->kind == EP_KIND_TRIANGLE;
    double before[2] = {0, 0}, noise[3], far = patch->radius;
    for (int c = 0; c < 3; ++c) far += fabs(patch->centre[c]);
    for (int row = 0; row < 3; ++row) {
        noise[row] = 1e-15;
        for (int c = 0; c < 3; ++c) noise[row] += 1e-13 * fabs(leaf->frame[c][row]) * far;
    }
    remainder_at last = evaluate(p, patch, leaf, before);
    for (int k = 0; k < 40; ++k) {
        double x[2];
        sample(r, triangle, x);
        const remainder_at e = evaluate(p, patch, leaf, x);
        for (int c = 0; c < 3; ++c)
            CHECK(box->lower[c] <= e.p[c] && e.p[c] <= box->upper[c],
                  "%s patch %d, leaf %zu: %c is %.17g outside [%.9g, %.9g]", w.style, w.patch, w.leaf, "xyz"[c], e.p[c],
                  box->lower[c], box->upper[c]);
        if (!(leaf->height < INFINITY)) continue; /* left to subdivision */

        HOLDS(fabs(e.r[0]), leaf->side_s, 0);
        HOLDS(fabs(e.r[1]), leaf->side_t, 1);
        HOLDS(fabs(e.r[2]), leaf->height, 2);
        const double apart = fmax(fabs(x[0] - before[0]), fabs(x[1] - before[1]));
        HOLDS(fabs(e.rs[0] - last.rs[0]) + fabs(e.rt[0] - last.rt[0]), leaf->bend[0] * apart, 0);
        HOLDS(fabs(e.rs[1] - last.rs[1]) + fabs(e.rt[1] - last.rt[1]), leaf->bend[1] * apart, 1);
        HOLDS(fabs(e.rs[2] - last.rs[2]) + fabs(e.rt[2] - last.rt[2]), leaf->bend[2] * apart, 2);
        HOLDS(fabs(e.r[0] - last.r[0]), leaf->stretch * apart, 0);
        HOLDS(fabs(e.r[1] - last.r[1]), leaf->stretch * apart, 1);

        const double middle = triangle ? 1.0 / 3 : 0.5, s = x[0] - middle, t = x[1] - middle;
        double off[3];
        for (int c = 0; c < 3; ++c)
            off[c] = fabs(e.r[c] - leaf->model[0][c] - leaf->model[1][c] * s * s / 2 - leaf->model[2][c] * s * t -
                          leaf->model[3][c] * t * t / 2);
        HOLDS(off[0], leaf->model_st, 0);
        HOLDS(off[1], leaf->model_st, 1);
        HOLDS(off[2], leaf->model_h, 2);
        before[0] = x[0], before[1] = x[1];
        last = e;
    }
}

static void check_patches(uint64_t seed, patch_limits limits, int count, unsigned leaves)
{
    for (int k = 0; k < count; ++k) {
        rng r = rng_split(seed, 0, (uint64_t)k);
        const patch_style style = (patch_style)(k % STYLES);
        test_patch p;
        random_patch(&r, style, k / STYLES % 2, limits, &p);
        const double offset[3] = {rng_in(&r, -1, 1) * 100, 0, rng_in(&r, -1, 1)};
        if (rng_below(&r, 3) == 0) move_patch(&p, rng_scale(&r, 1e-3, 1e3), offset);
        EPBuildSettings settings = epDefaultBuildSettings();
        settings.rayDistance = 1e-30f; /* no padding for rays from afar: boxes as tight as they come */
        settings.maxDepth = rng_below(&r, limits.most_degree > 9 ? 5 : 11); /* a piece that is still far from flat has bounds too */
        EPGeometry g = new_geometry(&p, 1, &settings);
        const ep_hierarchy *h = &g->hierarchy;
        assert_true(h->leaf_count > 0);
        for (unsigned i = 0; i < leaves; ++i)
            check_leaf(&p, h, (where){style_name(style), k, rng_below(&r, (unsigned)h->leaf_count)}, &r);
        epReleaseGeometry(g);
    }
}

static void polynomial(void **state)
{
    (void)state;
    check_patches(1, (patch_limits){9, 1}, 200, 20);
}

static void rational(void **state)
{
    (void)state;
    check_patches(2, (patch_limits){9, 50}, 60, 20);
}

static void high_degree(void **state)
{
    (void)state;
    check_patches(3, (patch_limits){25, 1}, 4, 10);
    check_patches(4, (patch_limits){15, 3}, 4, 10);
}

/* Leaves are dyadic parts of the domain: together they cover it without overlap. */
static void leaves_tile_the_domain(void **state)
{
    (void)state;
    for (int k = 0; k < 48; ++k) {
        rng r = rng_split(5, 0, (uint64_t)k);
        test_patch p;
        random_patch(&r, (patch_style)(k % STYLES), k % 2, (patch_limits){5, k % 3 ? 1 : 10}, &p);
        EPGeometry g = new_geometry(&p, 1, NULL);
        double area = 0;
        for (size_t i = 0; i < g->hierarchy.leaf_count; ++i) {
            const float *d = g->hierarchy.leaves[i].domain;
            area += fabs((double)d[2] * d[3] - (double)d[4] * d[5]);
        }
        CHECK(area == 1, "patch %d: %.17g", k, area);
        epReleaseGeometry(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polynomial),
        cmocka_unit_test(rational),
        cmocka_unit_test(high_degree),
        cmocka_unit_test(leaves_tile_the_domain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
