/* test_kernels.c - do all instruction sets and both kinds of kernel give the same bits?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * "plain" is the specification. Whether it is right is asked by test_hits.c; here a tolerance would sleep through a
 * multiply-add that is not fused. */
#include "test/support.h"

#include <stdio.h>
#include <string.h>

/* Lets a ray start next to its first hit, on either side. */
static void leave(const oracle *o, rng *r, const float org[3], const float dir[3], float *tnear)
{
    const double from[3] = {org[0], org[1], org[2]}, to[3] = {dir[0], dir[1], dir[2]};
    oracle_root roots[ORACLE_ROOTS];
    if (!oracle_intersect(o, from, to, 0, INFINITY, roots)) return;
    *tnear = (float)(roots[0].t_low * (1 + rng_sign(r) * rng_scale(r, 1e-7, 1e-2)));
}

/* Rays as they come: most of them at the leaf, one in eight of the sort that breaks things. */
static void fill(const oracle *o, const ep_patch *patch, rng *r, test_packet *p, unsigned n, uint32_t *active)
{
    *active = 0;
    for (unsigned i = 0; i < n; ++i) {
        float org[3], dir[3], tnear = 0, tfar = INFINITY;
        aim(o, (aim_kind)rng_below(r, AIM_KINDS), r, org, dir);
        if (rng_below(r, 4) == 0) {
            const float reach = 3 * patch->radius / fmaxf(fabsf(dir[0]) + fabsf(dir[1]) + fabsf(dir[2]), 1e-30f);
            tnear = (float)rng_in(r, 0, reach);
            tfar = tnear + (float)rng_in(r, 0, reach);
        }
        if (rng_below(r, 16) == 0) leave(o, r, org, dir, &tnear);
        const unsigned c = rng_below(r, 3);
        switch (rng_below(r, 80)) {
        case 0: org[c] = NAN; break;
        case 1: dir[c] = NAN; break;
        case 2: org[c] = INFINITY; break;
        case 3: dir[c] = -INFINITY; break;
        case 4: dir[0] = dir[1] = dir[2] = 0; break;
        case 5: org[c] = 1e30f; break;
        case 6: dir[0] *= 1e-38f, dir[1] *= 1e-38f, dir[2] *= 1e-38f; break;
        case 7: tfar = NAN; break;
        case 8: tnear = tfar; break;
        case 9: org[0] *= 1e4f, org[1] *= 1e4f, org[2] *= 1e4f; break;
        }
        set_ray(p, n, i, org, dir, tnear, tfar);
        if (rng_below(r, 8)) *active |= 1u << i; /* idle lanes must stay idle */
    }
}

typedef struct answer {
    ep_outcome o;
    alignas(64) float t[EP_PACKET], hit[5 * EP_PACKET];
} answer;

static answer run_packet(const ep_kernels *k, const ep_leaf *leaf, const float *net, const test_packet *p, unsigned n,
                         uint32_t active)
{
    EPCounters counters = {0};
    answer a;
    memset(&a, 0x5a, sizeof a);
    a.o = k->packet[leaf->shape](leaf, net, p->f, n, active, a.t, a.hit, &counters);
    return a;
}

/* Lane by lane, into the places of a packet of n. */
static answer run_single(const ep_kernels *k, const ep_leaf *leaf, const float *net, const test_packet *p, unsigned n,
                         uint32_t active)
{
    EPCounters counters = {0};
    answer a;
    memset(&a, 0x5a, sizeof a);
    a.o = (ep_outcome){0, 0, 0, 0};
    for (unsigned i = 0; i < n; ++i) {
        if (!(active >> i & 1)) continue;
        float ray[EP_RAY_FIELDS], t, hit[5];
        for (unsigned f = 0; f < EP_RAY_FIELDS; ++f) ray[f] = p->f[f * n + i];
        const ep_outcome o = k->single[leaf->shape](leaf, net, ray, &t, hit, &counters);
        a.o.hit |= (uint16_t)((o.hit & 1) << i);
        a.o.tie |= (uint16_t)((o.tie & 1) << i);
        a.o.vague |= (uint16_t)((o.vague & 1) << i);
        a.o.slow |= (uint16_t)((o.slow & 1) << i);
        if (!((o.hit | o.vague) & 1)) continue;
        a.t[i] = t;
        for (unsigned f = 0; f < 5; ++f) a.hit[f * n + i] = hit[f];
    }
    return a;
}

static void same(const answer *a, const answer *b, unsigned n, uint32_t active, const char *what, const char *where)
{
    CHECK(!memcmp(&a->o, &b->o, sizeof a->o), "%s: %s: hit %x %x, tie %x %x, vague %x %x, slow %x %x", where, what,
          a->o.hit, b->o.hit, a->o.tie, b->o.tie, a->o.vague, b->o.vague, a->o.slow, b->o.slow);
    CHECK(!(a->o.tie & ~a->o.hit), "%s: %s: hit %x, tie %x", where, what, a->o.hit, a->o.tie);
    const uint32_t found = a->o.hit | a->o.vague;
    CHECK(!(found & ~active) && !(a->o.slow & ~active) && !(found & a->o.slow), "%s: %s: active %x, hit %x, slow %x",
          where, what, active, a->o.hit, a->o.slow);
    for (unsigned i = 0; i < n; ++i) {
        if (!(found >> i & 1)) continue;
        CHECK(!memcmp(&a->t[i], &b->t[i], 4), "%s: %s: lane %u: t %a and %a", where, what, i, a->t[i], b->t[i]);
        for (unsigned f = 0; f < 5; ++f)
            CHECK(!memcmp(&a->hit[f * n + i], &b->hit[f * n + i], 4), "%s: %s: lane %u, field %u: %a and %a", where,
                  what, i, f, a->hit[f * n + i], b->hit[f * n + i]);
    }
}

typedef struct tangents {
    ep_roots o;
    float t[2][EP_PACKET], hits[2][5 * EP_PACKET];
} tangents;

static tangents run_tangents(const ep_kernels *kernels, const ep_leaf *leaf, const float *net, const test_packet *rays,
                             unsigned n, uint32_t active)
{
    tangents a;
    memset(&a, 0, sizeof a);
    for (int s = 0; s < 2; ++s) a.o.t[s] = a.t[s], a.o.hits[s] = a.hits[s];
    kernels->tangent[leaf->shape](leaf, net, rays->f, n, active, &a.o);
    return a;
}

/* Lane i of n in one answer, and lane j of m in the other. */
static void same_tangent(const tangents *a, unsigned i, unsigned n, const tangents *b, unsigned j, unsigned m,
                         const char *isa, const char *where)
{
    CHECK((a->o.open >> i & 1) == (b->o.open >> j & 1), "%s: %s: lane %u: open", where, isa, i);
    if (a->o.open >> i & 1) return; /* what was found before that depends on the width */
    for (int s = 0; s < 2; ++s) {
        CHECK((a->o.hit[s] >> i & 1) == (b->o.hit[s] >> j & 1) && (a->o.vague[s] >> i & 1) == (b->o.vague[s] >> j & 1),
              "%s: %s: lane %u: hit %d", where, isa, i, s);
        if (!((a->o.hit[s] | a->o.vague[s]) >> i & 1)) continue;
        CHECK(!memcmp(&a->t[s][i], &b->t[s][j], 4) && !memcmp(&a->o.radius[s][i], &b->o.radius[s][j], 4),
              "%s: %s: lane %u: t %a and %a", where, isa, i, a->t[s][i], b->t[s][j]);
        for (unsigned f = 0; f < 5; ++f)
            CHECK(!memcmp(&a->hits[s][f * n + i], &b->hits[s][f * m + j], 4), "%s: %s: lane %u, field %u", where, isa,
                  i, f);
    }
}

static void same_tangents(const tangents *a, const tangents *b, unsigned n, const char *isa, const char *where)
{
    for (unsigned i = 0; i < n; ++i) same_tangent(a, i, n, b, i, n, isa, where);
}

/* Degrees whose shape is `special` of 0..4, where 0 is what has no kernel of its own. */
static void shape_patch(rng *r, bool triangle, bool rational, unsigned special, test_patch *p)
{
    do {
        /* none that is left to subdivision as a whole */
        const patch_style style = rng_below(r, 3) ? STYLE_GENTLE : (patch_style)rng_below(r, STYLE_DEGENERATE);
        random_patch(r, style, triangle, (patch_limits){special ? special : 8, rational ? 20 : 1}, p);
    } while (special ? p->shape.m != special || p->shape.n != special
                     : p->shape.m == p->shape.n && p->shape.m <= EP_SPECIAL_DEGREES);
}

/* A patch of a shape, cut into few leaves, and its oracle. */
static EPGeometry shape_geometry(rng *r, unsigned shape, oracle **o)
{
    const unsigned special = shape % (EP_SPECIAL_DEGREES + 1), kind = shape / (EP_SPECIAL_DEGREES + 1);
    test_patch p;
    shape_patch(r, kind / 2, kind % 2, special, &p);
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.maxDepth = rng_below(r, kind / 2 ? 4 : 6); /* triangles are quartered */
    *o = new_oracle(&p, 1);
    return new_geometry(&p, 1, &settings);
}

static void same_bits(void **state)
{
    (void)state;
    size_t lanes = 0, hits = 0, slow = 0;
    bool seen[EP_SHAPES] = {false}; /* by leaves: theirs may be less than their patch's */
    for (unsigned shape = 0; shape < EP_SHAPES; ++shape)
        for (uint64_t k = 0; k < 40; ++k) {
            rng r = rng_split(1, shape, k);
            oracle *o;
            EPGeometry g = shape_geometry(&r, shape, &o);
            const ep_patch *patch = &g->hierarchy.patches[0];
            for (int packet = 0; packet < 40; ++packet) {
                static const unsigned widths[] = {4, 8, 16};
                const unsigned n = widths[rng_below(&r, 3)];
                const ep_leaf *leaf = &g->hierarchy.leaves[rng_below(&r, (unsigned)g->hierarchy.leaf_count)];
                const float *net = g->hierarchy.nets + leaf->net;
                seen[leaf->shape] = true;
                test_packet rays;
                uint32_t active;
                fill(o, patch, &r, &rays, n, &active);
                const answer want = run_packet(&ep_kernels_plain, leaf, net, &rays, n, active);
                char where[80];
                snprintf(where, sizeof where, "shape %u, patch %d, packet %d of %u", shape, (int)k, packet, n);
                for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
                    const ep_kernels *kernels = ep_find_kernels(*isa);
                    const answer many = run_packet(kernels, leaf, net, &rays, n, active);
                    same(&want, &many, n, active, *isa, where);
                    const answer one = run_single(kernels, leaf, net, &rays, n, active);
                    same(&want, &one, n, active, "single ray", where);
                }
                lanes += (unsigned)__builtin_popcount(active);
                hits += (unsigned)__builtin_popcount(want.o.hit);
                slow += (unsigned)__builtin_popcount(want.o.slow);
            }
            oracle_free(o);
            epReleaseGeometry(g);
        }
    for (unsigned shape = 0; shape < EP_SHAPES; ++shape) CHECK(seen[shape], "no leaf of shape %u", shape);
    /* kernels that answer nothing must not pass */
    CHECK(hits > lanes / 20 && slow < lanes / 2, "%zu lanes, %zu hits, %zu slow", lanes, hits, slow);
}

/* Nearly tangent rays, in packets and alone. */
static void same_bits_of_tangents(void **state)
{
    (void)state;
    size_t lanes = 0, hits[2] = {0, 0};
    for (unsigned shape = 0; shape < EP_SHAPES; ++shape)
        for (uint64_t k = 0; k < 20; ++k) {
            rng r = rng_split(3, shape, k);
            oracle *o;
            EPGeometry g = shape_geometry(&r, shape, &o);
            for (int i = 0; i < 30; ++i) {
                static const unsigned widths[] = {4, 8, 16};
                const unsigned n = widths[rng_below(&r, 3)];
                const ep_leaf *leaf = &g->hierarchy.leaves[rng_below(&r, (unsigned)g->hierarchy.leaf_count)];
                const float *net = g->hierarchy.nets + leaf->net;
                if (!(leaf->height < INFINITY)) continue;
                test_packet rays;
                for (unsigned lane = 0; lane < n; ++lane) {
                    float org[3], dir[3];
                    aim(o, rng_below(&r, 4) ? AIM_GRAZING : AIM_INSIDE, &r, org, dir);
                    set_ray(&rays, n, lane, org, dir, 0, INFINITY);
                }
                const uint32_t active = (uint32_t)rng_bits(&r) & ((1u << n) - 1);
                const tangents want = run_tangents(&ep_kernels_plain, leaf, net, &rays, n, active);
                char where[80];
                snprintf(where, sizeof where, "shape %u, patch %d, packet %d of %u", shape, (int)k, i, n);
                for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
                    const ep_kernels *kernels = ep_find_kernels(*isa);
                    const tangents many = run_tangents(kernels, leaf, net, &rays, n, active);
                    same_tangents(&want, &many, n, *isa, where);
                    for (unsigned lane = 0; lane < n; ++lane) {
                        test_packet one;
                        for (unsigned f = 0; f < EP_RAY_FIELDS; ++f) one.f[f] = rays.f[f * n + lane];
                        const tangents single = run_tangents(kernels, leaf, net, &one, 1, active >> lane & 1);
                        same_tangent(&want, lane, n, &single, 0, 1, *isa, where);
                    }
                }
                lanes += (unsigned)__builtin_popcount(active & ~want.o.open);
                for (int s = 0; s < 2; ++s) hits[s] += (unsigned)__builtin_popcount(want.o.hit[s] & ~want.o.open);
            }
            oracle_free(o);
            epReleaseGeometry(g);
        }
    CHECK(hits[0] > lanes / 10 && hits[1] > lanes / 100, "%zu lanes, %zu and %zu hits", lanes, hits[0], hits[1]);
}

/* The cells of nearly tangent rays. */
static void same_bits_of_cells(void **state)
{
    (void)state;
    size_t hits = 0;
    for (unsigned shape = 0; shape < EP_SHAPES; ++shape)
        for (uint64_t k = 0; k < 20; ++k) {
            rng r = rng_split(2, shape, k);
            oracle *o;
            EPGeometry g = shape_geometry(&r, shape, &o);
            for (int i = 0; i < 30; ++i) {
                const ep_leaf *leaf = &g->hierarchy.leaves[rng_below(&r, (unsigned)g->hierarchy.leaf_count)];
                const float *net = g->hierarchy.nets + leaf->net;
                test_packet ray;
                float org[3], dir[3];
                aim(o, AIM_GRAZING, &r, org, dir);
                set_ray(&ray, 1, 0, org, dir, 0, INFINITY);
                if (!(leaf->height < INFINITY)) continue;
                /* the same ray in several places of a packet, and with other parts of its way */
                static const unsigned lanes[] = {0, 0, 0};
                const float middle = (float)rng_in(&r, -1, 1), from[] = {-1, -1, middle}, to[] = {1, middle, 1};
                ep_cells want, got;
                memset(&want, 0, sizeof want);
                ep_kernels_plain.cells[leaf->shape](leaf, net, ray.f, 1, lanes, 3, from, to, &want);
                for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
                    memset(&got, 0, sizeof got);
                    ep_find_kernels(*isa)->cells[leaf->shape](leaf, net, ray.f, 1, lanes, 3, from, to, &got);
                    CHECK(want.hit == got.hit && want.vague == got.vague && want.more == got.more &&
                              want.open == got.open,
                          "shape %u, patch %d, ray %d: %s: hit %x %x, open %x %x", shape, (int)k, i, *isa, want.hit,
                          got.hit, want.open, got.open);
                    for (unsigned c = 0; c < 3 * EP_CELLS; ++c) {
                        if ((want.hit | want.vague) >> c & 1)
                            CHECK(!memcmp(&want.t[c], &got.t[c], 4),
                                  "shape %u, patch %d, ray %d: %s: cell %u: t %a and %a", shape, (int)k, i, *isa, c,
                                  want.t[c], got.t[c]);
                        CHECK(!memcmp(&want.reach[c], &got.reach[c], 4),
                              "shape %u, patch %d, ray %d: %s: cell %u: %a and %a", shape, (int)k, i, *isa, c,
                              want.reach[c], got.reach[c]);
                        for (unsigned f = 0; (want.hit | want.vague) >> c & 1 && f < 5; ++f)
                            CHECK(!memcmp(&want.fields[f * EP_PACKET + c], &got.fields[f * EP_PACKET + c], 4),
                                  "shape %u, patch %d, ray %d: %s: cell %u, field %u", shape, (int)k, i, *isa, c, f);
                    }
                }
                hits += (want.hit | want.vague) != 0;
            }
            oracle_free(o);
            epReleaseGeometry(g);
        }
    assert_true(hits > 100);
}

static void names(void **state)
{
    (void)state;
    assert_null(ep_find_kernels("abacus"));
    assert_string_equal(epGetInstructionSets()[0], "plain");
    const char *best = NULL;
    for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
        assert_string_equal(ep_find_kernels(*isa)->isa, *isa);
        best = *isa;
    }
    assert_string_equal(ep_find_kernels(NULL)->isa, best);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits),
        cmocka_unit_test(same_bits_of_tangents),
        cmocka_unit_test(same_bits_of_cells),
        cmocka_unit_test(names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
