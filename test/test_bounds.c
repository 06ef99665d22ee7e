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

/* The piece's point at x, in leaf coordinates, less (x, 0): r. And its derivatives along s and t. */
typedef struct remainder_at {
    double p[3]; /* in space */
    double r[3], rs[3], rt[3];
} remainder_at;

static double middle_of(const ep_patch *patch)
{
    return patch->kind == EP_KIND_TRIANGLE ? 1.0 / 3 : 0.5;
}

/* H x²/2 for the second derivatives of coordinate c. */
static double half_form(const ep_leaf *leaf, int c, const double x[2])
{
    const double ss = (double)leaf->second[0][c], st = (double)leaf->second[1][c], tt = (double)leaf->second[2][c];
    return ss * x[0] * x[0] / 2 + st * x[0] * x[1] + tt * x[1] * x[1] / 2;
}

static remainder_at evaluate(const test_patch *p, const ep_patch *patch, const ep_leaf *leaf, const double x[2])
{
    const float *d = leaf->domain;
    const double uu = d[2], vv = d[3], uv = d[4], vu = d[5];
    double pu[3], pv[3];
    remainder_at e;
    evaluate_patch(p, d[0] + uu * x[0] + uv * x[1], d[1] + vu * x[0] + vv * x[1], e.p, pu, pv);
    for (int row = 0; row < 3; ++row) {
        e.r[row] = row < 2 ? middle_of(patch) - x[row] : 0;
        e.rs[row] = row == 0 ? -1 : 0;
        e.rt[row] = row == 1 ? -1 : 0;
        for (int c = 0; c < 3; ++c) {
            const double m = leaf->frame[c][row];
            e.r[row] += m * (e.p[c] - leaf->centre[c] - leaf->centre_low[c]);
            e.rs[row] += m * (uu * pu[c] + vu * pv[c]);
            e.rt[row] += m * (uv * pu[c] + vv * pv[c]);
        }
    }
    return e;
}

/* r from the coefficients that the kernels use, by summing powers in double. */
static void sum_powers(const ep_patch *patch, const ep_leaf *leaf, const float *net, double s, double t, double r[3])
{
    const unsigned m = leaf->degree_s, n = leaf->degree_t, stride = ep_leaf_stride(leaf);
    double sum[4] = {0, 0, 0, 1};
    if (leaf->rational) sum[3] = 0;
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= (patch->kind == EP_KIND_TRIANGLE ? n - j : m); ++i, net += stride)
            for (unsigned c = 0; c < stride; ++c) sum[c] += net[c] * pow(s, i) * pow(t, j);
    for (int c = 0; c < 3; ++c) r[c] = sum[c] / sum[3];
    if (leaf->rational) r[0] -= s, r[1] -= t;
}

/* `row` of the frame: its rounding in this test */
#define HOLDS(value, limit, row)                                                                                       \
    CHECK((value) <= (limit) + noise[row], "%s patch %d, leaf %zu, at %.17g %.17g: %.9g > %.9g", w.style, w.patch,     \
          w.leaf, x[0], x[1], (double)(value), (double)(limit))

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

        HOLDS(fabs(e.r[0]), leaf->side, 0);
        HOLDS(fabs(e.r[1]), leaf->side, 1);
        HOLDS(fabs(e.r[2]), leaf->height, 2);
        const double apart = fmax(fabs(x[0] - before[0]), fabs(x[1] - before[1]));
        const double s = x[0] - middle_of(patch), t = x[1] - middle_of(patch);
        const double ls = before[0] - middle_of(patch), lt = before[1] - middle_of(patch);
        double r_net[3];
        for (int c = 0; c < 3; ++c) {
            const double ss = leaf->second[0][c], st = leaf->second[1][c], tt = leaf->second[2][c];
            const double bend = c < 2 ? leaf->bend_st : leaf->bend_h, warp = c < 2 ? leaf->warp_st : leaf->warp_h;
            const double ds = e.rs[c] - last.rs[c], dt = e.rt[c] - last.rt[c];
            HOLDS(fabs(ds) + fabs(dt), bend * apart, c);
            HOLDS(fabs(ds - ss * (s - ls) - st * (t - lt)) + fabs(dt - st * (s - ls) - tt * (t - lt)), warp * apart, c);
        }
        /* the graph over the feet, and the way back from one */
        const double u[2] = {s + e.r[0], t + e.r[1]};
        HOLDS(fabs(e.r[2] - leaf->middle - half_form(leaf, 2, u)), leaf->graph, 2);
        double back[2] = {u[0], u[1]};
        for (int round = 0; round < 2; ++round) {
            const double m[2] = {half_form(leaf, 0, back), half_form(leaf, 1, back)};
            for (int c = 0; c < 2; ++c) back[c] = u[c] - m[c];
        }
        HOLDS(fabs(back[0] - s), leaf->foot, 0);
        HOLDS(fabs(back[1] - t), leaf->foot, 1);
        sum_powers(patch, leaf, h->nets + leaf->net, s, t, r_net);
        HOLDS(fabs(r_net[0] - e.r[0]), leaf->noise_st, 0);
        HOLDS(fabs(r_net[1] - e.r[1]), leaf->noise_st, 1);
        HOLDS(fabs(r_net[2] - e.r[2]), leaf->noise_h, 2);
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
        settings.maxDepth =
            rng_below(&r, limits.most_degree > 9 ? 5 : 11); /* a piece that is still far from flat has bounds too */
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
