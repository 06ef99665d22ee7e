/* start_tmpl.h - where iteration begins: at the root of a quadratic equation.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Seen from the plane the leaf is a graph, its height over its feet u = x + r_st(x), and along the ray u = u0 + p tau
 * where its height is tau. With H/2 the forms of the model, and a frame from which the graph has no linear terms but
 * those that cancel cubic ones, a hit has
 *
 *     |c0 + c1 tau + c2 tau²| <= P,   c0 = middle + H_h u0²/2,  c1 = H_h u0 p - 1,  c2 = H_h p²/2,
 *
 * P = graph + noise. How the leaf is parametrised does not matter. */
typedef struct w_graph {
    w_f c0, c1, c2, p;
    w_f e_st; /* u0 is right to this */
    w_f high; /* |tau| is below this */
} w_graph;

/* The model's forms of u0 = (v->s, v->t) and of p: H u0 / 2 and H p / 2 for s, t and heights. */
typedef struct w_forms {
    w_f plane_s[3], plane_t[3], way_s[3], way_t[3];
} w_forms;

EP_INLINE void w_form_of(const ep_leaf *leaf, int c, w_f s, w_f t, w_f *by_s, w_f *by_t)
{
    const w_f st = w_set(leaf->half[1][c]);
    *by_s = w_fma(st, t, w_set(leaf->half[0][c]) * s);
    *by_t = w_fma(w_set(leaf->half[2][c]), t, st * s);
}

EP_INLINE void w_forms_of(const ep_leaf *leaf, const w_visit *v, int c, w_forms *f)
{
    w_form_of(leaf, c, v->s, v->t, &f->plane_s[c], &f->plane_t[c]);
    w_form_of(leaf, c, v->p_s, v->p_t, &f->way_s[c], &f->way_t[c]);
}

/* c0, c1 / 2 and c2, from the forms of heights. */
EP_INLINE void w_equation(const ep_leaf *leaf, const w_visit *v, const w_forms *f, w_f *c0, w_f *c1_2, w_f *c2)
{
    *c0 = w_fma(v->t, f->plane_t[2], w_fma(v->s, f->plane_s[2], w_set(leaf->middle)));
    *c1_2 = w_fma(v->t, f->way_t[2], w_fma(v->s, f->way_s[2], w_set(-0.5f)));
    *c2 = w_fma(v->p_t, f->way_t[2], v->p_s * f->way_s[2]);
}

/* u0 = (v->s, v->t) is right to e_st, heights along the ray to e_h, and |tau| is below `high`. */
EP_INLINE w_graph w_meet_graph(const ep_leaf *leaf, const w_visit *v, int triangle, w_f e_st, w_f e_h, w_f high)
{
    w_graph g;
    const float reach = ep_leaf_room(leaf, triangle);
    w_forms f;
    w_forms_of(leaf, v, 2, &f);
    w_equation(leaf, v, &f, &g.c0, &g.c1, &g.c2);
    g.c1 = g.c1 + g.c1;

    /* c0, c1 tau and c2 tau² are right to a few roundings of terms below `terms` */
    g.e_st = e_st;
    g.high = high;
    const w_f along = w_fma(v->p_max, g.high, w_max(w_abs(v->s), w_abs(v->t)));
    const w_f terms = w_fma(w_set(leaf->bend_h) * along, along, g.high + g.high);
    g.p = w_fma(w_set(EP_TERMS), terms, w_fma(w_set(leaf->bend_h * reach), g.e_st, w_set(leaf->graph) + e_h));
    return g;
}

/* The point x = u - H_st u²/2 over a foot that is in D give or take `about`, be that more than EP_ABOUT: returns how
 * far x may be off, as ep_leaf_from_foot. */
EP_INLINE w_f w_above(const ep_leaf *leaf, int triangle, w_f u_s, w_f u_t, w_f about, w_f x[2])
{
    const w_f u[2] = {u_s, u_t};
    for (int c = 0; c < 2; ++c) {
        w_f by_s, by_t;
        w_form_of(leaf, c, u_s, u_t, &by_s, &by_t);
        x[c] = w_fnma(by_t, u_t, w_fnma(by_s, u_s, u[c]));
    }
    const w_f one = w_set(1.0f), beside = w_set(ep_leaf_side(leaf, triangle)) + about;
    const w_f k =
        w_set(leaf->bend_st) * w_fma(w_set(triangle ? 4.0f : 1.0f), beside, w_set(triangle ? 2 * EP_THIRD : EP_HALF));
    const w_f once = w_fma(k + one, about, w_set(leaf->foot));
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
    const w_f q_2 = w_select(falls, q, -q), room = w_set(ep_leaf_room(leaf, triangle));
    const w_f about = w_fma(v->p_max, r.delta, g->e_st);
    const w_f u_2 = w_max(w_abs(w_fma(v->p_s, q_2, v->s * twice)), w_abs(w_fma(v->p_t, q_2, v->t * twice)));
    const w_f t_2 = w_select(w_lt(twice, zero), -q_2, q_2) * v->inverse; /* from the plane, times |2 c2| */
    const w_f late = w_fma(w_fma(w_set(EP_TERMS), within, r.delta), w_abs(v->inverse),
                           w_set(EP_TERMS) * (w_abs(v->moved) + w_abs(tnear)));
    const w_m behind = w_lt(w_fma(late, size, t_2), (tnear - v->moved) * size);
    const w_m second = w_andnot(w_and(w_le(q, within * size), w_le(u_2, (room + about) * size)), behind);
    /* where it would be tangent, times |2 c2| */
    const w_f spread = w_sqrt(w_max(d + width, zero)) * w_set(1 + 0x1p-10f), far = w_abs(g->c1);
    const w_f u = w_max(w_abs(w_fnma(v->p_s, g->c1, v->s * twice)), w_abs(w_fnma(v->p_t, g->c1, v->t * twice)));
    const w_f terms = w_fma(v->p_max, far, w_max(w_abs(v->s), w_abs(v->t)) * size);
    const w_f beside = w_fma(w_set(EP_TERMS), terms, w_fma(v->p_max, spread, (room + g->e_st) * size));
    const w_m outside = w_or(w_lt(w_fma(g->high, size, spread), far), w_lt(beside, u));
    r.none = w_or(r.none, w_andnot(outside, clear));
    r.unclear = w_or(second, w_andnot(v->live, clear));
    return r;
}

/* For most rays one step of Newton's, from the plane, will do: with y = 1/c1, e = c0 y and z = 4 c2 e y, the smaller
 * root is
 *
 *     -2 e / (1 + sqrt(1 - z)) = -e (1 + z/4 + z²/8 + ...),
 *
 * which is within 0.344 |z e| of -e if |z| <= 1/2. A hit is no farther from it than P |y| times the mean of
 * (1 - z - x)^-1/2 for x from 0 to 4 |c2| P y², which is below 1.07 (1 + |z|) if that is at most 1/8. The other root is
 * farther than (1 + sqrt(1/2)) / |2 c2 y| from the plane. Computed with c1/2, so with 2 y and 2 e. */
#define EP_EASY_Z 0.5f
#define EP_EASY_REST (0.5f * 0.344f)
#define EP_EASY_WIDTH 0.125f
#define EP_EASY_SLOPE (0.5f * 1.07f)
#define EP_EASY_OTHER 1.7f

/* Where iteration begins: over the foot u0 + p tau. Rays with two roots, and those that are too nearly tangent, are
 * slow. `graph` and `foot` hold for all rays that have entered, and grow with how far they have come. */
EP_INLINE void w_start(const ep_leaf *leaf, w_visit *v, int triangle, w_3 o, w_f tnear)
{
    v->o = o;
    w_f c0, c1_2, c2;
    w_forms f;
    for (int c = 0; c < 3; ++c) w_forms_of(leaf, v, c, &f);
    w_equation(leaf, v, &f, &c0, &c1_2, &c2);
    const w_f high = w_fma(v->far, w_set(leaf->reach), w_set(leaf->height));
    const w_f p = w_fma(v->far, w_set(leaf->reach), w_set(leaf->graph));
    const w_f y = w_set(1.0f) / c1_2, e = c0 * y, ratio = c2 * y, z = e * ratio, size = w_abs(z);
    const w_f spread = w_abs(y) * p, slope = w_set(EP_EASY_SLOPE) * spread;
    w_root r = {.tau = -e * w_set(0.5f), .none = w_mask(0), .unclear = w_mask(0)};
    r.delta = w_fma(size, w_fma(w_set(EP_EASY_REST), w_abs(e), slope), slope);
    const w_m easy =
        w_and(w_le(size, w_set(EP_EASY_Z)), w_and(w_le(w_abs(ratio) * spread, w_set(EP_EASY_WIDTH)),
                                                  w_le(w_abs(ratio) * (high + r.delta), w_set(EP_EASY_OTHER))));
    const w_m hard = w_andnot(v->live, easy);
    if (w_bits(hard)) {
        const w_graph g = {c0, c1_2 + c1_2, c2, p, w_set(leaf->reach) * v->far, high};
        const w_root exact = w_near_root(leaf, v, &g, triangle, tnear);
        r.tau = w_select(hard, exact.tau, r.tau);
        r.delta = w_select(hard, exact.delta, r.delta);
        r.none = w_and(hard, exact.none);
        r.unclear = w_and(hard, exact.unclear);
    }
    const w_f about = w_fma(w_set(leaf->reach), v->far, v->p_max * r.delta);
    /* over the foot u: x = u - H_st u²/2 */
    const w_f u[2] = {w_fma(v->p_s, r.tau, v->s), w_fma(v->p_t, r.tau, v->t)};
    w_f x[2];
    for (int c = 0; c < 2; ++c)
        x[c] = w_fnma(w_fma(f.way_t[c], r.tau, f.plane_t[c]), u[1],
                      w_fnma(w_fma(f.way_s[c], r.tau, f.plane_s[c]), u[0], u[c]));
    const w_m left = w_andnot(v->live, r.none), start = w_andnot(left, r.unclear);
    const w_m vain = w_andnot(start, w_le(about, w_set(EP_ABOUT)));
    const w_f off = w_fma(w_set(ep_leaf_from_foot(leaf, triangle)), about, w_set(leaf->foot));
    v->radius = triangle ? off + off : off;
    const w_m in = w_and(w_le(w_abs(r.tau), high + r.delta), w_le(w_outside(triangle, x[0], x[1]), v->radius));
    v->slow = w_or(v->slow, w_or(w_and(left, r.unclear), vain));
    v->live = w_and(w_andnot(start, vain), in);
    w_clamp(triangle, &x[0], &x[1]);
    v->s = x[0];
    v->t = x[1];
}
