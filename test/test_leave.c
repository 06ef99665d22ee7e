/* test_leave.c - is a hit as near to the surface as epGetHitError says, and can a ray leave it?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Distance from x to the surface, by Gauss-Newton from u, v without a domain. */
static double distance(const test_patch *p, double u, double v, const double x[3])
{
    double d[3], y[3], yu[3], yv[3];
    for (int k = 0; k < 20; ++k) {
        evaluate_patch(p, u, v, y, yu, yv);
        for (int c = 0; c < 3; ++c) d[c] = x[c] - y[c];
        const double a = dot(yu, yu), b = dot(yu, yv), e = dot(yv, yv), f = dot(yu, d), g = dot(yv, d);
        const double det = a * e - b * b;
        if (!(det > 1e-20 * a * e)) break;
        u += (f * e - b * g) / det;
        v += (a * g - f * b) / det;
    }
    return sqrt(dot(d, d));
}

static void leave(uint64_t seed, patch_limits limits, double scale, const double offset[3])
{
    unsigned hits = 0;
    for (uint64_t k = 0; k < 60; ++k) {
        rng r = rng_split(seed, 0, k);
        test_patch p;
        random_patch(&r, k % 3 ? STYLE_GENTLE : STYLE_WILD, k % 2, limits, &p);
        move_patch(&p, scale, offset);
        oracle *o = new_oracle(&p, 1);
        test_scene s = new_scene(&p, 1, NULL);
        for (int i = 0; i < 300; ++i) {
            float org[3], dir[3];
            aim(o, (aim_kind)(i % AIM_KINDS), &r, org, dir);
            const judge_answer a = trace_one(s.scene, org, dir, 0, INFINITY);
            if (!(a.t < INFINITY)) continue;
            const float error = epGetHitError(s.geometry, 0, org, dir, (float)a.t);
            double x[3];
            for (int c = 0; c < 3; ++c) x[c] = org[c] + a.t * dir[c];
            const double off = distance(&p, a.u, a.v, x);
            CHECK(off <= error, "patch %d: %s: %g from the surface, not %g", (int)k, ray_text(org, dir), off, error);
            ++hits;

            /* a new ray from there, along a random direction of the side it leaves to */
            const double length = sqrt(dot(a.normal, a.normal));
            if (!(length > 0)) continue;
            const double side = rng_sign(&r);
            float from[3], to[3];
            double d[3], up = 0, ahead = 0, away = 0;
            rng_direction(&r, d);
            for (int c = 0; c < 3; ++c) up += d[c] * side * a.normal[c] / length;
            for (int c = 0; c < 3; ++c) {
                to[c] = (float)(up < 0 ? -d[c] : d[c]);
                const float hit = org[c] + (float)a.t * dir[c];
                /* as an app would: the bound, and the rounding of this sum */
                const float step = error + 0x1p-22f * fabsf(hit);
                from[c] = hit + step * (float)(side * a.normal[c] / length);
            }
            const judge_answer again = trace_one(s.scene, from, to, 0, INFINITY);
            if (!(again.t < INFINITY)) continue;
            for (int c = 0; c < 3; ++c) {
                ahead += again.t * to[c] * again.t * to[c];
                away += again.normal[c] * a.normal[c];
            }
            /* the same sheet again: next to where it started, with the same normal */
            away /= length * sqrt(dot(again.normal, again.normal));
            CHECK(!(sqrt(ahead) < 4 * error && fabs(away) > 0.999), "patch %d: %s: leaves by %g and hits again at %g",
                  (int)k, ray_text(org, dir), error, sqrt(ahead));
        }
        free_scene(&s);
        oracle_free(o);
    }
    assert_true(hits > 3000);
}

static void here(void **state)
{
    (void)state;
    leave(1, (patch_limits){6, 1}, 1, (double[3]){0, 0, 0});
}

static void rational(void **state)
{
    (void)state;
    leave(2, (patch_limits){4, 10}, 1, (double[3]){0, 0, 0});
}

static void far_away(void **state)
{
    (void)state;
    leave(3, (patch_limits){4, 1}, 1, (double[3]){1000, -3000, 500});
}

static void small(void **state)
{
    (void)state;
    leave(4, (patch_limits){4, 1}, 1e-4, (double[3]){0, 0, 0});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(here),
        cmocka_unit_test(rational),
        cmocka_unit_test(far_away),
        cmocka_unit_test(small),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
