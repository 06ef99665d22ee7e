/* test_leave.c - is a hit as near to the surface as epGetHitError says, and can a ray leave it?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/support.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Distance from x to the surface, by Gauss-Newton from u, v without a domain; at a pole that may go anywhere. */
static double distance(const test_patch *p, double u, double v, const double x[3])
{
    double d[3], y[3], yu[3], yv[3], least = INFINITY;
    for (int k = 0; k < 20; ++k) {
        evaluate_patch(p, u, v, y, yu, yv);
        for (int c = 0; c < 3; ++c) d[c] = x[c] - y[c];
        least = fmin(least, sqrt(dot(d, d)));
        const double a = dot(yu, yu), b = dot(yu, yv), e = dot(yv, yv), f = dot(yu, d), g = dot(yv, d);
        const double det = a * e - b * b;
        if (!(det > 1e-20 * a * e)) break;
        u += (f * e - b * g) / det;
        v += (a * g - f * b) / det;
    }
    return least;
}

/* A new ray from a hit, along a random direction of the side that it leaves to. False where there is no normal. */
static bool new_ray(rng *r, const float org[3], const float dir[3], const judge_answer *a, float error, float from[3],
                    float to[3])
{
    const double length = sqrt(dot(a->normal, a->normal)), side = rng_sign(r);
    double d[3], up = 0;
    if (!(length > 0)) return false;
    rng_direction(r, d);
    for (int c = 0; c < 3; ++c) up += d[c] * side * a->normal[c] / length;
    for (int c = 0; c < 3; ++c) {
        to[c] = (float)(up < 0 ? -d[c] : d[c]);
        const float hit = org[c] + (float)a->t * dir[c];
        /* as an app would: the bound, and the rounding of this sum */
        const float step = error + 0x1p-22f * fabsf(hit);
        from[c] = hit + step * (float)(side * a->normal[c] / length);
    }
    return true;
}

/* Whether the ray's hit is a point of the surface that lies behind its origin. */
static bool hits_behind(const oracle *o, const float from[3], const float to[3], const judge_answer *a)
{
    const double org[3] = {from[0], from[1], from[2]}, dir[3] = {to[0], to[1], to[2]};
    oracle_root roots[ORACLE_ROOTS];
    const size_t count = oracle_intersect(o, org, dir, -INFINITY, INFINITY, roots);
    const oracle_root *nearest = NULL;
    for (size_t k = 0; k < count; ++k)
        if (!nearest || fabs(roots[k].t_low - a->t) < fabs(nearest->t_low - a->t)) nearest = &roots[k];
    /* where the ray is tangent, there is no telling */
    return !nearest || (nearest->t_low == nearest->t_high && nearest->t_low <= 0);
}

typedef struct leave_case {
    uint64_t seed;
    patch_limits limits;
    double scale, offset[3];
    int styles; /* the first so many of them */
} leave_case;

static void leave(const leave_case *c)
{
    unsigned hits = 0;
    for (int k = 0; k < 60; ++k) {
        rng r = rng_split(c->seed, 0, (uint64_t)k);
        test_patch p;
        random_patch(&r, (patch_style)(k / 2 % c->styles), k % 2, c->limits, &p);
        move_patch(&p, c->scale, (double[3]){0, 0, 0});
        move_patch(&p, 1, c->offset);
        oracle *o = new_oracle(&p, 1);
        test_scene s = new_scene(&p, 1, NULL);
        for (int i = 0; i < 300; ++i) {
            float org[3], dir[3], from[3], to[3];
            aim(o, (aim_kind)(i % AIM_KINDS), &r, org, dir);
            const judge_answer a = trace_one(s.scene, org, dir, 0, INFINITY);
            if (!(a.t < INFINITY)) continue;
            const float error = epGetHitError(s.geometry, 0, org, dir, (float)a.t);
            double x[3];
            for (int m = 0; m < 3; ++m) x[m] = org[m] + a.t * dir[m];
            const double off = distance(&p, a.u, a.v, x);
            CHECK(off <= error, "patch %d: %s: %g from the surface, not %g", k, ray_text(org, dir), off, error);
            ++hits;
            if (!new_ray(&r, org, dir, &a, error, from, to)) continue;
            const judge_answer again = trace_one(s.scene, from, to, 0, INFINITY);
            CHECK(!(again.t < INFINITY && hits_behind(o, from, to, &again)),
                  "patch %d: %s: leaves by %g as %s and hits again at %g", k, ray_text(org, dir), error,
                  ray_text(from, to), again.t);
        }
        free_scene(&s);
        oracle_free(o);
    }
    assert_true(hits > 3000);
}

static void here(void **state)
{
    (void)state;
    leave(&(leave_case){1, {6, 1}, 1, {0, 0, 0}, STYLE_DEGENERATE});
}

static void rational(void **state)
{
    (void)state;
    leave(&(leave_case){2, {4, 10}, 1, {0, 0, 0}, STYLE_DEGENERATE});
}

static void far_away(void **state)
{
    (void)state;
    leave(&(leave_case){3, {4, 1}, 1, {1000, -3000, 500}, STYLE_FLAT});
    leave(&(leave_case){4, {4, 3}, 1, {1000, -3000, 500}, STYLE_FLAT});
}

static void small(void **state)
{
    (void)state;
    leave(&(leave_case){5, {4, 1}, 1e-4, {0, 0, 0}, STYLE_DEGENERATE});
    leave(&(leave_case){6, {4, 3}, 1e-4, {4, 0, 0}, STYLE_FLAT});
}

static void huge(void **state)
{
    (void)state;
    leave(&(leave_case){7, {5, 2}, 1e6, {0, 0, 0}, STYLE_DEGENERATE});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(here),  cmocka_unit_test(rational), cmocka_unit_test(far_away),
        cmocka_unit_test(small), cmocka_unit_test(huge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
