/* test_trim.c - points and domains against a slow reference.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Seeds are fixed; every failure names the case, and EP_TRIM_CASE=N runs that one alone. */
#include "test/test_trim.h"

#include <stdio.h>
#include <stdlib.h>

/* Nearer to a border than this, rounding and the reference's chords may decide. */
static const double band = 2e-5;

static bool wanted(unsigned k)
{
    const char *only = getenv("EP_TRIM_CASE");
    return !only || strtoul(only, NULL, 10) == k;
}

static const trim_style styles[] = {{0, 1, 3}, {0, 20, 5}, {0.125, 1, 3}, {0.125, 4, 4}};

static trim_shape *shape_of_case(unsigned k)
{
    rng r = rng_split(4, 0, k);
    return random_shape(&r, 1 + k / EP_ARRAY_LEN(styles) % 4, styles[k % EP_ARRAY_LEN(styles)]);
}

static void points_anywhere(void **state)
{
    (void)state;
    unsigned points = 0, decided = 0;
    for (unsigned k = 0; k < 160; ++k) {
        if (!wanted(k)) continue;
        trim_shape *s = shape_of_case(k);
        ep_trim *trim = new_trim(s);
        rng r = rng_split(4, 1, k);
        for (int i = 0; i < 300; ++i) {
            double x = rng_in(&r, -0.5, 1.5), y = rng_in(&r, -0.5, 1.5);
            /* level with corners as often as not */
            if (i % 3 == 0) y = floor(y * 16) / 16;
            if (i % 3 == 1) x = floor(x * 16) / 16;
            const shape_side want = shape_at(s, x, y, band);
            const bool got = ep_trim_has_point(trim, x, y);
            ++points;
            decided += want != SHAPE_NEAR;
            if (want != SHAPE_NEAR && (want == SHAPE_IN) != got)
                FAIL("case %u: (%.17g, %.17g) is %d, not %d", k, x, y, want, got);
        }
        ep_trim_free(trim);
        shape_free(s);
    }
    CHECK(decided > 0.9 * points, "%u of %u points are too near to a border", points - decided, points);
}

/* What a domain of a random hierarchy is found to be, checked with points in it. */
typedef struct walk {
    const trim_shape *shape;
    const ep_trim *trim;
    unsigned number;
    rng r;
    ep_trim_store store;
} walk;

static void point_in(const ep_trim_domain *d, rng *r, double *x, double *y)
{
    double sum = 0;
    *x = *y = 0;
    const unsigned corner = rng_below(r, d->count + 2); /* at a corner, or anywhere */
    for (unsigned i = 0; i < d->count; ++i) {
        const double w = corner < d->count ? i == corner : rng_unit(r);
        sum += w, *x += w * d->corner[i][0], *y += w * d->corner[i][1];
    }
    *x /= sum, *y /= sum;
}

/* No border within reach: all points of the domain there are on the same side. */
static void check_square(walk *w, const ep_trim_domain *d, double u, double v, double reach, uint32_t want)
{
    for (int i = 0; i < 4 && reach > 0; ++i) {
        double x, y;
        point_in(d, &w->r, &x, &y);
        /* as near as it has to be, on the way there */
        const double far = fmax(fabs(x - u), fabs(y - v)), f = far > reach ? 0.99 * reach / far : 0.99;
        x = u + f * (x - u), y = v + f * (y - v);
        if (ep_trim_has_point(w->trim, x, y) != want)
            FAIL("case %u: (%.17g, %.17g) is not as (%.17g, %.17g), %g around it", w->number, x, y, u, v, reach);
    }
}

static void check_domain(walk *w, const ep_trim_domain *d, const ep_trim_part *part)
{
    float u[16], v[16];
    uint32_t want = 0;
    for (unsigned i = 0; i < 16; ++i) {
        double x, y;
        point_in(d, &w->r, &x, &y);
        u[i] = (float)x, v[i] = (float)y;
        want |= (uint32_t)ep_trim_has_point(w->trim, u[i], v[i]) << i;
        const shape_side side = i % 4 == 0 ? shape_at(w->shape, u[i], v[i], band) : SHAPE_NEAR;
        if (side != SHAPE_NEAR && (want >> i & 1) != (side == SHAPE_IN))
            FAIL("case %u: (%.9g, %.9g) is not %u", w->number, u[i], v[i], want >> i & 1);
    }
    if (part->state == EP_TRIM_CROSSED) {
        ep_message m;
        uint32_t node;
        if (ep_trim_keep(w->trim, part, d, &w->store, &node, &m)) FAIL("%s", m.text);
        const uint32_t mask = (uint32_t)rng_bits(&w->r) & 0xffff;
        const uint32_t got = ep_trim_inside(w->trim, w->store.words, node, 16, u, v, mask);
        for (unsigned i = 0; i < 16; ++i)
            if (((want & mask) ^ got) >> i & 1)
                FAIL("case %u: (%.9g, %.9g) is %u in the plane and %u in a leaf", w->number, u[i], v[i], want >> i & 1,
                     got >> i & 1);
        uint32_t open;
        const double reach = ldexp(1, -4 - (int)rng_below(&w->r, 24));
        const uint32_t in = ep_trim_sift(w->trim, w->store.words, node, 16, u, v, mask, reach, &open);
        CHECK(!(in & open) && !((in | open) & ~mask) && in == (want & mask & ~open), "case %u: %x of %x, %x open",
              w->number, in, want & mask, open);
        for (unsigned i = 0; i < 16; ++i)
            check_square(w, d, u[i], v[i], mask & ~open & 1u << i ? reach : 0, want >> i & 1);
    } else if (want != (part->state == EP_TRIM_INSIDE ? 0xffff : 0)) {
        FAIL("case %u: state %d, points %x, near (%.9g, %.9g)", w->number, part->state, want, u[0], v[0]);
    }
}

/* Domains of a hierarchy: halves of rectangles, and triangles cut from an edge. */
static void walk_domain(walk *w, const ep_trim_domain *d, const ep_trim_part *parent, int depth)
{
    ep_message m;
    ep_trim_part part;
    if (ep_trim_cut(w->trim, parent, d, &part, &m)) FAIL("%s", m.text);
    if (depth % 3 == 2 || part.state != EP_TRIM_CROSSED) check_domain(w, d, &part);
    if (depth < 8 && part.state == EP_TRIM_CROSSED) {
        const double f = rng_below(&w->r, 2) ? 0.5 : rng_in(&w->r, 0.1, 0.9);
        for (int side = 0; side < 2; ++side) {
            ep_trim_domain half;
            if (d->count == 3) {
                const unsigned k = (unsigned)depth % 3;
                double mid[2];
                for (int c = 0; c < 2; ++c) mid[c] = (float)((1 - f) * d->corner[k][c] + f * d->corner[(k + 1) % 3][c]);
                ep_point2 p[3];
                for (int c = 0; c < 2; ++c) {
                    p[0][c] = d->corner[(k + 2) % 3][c];
                    p[1][c] = side ? mid[c] : d->corner[k][c];
                    p[2][c] = side ? d->corner[(k + 1) % 3][c] : mid[c];
                }
                half = ep_domain_polygon(3, p, d->margin);
            } else {
                ep_point2 lo, hi;
                ep_domain_bounds(d, lo, hi);
                (side ? lo : hi)[depth & 1] = (float)((1 - f) * lo[depth & 1] + f * hi[depth & 1]);
                half = ep_domain_rectangle(lo[0], hi[0], lo[1], hi[1], d->margin);
            }
            walk_domain(w, &half, &part, depth + 1);
        }
    }
    ep_trim_part_free(&part);
}

static void domains(void **state)
{
    (void)state;
    for (unsigned k = 0; k < 80; ++k) {
        if (!wanted(k)) continue;
        walk w = {.number = k, .shape = shape_of_case(k), .r = rng_split(4, 2, k)};
        w.trim = new_trim((trim_shape *)w.shape);
        const ep_trim_domain square = ep_domain_rectangle(0, 1, 0, 1, 0x1p-20);
        const ep_trim_domain triangle = ep_domain_polygon(3, (const ep_point2[]){{0, 0}, {1, 0}, {0, 1}}, 0x1p-20);
        walk_domain(&w, k & 1 ? &square : &triangle, &w.trim->root, 0);
        ep_free(w.store.words);
        ep_trim_free((ep_trim *)w.trim);
        shape_free((trim_shape *)w.shape);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_anywhere),
        cmocka_unit_test(domains),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
