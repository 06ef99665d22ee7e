/* single_tmpl.h - one ray against one leaf, the lanes across the coordinates of a point.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Operation for operation what packet_tmpl.h and newton_tmpl.h do to one of their lanes, so with the same bits; what it
 * all means stands there. A vector has s, t, h in its first three lanes, a quantity of the leaf's plane in the first
 * two; what is in the others does not matter. A number that multiplies vectors is in all lanes, any other is a float.
 */

/* F's Jacobian: J^-1 (s, t) = (m_0 s - n_0 t, m_1 t - n_1 s) inverse. */
typedef struct f4_linear {
    f4 m, n, inverse;
    f4 c;       /* the Newton point less y            */
    float i, q; /* magnitudes of J^-1 and of J^-1 p */
} f4_linear;

EP_INLINE float f1_fma(float a, float b, float c)
{
    return __builtin_fmaf(a, b, c);
}

EP_INLINE float f1_abs(float a)
{
    return __builtin_fabsf(a);
}

EP_INLINE float f1_sqrt(float a)
{
    return __builtin_sqrtf(a);
}

EP_INLINE float f1_max(float a, float b)
{
    return a > b ? a : b;
}

EP_INLINE float f1_min(float a, float b)
{
    return a < b ? a : b;
}

EP_INLINE f4 f4_to_leaf(const f4 *frame, f4 x)
{
    return f4_fma(frame[2], f4_lane(x, 2), f4_fma(frame[1], f4_lane(x, 1), frame[0] * f4_lane(x, 0)));
}

EP_INLINE f4 f4_clamp(int triangle, f4 x)
{
    const f4 low = f4_set(triangle ? -EP_THIRD : -EP_HALF), high = f4_set(triangle ? 2 * EP_THIRD : EP_HALF);
    x = f4_max(x, low);
    if (!triangle) return f4_min(x, high);
    const f4 third = f4_set(EP_THIRD);
    const f4 excess = f4_max((x + f4_swap(x)) - third, f4_set(0.0f)) * f4_set(0.5f);
    x = f4_max(x - excess, low);
    const f4 s = f4_min(x, high);
    return f4_first(s, f4_min(x, third - f4_lane(s, 0)));
}

EP_INLINE float f4_outside(int triangle, f4 x)
{
    if (!triangle) return f1_max(f4_abs(x)[0], f4_abs(x)[1]) - EP_HALF;
    return f1_max(f1_max(-x[0], -x[1]), x[0] + x[1]) - EP_THIRD;
}

/* The larger of the first two. */
EP_INLINE float f4_norm(f4 x)
{
    x = f4_abs(x);
    return f1_max(x[0], x[1]);
}

/* `at`: S - o; `ds`, `dt`: the tangents. */
EP_INLINE f4_linear f4_solve(f4 p, f4 at, f4 ds, f4 dt)
{
    const f4 f = f4_fnma(p, f4_lane(at, 2), at);
    const f4 by_s = f4_fnma(p, f4_lane(ds, 2), ds), by_t = f4_fnma(p, f4_lane(dt, 2), dt);
    const f4 s_by = f4_swap(by_s), t_by = f4_swap(by_t);
    f4_linear l = {.m = f4_first(t_by, s_by), .n = f4_first(by_t, by_s)};
    const f4 det = f4_fnma(l.n, f4_first(s_by, t_by), l.m * f4_first(by_s, by_t));
    l.inverse = f4_set(1.0f) / det;
    l.c = f4_fnma(l.m, f, l.n * f4_swap(f)) * l.inverse;
    const f4 i = f4_abs(l.m) + f4_abs(l.n), q = f4_abs(f4_fnma(l.n, f4_swap(p), l.m * p));
    const float size = f4_abs(l.inverse)[0];
    l.i = f1_max(i[0], i[1]) * size;
    l.q = f1_max(q[0], q[1]) * size;
    return l;
}

EP_INLINE float f4_spread(const f4_linear *l, float st, float h)
{
    return f1_fma(l->q, h, l->i * st);
}

/* S - o and the tangents at x. */
EP_INLINE void f4_jet(const float *net, f4 x, f4 o, int triangle, unsigned m, unsigned n, int rational, f4 *at, f4 *ds,
                      f4 *dt)
{
    /* x + -0 is x, to the sign of a zero */
    const f4 one_s = {1, -0.0f, -0.0f, -0.0f}, one_t = {-0.0f, 1, -0.0f, -0.0f};
    f4_series(net, rational ? 4 : 3, triangle, m, n, f4_lane(x, 0), f4_lane(x, 1), at, ds, dt);
    if (rational) {
        const f4 inverse = f4_set(1.0f) / f4_lane(*at, 3);
        *at = *at * inverse;
        *ds = f4_fnma(*at, f4_lane(*ds, 3), *ds) * inverse;
        *dt = f4_fnma(*at, f4_lane(*dt, 3), *dt) * inverse;
        *at = *at - o;
    } else {
        *at = f4_third((x - o) + *at, *at - o);
        *ds = *ds + one_s;
        *dt = *dt + one_t;
    }
}

/* Ng, u and v at x, `a` and `b` being the tangents there. */
EP_INLINE void f4_put_hit(const ep_leaf *leaf, int triangle, f4 x, f4 a, f4 b, float *hit)
{
    const f4 n = f4_set(leaf->volume) * f4_next(f4_fnma(f4_next(a), b, a * f4_next(b)));
    for (int c = 0; c < 3; ++c)
        hit[EP_HIT_NG + c] = f1_fma(leaf->frame[c][2], n[2], f1_fma(leaf->frame[c][1], n[1], leaf->frame[c][0] * n[0]));
    const f4 edge = f4_set(triangle ? EP_THIRD : EP_HALF), one = f4_set(1.0f), zero = f4_set(0.0f);
    const f4 domain = f4_load(leaf->domain), from = x + edge;
    f4 base = domain;
    if (triangle) base = f4_fma(f4_swap(from), f4_high(f4_load(leaf->domain + 2)), base);
    f4 uv = f4_fma(from, f4_high(domain), base);
    uv = f4_max(uv, zero);
    const f4 u = f4_min(uv, one);
    uv = f4_first(u, f4_min(uv, triangle ? one - f4_lane(u, 0) : one));
    hit[EP_HIT_U] = uv[0];
    hit[EP_HIT_V] = uv[1];
}

EP_INLINE ep_outcome f4_single(const ep_leaf *leaf, const float *net, const float *ray, float *t_out, float *hit_out,
                               EPCounters *counters, int triangle, unsigned m, unsigned n, int rational)
{
    const ep_outcome none = {0, 0, 0, 0}, slow = {0, 0, 0, 1};
    const f4 org = f4_load(ray + EP_RAY_ORG), dir = f4_load(ray + EP_RAY_DIR);
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    const f4 frame[3] = {f4_load(leaf->frame[0]), f4_load(leaf->frame[1]), f4_load(leaf->frame[2])};
    const f4 centre = f4_load(leaf->centre), centre_low = f4_load(leaf->centre_low), relative = org - centre;

    /* enter */
    const f4 near = f4_to_leaf(frame, relative - centre_low), d = f4_to_leaf(frame, dir), da = f4_abs(dir);
    const float d_sum = (da[0] + da[1]) + da[2];
    const f4 inverse = f4_set(1.0f) / f4_lane(d, 2), t_plane = -f4_lane(near, 2) * inverse;
    const f4 p = d * inverse, plane = f4_fma(t_plane, d, near);
    const float far = f4_abs(t_plane)[0] * d_sum;
    const float side = f1_fma(leaf->reach_st, far, leaf->side);
    const float height = f1_fma(leaf->reach_h, far, leaf->height);
    const f4 along = f4_fma(f4_abs(p), f4_set(height), f4_set(side));
    const float reach = f4_abs(inverse)[0] * height;
    const f4 bound = f4_set(triangle ? EP_THIRD : EP_HALF) + along;
    ++counters->visits;
    if (!(f4_abs(inverse)[0] > 0)) {
        ++counters->solves;
        return slow;
    }
    if (f4_lt(bound, triangle ? -plane : f4_abs(plane)) & 3) return none;
    if (triangle && EP_THIRD + (along[0] + along[1]) < plane[0] + plane[1]) return none;
    if (tfar < t_plane[0] - reach || t_plane[0] + reach < tnear) return none;
    ++counters->solves;
    if (!(f4_norm(p) < EP_STEEP)) return slow;

    /* move, start */
    const float way = d_sum * reach;
    const f4 back = relative - org, low = ((org - (relative - back)) - (centre + back)) - centre_low;
    const f4 o = f4_to_leaf(frame, f4_fma(t_plane, dir, relative) + low);
    const float noise_st = f1_fma(leaf->reach_st, way, leaf->noise_st);
    const float noise_h = f1_fma(leaf->reach_h, way, leaf->noise_h);
    const f4 ss = f4_load(leaf->half[0]), st = f4_load(leaf->half[1]), tt = f4_load(leaf->half[2]);
    float radius;
    f4 x;
    {
        /* the graph */
        const float extent = triangle ? 2 * EP_THIRD : EP_HALF, room = extent + leaf->side;
        const float ss_h = leaf->half[0][2], st_h = leaf->half[1][2], tt_h = leaf->half[2][2];
        const float s = plane[0], t = plane[1], p_s = p[0], p_t = p[1];
        const float g_s = f1_fma(st_h, t, ss_h * s), g_t = f1_fma(tt_h, t, st_h * s);
        const float c0 = f1_fma(t, g_t, f1_fma(s, g_s, leaf->middle));
        const float c1 = f1_fma(p_t + p_t, g_t, f1_fma(p_s + p_s, g_s, -1.0f));
        const float c2 = f1_fma(p_t, f1_fma(tt_h, p_t, st_h * p_s), p_s * f1_fma(st_h, p_t, ss_h * p_s));

        const float e_st = f1_fma(leaf->reach_st, far, noise_st), e_h = f1_fma(leaf->reach_h, far, noise_h);
        const float p_max = f4_norm(p), high = leaf->height + e_h, along = f1_fma(p_max, high, f4_norm(plane));
        const float terms = f1_fma(leaf->bend_h * along, along, high + high);
        const float error = f1_fma(EP_TERMS, terms, f1_fma(leaf->bend_h * room, e_st, leaf->graph + e_h));

        /* its root */
        const float y = 1.0f / c1, e = c0 * y, ratio = (4.0f * c2) * y, z = e * ratio;
        const float spread = f1_abs(y) * error, slope = EP_SERIES_SLOPE * spread;
        float tau = -e * f1_fma(z, f1_fma(z, f1_fma(z, 5.0f / 64, 1.0f / 8), 1.0f / 4), 1.0f);
        float delta = f1_fma(EP_SERIES_REST, f1_abs(e), f1_fma(slope, f1_abs(z), slope));
        if (!(f1_abs(z) <= EP_SERIES_Z && f1_abs(ratio) * spread <= EP_SERIES_WIDTH &&
              f1_abs(ratio) * (high + delta) <= EP_SERIES_OTHER)) {
            const float four = 4.0f * c2, width = f1_abs(four) * error;
            const float d = f1_fma(-four, c0, c1 * c1);
            if (d + width < 0) return none;
            if (!(width < 0.75f * d)) {
                const float spread = f1_sqrt(f1_max(d + width, 0.0f)) * (1 + 0x1p-10f);
                const float twice = c2 + c2, size = f1_abs(twice);
                const f4 u = f4_fnma(p, f4_set(c1), plane * f4_set(twice));
                const float sum = f1_fma(p_max, f1_abs(c1), f4_norm(plane) * size);
                const float beside = f1_fma(EP_TERMS, sum, f1_fma(p_max, spread, (room + e_st) * size));
                return f1_fma(high, size, spread) < f1_abs(c1) || beside < f4_norm(u) ? none : slow;
            }
            const float root = f1_sqrt(d), q = f1_abs(c1) + root, over = 1.0f / (q * root), twice_c0 = c0 + c0;
            delta = (1.5f * error) * (q * over);
            tau = ((c1 < 0 ? twice_c0 : -twice_c0) * root) * over;
            const float twice = c2 + c2, size = f1_abs(twice), within = high + delta, q_2 = c1 < 0 ? q : -q;
            const float about = f1_fma(p_max, delta, e_st);
            const f4 u_2 = f4_fma(p, f4_set(q_2), plane * f4_set(twice));
            const float t_2 = (twice < 0 ? -q_2 : q_2) * inverse[0];
            const float late = f1_fma(f1_fma(EP_TERMS, within, delta), f1_abs(inverse[0]),
                                      EP_TERMS * (f1_abs(t_plane[0]) + f1_abs(tnear)));
            const bool behind = f1_fma(late, size, t_2) < (tnear - t_plane[0]) * size;
            if (q <= within * size && f4_norm(u_2) <= (room + about) * size && !behind) return slow;
        }

        /* and the point there */
        const f4 u = f4_fma(p, f4_set(tau), plane);
        const float about = f1_fma(p_max, delta, e_st), beside = leaf->side + about;
        if (!(f1_abs(tau) <= high + delta && f4_outside(triangle, u) <= (triangle ? beside + beside : beside)))
            return none;
        const f4 u_s = f4_lane(u, 0), u_t = f4_lane(u, 1);
        const f4 h_s = f4_fma(st, u_t, ss * u_s), h_t = f4_fma(tt, u_t, st * u_s);
        const f4 m_u = f4_fma(h_t, u_t, h_s * u_s), twice = m_u + m_u;
        x = f4_fma(h_s, f4_lane(twice, 0), f4_fma(h_t, f4_lane(twice, 1), u - m_u));
        const float k = leaf->bend_st * f1_fma(triangle ? 4.0f : 1.0f, beside, extent);
        const float once = f1_fma(f1_fma(f1_fma(1.5f, k, 1.0f), k, 1.0f), about, leaf->foot);
        const float off = triangle ? once + once : once;
        if (off < f4_outside(triangle, x)) return none;
        radius = f1_min(off, 1.0f);
        x = f4_clamp(triangle, x);
    }

    for (;;) {
        f4 at, ds, dt;
        f4_jet(net, x, o, triangle, m, n, rational, &at, &ds, &dt);
        ++counters->evaluations;

        /* advance */
        const f4_linear l = f4_solve(p, at, ds, dt);
        const float c_s = l.c[0], c_t = l.c[1];
        const f4 curve = f4_fma(st, f4_set((c_s + c_s) * c_t), f4_fma(tt, f4_set(c_t * c_t), ss * f4_set(c_s * c_s)));
        const f4 v = f4_fnma(p, f4_lane(curve, 2), curve);
        const f4 step = f4_fma(f4_fnma(l.m, v, l.n * f4_swap(v)), l.inverse, l.c);
        const f4 found = x + step, step_s = f4_lane(step, 0), step_t = f4_lane(step, 1);
        const float bend = f4_spread(&l, leaf->bend_st, leaf->bend_h);
        const float warp = f4_spread(&l, leaf->warp_st, leaf->warp_h);
        const float noise = f4_spread(&l, noise_st, noise_h);
        const float length = f4_norm(l.c), around = length + noise, turn = bend * radius;
        const bool unique = turn <= 1.0f;
        const float e = unique ? f1_min(radius, f1_fma(turn, around, around)) : radius, ge = bend * e;
        const float third = f1_fma(0.25f, ge, 1.0f), bound = 0.5f * e * f1_fma(ge * ge, third, warp * e);
        const float displaced = f1_fma(noise, f1_fma(0.5f, f1_fma(ge, ge, bend * noise), ge), noise);
        const float margin = displaced + bound, outside = f4_outside(triangle, found);
        const float left = triangle ? margin + margin : margin;
        if (left < outside || radius + margin < f4_norm(step)) return none;
        if (length <= EP_NEAR && bound <= f1_max(EP_REMAINDER * noise, EP_ACCEPT * leaf->noise_st) && unique &&
            bend * margin <= 1.0f) {
            const bool vague = EP_FLAT < margin || (EP_SHARP < left && -outside <= left);
            const f4 above = f4_fma(dt, step_t, f4_fma(ds, step_s, at + curve));
            const float t = f1_fma(above[2], inverse[0], t_plane[0]);
            if (!(tnear < t && t <= tfar)) {
                if (!vague) return none;
                const float slope = f1_fma(leaf->bend_h, length + margin, f1_abs(ds[2]) + f1_abs(dt[2]));
                const float lift = 0.5f * e * f1_fma(leaf->bend_h * ge, e * third, leaf->warp_h * e);
                const float late = f1_fma(EP_TERMS, f1_abs(t_plane[0]) + f1_abs(t),
                                          (f1_fma(slope, margin, noise_h) + lift) * f1_abs(inverse[0]));
                if (!(tnear < t + late && t - late <= tfar)) return none;
            }
            *t_out = t;
            const f4 twice_s = step_s + step_s, twice_t = step_t + step_t;
            f4_put_hit(leaf, triangle, found, f4_fma(st, twice_t, f4_fma(ss, twice_s, ds)),
                       f4_fma(tt, twice_t, f4_fma(st, twice_s, dt)), hit_out);
            return (ep_outcome){1, t == tfar, vague, 0};
        }
        if (!(left < 0.75f * radius)) return slow;
        x = f4_clamp(triangle, found);
        radius = left;
    }
}
