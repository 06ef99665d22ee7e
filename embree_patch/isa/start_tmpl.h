/* start_tmpl.h - where iteration begins: at the root of a quadratic equation.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Seen from the plane the leaf is a graph, its height over its feet u = x + r_st(x), and along the ray u = u0 + p tau
 * where its height is tau. With H the second derivatives at the middle, and a plane from which the graph has no linear
 * terms but those that cancel cubic ones, a hit has
 *
 *     |c0 + c1 tau + c2 tau²| <= P,   c0 = middle + H_h u0²/2,  c1 = H_h u0 p - 1,  c2 = H_h p²/2,
 *
 * P = graph + noise. How the leaf is parametrised does not matter. */
typedef struct w_graph {
    w_f c0, c1, c2, p;
    w_f e_st;  /* u0 is right to this */
    w_f high;  /* |tau| is below this */
    w_f p_max; /* the larger of |p|   */
} w_graph;

/* u0 = (v->s, v->t) is right to e_st, heights along the ray to e_h, and |tau| is below `high`. */
EP_INLINE w_graph w_meet_graph(const ep_leaf *leaf, const w_visit *v, int triangle, w_f e_st, w_f e_h, w_f high)
{
    w_graph g;
    const float reach = (triangle ? 2 * EP_THIRD : EP_HALF) + leaf->side;
    const w_f s = v->s, t = v->t;
    const w_f ss = w_set(leaf->half[0][2]), st = w_set(leaf->half[1][2]), tt = w_set(leaf->half[2][2]);
    const w_f g_s = w_fma(st, t, ss * s), g_t = w_fma(tt, t, st * s);
    g.c0 = w_fma(t, g_t, w_fma(s, g_s, w_set(leaf->middle)));
    g.c1 = w_fma(v->p_t + v->p_t, g_t, w_fma(v->p_s + v->p_s, g_s, w_set(-1.0f)));
    g.c2 = w_fma(v->p_t, w_fma(tt, v->p_t, st * v->p_s), v->p_s * w_fma(st, v->p_t, ss * v->p_s));

    /* c0, c1 tau and c2 tau² are right to a few roundings of terms below `terms` */
    g.e_st = e_st;
    g.high = high;
    g.p_max = w_max(w_abs(v->p_s), w_abs(v->p_t));
    const w_f along = w_fma(g.p_max, g.high, w_max(w_abs(s), w_abs(t)));
    const w_f terms = w_fma(w_set(leaf->bend_h) * along, along, g.high + g.high);
    g.p = w_fma(w_set(EP_TERMS), terms, w_fma(w_set(leaf->bend_h * reach), g.e_st, w_set(leaf->graph) + e_h));
    return g;
}

/* The point over the foot (u_s, u_t), which is in D give or take `about`: x = u - m + H_st u m, m = H_st u²/2. Returns
 * how far that may be off: `foot`, and by at most 1 + k + 3/2 k² times what u is, k = |H_st| |u|. */
EP_INLINE w_f w_above(const ep_leaf *leaf, int triangle, w_f u_s, w_f u_t, w_f about, w_f x[2])
{
    const w_f one = w_set(1.0f), beside = w_set(leaf->side) + about;
    w_f h_s[2], h_t[2], m[2], twice[2];
    for (int c = 0; c < 2; ++c) {
        const w_f ss = w_set(leaf->half[0][c]), st = w_set(leaf->half[1][c]), tt = w_set(leaf->half[2][c]);
        h_s[c] = w_fma(st, u_t, ss * u_s);
        h_t[c] = w_fma(tt, u_t, st * u_s);
        m[c] = w_fma(h_t[c], u_t, h_s[c] * u_s);
        twice[c] = m[c] + m[c];
    }
    x[0] = w_fma(h_s[0], twice[0], w_fma(h_t[0], twice[1], u_s - m[0]));
    x[1] = w_fma(h_s[1], twice[0], w_fma(h_t[1], twice[1], u_t - m[1]));
    /* the triangle's corner is where both coordinates of a foot are farthest out */
    const w_f k =
        w_set(leaf->bend_st) * w_fma(w_set(triangle ? 4.0f : 1.0f), beside, w_set(triangle ? 2 * EP_THIRD : EP_HALF));
    const w_f once = w_fma(w_fma(w_fma(w_set(1.5f), k, one), k, one), about, w_set(leaf->foot));
    return triangle ? once + once : once;
}

/* A root of the graph's equation, and how far a hit may be from it. */
typedef struct w_root {
    w_f tau, delta;
    w_m none;    /* the ray misses                           */
    w_m unclear; /* there may be another, or none            */
} w_root;

/* With D = c1² - 4 c2 c0 and w = 4 |c2| P the ray misses if D < -w. If not, tau is within delta of one of the two roots
 * for D, delta = 2 P / (sqrt(D) + sqrt(D - w)): less than 4/3 P / sqrt(D) if w < 3/4 D. Usually one of the roots is
 * nowhere near the leaf, or before tnear. And else the ray is nearly tangent, hits being within sqrt(D + w) / |2 c2| of
 * -c1 / (2 c2): mostly that is not in the leaf. */
EP_INLINE w_root w_near_root(const ep_leaf *leaf, const w_visit *v, const w_graph *g, int triangle, w_f tnear)
{
    w_root r;
    const w_f zero = w_set(0.0f), one = w_set(1.0f), four = w_set(4.0f) * g->c2, width = w_abs(four) * g->p;
    const w_f d = w_fnma(four, g->c0, g->c1 * g->c1), root = w_sqrt(w_max(d, zero));
    const w_m clear = w_lt(width, w_set(0.75f) * d), falls = w_lt(g->c1, zero);
    const w_f q = w_abs(g->c1) + root, inverse = one / (q * root), twice_c0 = g->c0 + g->c0;
    r.none = w_lt(d + width, zero);
    r.delta = (w_set(1.5f) * g->p) * (q * inverse);
    r.tau = (w_select(falls, twice_c0, -twice_c0) * root) * inverse;
    /* the other is at tau_2 = q_2 / (2 c2) */
    const w_f twice = g->c2 + g->c2, size = w_abs(twice), within = g->high + r.delta;
    const w_f q_2 = w_select(falls, q, -q), room = w_set((triangle ? 2 * EP_THIRD : EP_HALF) + leaf->side);
    const w_f about = w_fma(g->p_max, r.delta, g->e_st);
    const w_f u_2 = w_max(w_abs(w_fma(v->p_s, q_2, v->s * twice)), w_abs(w_fma(v->p_t, q_2, v->t * twice)));
    const w_f t_2 = w_select(w_lt(twice, zero), -q_2, q_2) * v->inverse; /* from the plane, times |2 c2| */
    const w_f late = w_fma(w_fma(w_set(EP_TERMS), within, r.delta), w_abs(v->inverse),
                           w_set(EP_TERMS) * (w_abs(v->moved) + w_abs(tnear)));
    const w_m behind = w_lt(w_fma(late, size, t_2), (tnear - v->moved) * size);
    const w_m second = w_andnot(w_and(w_le(q, within * size), w_le(u_2, (room + about) * size)), behind);
    /* where it would be tangent, times |2 c2| */
    const w_f spread = w_sqrt(w_max(d + width, zero)) * w_set(1 + 0x1p-10f), far = w_abs(g->c1);
    const w_f u = w_max(w_abs(w_fnma(v->p_s, g->c1, v->s * twice)), w_abs(w_fnma(v->p_t, g->c1, v->t * twice)));
    const w_f terms = w_fma(g->p_max, far, w_max(w_abs(v->s), w_abs(v->t)) * size);
    const w_f beside = w_fma(w_set(EP_TERMS), terms, w_fma(g->p_max, spread, (room + g->e_st) * size));
    const w_m outside = w_or(w_lt(w_fma(g->high, size, spread), far), w_lt(beside, u));
    r.none = w_or(r.none, w_andnot(outside, clear));
    r.unclear = w_or(second, w_andnot(v->live, clear));
    return r;
}

/* For most rays a series will do: with y = 1/c1, e = c0 y and z = 4 c2 e y, the smaller root is
 *
 *     -2 e / (1 + sqrt(1 - z)) = -e (1 + z/4 + z²/8 + 5/64 z³ + ...),
 *
 * whose next term and all after it are below 0.007 if |z| <= 1/2. A hit is no farther from it than P |y| times the mean
 * of 1/sqrt(1 - z - x) for x from 0 to 4 |c2| P y², which is below 1.07 (1 + |z|) if that is at most 1/8. The other
 * root is farther than (1 + sqrt(1/2)) / |2 c2 y| from the plane. */
#define EP_SERIES_Z 0.5f
#define EP_SERIES_REST 0.007f
#define EP_SERIES_WIDTH 0.125f
#define EP_SERIES_SLOPE 1.07f
#define EP_SERIES_OTHER 3.4f

/* Where iteration begins: over the foot u0 + p tau. Rays with two roots, and those that are too nearly tangent, are
 * slow. */
EP_INLINE void w_start(const ep_leaf *leaf, w_visit *v, int triangle, w_3 o, w_f tnear)
{
    const w_f one = w_set(1.0f);
    v->o = o;
    v->noise_st = w_fma(w_set(leaf->reach_st), v->way, w_set(leaf->noise_st));
    v->noise_h = w_fma(w_set(leaf->reach_h), v->way, w_set(leaf->noise_h));
    const w_f e_st = w_fma(w_set(leaf->reach_st), v->far, v->noise_st);
    const w_f e_h = w_fma(w_set(leaf->reach_h), v->far, v->noise_h);
    const w_graph g = w_meet_graph(leaf, v, triangle, e_st, e_h, w_set(leaf->height) + e_h);
    const w_f y = one / g.c1, e = g.c0 * y, ratio = (w_set(4.0f) * g.c2) * y, z = e * ratio;
    const w_f spread = w_abs(y) * g.p, slope = w_set(EP_SERIES_SLOPE) * spread;
    const w_f series = w_fma(z, w_fma(z, w_fma(z, w_set(5.0f / 64), w_set(1.0f / 8)), w_set(1.0f / 4)), one);
    w_root r = {.tau = -e * series, .none = w_mask(0), .unclear = w_mask(0)};
    r.delta = w_fma(w_set(EP_SERIES_REST), w_abs(e), w_fma(slope, w_abs(z), slope));
    const w_m easy = w_and(w_le(w_abs(z), w_set(EP_SERIES_Z)),
                           w_and(w_le(w_abs(ratio) * spread, w_set(EP_SERIES_WIDTH)),
                                 w_le(w_abs(ratio) * (g.high + r.delta), w_set(EP_SERIES_OTHER))));
    const w_m hard = w_andnot(v->live, easy);
    if (w_bits(hard)) {
        const w_root exact = w_near_root(leaf, v, &g, triangle, tnear);
        r.tau = w_select(hard, exact.tau, r.tau);
        r.delta = w_select(hard, exact.delta, r.delta);
        r.none = w_and(hard, exact.none);
        r.unclear = w_and(hard, exact.unclear);
    }
    const w_f about = w_fma(g.p_max, r.delta, g.e_st), beside = w_set(leaf->side) + about;
    const w_f u_s = w_fma(v->p_s, r.tau, v->s), u_t = w_fma(v->p_t, r.tau, v->t);
    const w_m in = w_and(w_le(w_abs(r.tau), g.high + r.delta),
                         w_le(w_outside(triangle, u_s, u_t), triangle ? beside + beside : beside));
    const w_m left = w_andnot(v->live, r.none), slow = w_and(left, r.unclear);
    w_f x[2];
    const w_f off = w_above(leaf, triangle, u_s, u_t, about, x);
    v->slow = w_or(v->slow, slow);
    v->live = w_andnot(w_andnot(w_and(left, in), slow), w_lt(off, w_outside(triangle, x[0], x[1])));
    v->radius = w_min(off, one);
    w_clamp(triangle, &x[0], &x[1]);
    v->s = x[0];
    v->t = x[1];
}
