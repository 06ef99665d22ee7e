/* test_solve.c - does subdivision find every root, alone?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/solve.h"
#include "test/support.h"

/* A border in the plane x = 0 and rays in that plane: in exact arithmetic they meet the patch at its very border, and
 * the patch on the other side there too. Rounding must not put them outside of both. */
static void at_the_very_border(void **state)
{
    (void)state;
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = 0; /* a leaf is the patch */
    for (uint64_t k = 0; k < 200; ++k) {
        rng r = rng_split(1, 0, k);
        test_patch p;
        random_patch(&r, STYLE_GENTLE, k % 2, (patch_limits){3, 1}, &p);
        for (unsigned j = 0; j <= p.shape.n; ++j) p.points[net_index(p.shape, 0, j)][0] = 0;
        EPGeometry g = new_geometry(&p, 1, &settings);
        assert_int_equal(g->hierarchy.leaf_count, 1);
        for (int i = 0; i < 20; ++i) {
            const double v = rng_in(&r, 0.05, 0.95), angle = rng_in(&r, 0, 6.283185307179586);
            double x[3], xu[3], xv[3];
            evaluate_patch(&p, 0, v, x, xu, xv);
            const double d[3] = {0, cos(angle), sin(angle)};
            /* a crossing, of the border and of the patch */
            if (fabs(xv[1] * d[2] - xv[2] * d[1]) < 0.1 * hypot(xv[1], xv[2]) || fabs(xu[0]) < 0.1) continue;
            float org[3], dir[3];
            for (int c = 0; c < 3; ++c) {
                org[c] = (float)(x[c] - rng_in(&r, 1, 4) * d[c]);
                dir[c] = (float)(x[c] - org[c]);
            }
            /* the patch may meet the ray elsewhere too */
            ep_root root = {.t = 0.9};
            bool found = false;
            while (!found &&
                   ep_solve(&g->hierarchy.patches[0], &g->hierarchy.leaves[0], org, dir, root.t + 1e-9, 1.1, &root))
                found = root.u <= 1e-9 && fabs(root.v - v) <= 1e-4;
            CHECK(found, "patch %d: %s: nothing at v %g", (int)k, ray_text(org, dir), v);
        }
        epReleaseGeometry(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(at_the_very_border),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
