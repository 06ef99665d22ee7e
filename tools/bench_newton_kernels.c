/* bench_newton_kernels.c - Newton's method as it is usual: what the kernels would be without certificates.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The leaf, its prism, where iteration starts, the evaluation of the surface and the second-order step are the
 * library's (embree_patch/isa). What is left out is everything that is not needed for a picture: no bound says whether
 * there is another root, or none, or how far off the hit is; a ray that is not there after NEWTON_STEPS misses. Such
 * kernels are all but as fast as they can be; those of packet_tmpl.h and single_tmpl.h have to be measured by them.
 * Compiled once per instruction set, with LANES and KERNELS. */
#include LANES
#include "embree_patch/isa/shapes_tmpl.h"

#include "tools/bench_newton_kernels.h"

static ep_outcome outcome(uint32_t hit, uint32_t tie)
{
    return (ep_outcome){(uint16_t)hit, (uint16_t)tie, 0, 0};
}

/* The prism, and where the ray meets the plane. */
EP_INLINE w_visit w_newton_enter(const ep_leaf *leaf, const w_rays *r, int triangle, w_m active)
{
    const w_3 o = w_origin(leaf, r), d = w_to_leaf(leaf, r->dir);
    w_visit v;
    v.inverse = w_set(1.0f) / d.z;
    v.moved = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    v.s = w_fma(v.moved, d.x, o.x);
    v.t = w_fma(v.moved, d.y, o.y);
    const w_f rim = w_set(leaf->rim), height = w_set(leaf->height), reach = w_abs(v.inverse) * height;
    const w_f reach_s = w_fma(w_abs(v.p_s), height, rim), reach_t = w_fma(w_abs(v.p_t), height, rim);
    w_m out = w_or(w_lt(r->tfar, v.moved - reach), w_lt(v.moved + reach, r->tnear));
    if (triangle)
        out = w_or(out, w_or(w_or(w_lt(reach_s, -v.s), w_lt(reach_t, -v.t)),
                             w_lt((reach_s + reach_t) - w_set(EP_THIRD), v.s + v.t)));
    else out = w_or(out, w_or(w_lt(reach_s, w_abs(v.s)), w_lt(reach_t, w_abs(v.t))));
    v.live = w_andnot(active, out);
    return v;
}

/* Over the nearer root of the graph's equation; where it has none, where the ray is nearest to that. */
EP_INLINE void w_newton_start(const ep_leaf *leaf, w_visit *v, int triangle)
{
    const w_f zero = w_set(0.0f), height = w_set(leaf->height);
    w_f c0, c1_2, c2;
    w_forms f;
    for (int c = 0; c < 3; ++c) w_forms_of(leaf, v, c, &f);
    w_equation(leaf, v, &f, &c0, &c1_2, &c2);
    const w_f y = w_set(1.0f) / c1_2, e = c0 * y;
    w_f tau = -e * w_set(0.5f);
    const w_m hard = w_andnot(v->live, w_le(w_abs(c2 * y * e), w_set(EP_EASY_Z)));
    if (w_bits(hard)) {
        const w_f q = w_abs(c1_2) + w_sqrt(w_max(w_fnma(c2, c0, c1_2 * c1_2), zero));
        tau = w_select(hard, w_select(w_lt(c1_2, zero), c0, -c0) / q, tau);
    }
    tau = w_min(w_max(tau, -height), height);
    const w_f u[2] = {w_fma(v->p_s, tau, v->s), w_fma(v->p_t, tau, v->t)};
    w_f x[2];
    for (int c = 0; c < 2; ++c)
        x[c] = w_fnma(w_fma(f.way_t[c], tau, f.plane_t[c]), u[1],
                      w_fnma(w_fma(f.way_s[c], tau, f.plane_s[c]), u[0], u[c]));
    w_clamp(triangle, &x[0], &x[1]);
    v->s = x[0];
    v->t = x[1];
}

EP_INLINE w_step w_newton_step(const w_visit *v, const w_surface *j)
{
    const w_linear l = w_solve(v, j);
    const w_f ss = l.d_s * l.d_s, st = l.d_s * l.d_t, tt = l.d_t * l.d_t, square = l.inverse * l.inverse;
    const w_3 curve = {w_fma(j->st.x, st, w_fma(j->tt.x, tt, j->ss.x * ss)),
                       w_fma(j->st.y, st, w_fma(j->tt.y, tt, j->ss.y * ss)),
                       w_fma(j->st.z, st, w_fma(j->tt.z, tt, j->ss.z * ss))};
    const w_f v_s = w_fnma(v->p_s, curve.z, curve.x), v_t = w_fnma(v->p_t, curve.z, curve.y);
    w_step r;
    r.step_s = w_fma(w_fnma(l.tt, v_s, l.st * v_t), square, l.d_s) * l.inverse;
    r.step_t = w_fma(w_fnma(l.ss, v_t, l.ts * v_s), square, l.d_t) * l.inverse;
    r.height = w_fma(j->dt.z, r.step_t, w_fma(j->ds.z, r.step_s, w_fma(curve.z, square, j->at.z)));
    r.s = v->s + r.step_s;
    r.t = v->t + r.step_t;
    return r;
}

EP_INLINE ep_outcome w_newton(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays, uint32_t active,
                              float *t_out, float *hit_out, EPCounters *counters, int triangle, unsigned m, unsigned n,
                              int rational)
{
    uint32_t hit = 0, tie = 0;
    for (unsigned base = 0; base < rays; base += EP_LANES, ray += EP_LANES, t_out += EP_LANES, hit_out += EP_LANES) {
        const uint32_t lanes = active >> base & (uint32_t)((1ull << EP_LANES) - 1);
        if (!lanes) continue;
        const w_rays r = w_load_rays(leaf, ray, rays, rays - base);
        w_visit v = w_newton_enter(leaf, &r, triangle, w_mask(lanes));
        uint32_t live = w_bits(v.live);
        counters->visits += (unsigned)__builtin_popcount(lanes);
        counters->solves += (unsigned)__builtin_popcount(live);
        if (!live) continue;
        v.o = w_move(leaf, &r, v.moved);
        w_newton_start(leaf, &v, triangle);
        for (int step = 0; live && step < NEWTON_STEPS; ++step) {
            const w_surface jet = w_surface_at(net, &v, triangle, m, n, rational);
            counters->evaluations += (unsigned)__builtin_popcount(live);
            w_step next = w_newton_step(&v, &jet);
            const w_f t = w_fma(next.height, v.inverse, v.moved);
            const w_m near = w_le(w_max(w_abs(next.step_s), w_abs(next.step_t)), w_set(NEWTON_NEAR));
            const w_m in = w_and(w_le(w_outside(triangle, next.s, next.t), w_set(NEWTON_RIM)),
                                 w_and(w_lt(r.tnear, t), w_le(t, r.tfar)));
            const w_m found = w_and(w_and(v.live, near), in);
            const uint32_t bits = w_bits(found);
            if (bits) {
                hit |= bits << base;
                tie |= w_bits(w_and(found, w_le(r.tfar, t))) << base;
                w_store(t_out, bits, t);
                w_put_hit(leaf, triangle, &jet, &next, hit_out, rays, bits);
            }
            v.live = w_andnot(v.live, near);
            live = w_bits(v.live);
            w_clamp(triangle, &next.s, &next.t);
            v.s = next.s;
            v.t = next.t;
        }
    }
    return outcome(hit, tie);
}

/* The same for one ray, its lanes across the coordinates of a point, as in single_tmpl.h. */
EP_INLINE ep_outcome f4_newton(const ep_leaf *leaf, const float *net, const float *ray, float *t_out, float *hit_out,
                               EPCounters *counters, int triangle, unsigned m, unsigned n, int rational)
{
    const f4 org = f4_load(ray + EP_RAY_ORG), dir = f4_load(ray + EP_RAY_DIR);
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    const f4 frame[3] = {f4_load(leaf->frame[0]), f4_load(leaf->frame[1]), f4_load(leaf->frame[2])};
    const f4 centre = f4_load(leaf->centre), centre_low = f4_load(leaf->centre_low), relative = org - centre;
    ++counters->visits;

    const f4 near = f4_to_leaf(frame, relative - centre_low), d = f4_to_leaf(frame, dir);
    const f4 inverse = f4_set(1.0f) / f4_lane(d, 2), t_plane = -f4_lane(near, 2) * inverse;
    const f4 p = d * inverse, plane = f4_fma(t_plane, d, near);
    const float height = leaf->height, reach = f4_abs(inverse)[0] * height;
    const f4 prism = f4_fma(f4_abs(p), f4_set(height), f4_set(leaf->rim));
    if (f4_lt(prism, triangle ? -plane : f4_abs(plane)) & 3) return outcome(0, 0);
    if (triangle && (prism[0] + prism[1]) - EP_THIRD < plane[0] + plane[1]) return outcome(0, 0);
    if (tfar < t_plane[0] - reach || t_plane[0] + reach < tnear) return outcome(0, 0);
    ++counters->solves;

    const f4 ss = f4_load(leaf->half[0]), st = f4_load(leaf->half[1]), tt = f4_load(leaf->half[2]);
    const f4 s = f4_lane(plane, 0), t = f4_lane(plane, 1), p_s = f4_lane(p, 0), p_t = f4_lane(p, 1);
    const f4 way_s = f4_fma(st, p_t, ss * p_s), way_t = f4_fma(tt, p_t, st * p_s);
    const f4 plane_s = f4_fma(st, t, ss * s), plane_t = f4_fma(tt, t, st * s);
    const f4 c1_2 = f4_fma(t, way_t, f4_fma(s, way_s, f4_set(-0.5f))), y = f4_set(1.0f) / c1_2;
    const f4 c0 = f4_fma(t, plane_t, f4_fma(s, plane_s, f4_set(leaf->middle)));
    const f4 c2 = f4_fma(p_t, way_t, p_s * way_s), e = c0 * y;
    f4 root = (f4_set(-0.5f) * c0) * y;
    if (EP_SELDOM(!(f1_abs(c2[2] * y[2] * e[2]) <= EP_EASY_Z))) {
        const float c = c1_2[2], q = f1_abs(c) + f1_sqrt(f1_max(f1_fma(-c2[2], c0[2], c * c), 0.0f));
        root = f4_set((c < 0 ? c0[2] : -c0[2]) / q);
    }
    const f4 tau = f4_min(f4_max(f4_lane(root, 2), f4_set(-height)), f4_set(height)), u = f4_fma(p, tau, plane);
    const f4 h_s = f4_fma(way_s, tau, plane_s), h_t = f4_fma(way_t, tau, plane_t);
    f4 x = f4_clamp(triangle, f4_fnma(h_t, f4_lane(u, 1), f4_fnma(h_s, f4_lane(u, 0), u)));

    const f4 back = relative - org, low = ((org - (relative - back)) - (centre + back)) - centre_low;
    const f4 o = f4_to_leaf(frame, f4_fma(t_plane, dir, relative) + low);
    for (int step = 0; step < NEWTON_STEPS; ++step) {
        const f4_jet j = f4_surface_at(net, x, o, triangle, m, n, rational);
        ++counters->evaluations;
        const f4_linear l = f4_solve(p, j.f, j.s, j.t);
        const f4 dd = l.d * l.d, square = l.inverse * l.inverse;
        const f4 curve =
            f4_fma(j.st, f4_lane(l.d * f4_swap(l.d), 0), f4_fma(j.tt, f4_lane(dd, 1), j.ss * f4_lane(dd, 0)));
        const f4 v = f4_fnma(p, f4_lane(curve, 2), curve);
        const f4 way = f4_fma(f4_fnma(l.m, v, l.n * f4_swap(v)), square, l.d) * l.inverse, next = x + way;
        if (EP_SELDOM(!(f4_norm(way) <= NEWTON_NEAR))) {
            x = f4_clamp(triangle, next);
            continue;
        }
        if (!(f4_outside(triangle, next) <= NEWTON_RIM)) break;
        const f4 way_s1 = f4_lane(way, 0), way_t1 = f4_lane(way, 1), twice_s = way_s1 + way_s1,
                 twice_t = way_t1 + way_t1;
        const f4 above = f4_fma(j.t, way_t1, f4_fma(j.s, way_s1, f4_fma(curve, f4_lane(square, 0), j.f)));
        const float k = f1_fma(above[2], inverse[0], t_plane[0]);
        if (!(tnear < k && k <= tfar)) break;
        *t_out = k;
        f4_put_hit(leaf, triangle, next, f4_fma(j.st, way_t1, f4_fma(j.ss, twice_s, j.s)),
                   f4_fma(j.tt, twice_t, f4_fma(j.st, way_s1, j.t)), hit_out);
        return outcome(1, k == tfar);
    }
    return outcome(0, 0);
}

#define EP_SHAPE(name, triangle, m, n, rational)                                                                       \
    EP_PACKET_AND_SINGLE(w_newton, f4_newton, name, triangle, m, n, rational)
EP_EVERY_SHAPE

const newton_kernels KERNELS = {.packet = EP_ALL(packet), .single = EP_ALL(single)};
