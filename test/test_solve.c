/* test_solve.c - does subdivision find every root, alone? And does polishing go to the one that it begins near?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/kernels.h"
#include "embree_patch/line.h"
#include "embree_patch/polish.h"
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

/* A ray in the plane of a flat patch, along its sides or askew, is in the surface from its border on: the first root is
 * where it comes in. */
static void within_a_flat_patch(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 60; ++k) {
        rng r = rng_split(3, 0, k);
        const bool triangle = k % 2;
        const unsigned n = 1 + rng_below(&r, 4);
        test_patch p = {.shape = {triangle, n, n}};
        for (unsigned j = 0; j <= n; ++j)
            for (unsigned i = 0; net_has(p.shape, i, j); ++i) {
                double *x = p.points[net_index(p.shape, i, j)];
                x[0] = (double)i / n, x[1] = (double)j / n, x[2] = 0, x[3] = 1;
            }
        test_scene s = new_scene(&p, 1, NULL);
        for (int i = 0; i < 12; ++i) {
            const int axis = i % 3; /* along u, along v, askew */
            const double at = rng_in(&r, 0.1, 0.4), slope = axis == 2 ? rng_in(&r, 0.05, 0.5) : 0;
            float org[3] = {-1, (float)at, 0}, dir[3] = {1, (float)slope, 0};
            if (axis == 1) org[0] = (float)at, org[1] = -1, dir[0] = 0, dir[1] = 1;
            if ((double)org[1] + slope > 0.9) continue;
            const judge_answer a = trace_one(s.scene, org, dir, 0, INFINITY);
            CHECK(fabs(a.t - 1) < 1e-5, "%s %u: %s: t %.9g", triangle ? "triangle" : "tensor", n, ray_text(org, dir),
                  a.t);
        }
        free_scene(&s);
    }
}

/* A triangle that is no more than a line, two of its corners being one point, with weights far apart: in homogeneous
 * coordinates it is no line, and Newton's method ends beside the domain. What is taken for a root has to be at the ray.
 */
static void past_a_line(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 2000; ++k) {
        rng r = rng_split(4, 0, k);
        test_patch p = {.shape = {true, 1, 1}};
        for (unsigned i = 0; i < 3; ++i) p.points[i][3] = rng_scale(&r, 0.02, 50);
        for (int c = 0; c < 3; ++c) p.points[1][c] = rng_in(&r, -1, 1);
        EPGeometry g = new_geometry(&p, 1, NULL);
        const double at = rng_scale(&r, 1e-4, 1);
        const int axis = (int)rng_below(&r, 3);
        float org[3], dir[3] = {0};
        for (int c = 0; c < 3; ++c) org[c] = (float)(at * p.points[1][c]);
        org[axis] = 2;
        dir[axis] = -1;
        for (size_t i = 0; i < g->hierarchy.leaf_count; ++i) {
            ep_root root;
            if (!ep_solve(&g->hierarchy.patches[0], &g->hierarchy.leaves[i], org, dir, 0, INFINITY, &root) ||
                !root.crossing)
                continue;
            double x[3], xu[3], xv[3], off = 0;
            evaluate_patch(&p, root.u, root.v, x, xu, xv);
            for (int c = 0; c < 3; ++c) off = fmax(off, fabs(x[c] - (double)org[c] - root.t * (double)dir[c]));
            CHECK(off < 1e-6, "%s: t %.9g, u %.9g, v %.9g: %.3g off the ray", ray_text(org, dir), root.t, root.u,
                  root.v, off);
        }
        epReleaseGeometry(g);
    }
}

/* How far a point is from the line that is to have a piece without a frame near it. `across`: lines through the point
 * in that direction are as far away. */
static double away(const ep_leaf *leaf, const double x[3], double across[3])
{
    double from[3], cross2 = 0, length2 = 0;
    for (int c = 0; c < 3; ++c) from[c] = x[c] - leaf->centre[c] - leaf->centre_low[c];
    for (int c = 0; c < 3; ++c) {
        const double a = leaf->frame[(c + 1) % 3][0], b = leaf->frame[(c + 2) % 3][0];
        across[c] = from[(c + 1) % 3] * b - from[(c + 2) % 3] * a;
        cross2 += across[c] * across[c];
        length2 += (double)leaf->frame[c][0] * leaf->frame[c][0];
    }
    for (int c = 0; c < 3; ++c) across[c] /= cross2 > 0 ? sqrt(cross2) : 1;
    return sqrt(cross2 / length2);
}

/* Pieces without a frame, poles and lines: all of one is as near to its line as it says, rays at that distance and a
 * little more are told from it, and none that subdivision finds a root for. */
static void past_pieces_without_a_frame(void **state)
{
    (void)state;
    unsigned long met = 0, told = 0, wide = 0;
    for (uint64_t k = 0; k < 600; ++k) {
        rng r = rng_split(5, 0, k);
        test_patch p;
        random_patch(&r, k % 3 ? STYLE_DEGENERATE : STYLE_COLLAPSED, k % 2, (patch_limits){6, k % 5 ? 1 : 4}, &p);
        const double offset[3] = {rng_in(&r, -100, 100), 0, 3};
        if (k % 4 == 0) move_patch(&p, rng_scale(&r, 1e-3, 1e3), offset);
        EPGeometry g = new_geometry(&p, 1, NULL);
        const ep_patch *patch = &g->hierarchy.patches[0];
        for (size_t i = 0; i < g->hierarchy.leaf_count; ++i) {
            const ep_leaf *leaf = &g->hierarchy.leaves[i];
            if (leaf->height < INFINITY || (i > 40 && rng_below(&r, 50))) continue;
            const ep_domain d = ep_leaf_domain(leaf);
            for (int n = 0; n < 20; ++n) {
                double s = rng_unit(&r), t = rng_unit(&r), x[3], xu[3], xv[3];
                if (rng_below(&r, 2)) s = rng_below(&r, 2);
                if (rng_below(&r, 2)) t = rng_below(&r, 2);
                if (p.shape.triangle && s + t > 1) s = 1 - s, t = 1 - t;
                evaluate_patch(&p, d.u0 + s * d.uu + t * d.uv, d.v0 + s * d.vu + t * d.vv, x, xu, xv);
                const double rounding = 0x1p-50 * (fabs(x[0]) + fabs(x[1]) + fabs(x[2]));
                double across[3];
                const double far = away(leaf, x, across);
                CHECK(far <= (double)leaf->foot + rounding, "patch %lu, leaf %zu: %.9g > %.9g", (unsigned long)k, i,
                      far, leaf->foot);
                float org[3], dir[3], lo[3];
                const double by = rng_scale(&r, 1e-7, 1) * patch->radius;
                for (int c = 0; c < 3; ++c) {
                    lo[c] = (float)(x[c] + (n % 2 ? by * rng_in(&r, -1, 1) : 0));
                    dir[c] = n % 4 ? (float)rng_in(&r, -1, 1) : (float)across[c] + 0.1f * leaf->frame[c][0];
                    org[c] = lo[c] - dir[c];
                }
                ep_root root;
                ep_line l;
                double from = -INFINITY, to = INFINITY;
                assert_true(ep_line_of(patch, org, dir, &l));
                const bool near = ep_line_clip(patch, leaf, &l, &from, &to);
                const bool found = ep_solve(patch, leaf, org, dir, -INFINITY, INFINITY, &root);
                CHECK(near || !found, "patch %lu, leaf %zu: %s: a root at %.9g is passed by", (unsigned long)k, i,
                      ray_text(org, dir), root.t);
                met += found;
                told += !near;
                wide += near && !found;
            }
        }
        epReleaseGeometry(g);
    }
    CHECK(met > 100 && told > 3 * wide, "%lu met, %lu told, %lu not", met, told, wide);
}

/* From up to 2^-9 away, polishing has to end where the surface meets the ray, with the surface's normal there: as well
 * as doubles tell, whatever the number of steps. */
static void polished_roots(void **state)
{
    (void)state;
    int polished = 0, tried = 0;
    for (uint64_t k = 0; k < 400; ++k) {
        rng r = rng_split(2, 0, k);
        test_patch p;
        random_patch(&r, k % 4 < 2 ? STYLE_GENTLE : STYLE_WILD, k % 2, (patch_limits){6, k % 3 ? 1 : 4}, &p);
        EPGeometry g = new_geometry(&p, 1, NULL);
        for (int i = 0; i < 20; ++i) {
            double u = rng_in(&r, 0.05, 0.95), v = rng_in(&r, 0.05, 0.95), x[3], xu[3], xv[3], n[3], nn = 0, nd = 0;
            if (p.shape.triangle && u + v > 0.95) u = 0.5 * u, v = 0.4 * v;
            evaluate_patch(&p, u, v, x, xu, xv);
            float org[3], dir[3], field[5] = {0};
            double dd = 0, size = 0;
            for (int c = 0; c < 3; ++c) {
                org[c] = (float)(x[c] + rng_in(&r, -3, 3));
                dir[c] = (float)(x[c] - org[c]);
                dd += (double)dir[c] * dir[c];
                n[c] = xu[(c + 1) % 3] * xv[(c + 2) % 3] - xu[(c + 2) % 3] * xv[(c + 1) % 3];
                nn += n[c] * n[c];
                nd += n[c] * (double)dir[c];
                size += fabs(xu[c]) + fabs(xv[c]);
            }
            if (!(fabs(nd) > 0.2 * sqrt(nn * dd) && sqrt(nn) > 0.05 * size * size)) continue;
            const double away = rng_scale(&r, 0x1p-24, 0x1p-9);
            float t = (float)(1 + rng_in(&r, -away, away));
            field[EP_HIT_U] = (float)(u + rng_in(&r, -away, away));
            field[EP_HIT_V] = (float)(v + rng_in(&r, -away, away));
            double exact[2];
            const ep_leaf whole = {.domain = {0, 0, 1, 1, 0, 0}};
            ++tried;
            if (ep_polish(&g->hierarchy.patches[0], &whole, org, dir, &t, field, exact) != EP_POLISHED) continue;
            ++polished;
            evaluate_patch(&p, exact[0], exact[1], x, xu, xv);
            double along = 0, off[3], most = 0;
            for (int c = 0; c < 3; ++c) along += (x[c] - (double)org[c]) * (double)dir[c] / dd;
            for (int c = 0; c < 3; ++c)
                off[c] = x[c] - (double)org[c] - along * (double)dir[c], most += off[c] * off[c];
            CHECK(sqrt(most) <= 1e-10 * (size + sqrt(dd)), "patch %d: %s: from %.2g away: %.3g off the ray", (int)k,
                  ray_text(org, dir), away, sqrt(most));
            CHECK(fabs((double)t - along) <= 1e-7 * fabs(along), "patch %d: t is %.9g, not %.9g", (int)k, t, along);
            for (int c = 0; c < 3; ++c) {
                const double want = xu[(c + 1) % 3] * xv[(c + 2) % 3] - xu[(c + 2) % 3] * xv[(c + 1) % 3];
                CHECK(fabs((double)field[c] - want) <= 1e-6 * size * size,
                      "patch %d: %s: from %.2g away: normal %d is %.9g, not %.9g", (int)k, ray_text(org, dir), away, c,
                      field[c], want);
            }
        }
        epReleaseGeometry(g);
    }
    assert_true(tried > 2000 && polished > tried * 9 / 10);
}

/* Points of a leaf, and lines through them: the part that is met along any piece of such a line around the point has
 * it, and is small if the piece is. */
static void parts_that_lines_meet(void **state)
{
    (void)state;
    int small = 0, pieces = 0;
    for (uint64_t k = 0; k < 400; ++k) {
        rng r = rng_split(5, 0, k);
        test_patch p;
        random_patch(&r, k % 4 < 2 ? STYLE_GENTLE : STYLE_WILD, k % 2, (patch_limits){6, k % 3 ? 1 : 4}, &p);
        EPGeometry g = new_geometry(&p, 1, NULL);
        const ep_patch *patch = &g->hierarchy.patches[0];
        ep_point local[EP_NET_POINTS];
        ep_patch_local(patch, local);
        for (int i = 0; i < 100; ++i) {
            const ep_leaf *leaf = &g->hierarchy.leaves[rng_below(&r, (unsigned)g->hierarchy.leaf_count)];
            const ep_domain d = ep_leaf_domain(leaf);
            double s = rng_in(&r, 0, 1), t = rng_in(&r, 0, 1), x[3], xu[3], xv[3];
            if (i % 5 == 0) s = 0;
            if (p.shape.triangle && s + t > 1) s = 1 - s, t = 1 - t;
            const double u = d.u0 + s * d.uu + t * d.uv, v = d.v0 + s * d.vu + t * d.vv;
            evaluate_patch(&p, u, v, x, xu, xv);
            /* any direction, or one along the surface */
            const double a = rng_in(&r, -1, 1), b = rng_in(&r, -1, 1);
            double way[3], at[3];
            for (int c = 0; c < 3; ++c) {
                way[c] = i % 2 ? a * xu[c] + b * xv[c] : rng_in(&r, -1, 1);
                at[c] = x[c] - patch->centre[c];
            }
            const ep_line line = {ep_v3(at[0] - 0.7 * way[0], at[1] - 0.7 * way[1], at[2] - 0.7 * way[2]),
                                  ep_v3(way[0], way[1], way[2]), 0.3};
            const double length = rng_scale(&r, 1e-12, 10), before = rng_in(&r, 0, 1);
            const ep_domain part =
                ep_line_part(patch, leaf, local, &line, 1 - before * length, 1 + (1 - before) * length);
            CHECK(s >= part.u0 - 1e-13 && t >= part.v0 - 1e-13 &&
                      (p.shape.triangle ? s + t <= part.u0 + part.v0 + part.uu + 1e-13
                                        : s <= part.u0 + part.uu + 1e-13 && t <= part.v0 + part.vv + 1e-13),
                  "patch %d, leaf %d: (%.9g, %.9g) is not in the part from (%.9g, %.9g), %.3g by %.3g, of %.3g of the "
                  "way",
                  (int)k, (int)(leaf - g->hierarchy.leaves), s, t, part.u0, part.v0, part.uu, part.vv, length);
            if (length > 1e-6 || leaf->stretch > EP_STRETCH / 2) continue;
            ++pieces;
            small += fmax(part.uu, part.vv) < 0x1p-8;
        }
        epReleaseGeometry(g);
    }
    assert_true(pieces > 2000 && small > pieces * 99 / 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(at_the_very_border), cmocka_unit_test(within_a_flat_patch),
        cmocka_unit_test(past_a_line),        cmocka_unit_test(past_pieces_without_a_frame),
        cmocka_unit_test(polished_roots),     cmocka_unit_test(parts_that_lines_meet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
