/* tangent_tmpl.h - rays that may meet a leaf twice, or hardly: the packet kernel's slow ones, one ray a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * As in packet_tmpl.h, but a neighbourhood that does not shrink is folded (fold_tmpl.h), and of two the second waits.
 * Nearly every ray is decided by two evaluations; what is still open is cut into cells (cells_tmpl.h).
 *
 * Roots beyond tfar count, too: whether a lane is open, and so how its nearer root is found, to the bit, must not
 * depend on what the ray has met before. */

/* Where iteration begins: one neighbourhood for each part of the way that the graph's equation leaves, here with foot
 * and height of the moved origin. Roots are between *first and *last above that. */
EP_INLINE void w_begin(const ep_leaf *leaf, w_visit *v, w_stack *wait, int triangle, const w_way *way, w_f *first,
                       w_f *last)
{
    const w_f one = w_set(1.0f), half = w_set(0.5f);
    const w_f a = way->from * way->d.z, b = way->to * way->d.z, high = w_max(w_abs(a), w_abs(b));
    *first = w_fma(w_set(-0x1p-20f), high, w_min(a, b));
    *last = w_fma(w_set(0x1p-20f), high, w_max(a, b));
    const w_graph g = w_meet_graph(leaf, v, triangle, v->noise_st, v->noise_h, high);
    const w_f p = w_fma(w_set(EP_TERMS), w_abs(v->o.z) + w_set(fabsf(leaf->middle)), g.p);
    const w_parts parts = w_quadratic(g.c0 - v->o.z, g.c1, g.c2, p, w_set(0.0f), w_lt(v->inverse, w_set(0.0f)));
    w_near near[2];
    for (int k = 0; k < 2; ++k) {
        const w_f from = w_max(parts.from[k], *first), to = w_min(parts.to[k], *last);
        const w_f tau = half * (from + to), h = w_fma(half, to - from, w_set(0x1p-20f) * (w_abs(from) + w_abs(to)));
        w_f x[2];
        const w_f off =
            w_above(leaf, triangle, w_fma(v->p_s, tau, v->s), w_fma(v->p_t, tau, v->t), w_fma(v->p_max, h, g.e_st), x);
        near[k].none = w_or(w_lt(to, from), w_lt(off, w_outside(triangle, x[0], x[1])));
        w_clamp(triangle, &x[0], &x[1]);
        near[k].s = x[0];
        near[k].t = x[1];
        near[k].radius = w_min(off, one);
    }
    near[1].none = w_or(near[1].none, w_andnot(v->live, parts.two));
    const w_m left = w_andnot(v->live, w_or(parts.none, w_and(near[0].none, near[1].none)));
    v->live = w_mask(0);
    w_go_on(v, wait, near, left);
}

EP_INLINE void w_tangent(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays, uint32_t active,
                         ep_roots *out, int triangle, unsigned m, unsigned n, int rational)
{
    out->hit[0] = out->hit[1] = out->vague[0] = out->vague[1] = out->open = 0;
    for (unsigned base = 0; base < rays; base += EP_LANES, ray += EP_LANES) {
        const uint32_t lanes = active >> base & (uint32_t)((1ull << EP_LANES) - 1);
        if (!lanes) continue;
        const w_rays r = w_load_rays(leaf, ray, rays, rays - base);
        w_way way;
        w_visit v = w_approach(leaf, triangle, &r, w_mask(lanes), &way);
        w_stack wait = w_empty();
        w_f first, last;
        w_begin(leaf, &v, &wait, triangle, &way, &first, &last);
        uint32_t live = w_bits(v.live), hit[2] = {0, 0};
        while (live) {
            const w_surface jet = w_surface_at(net, &v, triangle, m, n, rational);
            const w_near here = w_here(&v);
            const w_step step = w_advance(leaf, &v, triangle, 1, &jet);
            if (w_bits(step.stuck)) w_fold(leaf, &v, &wait, triangle, &here, &jet, first, last, step.stuck);
            const w_f t = w_fma(step.height, v.inverse, v.moved);
            const uint32_t found = w_bits(w_and(step.hit, w_nearly(&step, v.moved, t, r.tnear, w_set(INFINITY))));
            const w_m vague = w_or(step.vague, w_is_astray(leaf, &v));
            const uint32_t slot[2] = {found & ~hit[0], found & hit[0]};
            v.slow = w_or(v.slow, w_mask(found & hit[1])); /* three roots in a leaf */
            for (unsigned k = 0; k < 2; ++k) {
                const uint32_t bits = slot[k];
                if (!bits) continue;
                hit[k] |= bits;
                out->vague[k] |= w_bits(w_and(w_mask(bits), vague)) << base;
                w_store(out->radius[k] + base, bits, step.radius);
                w_store(out->t[k] + base, bits, t);
                w_put_hit(leaf, triangle, &jet, &step, out->hits[k] + base, rays, bits);
            }
            w_next(&v, &wait, w_mask(~0u));
            live = w_bits(v.live);
        }
        out->open |= w_bits(v.slow) << base;
        for (unsigned k = 0; k < 2; ++k) out->hit[k] |= hit[k] << base;
    }
}
