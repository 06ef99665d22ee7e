/* hits.c - see hits.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/hits.h"

#include <stdio.h>
#include <string.h>

typedef struct tally {
    unsigned long rays, hits, left_out, faults;
} tally;

static void explain(const hits_case *c, int index, const test_patch *p, const float org[3], const float dir[3],
                    const char *what, const judge_answer *a, float t_in_packet, const oracle_root *roots, size_t count)
{
    print_error(
        "seed %d, patch %d (%s of degree %u %u): %s: %s\n    answer  t %.9g u %.9g v %.9g, in a packet t %.9g\n",
        (int)c->seed, index, p->shape.triangle ? "triangle" : "tensor", p->shape.m, p->shape.n, what,
        ray_text(org, dir), a->t, a->u, a->v, t_in_packet);
    for (size_t k = 0; k < count && k < 4; ++k)
        print_error("    %s t %.12g u %.12g v %.12g cosine %.2g border %.2g\n",
                    roots[k].doubtful ? "perhaps" : "root   ", roots[k].t_low, roots[k].u, roots[k].v, roots[k].cosine,
                    roots[k].border);
}

/* Moves the origin along the ray, as far as floats let it. */
static void start_from(const double centre[3], double distance, float org[3], float dir[3])
{
    double away = 0, d = 0, dd = 0;
    for (int x = 0; x < 3; ++x) {
        away += (centre[x] - org[x]) * dir[x];
        dd += (double)dir[x] * dir[x];
    }
    d = away / dd - distance / sqrt(dd);
    for (int x = 0; x < 3; ++x) {
        const double target = org[x] + away / dd * dir[x];
        org[x] = (float)(org[x] + d * dir[x]);
        dir[x] = (float)(target - org[x]);
    }
}

static void judge_packet(const hits_case *c, int index, const test_patch *p, const oracle *o, RTCScene scene, rng *r,
                         unsigned packet, tally *t)
{
    test_packet many;
    float org[16][3], dir[16][3];
    double lower[3], upper[3], centre[3];
    oracle_bounds(o, lower, upper);
    for (int x = 0; x < 3; ++x) centre[x] = (lower[x] + upper[x]) / 2;
    for (unsigned i = 0; i < 16; ++i) {
        aim(o, (aim_kind)((16 * packet + i) % AIM_KINDS), r, org[i], dir[i]);
        if (c->distance > 0) start_from(centre, c->distance, org[i], dir[i]);
        set_ray(&many, 16, i, org[i], dir[i], 0, INFINITY);
    }
    ep_rtc_intersect(scene, 16, many.valid, many.f, false);
    for (unsigned i = 0; i < 16; ++i) {
        const judge_answer a = trace_one(scene, org[i], dir[i], 0, INFINITY);
        double od[3], dd[3];
        oracle_root roots[ORACLE_ROOTS];
        for (int x = 0; x < 3; ++x) od[x] = org[i][x], dd[x] = dir[i][x];
        const size_t count = oracle_intersect(o, od, dd, 0, INFINITY, roots);
        const judge_verdict v = judge(o, od, dd, roots, count, &a, &judge_usual, NULL);
        const bool hit = get_id(&many, 16, HIT_GEOM, i) != RTC_INVALID_GEOMETRY_ID;
        const bool same = hit == (a.t < INFINITY) &&
                          (!hit || (many.f[EP_RAY_TFAR * 16 + i] == (float)a.t &&
                                    many.f[HIT_U * 16 + i] == (float)a.u && many.f[HIT_V * 16 + i] == (float)a.v));
        ++t->rays;
        t->hits += hit;
        t->left_out += v == JUDGE_LEFT_OUT;
        if (v < JUDGE_MISSED && same) continue;
        if (++t->faults <= 5)
            explain(c, index, p, org[i], dir[i], same ? judge_names[v] : "other bits in a packet", &a,
                    many.f[EP_RAY_TFAR * 16 + i], roots, count);
    }
}

void check_hits(const hits_case *c)
{
    tally t = {0};
    for (int k = 0; k < c->patches; k += TEST_STEP) {
        rng r = rng_split(c->seed, 0, (uint64_t)k);
        test_patch p;
        const patch_style style = c->styles[k % c->style_count];
        const bool triangle = c->triangles && (!c->tensors || k / c->style_count % 2);
        /* at a triangle's pole, subdivision takes a hundred times as long, and that of the oracle twice as long again
         */
        const int rays = triangle && style == STYLE_COLLAPSED ? c->rays / 8 : c->rays;
        random_patch(&r, style, triangle, c->limits, &p);
        move_patch(&p, c->scale, c->offset);
        oracle *o = new_oracle(&p, 1);
        EPBuildSettings settings = epDefaultBuildSettings();
        settings.rayDistance = (float)c->distance;
        test_scene s = new_scene(&p, 1, &settings);
        for (unsigned packet = 0; packet < (unsigned)rays / 16; ++packet)
            judge_packet(c, k, &p, o, s.scene, &r, packet, &t);
        free_scene(&s);
        oracle_free(o);
    }
    print_message("%lu rays, %lu hits, %lu left out, %lu faults\n", t.rays, t.hits, t.left_out, t.faults);
    assert_true(t.hits > t.rays / 10);
    assert_int_equal(t.faults, 0);
}
