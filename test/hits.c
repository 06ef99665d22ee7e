/* hits.c - see hits.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/capture.h"

/* A packet of n, of which the first `used` lanes are. */
static void set_rays(test_packet *p, unsigned n, const test_ray *rays, unsigned used)
{
    for (unsigned i = 0; i < n; ++i) {
        const test_ray *r = &rays[i < used ? i : 0];
        set_ray(p, n, i, r->org, r->dir, 0, INFINITY);
        if (i >= used) p->valid[i] = 0;
    }
}

/* The rays in packets of n. */
static void compare_packets(RTCScene scene, const test_ray *rays, unsigned count, unsigned n, hits_answer *answers)
{
    for (unsigned first = 0; first < count; first += n) {
        const unsigned used = count - first < n ? count - first : n;
        test_packet p;
        set_rays(&p, n, rays + first, used);
        ep_rtc_intersect(scene, n, p.valid, p.f, false);
        for (unsigned i = 0; i < used; ++i) {
            hits_answer *a = &answers[first + i];
            const judge_answer many = answer_of(&p, n, i);
            if (a->fault || same_answer(&many, &a->alone)) continue;
            a->fault = "other bits in a packet";
            a->width = n;
            a->many = many;
        }
        set_rays(&p, n, rays + first, used);
        ep_rtc_occluded(scene, n, p.valid, p.f, false);
        for (unsigned i = 0; i < used; ++i) {
            hits_answer *a = &answers[first + i];
            const float t = get_float(&p, n, EP_RAY_TFAR, i);
            if (a->fault || (t == -INFINITY) == (a->alone.t < INFINITY)) continue;
            a->fault = "occlusion disagrees";
            a->width = n;
            a->many = (judge_answer){.t = t};
        }
    }
}

void judge_rays(const oracle *o, RTCScene scene, const test_ray *rays, unsigned count, hits_answer *answers)
{
    for (unsigned i = 0; i < count; ++i) {
        const test_ray *r = &rays[i];
        hits_answer *a = &answers[i];
        const double org[3] = {r->org[0], r->org[1], r->org[2]}, dir[3] = {r->dir[0], r->dir[1], r->dir[2]};
        a->width = 0;
        a->alone = trace_one(scene, r->org, r->dir, 0, INFINITY);
        a->count = oracle_intersect(o, org, dir, 0, INFINITY, a->roots);
        a->verdict = judge(o, org, dir, a->roots, a->count, &a->alone, &judge_usual, NULL);
        a->fault = a->verdict < JUDGE_MISSED ? NULL : judge_names[a->verdict];
        if (a->fault || !(a->alone.t < INFINITY)) continue;
        a->many = trace_one(scene, r->org, r->dir, 0, nextafterf(a->alone.t, INFINITY));
        if (same_answer(&a->many, &a->alone)) continue;
        a->fault = "other bits if the ray ends there";
        a->width = 1;
    }
    static const unsigned widths[] = {1, 4, 8, 16};
    for (size_t w = 0; w < EP_ARRAY_LEN(widths); ++w) compare_packets(scene, rays, count, widths[w], answers);
}

static void explain(const hits_case *c, int index, const char *isa, const test_patch *p, const test_ray *ray,
                    const hits_answer *a)
{
    print_error("seed %d, patch %d (%s of degree %u %u), %s: %s: %s\n    answer  t %.9g u %.9g v %.9g", (int)c->seed,
                index, p->shape.triangle ? "triangle" : "tensor", p->shape.m, p->shape.n, isa, a->fault,
                ray_text(ray->org, ray->dir), a->alone.t, a->alone.u, a->alone.v);
    print_error("\n");
    if (a->width)
        print_error("    in a packet of %u t %.9g u %.9g v %.9g\n", a->width, a->many.t, a->many.u, a->many.v);
    for (size_t k = 0; k < a->count && k < 4; ++k) {
        const oracle_root *r = &a->roots[k];
        print_error("    %s t %.12g u %.12g v %.12g cosine %.2g border %.2g\n", r->doubtful ? "perhaps" : "root   ",
                    r->t_low, r->u, r->v, r->cosine, r->border);
    }
}

/* Moves the origin along the ray, as far as floats let it. */
static void start_from(const double centre[3], double distance, test_ray *ray)
{
    double away = 0, d = 0, dd = 0;
    for (int x = 0; x < 3; ++x) {
        away += (centre[x] - ray->org[x]) * ray->dir[x];
        dd += (double)ray->dir[x] * ray->dir[x];
    }
    d = away / dd - distance / sqrt(dd);
    for (int x = 0; x < 3; ++x) {
        const double target = ray->org[x] + away / dd * ray->dir[x];
        ray->org[x] = (float)(ray->org[x] + d * ray->dir[x]);
        ray->dir[x] = (float)(target - ray->org[x]);
    }
}

static void aim_packet(const hits_case *c, const oracle *o, rng *r, unsigned packet, test_ray rays[16])
{
    double lower[3], upper[3], centre[3];
    oracle_bounds(o, lower, upper);
    for (int x = 0; x < 3; ++x) centre[x] = (lower[x] + upper[x]) / 2;
    for (unsigned i = 0; i < 16; ++i) {
        aim(o, (aim_kind)((16 * packet + i) % AIM_KINDS), r, rays[i].org, rays[i].dir);
        if (c->distance > 0) start_from(centre, c->distance, &rays[i]);
    }
}

/* Patch k of the case. */
static void judge_patch(const hits_case *c, int k, unsigned most, FILE *captures, hits_tally *t)
{
    static const double origin[3] = {0, 0, 0};
    const char *const *isas = epGetInstructionSets();
    unsigned isa_count = 0;
    while (isas[isa_count]) ++isa_count;
    const unsigned long before = t->faults;
    rng r = rng_split(c->seed, 0, (uint64_t)k);
    test_patch p;
    const patch_style style = c->styles[k % c->style_count];
    const bool triangle = c->triangles && (!c->tensors || k / c->style_count % 2);
    /* subdivision takes long, the oracle's above all, where a curve in the domain is one point of space */
    const bool slow = style == STYLE_DEGENERATE || (triangle && style == STYLE_COLLAPSED);
    const int rays = slow ? c->rays / 8 : c->rays;
    random_patch(&r, style, triangle, c->limits, &p);
    move_patch(&p, c->scale, origin);
    move_patch(&p, 1, c->offset);
    oracle *o = new_oracle(&p, 1);
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.rayDistance = (float)c->distance;
    settings.isa = isas[(unsigned)k % isa_count];
    if (c->depths) settings.maxDepth = rng_below(&r, c->depths);
    test_scene s = new_scene(&p, 1, &settings);
    for (unsigned packet = 0; packet < (unsigned)rays / 16; ++packet) {
        test_ray ray[16];
        hits_answer answer[16];
        aim_packet(c, o, &r, packet, ray);
        judge_rays(o, s.scene, ray, 16, answer);
        for (unsigned i = 0; i < 16; ++i) {
            ++t->rays;
            t->hits += answer[i].alone.t < INFINITY;
            t->left_out += answer[i].verdict == JUDGE_LEFT_OUT;
            if (!answer[i].fault) continue;
            if (t->faults++ < most) explain(c, k, settings.isa, &p, &ray[i], &answer[i]);
            if (!captures) continue;
            if (t->faults == before + 1) write_captured_patch(captures, &p, &settings);
            write_captured_ray(captures, &ray[i]);
        }
    }
    free_scene(&s);
    oracle_free(o);
}

hits_tally judge_hits(const hits_case *c, unsigned most, FILE *captures)
{
    hits_tally t = {0};
    for (int k = 0; k < c->patches; k += TEST_STEP) judge_patch(c, k, most, captures, &t);
    print_message("%lu rays, %lu hits, %lu left out, %lu faults\n", t.rays, t.hits, t.left_out, t.faults);
    return t;
}

void check_hits(const hits_case *c)
{
    const hits_tally t = judge_hits(c, 5, NULL);
    assert_true(t.hits > t.rays / 10);
    assert_int_equal(t.faults, 0);
}
