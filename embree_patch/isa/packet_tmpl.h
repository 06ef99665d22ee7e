/* packet_tmpl.h - a packet of rays against one leaf, one ray a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * `kind`, `m`, `n`, `rational` are constants where a shape has a kernel of its own, so that its loops unroll. */

/* Four coordinates of a point, one a register; w is 1 unless the patch is rational, and then not used. */
typedef struct w_4 {
    w_f c[4];
} w_4;

EP_INLINE w_4 w_mix(w_f t, w_4 a, w_4 d, int coordinates)
{
    w_4 r = a;
    for (int c = 0; c < coordinates; ++c) r.c[c] = w_fma(t, d.c[c], a.c[c]);
    return r;
}
EP_INLINE w_4 w_difference(w_4 a, w_4 b, int coordinates)
{
    w_4 r = a;
    for (int c = 0; c < coordinates; ++c) r.c[c] = a.c[c] - b.c[c];
    return r;
}

/* The points of the last level but one (patch.h): h[part] = sum_j e_j sum_i c_i block_ij[part]. */
EP_INLINE void w_last_level(const float *net, int triangle, unsigned m, unsigned n, int coordinates, w_f u, w_f v,
                            w_4 h[4])
{
    const w_f one = w_set(1.0f);
    const int parts = triangle ? 3 : 4;
    w_f c[EP_MAX_DEGREE], e[EP_MAX_DEGREE];
    if (triangle) {
        w_bernstein(n - 1, v, one, e);
    } else {
        w_bernstein(m - 1, u, one - u, c);
        w_bernstein(n - 1, v, one - v, e);
    }
    for (unsigned j = 0; j < n; ++j) {
        const unsigned count = triangle ? n - j : m;
        if (triangle) w_bernstein(count - 1, u, (one - u) - v, c);
        for (int part = 0; part < parts; ++part)
            for (int k = 0; k < coordinates; ++k) {
                const float *p = net + 4 * part + k;
                w_f q = c[0] * w_set(p[0]);
                for (unsigned i = 1; i < count; ++i) q = w_fma(c[i], w_set(p[16 * i]), q);
                h[part].c[k] = j ? w_fma(e[j], q, h[part].c[k]) : e[0] * q;
            }
        net += 16 * count;
    }
}

/* Point and tangents at u, v, relative to the patch's centre. */
EP_INLINE void w_evaluate(const ep_patch *patch, int triangle, unsigned m, unsigned n, int rational, w_f u, w_f v,
                          w_4 *s, w_4 *su, w_4 *sv)
{
    const int k = rational ? 4 : 3;
    w_4 h[4];
    w_last_level(patch->net, triangle, m, n, k, u, v, h);
    if (triangle) { /* h: w, v, u */
        *sv = w_difference(h[1], h[0], k);
        *su = w_difference(h[2], h[0], k);
        *s = w_mix(u, w_mix(v, h[0], *sv, k), *su, k);
    } else { /* h: 00, 01, 10, 11 */
        const w_4 d0 = w_difference(h[2], h[0], k), d1 = w_difference(h[3], h[1], k);
        const w_4 a0 = w_mix(u, h[0], d0, k), a1 = w_mix(u, h[1], d1, k);
        *sv = w_difference(a1, a0, k);
        *s = w_mix(v, a0, *sv, k);
        *su = w_mix(v, d0, w_difference(d1, d0, k), k);
    }
    for (int c = 0; c < k; ++c) {
        su->c[c] = w_set((float)m) * su->c[c];
        sv->c[c] = w_set((float)n) * sv->c[c];
    }
    if (rational) {
        const w_f inverse = w_set(1.0f) / s->c[3];
        for (int c = 0; c < 3; ++c) {
            s->c[c] = s->c[c] * inverse;
            su->c[c] = w_fnma(s->c[c], su->c[3], su->c[c]) * inverse;
            sv->c[c] = w_fnma(s->c[c], sv->c[3], sv->c[c]) * inverse;
        }
    }
}

/* A vector of space in leaf coordinates. */
EP_INLINE w_3 w_to_leaf(const ep_leaf *leaf, const w_f *x)
{
    w_f r[3];
    for (int c = 0; c < 3; ++c)
        r[c] = w_fma(w_set(leaf->frame[2][c]), x[2],
                     w_fma(w_set(leaf->frame[1][c]), x[1], w_set(leaf->frame[0][c]) * x[0]));
    return (w_3){ r[0], r[1], r[2] };
}

/* Tangents along the leaf's own sides: S_s = uu S_u + vu S_v, S_t = uv S_u + vv S_v. */
EP_INLINE w_f w_along(float a, w_f su, float b, w_f sv, int triangle)
{
    return triangle ? w_fma(w_set(a), su, w_set(b) * sv) : w_set(a) * su;
}

/* The patch's parameters at (s, t) of a leaf. */
EP_INLINE void w_parameters(const ep_leaf *leaf, int triangle, w_f s, w_f t, w_f *u, w_f *v)
{
    const float *d = leaf->domain;
    *u = w_fma(s, w_set(d[2]), triangle ? w_fma(t, w_set(d[4]), w_set(d[0])) : w_set(d[0]));
    *v = w_fma(t, w_set(d[3]), triangle ? w_fma(s, w_set(d[5]), w_set(d[1])) : w_set(d[1]));
}

/* The origin moved by t: o' = (org - centre) + t dir, with the roundings of the difference and of the product carried
 * along (Knuth's two-sum, and a fused multiply-add): right to an ulp of o' itself, however far the ray has come. */
EP_INLINE void w_move(const ep_patch *patch, const w_f *org, const w_f *dir, w_f t, w_f *moved)
{
    for (int c = 0; c < 3; ++c) {
        const w_f centre = w_set(patch->centre[c]), o = org[c] - centre, back = o - org[c];
        const w_f lost = (org[c] - (o - back)) - (centre + back);
        const w_f way = t * dir[c], way_lost = w_fma(t, dir[c], -way);
        moved[c] = (o + way) + ((way_lost + lost) - w_set(patch->centre_low[c]));
    }
}

/* The jet of S - o' at (s, t). */
EP_INLINE w_jet w_jet_at(const ep_leaf *leaf, const ep_patch *patch, int triangle, unsigned m, unsigned n, int rational,
                         w_f s, w_f t, const w_f *moved)
{
    const float *d = leaf->domain;
    w_f u, v;
    w_4 p, su, sv;
    w_parameters(leaf, triangle, s, t, &u, &v);
    w_evaluate(patch, triangle, m, n, rational, u, v, &p, &su, &sv);
    for (int c = 0; c < 3; ++c) p.c[c] = p.c[c] - moved[c];
    const w_3 lu = w_to_leaf(leaf, su.c), lv = w_to_leaf(leaf, sv.c);
    w_jet j;
    j.at = w_to_leaf(leaf, p.c);
    j.ds = (w_3){ w_along(d[2], lu.x, d[5], lv.x, triangle), w_along(d[2], lu.y, d[5], lv.y, triangle),
                  w_along(d[2], lu.z, d[5], lv.z, triangle) };
    j.dt = (w_3){ w_along(d[3], lv.x, d[4], lu.x, triangle), w_along(d[3], lv.y, d[4], lu.y, triangle),
                  w_along(d[3], lv.z, d[4], lu.z, triangle) };
    return j;
}

/* Ng and u, v of the hits in `mask` into the rows of a hit packet. */
EP_INLINE void w_put_hit(const ep_leaf *leaf, int triangle, const w_jet *jet, const w_step *step, float *hit,
                         unsigned rays, uint32_t mask)
{
    const w_f zero = w_set(0.0f), one = w_set(1.0f);
    w_f u, v, ng[3];
    w_parameters(leaf, triangle, step->s, step->t, &u, &v);
    u = w_min(w_max(u, zero), one);
    v = w_min(w_max(v, zero), triangle ? one - u : one);
    w_normal(leaf, jet, step, ng);
    for (unsigned c = 0; c < 3; ++c) w_store(hit + (EP_HIT_NG + c) * rays, mask, ng[c]);
    w_store(hit + EP_HIT_U * rays, mask, u);
    w_store(hit + EP_HIT_V * rays, mask, v);
}

EP_INLINE ep_outcome w_packet(const ep_leaf *leaf, const ep_patch *patch, const float *ray, unsigned rays,
                              uint32_t active, float *t_out, float *hit_out, EPCounters *counters, int triangle,
                              unsigned m, unsigned n, int rational)
{
    ep_outcome outcome = { 0, 0 };
    for (unsigned base = 0; base < rays; base += EP_LANES, ray += EP_LANES, t_out += EP_LANES, hit_out += EP_LANES) {
        const uint32_t lanes = active >> base & (uint32_t)((1ull << EP_LANES) - 1);
        if (!lanes) continue;
        w_f org[3], dir[3], o[3], moved[3];
        for (int c = 0; c < 3; ++c) {
            org[c] = w_load(ray + (EP_RAY_ORG + (unsigned)c) * rays, rays - base);
            dir[c] = w_load(ray + (EP_RAY_DIR + (unsigned)c) * rays, rays - base);
            o[c] = (org[c] - w_set(patch->centre[c])) - w_set(patch->centre_low[c]);
        }
        const w_f tnear = w_load(ray + EP_RAY_TNEAR * rays, rays - base);
        const w_f tfar = w_load(ray + EP_RAY_TFAR * rays, rays - base);
        w_3 leaf_o = w_to_leaf(leaf, o);
        leaf_o.x = leaf_o.x + w_set(leaf->frame[3][0]);
        leaf_o.y = leaf_o.y + w_set(leaf->frame[3][1]);
        leaf_o.z = leaf_o.z + w_set(leaf->frame[3][2]);
        const w_f o_sum = (w_abs(o[0]) + w_abs(o[1])) + w_abs(o[2]);
        const w_f d_sum = (w_abs(dir[0]) + w_abs(dir[1])) + w_abs(dir[2]);
        w_visit visit = w_enter(leaf, triangle, leaf_o, w_to_leaf(leaf, dir), o_sum, d_sum, tnear, tfar, w_mask(lanes));
        counters->visits += (unsigned)__builtin_popcount(lanes);
        uint32_t live = w_bits(visit.live), hit = 0;
        counters->solves += (unsigned)__builtin_popcount(live | w_bits(visit.slow));
        if (live) w_move(patch, org, dir, visit.t_plane, moved);

        while (live) {
            const w_jet jet = w_jet_at(leaf, patch, triangle, m, n, rational, visit.s, visit.t, moved);
            counters->evaluations += (unsigned)__builtin_popcount(live);
            const w_step step = w_advance(leaf, &visit, triangle, &jet);
            const w_f t = visit.t_plane + step.distance;
            const w_m within = w_and(w_lt(w_load(ray + EP_RAY_TNEAR * rays, rays - base), t),
                                     w_le(t, w_load(ray + EP_RAY_TFAR * rays, rays - base)));
            const uint32_t found = w_bits(w_and(step.hit, within));
            if (found) {
                hit |= found;
                w_store(t_out, found, t);
                w_put_hit(leaf, triangle, &jet, &step, hit_out, rays, found);
            }
            live = w_bits(visit.live);
        }
        outcome.slow |= w_bits(visit.slow) << base;
        outcome.hit |= hit << base;
    }
    return outcome;
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
    for (unsigned k = 0; k < rays; k += 4) active |= f4_load_mask(valid + k) << k;
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
