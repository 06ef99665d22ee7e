/* test_taylor.c - do Taylor models contain the functions that they stand for?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A function of a model is its polynomial and anything within `rest` of it; here that is the worst, `rest` itself, now
 * on this side and now on that. */
#include "embree_patch/taylor.h"
#include "test/oracle/rng.h"
#include "test/support.h"

enum { MODELS = 400, POINTS = 200 };

static const ep_monomials pieces[2] = {
    {.corners = 4, .corner = {{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}}},
    {.corners = 3, .corner = {{-1.0 / 3, -1.0 / 3}, {2.0 / 3, -1.0 / 3}, {-1.0 / 3, 2.0 / 3}}},
};

static ep_monomials monomials(bool triangle)
{
    ep_monomials m = pieces[triangle];
    for (unsigned d = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned j = 0; j <= d; ++j)
            m.max[ep_taylor_index(d - j, j)] =
                triangle ? pow(2.0 / 3, fmax(d - j, j)) * pow(1.0 / 3, fmin(d - j, j)) : pow(0.5, d);
    return m;
}

static void point_of(rng *r, bool triangle, double x[2])
{
    /* the border is where most is attained */
    const double edge = rng_below(r, 3) ? 1 : rng_unit(r);
    const ep_monomials *m = &pieces[triangle];
    const unsigned k = rng_below(r, m->corners);
    const double *p = m->corner[k], *q = m->corner[(k + 1) % m->corners], f = rng_unit(r);
    for (int c = 0; c < 2; ++c) x[c] = edge * (p[c] + f * (q[c] - p[c]));
}

static double polynomial(const ep_taylor *a, const double x[2])
{
    double sum = 0;
    for (unsigned d = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned j = 0; j <= d; ++j) sum += a->c[ep_taylor_index(d - j, j)] * pow(x[0], d - j) * pow(x[1], j);
    return sum;
}

static double value(const ep_taylor *a, const double x[2], rng *r)
{
    return polynomial(a, x) + rng_sign(r) * a->rest;
}

static ep_taylor random_model(rng *r, unsigned degree, double rest)
{
    ep_taylor a = {.rest = rest * rng_unit(r)};
    for (unsigned n = 0; n < ep_taylor_index(degree + 1, 0); ++n) a.c[n] = rng_in(r, -1, 1);
    return a;
}

static void check_within(const ep_taylor *a, double f, const double x[2], const char *what, int k)
{
    const double off = fabs(f - polynomial(a, x));
    CHECK(off <= a->rest + 1e-14 * (1 + fabs(f)), "%s %d at %.17g %.17g: off by %.9g, not %.9g", what, k, x[0], x[1],
          off, a->rest);
}

static void products_and_quotients(void **state)
{
    (void)state;
    for (int k = 0; k < MODELS; ++k) {
        rng r = rng_split(1, 0, (uint64_t)k);
        const bool triangle = k % 2;
        const ep_monomials m = monomials(triangle);
        /* products of degree two have no terms but these and the rests' */
        const unsigned degree = k / 2 % 2 ? 2 : EP_TAYLOR_DEGREE;
        const ep_taylor a = random_model(&r, degree, 0.1);
        ep_taylor b = random_model(&r, degree, 0.1);
        const double by = rng_in(&r, -2, 2);
        b.c[0] = 4; /* the others, on the piece, add up to less than 3 */
        const ep_taylor product = ep_taylor_multiply(&a, &b, &m), quotient = ep_taylor_divide(&a, &b, 1, &m),
                        sum = ep_taylor_add(&a, by, &b);
        for (int i = 0; i < POINTS; ++i) {
            double x[2];
            point_of(&r, triangle, x);
            const double f = value(&a, x, &r), g = value(&b, x, &r);
            check_within(&product, f * g, x, "product", k);
            check_within(&quotient, f / g, x, "quotient", k);
            check_within(&sum, f + by * g, x, "sum", k);
        }
    }
}

/* Linear terms against cubic ones, as a leaf's frame leaves them, alone and with all others. */
static void ranges(void **state)
{
    (void)state;
    for (int k = 0; k < MODELS; ++k) {
        rng r = rng_split(2, 0, (uint64_t)k);
        const bool triangle = k % 2, odd = k / 2 % 2;
        const ep_monomials m = monomials(triangle);
        ep_taylor a = random_model(&r, EP_TAYLOR_DEGREE, odd ? 0 : 0.01);
        for (unsigned n = 0; odd && n < EP_TAYLOR_TERMS; ++n)
            if (n != 1 && n != 2 && (n < 6 || n > 9)) a.c[n] = 0;
        for (unsigned n = 1; n <= 2; ++n) a.c[n] = -0.25 * rng_unit(&r) * (a.c[n == 1 ? 6 : 9] + a.c[n == 1 ? 8 : 7]);
        const ep_range bound = ep_taylor_range(&a, &m);
        ep_range found = EP_NOTHING;
        for (int i = 0; i < 10 * POINTS; ++i) {
            double x[2];
            point_of(&r, triangle, x);
            const double scale = i % 2 ? rng_unit(&r) : 1;
            x[0] *= scale, x[1] *= scale;
            ep_include(&found, value(&a, x, &r));
        }
        CHECK(bound.lo <= found.lo && found.hi <= bound.hi, "model %d: [%.9g, %.9g] is not in [%.9g, %.9g]", k,
              found.lo, found.hi, bound.lo, bound.hi);
        if (odd)
            CHECK(ep_half(bound) <= 1.75 * ep_half(found), "model %d: [%.9g, %.9g] for [%.9g, %.9g]", k, bound.lo,
                  bound.hi, found.lo, found.hi);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_and_quotients),
        cmocka_unit_test(ranges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
