/* test_scale.c - do hits stay right far from the origin, tiny, huge, and from afar?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/hits.h"

#define SOME {STYLE_GENTLE, STYLE_WILD}, 2

static void one_at_3000(void **state)
{
    (void)state;
    check_hits(&(hits_case){1, 24, 320, true, true, {5, 1}, SOME, 1, {3000, -2500, 1700}, 0, 0});
}

static void one_at_3000_rational(void **state)
{
    (void)state;
    check_hits(&(hits_case){2, 16, 320, true, true, {4, 3}, SOME, 1, {-3000, 100, 3000}, 0, 0});
}

static void tiny_seen_from_4(void **state)
{
    (void)state;
    check_hits(&(hits_case){3, 24, 320, true, true, {5, 1}, SOME, 1e-4, {0, 0, 0}, 4, 0});
}

static void tiny_at_10000(void **state)
{
    (void)state;
    check_hits(&(hits_case){4, 24, 320, true, true, {5, 1}, SOME, 1e-4, {10000, 10000, -10000}, 0, 0});
}

static void huge(void **state)
{
    (void)state;
    check_hits(&(hits_case){5, 24, 320, true, true, {5, 1}, SOME, 1e6, {0, 0, 0}, 0, 0});
}

/* What normals are made of is no float any more, but they are. */
static void beyond_floats(void **state)
{
    (void)state;
    check_hits(&(hits_case){8, 8, 320, true, true, {4, 2}, SOME, 1e14, {0, 0, 0}, 0, 0});
    check_hits(&(hits_case){9, 8, 320, true, true, {4, 2}, SOME, 1e-13, {0, 0, 0}, 0, 0});
}

static void from_a_thousand_away(void **state)
{
    (void)state;
    check_hits(&(hits_case){6, 24, 320, true, true, {5, 1}, SOME, 1, {0, 0, 0}, 1000, 0});
}

/* The same patch at powers of two of its size gives the same hits, bit for bit, whether or not directions are as long:
 * nothing knows an absolute length. */
static void powers_of_two(void **state)
{
    (void)state;
    static const double origin[3] = {0, 0, 0};
    for (uint64_t k = 0; k < 12; ++k) {
        rng r = rng_split(7, 0, k);
        test_patch p;
        random_patch(&r, (patch_style)(k % 2), k / 2 % 2, (patch_limits){4, k % 3 ? 1 : 4}, &p);
        for (size_t i = 0; i < net_count(p.shape); ++i)
            for (int c = 0; c < 3; ++c) p.points[i][c] = (float)p.points[i][c];
        oracle *o = new_oracle(&p, 1);
        test_scene one = new_scene(&p, 1, NULL);
        for (int power = -40; power <= 40; power += 20) {
            test_patch q = p;
            move_patch(&q, ldexp(1, power), origin);
            test_scene other = new_scene(&q, 1, NULL);
            assert_true(one.geometry->hierarchy.leaf_count == other.geometry->hierarchy.leaf_count);
            for (int i = 0; i < 100; ++i) {
                float org[3], dir[3], far_org[3], far_dir[3];
                aim(o, (aim_kind)(i % AIM_KINDS), &r, org, dir);
                for (int c = 0; c < 3; ++c) {
                    far_org[c] = (float)ldexp(org[c], power);
                    far_dir[c] = (float)ldexp(dir[c], power);
                }
                const judge_answer a = trace_one(one.scene, org, dir, 0, INFINITY);
                const judge_answer b = trace_one(other.scene, far_org, far_dir, 0, INFINITY);
                const judge_answer c = trace_one(other.scene, far_org, dir, 0, INFINITY);
                CHECK(a.t == b.t && a.u == b.u && a.v == b.v, "patch %d, 2^%d: %s: t %a and %a", (int)k, power,
                      ray_text(org, dir), a.t, b.t);
                CHECK(c.t == ldexp(a.t, power) && a.u == c.u && a.v == c.v, "patch %d, 2^%d, long: %s: t %a and %a",
                      (int)k, power, ray_text(org, dir), a.t, c.t);
            }
            free_scene(&other);
        }
        free_scene(&one);
        oracle_free(o);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_at_3000),
        cmocka_unit_test(one_at_3000_rational),
        cmocka_unit_test(tiny_seen_from_4),
        cmocka_unit_test(tiny_at_10000),
        cmocka_unit_test(huge),
        cmocka_unit_test(beyond_floats),
        cmocka_unit_test(from_a_thousand_away),
        cmocka_unit_test(powers_of_two),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
