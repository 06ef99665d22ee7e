/* tangent_tmpl.h - rays that may meet a leaf twice, or hardly: the packet kernel's slow ones, one ray a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * As in packet_tmpl.h, but a neighbourhood that does not shrink is folded (fold_tmpl.h), and of two the second waits
 * for a lane that has nothing to do. What becomes of a neighbourhood does not depend on which that is. Nearly every ray
 * is decided by two evaluations; what is still open is cut into cells (cells_tmpl.h).
 *
 * Roots beyond tfar count, too: whether a lane is open, and so how its nearer root is found, to the bit, must not
 * depend on what the ray has met before. */

/* Where iteration begins: one neighbourhood for each part of the way that the graph's equation leaves, here with foot
 * and height of the moved origin. */
EP_INLINE void w_begin(const ep_leaf *leaf, w_visit *v, w_stack *wait, int triangle, const w_way *way)
{
    const w_f one = w_set(1.0f), half = w_set(0.5f), little = w_set(0x1p-20f);
    const w_f a = way->from * way->d.z, b = way->to * way->d.z, high = w_max(w_abs(a), w_abs(b));
    const w_f first = w_fnma(little, high, w_min(a, b)), last = w_fma(little, high, w_max(a, b));
    const w_graph g = w_meet_graph(leaf, v, triangle, v->noise_st, v->noise_h, high);
    const w_f p = w_fma(w_set(EP_TERMS), w_abs(v->o.z) + w_set(fabsf(leaf->middle)), g.p);
    const w_parts parts = w_quadratic(g.c0 - v->o.z, g.c1, g.c2, p, w_set(0.0f), w_lt(v->inverse, w_set(0.0f)));
    w_near near[2];
    for (int k = 0; k < 2; ++k) {
        const w_f from = w_max(parts.from[k], first), to = w_min(parts.to[k], last);
        const w_f tau = half * (from + to), ends = little * (w_abs(from) + w_abs(to)), h = w_fma(half, to - from, ends);
        w_f x[2];
        const w_f off =
            w_above(leaf, triangle, w_fma(v->p_s, tau, v->s), w_fma(v->p_t, tau, v->t), w_fma(v->p_max, h, g.e_st), x);
        near[k].none = w_or(w_lt(to, from), w_lt(off, w_outside(triangle, x[0], x[1])));
        w_clamp(triangle, &x[0], &x[1]);
        near[k].s = x[0];
        near[k].t = x[1];
        near[k].radius = w_min(off, one);
        near[k].first = from - ends;
        near[k].last = to + ends;
    }
    near[1].none = w_or(near[1].none, w_andnot(v->live, parts.two));
    const w_m left = w_andnot(v->live, w_or(parts.none, w_and(near[0].none, near[1].none)));
    v->live = w_mask(0);
    w_go_on(v, wait, near, left);
}

/* Neighbourhoods that wait go to lanes that have nothing to do. ray[k]: whose lane k is. */
EP_INLINE void w_share(w_visit *v, w_stack *wait, unsigned ray[EP_LANES])
{
    const uint32_t all = (uint32_t)((1ull << EP_LANES) - 1), slow = w_bits(v->slow);
    uint32_t full = w_bits(wait->full[0]) & ~slow, idle = all & ~(w_bits(v->live) | slow | full), to = 0, taken = 0;
    if (!full || !idle) return;
    alignas(64) int from[EP_LANES];
    for (int k = 0; k < EP_LANES; ++k) from[k] = k;
    for (; full && idle; full &= full - 1, idle &= idle - 1) {
        const int a = __builtin_ctz(full), b = __builtin_ctz(idle);
        from[b] = a;
        ray[b] = ray[a];
        to |= 1u << b;
        taken |= 1u << a;
    }
    w_f *const fields[] = {&v->p_s, &v->p_t, &v->p_max,    &v->inverse, &v->moved, &v->o.x,
                           &v->o.y, &v->o.z, &v->noise_st, &v->noise_h, &v->tnear, &v->tfar};
    for (size_t k = 0; k < sizeof fields / sizeof *fields; ++k) *fields[k] = w_permute(*fields[k], from);
    const w_near next = {w_permute(wait->near[0].s, from),      w_permute(wait->near[0].t, from),
                         w_permute(wait->near[0].radius, from), w_permute(wait->near[0].first, from),
                         w_permute(wait->near[0].last, from),   w_mask(0)};
    w_be_at(v, &next, w_permute(wait->parts[0], from), w_mask(to));
    w_pop(wait, w_mask(taken));
}

/* A root: t, how accurate it is, 1 if it is certain plus 2 if it is vague, Ng, u and v. */
enum { EP_ROOT_T, EP_ROOT_RADIUS, EP_ROOT_KIND, EP_ROOT_HIT, EP_ROOT_FIELDS = EP_ROOT_HIT + 5 };

static void get_root(const ep_roots *out, unsigned k, unsigned rays, unsigned ray, float root[EP_ROOT_FIELDS])
{
    root[EP_ROOT_T] = out->t[k][ray];
    root[EP_ROOT_RADIUS] = out->radius[k][ray];
    root[EP_ROOT_KIND] = (float)((out->hit[k] >> ray & 1) + 2 * (out->vague[k] >> ray & 1));
    for (unsigned f = 0; f < 5; ++f) root[EP_ROOT_HIT + f] = out->hits[k][f * rays + ray];
}

static void put_root(ep_roots *out, unsigned k, unsigned rays, unsigned ray, const float root[EP_ROOT_FIELDS])
{
    const uint32_t bit = 1u << ray, kind = (uint32_t)root[EP_ROOT_KIND];
    out->hit[k] = (out->hit[k] & ~bit) | (kind & 1) << ray;
    out->vague[k] = (out->vague[k] & ~bit) | kind >> 1 << ray;
    out->t[k][ray] = root[EP_ROOT_T];
    out->radius[k][ray] = root[EP_ROOT_RADIUS];
    for (unsigned f = 0; f < 5; ++f) out->hits[k][f * rays + ray] = root[EP_ROOT_HIT + f];
}

/* Of two the nearer one comes first, whichever is found first. A ray with a third is open. */
static void add_root(ep_roots *out, unsigned rays, unsigned ray, const float root[EP_ROOT_FIELDS])
{
    float other[EP_ROOT_FIELDS];
    unsigned f = 0;
    if ((out->hit[1] | out->vague[1]) >> ray & 1) {
        out->open |= 1u << ray;
    } else if ((out->hit[0] | out->vague[0]) >> ray & 1) {
        get_root(out, 0, rays, ray, other);
        while (f + 1 < EP_ROOT_FIELDS && root[f] == other[f]) ++f;
        put_root(out, root[f] < other[f], rays, ray, other);
        put_root(out, !(root[f] < other[f]), rays, ray, root);
    } else {
        put_root(out, 0, rays, ray, root);
    }
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
        unsigned whose[EP_LANES];
        for (unsigned k = 0; k < EP_LANES; ++k) whose[k] = base + k;
        w_begin(leaf, &v, &wait, triangle, &way);
        w_share(&v, &wait, whose);
        uint32_t live = w_bits(v.live), slow;
        while (live) {
            const w_surface jet = w_surface_at(net, &v, triangle, m, n, rational);
            const w_near here = w_here(&v);
            const w_step step = w_advance(leaf, &v, triangle, 1, &jet);
            if (w_bits(step.stuck)) w_fold(leaf, &v, &wait, triangle, &here, &jet, step.stuck);
            const w_f t = w_fma(step.height, v.inverse, v.moved);
            const w_f late = w_late(&step, v.moved, t);
            uint32_t found = w_bits(w_and(step.hit, w_nearly(t, late, v.tnear, w_set(INFINITY))));
            if (found) {
                const uint32_t vague = w_bits(w_or(step.vague, w_is_astray(leaf, &v)));
                const uint32_t certain = w_bits(w_surely(&step, t, late, v.tnear, v.tfar));
                alignas(64) float roots[EP_ROOT_FIELDS * EP_LANES];
                w_store(roots + EP_ROOT_T * EP_LANES, ~0u, t);
                w_store(roots + EP_ROOT_RADIUS * EP_LANES, ~0u, step.radius);
                w_put_hit(leaf, triangle, &jet, &step, roots + EP_ROOT_HIT * EP_LANES, EP_LANES, ~0u);
                for (; found; found &= found - 1) {
                    const unsigned k = (unsigned)__builtin_ctz(found);
                    float root[EP_ROOT_FIELDS];
                    for (unsigned f = 0; f < EP_ROOT_FIELDS; ++f) root[f] = roots[f * EP_LANES + k];
                    root[EP_ROOT_KIND] = vague >> k & 1 ? 2.0f + (float)(certain >> k & 1) : 1.0f;
                    add_root(out, rays, whose[k], root);
                }
            }
            w_next(&v, &wait, w_mask(~0u));
            w_share(&v, &wait, whose);
            live = w_bits(v.live);
        }
        for (slow = w_bits(v.slow); slow; slow &= slow - 1) out->open |= 1u << whose[__builtin_ctz(slow)];
    }
}
