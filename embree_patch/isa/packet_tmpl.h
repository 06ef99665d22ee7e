/* packet_tmpl.h - a packet of rays against one leaf, one ray a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * `triangle`, `m`, `n`, `rational` are constants where a shape has a kernel of its own, so that its loops unroll. */

/* A vector of space in leaf coordinates. */
EP_INLINE w_3 w_to_leaf(const ep_leaf *leaf, const w_f *x)
{
    w_f r[3];
    for (int c = 0; c < 3; ++c)
        r[c] = w_fma(w_set(leaf->frame[2][c]), x[2],
                     w_fma(w_set(leaf->frame[1][c]), x[1], w_set(leaf->frame[0][c]) * x[0]));
    return (w_3){r[0], r[1], r[2]};
}

/* Rays, one a lane; o: org - centre, rounded. */
typedef struct w_rays {
    w_f org[3], dir[3], o[3], tnear, tfar;
} w_rays;

/* The next rays of a packet of `rays`, of which there are `left`. */
EP_INLINE w_rays w_load_rays(const ep_leaf *leaf, const float *ray, unsigned rays, unsigned left)
{
    w_rays r;
    for (unsigned c = 0; c < 3; ++c) {
        r.org[c] = w_load(ray + (EP_RAY_ORG + c) * rays, left);
        r.dir[c] = w_load(ray + (EP_RAY_DIR + c) * rays, left);
        r.o[c] = r.org[c] - w_set(leaf->centre[c]);
    }
    r.tnear = w_load(ray + EP_RAY_TNEAR * rays, left);
    r.tfar = w_load(ray + EP_RAY_TFAR * rays, left);
    return r;
}

/* The origin in leaf coordinates, roughly. */
EP_INLINE w_3 w_origin(const ep_leaf *leaf, const w_rays *r)
{
    w_f near[3];
    for (int c = 0; c < 3; ++c) near[c] = r->o[c] - w_set(leaf->centre_low[c]);
    return w_to_leaf(leaf, near);
}

/* The direction's sum norm. */
EP_INLINE w_f w_direction_sum(const w_rays *r)
{
    return (w_abs(r->dir[0]) + w_abs(r->dir[1])) + w_abs(r->dir[2]);
}

/* The origin moved by t, in leaf coordinates: right to two roundings of itself, however far the ray has come, because
 * the rounding of o = org - centre is put back (Knuth's two-sum). */
EP_INLINE w_3 w_move(const ep_leaf *leaf, const w_rays *r, w_f t)
{
    w_f moved[3];
    for (int c = 0; c < 3; ++c) {
        const w_f back = r->o[c] - r->org[c];
        const w_f low = ((r->org[c] - (r->o[c] - back)) - (w_set(leaf->centre[c]) + back)) - w_set(leaf->centre_low[c]);
        moved[c] = w_fma(t, r->dir[c], r->o[c]) + low;
    }
    return w_to_leaf(leaf, moved);
}

/* S - o at (v->s, v->t). A quotient P = N / W has P_s = (N_s - P W_s) / W, P_ss = (N_ss - 2 P_s W_s - P W_ss) / W. */
EP_INLINE w_surface w_surface_at(const float *net, const w_visit *v, int triangle, unsigned m, unsigned n, int rational)
{
    const int stride = rational ? 4 : 3;
    w_jet p[4];
    for (int c = 0; c < stride; ++c) p[c] = w_series(net + c, stride, triangle, m, n, v->s, v->t);
    if (rational) {
        const w_f inverse = w_set(1.0f) / p[3].f;
        for (int c = 0; c < 3; ++c) {
            p[c].f = p[c].f * inverse;
            p[c].s = w_fnma(p[c].f, p[3].s, p[c].s) * inverse;
            p[c].t = w_fnma(p[c].f, p[3].t, p[c].t) * inverse;
            p[c].ss = w_fnma(p[c].f, p[3].ss, w_fnma(p[c].s, p[3].s, p[c].ss)) * inverse;
            p[c].tt = w_fnma(p[c].f, p[3].tt, w_fnma(p[c].t, p[3].t, p[c].tt)) * inverse;
            p[c].st = w_fnma(p[c].f, p[3].st, w_fnma(p[c].t, p[3].s, w_fnma(p[c].s, p[3].t, p[c].st))) * inverse;
        }
    }
    w_surface j = {
        .ss = {p[0].ss, p[1].ss, p[2].ss}, .st = {p[0].st, p[1].st, p[2].st}, .tt = {p[0].tt, p[1].tt, p[2].tt}};
    if (rational) {
        j.at = (w_3){p[0].f - v->o.x, p[1].f - v->o.y, p[2].f - v->o.z};
        j.ds = (w_3){p[0].s, p[1].s, p[2].s};
        j.dt = (w_3){p[0].t, p[1].t, p[2].t};
    } else {
        const w_f one = w_set(1.0f);
        j.at = (w_3){(v->s - v->o.x) + p[0].f, (v->t - v->o.y) + p[1].f, p[2].f - v->o.z};
        j.ds = (w_3){p[0].s + one, p[1].s, p[2].s};
        j.dt = (w_3){p[0].t, p[1].t + one, p[2].t};
    }
    return j;
}

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
        w_visit visit = w_enter(leaf, triangle, w_origin(leaf, &r), w_to_leaf(leaf, r.dir), w_direction_sum(&r),
                                r.tnear, r.tfar, w_mask(lanes));
        counters->visits += (unsigned)__builtin_popcount(lanes);
        uint32_t live = w_bits(visit.live), hit = 0;
        counters->solves += (unsigned)__builtin_popcount(live | w_bits(visit.slow));
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
            w_m found = within;
            if (w_bits(vague)) /* seldom, so that what it takes is not always computed */
                found = w_or(found, w_and(vague, w_nearly(&step, visit.moved, t, after, before)));
            const uint32_t bits = w_bits(found);
            if (bits) {
                hit |= bits;
                all_tie |= w_bits(w_and(within, w_le(before, t))) << base;
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
