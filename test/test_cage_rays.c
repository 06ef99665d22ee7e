/* test_cage_rays.c - what do rays hit on the surface of a cage?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What a hit means is what Embree's own subdivision geometry says of the same cage. */
#include "test/cages.h"
#include "tools/cage_embree.h"
#include "tools/trace.h"

#include <stdlib.h>
#include <string.h>

static const unsigned widths[] = {1, 4, 8, 16};

/* A short ray at a point of the surface, from a side; false where it is too far from upright. u, v are not near the
 * border of a chart. */
static bool aim_upright(const subject *s, rng *r, trace_ray *ray)
{
    const chart *c = &s->patches->charts[rng_below(r, (unsigned)s->patches->chart_count)];
    double at[2], p[3], du[3], dv[3], n[3], d[3], u = rng_in(r, 0.01, 0.99), v = rng_in(r, 0.01, 0.99);
    if (c->kind == PATCH_TRIANGLE && u + v > 1) u = 1 - u, v = 1 - v;
    chart_place(c, u, v, &at[0], &at[1]);
    assert_int_equal(epEvaluate(s->g, c->face, at[0], at[1], p, du, dv, NULL), EP_OK);
    cross(du, dv, n);
    rng_direction(r, d);
    const double length = 0.05;
    *ray = (trace_ray){.tfar = 2};
    for (int x = 0; x < 3; ++x) {
        ray->org[x] = (float)(p[x] - length * d[x]);
        ray->dir[x] = (float)(length * d[x]);
    }
    return fabs(dot(d, n)) > 0.5 * sqrt(dot(n, n));
}

/* How far a hit's u, v are, on our surface, from its place on the ray. */
static double hit_error(EPGeometry g, const trace_ray *ray, uint32_t face, double u, double v, double t)
{
    double p[3], d[3];
    if (epEvaluate(g, face, u, v, p, NULL, NULL, NULL) != EP_OK) return INFINITY;
    for (int x = 0; x < 3; ++x) d[x] = ray->org[x] + t * ray->dir[x] - p[x];
    return sqrt(dot(d, d));
}

static RTCScene embree_scene(const subject *s)
{
    RTCScene scene = rtcNewScene(s->world->device);
    RTCGeometry g = cage_embree_geometry(s->patches, s->world->device, 128);
    assert_non_null(g);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene);
    return scene;
}

/* Its u, v come from a grid of so many cells: h^2/8 times what second derivatives there are. */
static void check_as_embree(const subject *s, const trace_ray *ray, const world_hit *got, const judge_answer *want)
{
    CHECK(want->patch == got->primID, "%s: %s hits face %u, not %u", s->name, ray_text(ray->org, ray->dir), got->primID,
          want->patch);
    CHECK(fabs(want->u - got->u) < 1e-3 && fabs(want->v - got->v) < 1e-3, "%s: %s: %.9g, %.9g, not %.9g, %.9g", s->name,
          ray_text(ray->org, ray->dir), got->u, got->v, want->u, want->v);
    CHECK(fabs(want->t - got->t) < 2e-3, "%s: %s: t %.9g, not %.9g", s->name, ray_text(ray->org, ray->dir), got->t,
          want->t);
}

enum { UPRIGHT = 800 };

/* Faces, u and v are Embree's. Its surface is another one where holes are (it takes their faces away), where a border
 * has a corner that is not sharp, and where sharpness changes along a crease. */
static void as_embree(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        if (!k->embree) continue;
        subject s = new_subject(k, 3, true);
        RTCScene scene = embree_scene(&s);
        trace_ray rays[UPRIGHT];
        world_hit hits[UPRIGHT];
        trace_result result;
        rng r = rng_split(5, 0, (uint64_t)(k - cages));
        for (unsigned i = 0; i < UPRIGHT;) i += aim_upright(&s, &r, &rays[i]);
        for (unsigned w = 0; w < EP_ARRAY_LEN(widths); ++w) {
            assert_true(
                trace_rays(s.world, rays, UPRIGHT, &(trace_options){widths[w], 1, false, false}, hits, &result));
            for (unsigned i = w; i < UPRIGHT; i += TEST_STEP) {
                const judge_answer a = trace_one(scene, rays[i].org, rays[i].dir, 0, rays[i].tfar);
                check_as_embree(&s, &rays[i], &hits[i], &a);
            }
        }
        rtcReleaseScene(scene);
        free_subject(&s);
    }
}

/* From inside: anywhere, at vertices of all levels down to the third, at their edges, to either side of the way. */
static trace_ray aim_out(const subject *s, const ref_mesh *m, int inside, rng *r)
{
    const unsigned c = rng_below(r, m->corner_count), to = ref_next(m, c), kind = rng_below(r, 3);
    const double x = kind == 1 ? 0 : rng_unit(r), a = rng_in(r, 0, 6.283185307179586), f = rng_in(r, 0, 0.9);
    double p[3], d[3], from[3] = {cos(a), sin(a), 0};
    trace_ray ray = {.tfar = INFINITY};
    if (inside == STAR) ref_limit(m, m->vertex[rng_below(r, m->corner_count)], from);
    assert_int_equal(epEvaluate(s->g, m->cage_face[m->face[c]], m->place[c][0] + x * (m->place[to][0] - m->place[c][0]),
                                m->place[c][1] + x * (m->place[to][1] - m->place[c][1]), p, NULL, NULL, NULL),
                     EP_OK);
    rng_direction(r, d);
    for (int i = 0; i < 3; ++i) {
        ray.org[i] = (float)(inside == STAR ? f * from[i] : from[i]);
        ray.dir[i] = (float)(kind ? p[i] - (double)ray.org[i] : d[i]);
    }
    return ray;
}

enum { OUT = 3000 };

static void check_closed(const cage_case *k, const subject *s)
{
    ref_mesh *m = refined(&s->cage, 4); /* sharpness has ended: limits */
    for (unsigned w = 0; w < EP_ARRAY_LEN(widths); ++w) {
        trace_ray rays[OUT];
        world_hit hits[OUT];
        trace_result result;
        rng r = rng_split(6, w, (uint64_t)(k - cages));
        for (unsigned i = 0; i < OUT; ++i) rays[i] = aim_out(s, m, (int)k->inside, &r);
        assert_true(trace_rays(s->world, rays, OUT, &(trace_options){widths[w], 1, false, false}, hits, &result));
        for (unsigned i = 0; i < OUT; ++i)
            CHECK(hits[i].t < INFINITY, "%s: %s escapes, width %u", s->name, ray_text(rays[i].org, rays[i].dir),
                  widths[w]);
    }
    ref_free(m);
}

static void no_escape(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        if (k->inside == OPEN) continue;
        subject s = new_subject(k, 4, false);
        check_closed(k, &s);
        free_subject(&s);
    }
}

/* However deep extraordinary points are isolated: hardly, and as deep as may be asked for. */
static void no_escape_at_any_level(void **state)
{
    (void)state;
    static const unsigned levels[] = {1, 2, 3, CAGE_LEVEL_MAX};
    for (const cage_case *k = cages; k < cages + CAGES; ++k) {
        if (k->inside == OPEN) continue;
        const ref_cage c = new_cage(k, 5);
        for (unsigned i = 0; i < EP_ARRAY_LEN(levels); ++i) {
            subject s = subject_of(k->name, &c, levels[i], false);
            check_closed(k, &s);
            free_subject(&s);
        }
    }
}

/* Points that move: hits are on the surface that is there then, cut when rays meet it or before. */
static void moved(void **state)
{
    (void)state;
    for (const cage_case *k = cages; k < cages + CAGES; k += 5) {
        subject target = new_subject(k, 9, true);
        for (int demand = 0; demand < 2; ++demand) {
            subject s = new_subject(k, 8, demand);
            assert_int_equal(s.patches->patch_count, target.patches->patch_count);
            trace_ray rays[UPRIGHT];
            world_hit hits[UPRIGHT];
            trace_result result;
            rng r = rng_split(7, 0, (uint64_t)(k - cages));
            const trace_options all = {16, 1, false, false};
            for (unsigned i = 0; i < UPRIGHT;) i += aim_upright(&target, &r, &rays[i]);
            assert_true(trace_rays(s.world, rays, UPRIGHT, &all, hits, &result));
            assert_int_equal(epSetPatchPoints(s.g, 0, target.patches->patch_count, EP_FORMAT_DOUBLE3,
                                              target.patches->points, 4 * sizeof(double)),
                             EP_OK);
            CHECK(epRefitGeometry(s.g) == EP_OK, "%s", epGetGeometryMessage(s.g));
            rtcCommitGeometry(rtcGetGeometry(s.world->rtc, 0));
            rtcCommitScene(s.world->rtc);
            assert_true(trace_rays(s.world, rays, UPRIGHT, &all, hits, &result));
            for (unsigned i = 0; i < UPRIGHT; ++i) {
                const world_hit *h = &hits[i];
                CHECK(h->t < INFINITY, "%s: %s misses", s.name, ray_text(rays[i].org, rays[i].dir));
                const double off = hit_error(target.g, &rays[i], h->primID, h->u, h->v, h->t);
                CHECK(off < 1e-6, "%s: %s: off by %g", s.name, ray_text(rays[i].org, rays[i].dir), off);
            }
            free_subject(&s);
        }
        free_subject(&target);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_embree),
        cmocka_unit_test(no_escape),
        cmocka_unit_test(no_escape_at_any_level),
        cmocka_unit_test(moved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
