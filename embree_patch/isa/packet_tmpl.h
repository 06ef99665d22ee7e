/* packet_tmpl.h - a packet of rays against one leaf, one ray a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * `triangle`, `m`, `n`, `rational` are constants where a shape has a kernel of its own, so that its loops unroll. */

/* Ng and u, v of the hits in `mask` into the rows of a hit packet. */
EP_INLINE void w_put_hit(const ep_leaf *leaf, int triangle, const w_surface *jet, const w_step *step, float *hit,
                         unsigned rays, uint32_t mask)
{
    w_f u, v, ng[3];
    w_parameters(leaf, triangle, step->s, step->t, &u, &v);
    w_normal(leaf, jet, step, ng);
    for (unsigned c = 0; c < 3; ++c) w_store(hit + (EP_HIT_NG + c) * rays, mask, ng[c]);
    w_store(hit + EP_HIT_U * rays, mask, u);
    w_store(hit + EP_HIT_V * rays, mask, v);
}

EP_INLINE ep_outcome w_packet(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays, uint32_t active,
                              float *t_out, float *hit_out, EPCounters *counters, int triangle, unsigned m, unsigned n,
                              int rational)
{
    uint32_t all_hit = 0, all_tie = 0, all_vague = 0, all_slow = 0;
    for (unsigned base = 0; base < rays; base += EP_LANES, ray += EP_LANES, t_out += EP_LANES, hit_out += EP_LANES) {
        const uint32_t lanes = active >> base & (uint32_t)((1ull << EP_LANES) - 1);
        if (!lanes) continue;
        const w_rays r = w_load_rays(leaf, ray, rays, rays - base);
        const w_3 o = w_origin(leaf, &r), d = w_to_leaf(leaf, r.dir);
        const w_f d_sum = w_direction_sum(&r);
        w_visit visit = w_enter(leaf, triangle, o, d, d_sum, r.tnear, r.tfar, w_mask(lanes));
        counters->visits += (unsigned)__builtin_popcount(lanes);
        uint32_t live = w_bits(visit.live), hit = 0;
        counters->solves += (unsigned)__builtin_popcount(live | w_bits(visit.slow));
        const w_m within = w_and(w_or(visit.live, visit.slow), w_starts_within(leaf, triangle, o, d, r.tnear));
        if (w_bits(within)) {
            const w_3 p = w_move(leaf, &r, r.tnear);
            const w_m gone = w_and(within, w_leaves(leaf, net, p, d, d_sum, triangle, m, n, rational));
            visit.live = w_andnot(visit.live, gone);
            visit.slow = w_andnot(visit.slow, gone);
            live = w_bits(visit.live);
        }
        if (live) {
            w_start(leaf, &visit, triangle, w_move(leaf, &r, visit.moved), r.tnear);
            live = w_bits(visit.live);
        }
        while (live) {
            const w_surface jet = w_surface_at(net, &visit, triangle, m, n, rational);
            counters->evaluations += (unsigned)__builtin_popcount(live);
            const w_step step = w_advance(leaf, &visit, triangle, 0, &jet);
            visit.slow = w_or(visit.slow, step.stuck);
            const w_f t = w_fma(step.height, visit.inverse, visit.moved);
            const w_f after = w_load(ray + EP_RAY_TNEAR * rays, rays - base);
            const w_f before = w_load(ray + EP_RAY_TFAR * rays, rays - base);
            const w_m within = w_and(step.hit, w_and(w_lt(after, t), w_le(t, before)));
            const w_m vague = w_and(step.hit, step.vague);
            w_m found = within, certain = within;
            if (w_bits(vague)) { /* seldom, so that what it takes is not always computed */
                const w_f late = w_late(&step, visit.moved, t);
                found = w_or(found, w_and(vague, w_nearly(t, late, after, before)));
                certain = w_andnot(within, w_andnot(vague, w_surely(&step, t, late, after, before)));
            }
            const uint32_t bits = w_bits(found);
            if (bits) {
                hit |= w_bits(certain);
                all_tie |= w_bits(w_and(certain, w_le(before, t))) << base;
                all_vague |= w_bits(w_and(found, step.vague)) << base;
                w_store(t_out, bits, t);
                w_put_hit(leaf, triangle, &jet, &step, hit_out, rays, bits);
            }
            live = w_bits(visit.live);
        }
        all_slow |= w_bits(visit.slow) << base;
        all_hit |= hit << base;
    }
    return (ep_outcome){(uint16_t)all_hit, (uint16_t)all_tie, (uint16_t)all_vague, (uint16_t)all_slow};
}

/* Before a filter: `valid` gets -1 and 0, tfar becomes the candidate's and what it was goes to `before`. */
static void w_offer(float *ray, unsigned rays, uint32_t mask, const float *t, float *before, int *valid)
{
    for (unsigned base = 0; base < rays; base += EP_LANES) {
        const unsigned left = rays - base;
        float *tfar = ray + EP_RAY_TFAR * rays + base;
        w_store(before + base, ~0u, w_load(tfar, left));
        w_store_mask(valid + base, mask >> base);
        w_store(tfar, mask >> base & (uint32_t)((1ull << (left < EP_LANES ? left : EP_LANES)) - 1),
                w_load(t + base, left));
    }
}

/* After it: lanes of `mask` whose `valid` is no longer set get their tfar back. Returns the others. */
static uint32_t w_settle(float *ray, unsigned rays, uint32_t mask, const float *before, const int *valid)
{
    uint32_t accepted = 0;
    for (unsigned base = 0; base < rays; base += EP_LANES) accepted |= w_load_mask(valid + base) << base;
    accepted &= mask;
    for (unsigned base = 0; base < rays; base += EP_LANES) {
        const uint32_t refused = (mask & ~accepted) >> base;
        if (refused) w_store(ray + EP_RAY_TFAR * rays + base, refused, w_load(before + base, rays - base));
    }
    return accepted;
}

static uint32_t w_active(const int *valid, unsigned rays)
{
    uint32_t active = 0;
    if (rays < EP_LANES)
        for (unsigned k = 0; k < rays; k += 4) active |= f4_load_mask(valid + k) << k;
    else
        for (unsigned k = 0; k < rays; k += EP_LANES) active |= w_load_mask(valid + k) << k;
    return active;
}

/* Writes the lanes in `mask` of the hits' first `fields` rows behind the rays. */
static void w_commit(float *rayhit, unsigned rays, uint32_t mask, const float *hit, unsigned fields)
{
    for (unsigned base = 0; base < rays; base += EP_LANES) {
        const uint32_t lanes = mask >> base & (uint32_t)((1ull << EP_LANES) - 1);
        if (!lanes) continue;
        for (unsigned f = 0; f < fields; ++f)
            w_store(rayhit + (EP_RAY_FIELDS + f) * rays + base, lanes, w_load(hit + f * rays + base, rays - base));
    }
}
