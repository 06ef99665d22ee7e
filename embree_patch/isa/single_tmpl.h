/* single_tmpl.h - one ray against one leaf, the lanes across the coordinates of a point.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Operation for operation what packet_tmpl.h and newton_tmpl.h do to one of their lanes, so with the same bits; what it
 * all means stands there. A vector has s, t, h in its first three lanes, a quantity of the leaf's plane in the first
 * two; what is in the others does not matter. A number that multiplies vectors is in all lanes, any other is a float.
 */

/* Ng, u and v at x, `a` and `b` being the tangents there. */
EP_INLINE void f4_put_hit(const ep_leaf *leaf, int triangle, f4 x, f4 a, f4 b, float *hit)
{
    const f4 n = f4_set(leaf->volume) * f4_cross(a, b);
    const float *f = leaf->frame[0], n_s = n[0], n_t = n[1], n_h = n[2];
    const float x_ng = f1_fma(f[2], n_h, f1_fma(f[1], n_t, f[0] * n_s));
    const float y_ng = f1_fma(f[5], n_h, f1_fma(f[4], n_t, f[3] * n_s));
    const float z_ng = f1_fma(f[8], n_h, f1_fma(f[7], n_t, f[6] * n_s));
    const f4 edge = f4_set(triangle ? EP_THIRD : EP_HALF), one = f4_set(1.0f), zero = f4_set(0.0f);
    const f4 domain = f4_load(leaf->domain), from = x + edge;
    f4 base = domain;
    if (triangle) base = f4_fma(f4_swap(from), f4_high(f4_load(leaf->domain + 2)), base);
    f4 uv = f4_fma(from, f4_high(domain), base);
    uv = f4_max(uv, zero);
    const f4 u = f4_min(uv, one);
    uv = f4_first(u, f4_min(uv, triangle ? one - f4_lane(u, 0) : one));
    f4_store(hit + EP_HIT_NG, (f4){x_ng, y_ng, z_ng, uv[0]}); /* at once, as it is loaded by ep_offer_one */
    hit[EP_HIT_V] = uv[1];
}

/* What w_start asks of a ray against a leaf's graph. */
typedef struct f1_graph {
    float c0, c1, c2, p, e_st, high, p_max;
} f1_graph;

/* w_near_root's answer: whether there is a root to begin at. */
typedef enum f1_answer { F1_ROOT, F1_NONE, F1_UNCLEAR } f1_answer;

static __attribute__((noinline)) f1_answer f1_near_root(const ep_leaf *leaf, const f1_graph *g, int triangle, f4 p,
                                                        f4 plane, float inverse, float moved, float tnear, float *tau,
                                                        float *delta)
{
    const float room = ep_leaf_room(leaf, triangle);
    const float four = 4.0f * g->c2, width = f1_abs(four) * g->p, d = f1_fma(-four, g->c0, g->c1 * g->c1);
    const float twice = g->c2 + g->c2, size = f1_abs(twice), far = f1_abs(g->c1);
    if (d + width < 0) return F1_NONE;
    if (!(width < 0.75f * d)) {
        const float spread = f1_sqrt(f1_max(d + width, 0.0f)) * (1 + 0x1p-10f);
        const f4 u = f4_fnma(p, f4_set(g->c1), plane * f4_set(twice));
        const float sum = f1_fma(g->p_max, far, f4_norm(plane) * size);
        const float beside = f1_fma(EP_TERMS, sum, f1_fma(g->p_max, spread, (room + g->e_st) * size));
        return f1_fma(g->high, size, spread) < far || beside < f4_norm(u) ? F1_NONE : F1_UNCLEAR;
    }
    const float root = f1_sqrt(d), q = far + root, over = 1.0f / (q * root), twice_c0 = g->c0 + g->c0;
    *delta = (1.5f * g->p) * (q * over);
    *tau = ((g->c1 < 0 ? twice_c0 : -twice_c0) * root) * over;
    const float within = g->high + *delta, q_2 = g->c1 < 0 ? q : -q, about = f1_fma(g->p_max, *delta, g->e_st);
    const f4 u_2 = f4_fma(p, f4_set(q_2), plane * f4_set(twice));
    const float t_2 = (twice < 0 ? -q_2 : q_2) * inverse;
    const float late =
        f1_fma(f1_fma(EP_TERMS, within, *delta), f1_abs(inverse), EP_TERMS * (f1_abs(moved) + f1_abs(tnear)));
    const bool behind = f1_fma(late, size, t_2) < (tnear - moved) * size;
    return q <= within * size && f4_norm(u_2) <= (room + about) * size && !behind ? F1_UNCLEAR : F1_ROOT;
}

EP_INLINE ep_outcome f4_single(const ep_leaf *leaf, const float *net, const float *ray, float *t_out, float *hit_out,
                               EPCounters *counters, int triangle, unsigned m, unsigned n, int rational)
{
    const ep_outcome none = {0, 0, 0, 0}, slow = {0, 0, 0, 1};
    const f4 org = f4_load(ray + EP_RAY_ORG), dir = f4_load(ray + EP_RAY_DIR);
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    const f4 frame[3] = {f4_load(leaf->frame[0]), f4_load(leaf->frame[1]), f4_load(leaf->frame[2])};
    const f4 centre = f4_load(leaf->centre), centre_low = f4_load(leaf->centre_low), relative = org - centre;
    ++counters->visits;

    /* enter */
    const f4 near = f4_to_leaf(frame, relative - centre_low), d = f4_to_leaf(frame, dir), da = f4_abs(dir);
    const float d_sum = (da[0] + da[1]) + da[2];
    const f4 inverse = f4_set(1.0f) / f4_lane(d, 2), t_plane = -f4_lane(near, 2) * inverse;
    const f4 p = d * inverse, plane = f4_fma(t_plane, d, near), p_abs = f4_abs(p);
    const float far = f4_abs(t_plane)[0] * d_sum;
    /* rim, height, graph and foot, for a ray from so far away */
    const f4 off = f4_fma(f4_set(far), f4_set(leaf->reach), f4_load(&leaf->rim));
    const f4 prism = f4_fma(p_abs, f4_lane(off, 1), f4_lane(off, 0));
    const float high = off[1], reach = f4_abs(inverse)[0] * high;
    if (!(f4_abs(inverse)[0] > 0)) {
        ++counters->solves;
        return slow;
    }
    if (f4_lt(prism, triangle ? -plane : f4_abs(plane)) & 3) return none;
    if (triangle && (prism[0] + prism[1]) - EP_THIRD < plane[0] + plane[1]) return none;
    if (tfar < t_plane[0] - reach || t_plane[0] + reach < tnear) return none;
    ++counters->solves;
    /* what was rounded off when the origin was taken to the leaf: w_move */
    const f4 back = relative - org, low = ((org - (relative - back)) - (centre + back)) - centre_low;
    if (f4_starts_within(leaf, triangle, near, d, tnear)) {
        const f4 start = f4_to_leaf(frame, f4_fma(f4_set(tnear), dir, relative) + low);
        if (f4_leaves(leaf, net, start, d, d_sum, triangle, m, n, rational)) return none;
    }
    const float p_max = f4_norm(p), astray = leaf->reach * far;
    if (!(p_max < EP_STEEP && astray < EP_ASTRAY)) return slow;

    /* start: the graph's equation, of heights in the third lane */
    const f4 ss = f4_load(leaf->half[0]), st = f4_load(leaf->half[1]), tt = f4_load(leaf->half[2]);
    const f4 s = f4_lane(plane, 0), t = f4_lane(plane, 1), p_s = f4_lane(p, 0), p_t = f4_lane(p, 1);
    const f4 way_s = f4_fma(st, p_t, ss * p_s), way_t = f4_fma(tt, p_t, st * p_s);
    const f4 plane_s = f4_fma(st, t, ss * s), plane_t = f4_fma(tt, t, st * s);
    const f4 half_c1 = f4_fma(t, way_t, f4_fma(s, way_s, f4_set(-0.5f))), over_c1 = f4_set(1.0f) / half_c1;
    const f4 c0s = f4_fma(t, plane_t, f4_fma(s, plane_s, f4_set(leaf->middle))), c2s = f4_fma(p_t, way_t, p_s * way_s);
    f4 root = (f4_set(-0.5f) * c0s) * over_c1; /* -e/2, a product sooner */
    const float c0 = c0s[2], c1_2 = half_c1[2], c2 = c2s[2], y = over_c1[2];
    const float e0 = c0 * y, ratio = c2 * y, z = e0 * ratio, size = f1_abs(z);
    const float spread = f1_abs(y) * off[2], slope = EP_EASY_SLOPE * spread;
    float delta = f1_fma(size, f1_fma(EP_EASY_REST, f1_abs(e0), slope), slope);
    if (EP_SELDOM(!(size <= EP_EASY_Z && f1_abs(ratio) * spread <= EP_EASY_WIDTH &&
                    f1_abs(ratio) * (high + delta) <= EP_EASY_OTHER))) {
        const f1_graph g = {c0, c1_2 + c1_2, c2, off[2], astray, high, p_max};
        float exact[2];
        const f1_answer a =
            f1_near_root(leaf, &g, triangle, p, plane, inverse[0], t_plane[0], tnear, &exact[0], &exact[1]);
        if (a != F1_ROOT) return a == F1_NONE ? none : slow;
        root = f4_set(exact[0]);
        delta = exact[1];
    }

    /* ... and the point there */
    const float about = f1_fma(leaf->reach, far, p_max * delta);
    if (!(about <= EP_ABOUT)) return slow;
    const f4 tau = f4_lane(root, 2), u = f4_fma(p, tau, plane);
    const f4 h_s = f4_fma(way_s, tau, plane_s), h_t = f4_fma(way_t, tau, plane_t);
    f4 x = f4_fnma(h_t, f4_lane(u, 1), f4_fnma(h_s, f4_lane(u, 0), u));
    float radius = f1_fma(ep_leaf_from_foot(leaf, triangle), about, leaf->foot);
    if (triangle) radius = radius + radius;
    if (!(f1_abs(tau[0]) <= high + delta && f4_outside(triangle, x) <= radius)) return none;
    x = f4_clamp(triangle, x);

    const f4 o = f4_to_leaf(frame, f4_fma(t_plane, dir, relative) + low);
    const float more = leaf->reach * (d_sum * reach);
    for (;;) {
        const f4_jet j = f4_surface_at(net, x, o, triangle, m, n, rational);
        ++counters->evaluations;

        /* advance */
        const f4_linear l = f4_solve(p, j.f, j.s, j.t);
        const f4 c = l.c, dd = l.d * l.d, d_ss = f4_lane(dd, 0), d_tt = f4_lane(dd, 1);
        const f4 d_st = f4_lane(l.d * f4_swap(l.d), 0), square = l.inverse * l.inverse;
        const f4 curve = f4_fma(j.st, d_st, f4_fma(j.tt, d_tt, j.ss * d_ss));
        const f4 v = f4_fnma(p, f4_lane(curve, 2), curve);
        const f4 step = f4_fma(f4_fnma(l.m, v, l.n * f4_swap(v)), square, l.d) * l.inverse;
        const f4 found = x + step, step_s = f4_lane(step, 0), step_t = f4_lane(step, 1);

        /* what it is worth */
        const float i = f4_norm(f4_abs(l.m) + f4_abs(l.n)), q = leaf->sigma * p_max;
        const f4 over = f4_abs(f4_lane(l.inverse, 0));
        const f4 bounds = f4_fma(f4_set(q), f4_load(&leaf->bend_h), f4_set(i) * f4_load(&leaf->bend_st)) * over;
        const float bend = bounds[0], noise = f1_fma((i + q) * more, over[0], bounds[1]), twist = bounds[2];
        const float length = f4_norm(c), around = length + noise, turn = bend * radius, steps = bend * around;
        const bool unique = !EP_SELDOM(!(steps <= EP_STEPS && f1_fma(EP_TURNS_LESS, steps, turn) <= EP_TURNS));
        const float e = unique ? f1_fma(EP_GROWS * steps, around, around) : radius + noise, ge = bend * e;
        const float third = f1_fma(0.25f, ge, 1.0f),
                    bound = (0.5f * e) * e * f1_fma(twist, e, bend * f1_fma(ge, third, EP_CURVE));
        const float margin = f1_fma(ge, f1_fma(0.5f, ge, 1.5f), 1.0f) * noise + bound;
        const float outside = f4_outside(triangle, found), left = triangle ? margin + margin : margin;
        if (left < outside) return none;
        if (!EP_SELDOM(!(length <= EP_NEAR && bound <= f1_max(EP_REMAINDER * noise, EP_ACCEPT * leaf->noise_st) &&
                         unique && ge <= EP_SURE))) {
            const bool vague = EP_SELDOM(EP_SHARP < left) && (EP_FLAT < margin || -outside <= left);
            const f4 above = f4_fma(j.t, step_t, f4_fma(j.s, step_s, f4_fma(curve, f4_lane(square, 0), j.f)));
            const float k = f1_fma(above[2], inverse[0], t_plane[0]);
            bool certain = tnear < k && k <= tfar;
            if (!certain && !vague) return none;
            if (vague) {
                const float bend_h = leaf->bend_h;
                const float grade = f1_fma(bend_h, length + margin, f1_abs(j.s[2]) + f1_abs(j.t[2]));
                const float slack = f1_fma(leaf->twist_h, e, bend_h * f1_fma(ge, third, EP_CURVE));
                const float lift = (0.5f * e) * e * slack;
                const float late = f1_fma(EP_TERMS, f1_abs(t_plane[0]) + f1_abs(k),
                                          (f1_fma(grade, margin, (leaf->noise_h + more)) + lift) * f1_abs(inverse[0]));
                if (!certain && !(tnear < k + late && k - late <= tfar)) return none;
                certain = certain && tnear < k - late && k + late <= tfar && !(-outside <= left);
            }
            *t_out = k;
            const f4 twice_s = step_s + step_s, twice_t = step_t + step_t;
            f4_put_hit(leaf, triangle, found, f4_fma(j.st, step_t, f4_fma(j.ss, twice_s, j.s)),
                       f4_fma(j.tt, twice_t, f4_fma(j.st, step_s, j.t)), hit_out);
            return (ep_outcome){certain, certain && k == tfar, vague, 0};
        }
        if (radius + margin < f4_norm(step)) return none;
        if (!(left < 0.75f * radius)) return slow;
        x = f4_clamp(triangle, found);
        radius = left;
    }
}
