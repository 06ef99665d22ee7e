/* newton_tmpl.h - enter a leaf, take a Newton step, decide. leaf.h derives every bound used here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * One ray a lane. single_tmpl.h does the same to one ray, operation for operation. */

/* A hit is taken once its point is within this of where the tangents were evaluated, in leaf coordinates. The point is
 * then right to rounding; the tangents, carried over by the model's second derivatives, to 2^-8 of those' range. */
#define EP_NEAR 0x1p-7f

/* ... and once what Newton leaves is certain to be below this part of its rounding error, or below EP_ACCEPT times that
 * of a ray that meets the leaf squarely. Rounding errors seldom reach a tenth of their bound; what Newton leaves may.
 */
#define EP_REMAINDER 0.25f
#define EP_ACCEPT 4.0f

/* A root that may be displaced by more than EP_FLAT along a leaf, where the ray is nearly tangent, is found again in
 * double; and so is one that may be farther than EP_SHARP on either side of the leaf's border. */
#define EP_FLAT 0x1p-16f
#define EP_SHARP 0x1p-18f

/* A ray so nearly parallel to the leaf's plane that 1 / h(d) is mostly rounding. */
#define EP_STEEP 0x1p12f

/* Rounding of a dozen operations. */
#define EP_TERMS 0x1p-19f

/* The domain in leaf coordinates: |s|, |t| <= 1/2, or s, t >= -1/3 and s + t <= 1/3. */
#define EP_HALF 0.5f
#define EP_THIRD (1.0f / 3)

/* Vectors of three, one component a register. */
typedef struct w_3 {
    w_f x, y, z;
} w_3;

/* What is known of a ray once it has entered a leaf. */
typedef struct w_visit {
    w_f p_s, p_t;          /* leaf.h: motion along the leaf per unit of height            */
    w_f inverse;           /* 1 / (direction's height)                                    */
    w_f t_plane;           /* where the ray meets the leaf's plane, and is moved to       */
    w_f far, way;          /* |t| |d| in the sum norm to the plane, and through the prism */
    w_3 o;                 /* the moved origin                                            */
    w_f noise_st, noise_h; /* rounding of F                                           */
    w_f s, t;              /* where to evaluate next                                      */
    w_f radius;            /* all roots are within this of it                             */
    w_m live;              /* neither certified to miss nor slow                          */
    w_m slow;
} w_visit;

/* The surface at (s, t), in leaf coordinates: S - o, and its derivatives. */
typedef struct w_jet {
    w_3 at, ds, dt;
} w_jet;

typedef struct w_step {
    w_f s, t, step_s, step_t; /* the improved Newton point, and the way there */
    w_f radius;               /* the roots are within this of it              */
    w_f height;               /* the root's above the moved origin            */
    w_f late;                 /* its t is no farther from the truth than this */
    w_m hit, vague;           /* vague: float says that there is one, double has to say where */
    w_m stuck;                /* neither, and the neighbourhood does not shrink               */
} w_step;

/* The nearest point of the domain, or close to it. */
EP_INLINE void w_clamp(int triangle, w_f *s, w_f *t)
{
    const w_f low = w_set(triangle ? -EP_THIRD : -EP_HALF), high = w_set(triangle ? 2 * EP_THIRD : EP_HALF);
    *s = w_max(*s, low);
    *t = w_max(*t, low);
    if (triangle) {
        const w_f third = w_set(EP_THIRD);
        const w_f excess = w_max((*s + *t) - third, w_set(0.0f)) * w_set(0.5f);
        *s = w_min(w_max(*s - excess, low), high);
        *t = w_min(w_max(*t - excess, low), third - *s);
    } else {
        *s = w_min(*s, high);
        *t = w_min(*t, high);
    }
}

/* How far outside the domain; negative inside. */
EP_INLINE w_f w_outside(int triangle, w_f s, w_f t)
{
    if (!triangle) return w_max(w_abs(s), w_abs(t)) - w_set(EP_HALF);
    return w_max(w_max(-s, -t), s + t) - w_set(EP_THIRD);
}

/* A Newton step: its Jacobian, the way to c, and the magnitudes of J^-1 and q = J^-1 p. */
typedef struct w_linear {
    w_f ss, st, ts, tt, inverse, c_s, c_t, i, q; /* c - y */
} w_linear;

EP_INLINE w_linear w_solve(const w_visit *v, const w_jet *j)
{
    w_linear l;
    const w_f f_s = w_fnma(v->p_s, j->at.z, j->at.x), f_t = w_fnma(v->p_t, j->at.z, j->at.y);
    l.ss = w_fnma(v->p_s, j->ds.z, j->ds.x);
    l.st = w_fnma(v->p_s, j->dt.z, j->dt.x);
    l.ts = w_fnma(v->p_t, j->ds.z, j->ds.y);
    l.tt = w_fnma(v->p_t, j->dt.z, j->dt.y);
    l.inverse = w_set(1.0f) / w_fnma(l.st, l.ts, l.ss * l.tt);
    l.c_s = w_fnma(l.tt, f_s, l.st * f_t) * l.inverse;
    l.c_t = w_fnma(l.ss, f_t, l.ts * f_s) * l.inverse;
    const w_f size = w_abs(l.inverse);
    l.i = w_max(w_abs(l.tt) + w_abs(l.st), w_abs(l.ts) + w_abs(l.ss)) * size;
    l.q = w_max(w_abs(w_fnma(l.st, v->p_t, l.tt * v->p_s)), w_abs(w_fnma(l.ts, v->p_s, l.ss * v->p_t))) * size;
    return l;
}

/* |J^-1| st + |q| h */
EP_INLINE w_f w_spread(const w_linear *l, w_f st, w_f h)
{
    return w_fma(l->q, h, l->i * st);
}

/* `o`, `d`: origin relative to the leaf's centre (rounded) and direction, in leaf coordinates; `d_sum`: the
 * direction's sum norm in space. Most rays that only touch the leaf's box end here. */
EP_INLINE w_visit w_enter(const ep_leaf *leaf, int triangle, w_3 o, w_3 d, w_f d_sum, w_f tnear, w_f tfar, w_m active)
{
    w_visit v;
    const w_f edge = w_set(triangle ? EP_THIRD : EP_HALF);
    v.inverse = w_set(1.0f) / d.z;
    v.t_plane = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    const w_f s = w_fma(v.t_plane, d.x, o.x), t = w_fma(v.t_plane, d.y, o.y);

    /* the prism, and what rounding adds to it: a root is within reach_s, reach_t of (s, t) */
    const w_f far = w_abs(v.t_plane) * d_sum;
    const w_f side = w_fma(w_set(leaf->reach_st), far, w_set(leaf->side));
    const w_f height = w_fma(w_set(leaf->reach_h), far, w_set(leaf->height));
    const w_f p_s = w_abs(v.p_s), p_t = w_abs(v.p_t);
    const w_f reach_s = w_fma(p_s, height, side), reach_t = w_fma(p_t, height, side);
    const w_f reach = w_abs(v.inverse) * height;
    w_m out;
    if (triangle)
        out = w_or(w_or(w_lt(edge + reach_s, -s), w_lt(edge + reach_t, -t)), w_lt(edge + (reach_s + reach_t), s + t));
    else out = w_or(w_lt(edge + reach_s, w_abs(s)), w_lt(edge + reach_t, w_abs(t)));
    out = w_or(out, w_or(w_lt(tfar, v.t_plane - reach), w_lt(v.t_plane + reach, tnear)));
    const w_m in = w_andnot(active, out); /* a NaN is never out */

    v.way = d_sum * reach;
    v.far = far;
    v.live = w_and(in, w_lt(w_max(p_s, p_t), w_set(EP_STEEP)));
    v.slow = w_andnot(in, v.live);
    v.s = s;
    v.t = t;
    return v;
}

/* Seen from the plane the leaf is a graph, its height over its feet u = x + r_st(x), and along the ray u = u0 + p tau
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

EP_INLINE w_graph w_meet_graph(const ep_leaf *leaf, w_visit *v, int triangle, w_3 o)
{
    w_graph g;
    const float reach = (triangle ? 2 * EP_THIRD : EP_HALF) + leaf->side;
    v->o = o;
    v->noise_st = w_fma(w_set(leaf->reach_st), v->way, w_set(leaf->noise_st));
    v->noise_h = w_fma(w_set(leaf->reach_h), v->way, w_set(leaf->noise_h));

    const w_f s = v->s, t = v->t;
    const w_f ss = w_set(leaf->half[0][2]), st = w_set(leaf->half[1][2]), tt = w_set(leaf->half[2][2]);
    const w_f g_s = w_fma(st, t, ss * s), g_t = w_fma(tt, t, st * s);
    g.c0 = w_fma(t, g_t, w_fma(s, g_s, w_set(leaf->middle)));
    g.c1 = w_fma(v->p_t + v->p_t, g_t, w_fma(v->p_s + v->p_s, g_s, w_set(-1.0f)));
    g.c2 = w_fma(v->p_t, w_fma(tt, v->p_t, st * v->p_s), v->p_s * w_fma(st, v->p_t, ss * v->p_s));

    /* u0 and tau are right to e_st and e_h; c0, c1 tau and c2 tau² to a few roundings of terms below `terms` */
    g.e_st = w_fma(w_set(leaf->reach_st), v->far, v->noise_st);
    const w_f e_h = w_fma(w_set(leaf->reach_h), v->far, v->noise_h);
    g.p_max = w_max(w_abs(v->p_s), w_abs(v->p_t));
    g.high = w_set(leaf->height) + e_h;
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
 * for D, delta = 2 P / (sqrt(D) + sqrt(D - w)): less than 4/3 P / sqrt(D) if w < 3/4 D, and else the ray is too nearly
 * tangent for this to help. Usually one of the roots is nowhere near the leaf, or before tnear. */
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
                           w_set(EP_TERMS) * (w_abs(v->t_plane) + w_abs(tnear)));
    const w_m behind = w_lt(w_fma(late, size, t_2), (tnear - v->t_plane) * size);
    const w_m second = w_andnot(w_and(w_le(q, within * size), w_le(u_2, (room + about) * size)), behind);
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
    const w_graph g = w_meet_graph(leaf, v, triangle, o);
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

/* The surface's own jet, and with it the improved Newton point c' and what follows from it. Lanes that it decides leave
 * v->live; `hit` are those with a root, at (s, t) and `height` above the moved origin. */
EP_INLINE w_step w_advance(const ep_leaf *leaf, w_visit *v, int triangle, const w_jet *j)
{
    w_step r;
    const w_f one = w_set(1.0f), half = w_set(0.5f);
    const w_linear l = w_solve(v, j);
    const w_f c_ss = l.c_s * l.c_s, c_st = (l.c_s + l.c_s) * l.c_t, c_tt = l.c_t * l.c_t;
    w_f curve[3];
    for (int c = 0; c < 3; ++c)
        curve[c] =
            w_fma(w_set(leaf->half[1][c]), c_st, w_fma(w_set(leaf->half[2][c]), c_tt, w_set(leaf->half[0][c]) * c_ss));
    const w_f v_s = w_fnma(v->p_s, curve[2], curve[0]), v_t = w_fnma(v->p_t, curve[2], curve[1]);
    r.step_s = w_fma(w_fnma(l.tt, v_s, l.st * v_t), l.inverse, l.c_s);
    r.step_t = w_fma(w_fnma(l.ss, v_t, l.ts * v_s), l.inverse, l.c_t);
    r.s = v->s + r.step_s;
    r.t = v->t + r.step_t;
    r.height = w_fma(j->dt.z, r.step_t, w_fma(j->ds.z, r.step_s, j->at.z + curve[2]));

    const w_f bend = w_spread(&l, w_set(leaf->bend_st), w_set(leaf->bend_h));
    const w_f warp = w_spread(&l, w_set(leaf->warp_st), w_set(leaf->warp_h));
    const w_f noise = w_spread(&l, v->noise_st, v->noise_h);
    const w_f length = w_max(w_abs(l.c_s), w_abs(l.c_t));
    const w_f way = length + noise, turn = bend * v->radius;
    const w_m unique = w_le(turn, one);
    const w_f e = w_select(unique, w_min(v->radius, w_fma(turn, way, way)), v->radius), ge = bend * e;
    const w_f bound = half * e * w_fma(ge * ge, w_fma(w_set(0.25f), ge, one), warp * e);
    const w_f displaced = w_fma(noise, w_fma(half, w_fma(ge, ge, bend * noise), ge), noise);
    const w_f margin = displaced + bound, outside = w_outside(triangle, r.s, r.t);
    /* errors add up in s + t, and in clamping to the triangle */
    r.radius = triangle ? margin + margin : margin;
    /* no root in D, or none in the neighbourhood */
    const w_m miss = w_or(w_lt(r.radius, outside), w_lt(v->radius + margin, w_max(w_abs(r.step_s), w_abs(r.step_t))));
    const w_m near = w_le(bound, w_max(w_set(EP_REMAINDER) * noise, w_set(EP_ACCEPT * leaf->noise_st)));
    /* from c', too, Newton's method in double goes to this root: rounding may have displaced it by more than e */
    const w_m sure = w_and(unique, w_le(bend * margin, one));
    const w_m done = w_and(w_and(w_le(length, w_set(EP_NEAR)), near), sure);
    r.vague = w_or(w_lt(w_set(EP_FLAT), margin), w_and(w_lt(w_set(EP_SHARP), r.radius), w_le(-outside, r.radius)));
    /* the height's derivatives, at y and by how they turn, times how far the root may be from c' */
    const w_f slope = w_fma(w_set(leaf->bend_h), length + margin, w_abs(j->ds.z) + w_abs(j->dt.z));
    r.late = w_fma(slope, margin, v->noise_h) * w_abs(v->inverse);
    const w_m shrinks = w_lt(r.radius, w_set(0.75f) * v->radius);
    r.hit = w_andnot(w_and(v->live, done), miss);
    v->live = w_andnot(v->live, w_or(miss, done));
    r.stuck = w_andnot(v->live, shrinks);
    v->live = w_and(v->live, shrinks);
    w_f s = r.s, t = r.t;
    w_clamp(triangle, &s, &t);
    v->s = w_select(shrinks, s, v->s);
    v->t = w_select(shrinks, t, v->t);
    v->radius = w_select(shrinks, r.radius, v->radius);
    return r;
}

/* May the root of a step, at t, `base` of it being the moved origin's, be between `after` and `before`? */
EP_INLINE w_m w_nearly(const w_step *step, w_f base, w_f t, w_f after, w_f before)
{
    const w_f late = w_fma(w_set(EP_TERMS), w_abs(base) + w_abs(t), step->late);
    return w_and(w_lt(after, t + late), w_le(t - late, before));
}

/* The patch's parameters at (s, t) of a leaf. */
EP_INLINE void w_parameters(const ep_leaf *leaf, int triangle, w_f s, w_f t, w_f *u, w_f *v)
{
    const float *d = leaf->domain;
    const w_f edge = w_set(triangle ? EP_THIRD : EP_HALF), zero = w_set(0.0f), one = w_set(1.0f);
    const w_f x = s + edge, y = t + edge;
    *u = w_fma(x, w_set(d[2]), triangle ? w_fma(y, w_set(d[4]), w_set(d[0])) : w_set(d[0]));
    *v = w_fma(y, w_set(d[3]), triangle ? w_fma(x, w_set(d[5]), w_set(d[1])) : w_set(d[1]));
    *u = w_min(w_max(*u, zero), one);
    *v = w_min(w_max(*v, zero), triangle ? one - *u : one);
}

/* Ng at the Newton point: the tangents' change over the step comes from the model's second derivatives. */
EP_INLINE void w_normal(const ep_leaf *leaf, const w_jet *j, const w_step *r, w_f ng[3])
{
    const w_f jds[3] = {j->ds.x, j->ds.y, j->ds.z}, jdt[3] = {j->dt.x, j->dt.y, j->dt.z};
    const w_f twice_s = r->step_s + r->step_s, twice_t = r->step_t + r->step_t;
    w_f a[3], b[3], n[3];
    for (int c = 0; c < 3; ++c) {
        const w_f ss = w_set(leaf->half[0][c]), st = w_set(leaf->half[1][c]), tt = w_set(leaf->half[2][c]);
        a[c] = w_fma(st, twice_t, w_fma(ss, twice_s, jds[c]));
        b[c] = w_fma(tt, twice_t, w_fma(st, twice_s, jdt[c]));
    }
    for (int c = 0; c < 3; ++c) {
        const int k = (c + 1) % 3, l = (c + 2) % 3;
        n[c] = w_set(leaf->volume) * w_fnma(a[l], b[k], a[k] * b[l]);
    }
    for (int c = 0; c < 3; ++c)
        ng[c] = w_fma(w_set(leaf->frame[c][2]), n[2],
                      w_fma(w_set(leaf->frame[c][1]), n[1], w_set(leaf->frame[c][0]) * n[0]));
}
