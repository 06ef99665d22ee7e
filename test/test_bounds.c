/* test_bounds.c - does every leaf hold its piece of the surface, and do the constants of the certificate hold?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Bounds are tight at corners and edges of a piece, so half of the samples are there. */
#include "test/piece.h"

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

/* The piece's point at (s, t), in leaf coordinates, less (s, t, 0): r. And its derivatives along s and t. */
typedef struct remainder_at {
    double p[3]; /* in space */
    double r[3], rs[3], rt[3];
} remainder_at;

static remainder_at evaluate(const piece *p, const double x[2])
{
    const piece_jet j = piece_at(p, x[0], x[1]);
    remainder_at e;
    for (int c = 0; c < 3; ++c) {
        e.p[c] = j.p[c];
        e.r[c] = j.at[c] - (c < 2 ? x[c] : 0);
        e.rs[c] = j.ds[c] - (c == 0);
        e.rt[c] = j.dt[c] - (c == 1);
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

/* What bounds r at x, its derivatives from there to another place `y` over `mid` half-way, and the models of the leaf
 * as a graph over its feet, at most comes to: in the order of names[]. */
enum { SIDE, HEIGHT, BEND_ST, BEND_H, TWIST_ST, TWIST_H, GRAPH, FOOT, STRETCH, SIGMA, BOUNDS };
static const char *const names[BOUNDS] = {"side",    "height", "bend_st", "bend_h",  "twist_st",
                                          "twist_h", "graph",  "foot",    "stretch", "sigma"};

/* H x y for the second derivatives of coordinate c. */
static double form(const ep_leaf *leaf, int c, const double x[2], const double y[2])
{
    const double ss = 2.0 * leaf->half[0][c], st = 2.0 * leaf->half[1][c], tt = 2.0 * leaf->half[2][c];
    return ss * x[0] * y[0] + st * (x[0] * y[1] + x[1] * y[0]) + tt * x[1] * y[1];
}

static void measure(const ep_leaf *leaf, const remainder_at *e, const double x[2], const remainder_at *mid,
                    const remainder_at *f, const double y[2], double found[BOUNDS])
{
    const double apart = fmax(fabs(x[0] - y[0]), fabs(x[1] - y[1]));
    for (int k = 0; k < BOUNDS; ++k) found[k] = 0;
    for (int c = 0; c < 3; ++c) {
        const double bend = (fabs(e->rs[c] - f->rs[c]) + fabs(e->rt[c] - f->rt[c])) / apart;
        const double a = e->rs[c] + f->rs[c] - 2 * mid->rs[c], b = e->rt[c] + f->rt[c] - 2 * mid->rt[c];
        const double twist = (fabs(a) + fabs(b)) / (0.75 * apart * apart);
        const int h = c == 2; /* each is followed by its like for the height */
        found[SIDE + h] = fmax(found[SIDE + h], fabs(e->r[c]));
        found[BEND_ST + h] = fmax(found[BEND_ST + h], bend);
        found[TWIST_ST + h] = fmax(found[TWIST_ST + h], twist);
    }
    const double u[2] = {x[0] + e->r[0], x[1] + e->r[1]};
    const double m[2] = {form(leaf, 0, u, u) / 2, form(leaf, 1, u, u) / 2};
    found[GRAPH] = fabs(e->r[2] - leaf->middle - form(leaf, 2, u, u) / 2);
    for (int c = 0; c < 2; ++c) {
        found[FOOT] = fmax(found[FOOT], fabs(u[c] - m[c] - x[c]));
        found[STRETCH] = fmax(found[STRETCH], fabs(e->rs[c]) + fabs(e->rt[c]));
    }
    const double cofactors[2] = {fabs(1 + e->rt[1]) + fabs(e->rt[0]), fabs(1 + e->rs[0]) + fabs(e->rs[1])};
    found[SIGMA] = fmax(cofactors[0], cofactors[1]);
}

static void bounds_of(const ep_leaf *leaf, bool triangle, double bound[BOUNDS])
{
    const double all[BOUNDS] = {(double)ep_leaf_side(leaf, triangle),
                                leaf->height,
                                leaf->bend_st,
                                leaf->bend_h,
                                leaf->twist_st,
                                leaf->twist_h,
                                leaf->graph,
                                leaf->foot,
                                leaf->stretch < EP_STRETCH ? (double)leaf->stretch / EP_STRETCH : INFINITY,
                                leaf->sigma};
    for (int k = 0; k < BOUNDS; ++k) bound[k] = all[k];
}

static void check_leaf(const test_patch *p, const ep_hierarchy *h, where w, rng *r)
{
    const ep_leaf *leaf = &h->leaves[w.leaf];
    const ep_box *box = &h->boxes[w.leaf];
    const ep_patch *patch = &h->patches[0];
    const piece piece = piece_of(p, h, w.leaf);
    const double corner = piece_corner(&piece);
    double noise[3], bound[BOUNDS], y[2] = {corner, corner};
    for (int row = 0; row < 3; ++row) noise[row] = piece_noise(&piece, row);
    bounds_of(leaf, p->shape.triangle, bound);
    remainder_at last = evaluate(&piece, y);
    for (int k = 0; k < 40; ++k) {
        double x[2];
        sample(r, p->shape.triangle, x);
        x[0] += corner, x[1] += corner;
        const remainder_at e = evaluate(&piece, x);
        for (int c = 0; c < 3; ++c)
            CHECK(box->lower[c] <= e.p[c] && e.p[c] <= box->upper[c],
                  "%s patch %d, leaf %zu: %c is %.17g outside [%.9g, %.9g]", w.style, w.patch, w.leaf, "xyz"[c], e.p[c],
                  box->lower[c], box->upper[c]);
        if (!(leaf->height < INFINITY)) continue; /* left to subdivision */

        const double apart = fmax(fabs(x[0] - y[0]), fabs(x[1] - y[1]));
        double found[BOUNDS], r_net[3];
        const remainder_at mid = evaluate(&piece, (const double[2]){0.5 * (x[0] + y[0]), 0.5 * (x[1] + y[1])});
        measure(leaf, &e, x, &mid, &last, y, found);
        for (int b = 0; b < BOUNDS && apart > 0; ++b) {
            const double by = b == BEND_ST || b == BEND_H     ? apart
                              : b == TWIST_ST || b == TWIST_H ? apart * apart / 8
                                                              : 1;
            const double rounding = fmax(noise[0], fmax(noise[1], noise[2])) / by;
            CHECK(found[b] <= bound[b] + rounding, "%s patch %d, leaf %zu, %s at %.17g %.17g: %.9g > %.9g", w.style,
                  w.patch, w.leaf, names[b], x[0], x[1], found[b], bound[b]);
        }
        sum_powers(patch, leaf, h->nets + leaf->net, x[0], x[1], r_net);
        for (int c = 0; c < 3; ++c) {
            const double limit = (double)(c < 2 ? leaf->noise_st : leaf->noise_h), off = fabs(r_net[c] - e.r[c]);
            CHECK(off <= limit + noise[c], "%s patch %d, leaf %zu, at %.17g %.17g: %.9g > %.9g", w.style, w.patch,
                  w.leaf, x[0], x[1], off, limit);
        }
        y[0] = x[0], y[1] = x[1];
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

/* One coordinate of a leaf that is a patch is a single power: then the bounds are as good as they can be, and half of
 * one would not hold. */
static void attained(void **state)
{
    (void)state;
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = 0;
    double best[BOUNDS] = {0};
    for (unsigned k = 0; k < 2 * 3 * 12; ++k) {
        static const unsigned power[12][2] = {{2, 0}, {1, 1}, {0, 2}, {3, 0}, {2, 1}, {1, 2},
                                              {0, 3}, {4, 0}, {3, 1}, {2, 2}, {1, 3}, {0, 4}};
        const unsigned *ij = power[k % 12], c = k / 12 % 3;
        const bool triangle = k / 36;
        rng r = rng_split(6, 0, k);
        double axes[3][3], x[3];
        test_patch p;
        skew_axes(&r, 0.2, axes);
        for (int a = 0; a < 3; ++a)
            axes[2][a] = axes[0][(a + 1) % 3] * axes[1][(a + 2) % 3] - axes[0][(a + 2) % 3] * axes[1][(a + 1) % 3];
        zero_patch((net_shape){triangle, 4, 4}, &p);
        add_power(&p, 1, 0, axes[0]);
        add_power(&p, 0, 1, axes[1]);
        for (int a = 0; a < 3; ++a) x[a] = 0.3 * axes[c][a];
        add_power(&p, ij[0], ij[1], x);
        EPGeometry g = new_geometry(&p, 1, &settings);
        assert_int_equal(g->hierarchy.leaf_count, 1);
        const ep_leaf *leaf = &g->hierarchy.leaves[0];
        const piece piece = piece_of(&p, &g->hierarchy, 0);
        double bound[BOUNDS], most[BOUNDS] = {0};
        bounds_of(leaf, triangle, bound);
        for (int i = 0; i < 400; ++i) {
            double at[2], y[2], found[BOUNDS];
            sample(&r, triangle, at);
            sample(&r, triangle, y);
            for (int a = 0; a < 2; ++a) {
                at[a] += piece_corner(&piece);
                y[a] = at[a] + 0.02 * (y[a] + piece_corner(&piece) - at[a]);
            }
            if (fmax(fabs(at[0] - y[0]), fabs(at[1] - y[1])) < 1e-3) continue;
            const remainder_at e = evaluate(&piece, at), f = evaluate(&piece, y);
            const remainder_at mid = evaluate(&piece, (const double[2]){0.5 * (at[0] + y[0]), 0.5 * (at[1] + y[1])});
            measure(leaf, &e, at, &mid, &f, y, found);
            for (int b = 0; b < BOUNDS; ++b) most[b] = fmax(most[b], found[b]);
        }
        for (int b = 0; b < BOUNDS; ++b) {
            const double rounding = b == TWIST_ST || b == TWIST_H ? 1e-7 : 1e-9;
            CHECK(most[b] <= bound[b] + rounding, "%s s^%u t^%u in %u: %s: %.9g > %.9g",
                  triangle ? "triangle" : "tensor", ij[0], ij[1], c, names[b], most[b], bound[b]);
            if (bound[b] > 1e-3) best[b] = fmax(best[b], most[b] / bound[b]);
        }
        epReleaseGeometry(g);
    }
    for (int b = 0; b < BOUNDS; ++b) CHECK(best[b] > 0.9, "%s: no more than %.3g of the bound", names[b], best[b]);
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
        cmocka_unit_test(attained),
        cmocka_unit_test(leaves_tile_the_domain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
