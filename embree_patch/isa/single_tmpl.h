/* single_tmpl.h - one ray against one leaf, the lanes across the control net.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Operation for operation what packet_tmpl.h does to one of its lanes, with sixteen coordinates of a block of the net
 * in a register instead of sixteen rays. */

EP_INLINE q_f s_row(const float *net, unsigned count, const float *c)
{
    q_f q = q_mul(c[0], net);
    for (unsigned i = 1; i < count; ++i) q = q_fma(c[i], net + 16 * i, q);
    return q;
}

EP_INLINE void s_evaluate(const ep_patch *patch, int triangle, unsigned m, unsigned n, int rational, float u, float v,
                          f4 *s, f4 *su, f4 *sv)
{
    const float *net = patch->net;
    float c[EP_MAX_DEGREE], e[EP_MAX_DEGREE];
    s_bernstein(n - 1, v, triangle ? 1.0f : 1.0f - v, e);
    s_bernstein((triangle ? n : m) - 1, u, triangle ? (1.0f - u) - v : 1.0f - u, c);
    q_f h = q_scale(e[0], s_row(net, m, c));
    for (unsigned j = 1; j < n; ++j) {
        net += 16 * (triangle ? n - j + 1 : m);
        if (triangle) s_bernstein(n - j - 1, u, (1.0f - u) - v, c);
        h = q_add_scaled(e[j], s_row(net, triangle ? n - j : m, c), h);
    }
    const f4 h0 = q_part(h, 0), h1 = q_part(h, 1), h2 = q_part(h, 2), u4 = f4_set(u), v4 = f4_set(v);
    if (triangle) {
        *sv = h1 - h0;
        *su = h2 - h0;
        *s = f4_fma(u4, *su, f4_fma(v4, *sv, h0));
    } else {
        const f4 h3 = q_part(h, 3);
        const f4 d0 = h2 - h0, d1 = h3 - h1;
        const f4 a0 = f4_fma(u4, d0, h0), a1 = f4_fma(u4, d1, h1);
        *sv = a1 - a0;
        *s = f4_fma(v4, *sv, a0);
        *su = f4_fma(v4, d1 - d0, d0);
    }
    *su = f4_set((float)m) * *su;
    *sv = f4_set((float)n) * *sv;
    if (rational) {
        const f4 inverse = f4_set(1.0f / (*s)[3]);
        *s = *s * inverse;
        const f4 wu = f4_lane(*su, 3), wv = f4_lane(*sv, 3);
        *su = f4_fnma(*s, wu, *su) * inverse;
        *sv = f4_fnma(*s, wv, *sv) * inverse;
    }
}

/* A vector of space in leaf coordinates. */
EP_INLINE f4 s_to_leaf(const f4 *frame, f4 x)
{
    return f4_fma(frame[2], f4_lane(x, 2), f4_fma(frame[1], f4_lane(x, 1), frame[0] * f4_lane(x, 0)));
}

EP_INLINE void s_parameters(const ep_leaf *leaf, int triangle, float s, float t, float *u, float *v)
{
    const float *d = leaf->domain;
    *u = s_fma(s, d[2], triangle ? s_fma(t, d[4], d[0]) : d[0]);
    *v = s_fma(t, d[3], triangle ? s_fma(s, d[5], d[1]) : d[1]);
}

EP_INLINE float s_along(float a, float su, float b, float sv, int triangle)
{
    return triangle ? s_fma(a, su, b * sv) : a * su;
}

EP_INLINE ep_outcome s_single(const ep_leaf *leaf, const ep_patch *patch, const float *ray, float *t_out,
                              float *hit_out, EPCounters *counters, int triangle, unsigned m, unsigned n, int rational)
{
    const float *dom = leaf->domain;
    const f4 org = f4_load3(ray + EP_RAY_ORG), dir = f4_load3(ray + EP_RAY_DIR);
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    const f4 centre = f4_load3(patch->centre), centre_low = f4_load3(patch->centre_low);
    const f4 first = org - centre, o = first - centre_low;
    const f4 frame[3] = { f4_load3(leaf->frame[0]), f4_load3(leaf->frame[1]), f4_load3(leaf->frame[2]) };
    const f4 lo = s_to_leaf(frame, o) + f4_load3(leaf->frame[3]), ld = s_to_leaf(frame, dir);
    const f4 oa = f4_abs(o), da = f4_abs(dir);
    s_visit visit = s_enter(leaf, triangle, (s_3){ lo[0], lo[1], lo[2] }, (s_3){ ld[0], ld[1], ld[2] },
                            (oa[0] + oa[1]) + oa[2], (da[0] + da[1]) + da[2], tnear, tfar, 1);
    ++counters->visits;
    if (!visit.live) {
        counters->solves += visit.slow;
        return (ep_outcome){ 0, visit.slow };
    }
    ++counters->solves;

    const f4 t_plane = f4_set(visit.t_plane), back = first - org;
    const f4 lost = (org - (first - back)) - (centre + back);
    const f4 way = t_plane * dir;
    const f4 way_lost = f4_fma(t_plane, dir, -way);
    const f4 moved = (first + way) + ((way_lost + lost) - centre_low);

    for (;;) {
        float u, v;
        s_parameters(leaf, triangle, visit.s, visit.t, &u, &v);
        f4 s, su, sv;
        s_evaluate(patch, triangle, m, n, rational, u, v, &s, &su, &sv);
        ++counters->evaluations;
        const f4 at = s_to_leaf(frame, s - moved), lu = s_to_leaf(frame, su), lv = s_to_leaf(frame, sv);
        s_jet jet;
        jet.at = (s_3){ at[0], at[1], at[2] };
        jet.ds = (s_3){ s_along(dom[2], lu[0], dom[5], lv[0], triangle), s_along(dom[2], lu[1], dom[5], lv[1], triangle),
                        s_along(dom[2], lu[2], dom[5], lv[2], triangle) };
        jet.dt = (s_3){ s_along(dom[3], lv[0], dom[4], lu[0], triangle), s_along(dom[3], lv[1], dom[4], lu[1], triangle),
                        s_along(dom[3], lv[2], dom[4], lu[2], triangle) };
        const s_step step = s_advance(leaf, &visit, triangle, &jet);
        if (visit.live) continue;
        if (visit.slow) return (ep_outcome){ 0, 1 };
        const float t = visit.t_plane + step.distance;
        if (!(step.hit && tnear < t && t <= tfar)) return (ep_outcome){ 0, 0 };

        *t_out = t;
        s_normal(leaf, &jet, &step, hit_out + EP_HIT_NG);
        s_parameters(leaf, triangle, step.s, step.t, &u, &v);
        hit_out[EP_HIT_U] = s_min(s_max(u, 0.0f), 1.0f);
        hit_out[EP_HIT_V] = s_min(s_max(v, 0.0f), triangle ? 1.0f - hit_out[EP_HIT_U] : 1.0f);
        return (ep_outcome){ 1, 0 };
    }
}
