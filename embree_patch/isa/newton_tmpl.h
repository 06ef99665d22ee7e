/* newton_tmpl.h - enter a leaf, take a Newton step, decide. leaf.h derives every bound used here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * One ray a lane. single_tmpl.h does the same to one ray, operation for operation. */

/* A hit is taken once its point is within this of where the tangents were evaluated, in leaf coordinates. The point is
 * then right to rounding; the tangents, carried over by second derivatives, to 2^-11 of the third ones. */
#define EP_NEAR 0x1p-5f

/* ... and once what Newton leaves is certain to be below this part of its rounding error, or below EP_ACCEPT times that
 * of a ray that meets the leaf squarely. Rounding errors seldom reach a tenth of their bound; what Newton leaves may.
 */
#define EP_REMAINDER 0.25f
#define EP_ACCEPT 4.0f

/* ... and once G e is below this. Then rounding has displaced it by less than 1.5 e, and what Newton leaves is less
 * than e/6: G times both is below a half. There is a root, too: its distance from y is that of the first of Newton's
 * steps, which quarter at least from there [Kantorovich]. */
#define EP_SURE 0.25f

/* A root that may be displaced by more than EP_FLAT along a leaf, where the ray is nearly tangent, is found again in
 * double; and so is one that may be farther than EP_SHARP (leaf.h) on either side of the leaf's border. */
#define EP_FLAT 0x1p-16f

/* Conclusion (2): the most that a may be; what G e may be where a is zero, and how much less per a; and what |x* - y|
 * grows by, per a. */
#define EP_STEPS 0.375f
#define EP_TURNS 2.0f
#define EP_TURNS_LESS (4.0f / 3 * (1 + 0x1p-20f))
#define EP_GROWS (8.0f / 9 * (1 + 0x1p-20f))

/* Rounding of second derivatives, in bend: Horner's scheme of the highest degree errs by 103 eps of its terms. */
#define EP_CURVE 0x1p-17f

/* Rounding of a dozen operations. */
#define EP_TERMS 0x1p-19f

/* The domain in leaf coordinates: |s|, |t| <= 1/2, or s, t >= -1/3 and s + t <= 1/3. */
#define EP_HALF 0.5f
#define EP_THIRD (1.0f / 3)

/* Vectors of three, one component a register. */
typedef struct w_3 {
    w_f x, y, z;
} w_3;

EP_INLINE w_3 w_cross(w_3 a, w_3 b)
{
    return (w_3){w_fnma(a.z, b.y, a.y * b.z), w_fnma(a.x, b.z, a.z * b.x), w_fnma(a.y, b.x, a.x * b.y)};
}

/* What is known of a ray once it has entered a leaf. */
typedef struct w_visit {
    w_f p_s, p_t, p_max;   /* leaf.h: motion along the leaf per unit of height, and the larger */
    w_f inverse;           /* 1 / (direction's height)                                         */
    w_f moved;             /* how far the origin is moved, in t: usually to the plane          */
    w_f far, way;          /* |t| |d| in the sum norm to there, and through the prism          */
    w_3 o;                 /* the moved origin                                                 */
    w_f noise_st, noise_h; /* rounding of F, where rays may be as good as parallel to the leaf */
    w_f s, t;              /* where to evaluate next                                      */
    w_f radius;            /* all roots are within this of it                             */
    w_f first, last;       /* fold_tmpl.h: between these heights above the moved origin   */
    w_f parts;             /* ... and in how many steps that has been divided             */
    w_f tnear, tfar;       /* the ray's                                                   */
    w_m live;              /* neither certified to miss nor slow                          */
    w_m slow;
} w_visit;

/* The surface at (s, t), in leaf coordinates: S - o, its derivatives, and half of the second ones, but all of the
 * mixed. */
typedef struct w_surface {
    w_3 at, ds, dt, ss, st, tt;
} w_surface;

typedef struct w_step {
    w_f s, t, step_s, step_t; /* the improved Newton point, and the way there */
    w_f radius;               /* the roots are within this of it              */
    w_f height;               /* the root's above the moved origin            */
    w_f late;                 /* its t is no farther from the truth than this */
    w_m hit, vague;           /* vague: float says that there is one, double has to say where */
    w_m rim;                  /* it may be beside the leaf                      */
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

/* A Newton step: J and one over its determinant, c - y. */
typedef struct w_linear {
    w_f ss, st, ts, tt, inverse, c_s, c_t;
    w_f d_s, d_t;               /* w_solve: c - y times the determinant  */
    w_f a_s, a_t, over, height; /* w_solve_grazing; and ...              */
    w_f i, q;                   /* ... magnitudes of J^-1 and q = J^-1 p */
} w_linear;

EP_INLINE w_linear w_solve(const w_visit *v, const w_surface *j)
{
    w_linear l;
    const w_f f_s = w_fnma(v->p_s, j->at.z, j->at.x), f_t = w_fnma(v->p_t, j->at.z, j->at.y);
    l.ss = w_fnma(v->p_s, j->ds.z, j->ds.x);
    l.st = w_fnma(v->p_s, j->dt.z, j->dt.x);
    l.ts = w_fnma(v->p_t, j->ds.z, j->ds.y);
    l.tt = w_fnma(v->p_t, j->dt.z, j->dt.y);
    l.inverse = w_set(1.0f) / w_fnma(l.st, l.ts, l.ss * l.tt);
    l.d_s = w_fnma(l.tt, f_s, l.st * f_t);
    l.d_t = w_fnma(l.ss, f_t, l.ts * f_s);
    l.c_s = l.d_s * l.inverse;
    l.c_t = l.d_t * l.inverse;
    return l;
}

/* J's entries grow with p and all but cancel in its determinant. For a ray along the leaf J = A - p g^T is taken apart
 * instead, A = I + R being close to I: with a = A^-1 p, the step d and the height x that the ray gains on it satisfy
 *
 *     A d - p x = -f_st,  g d - x = -f_h:   d = a x - A^-1 f_st,  x = (f_h - g A^-1 f_st) / (1 - g a).
 *
 * f is S - o less where the ray comes closest to it, so that nothing cancels in that. Here ss to tt and `inverse` are
 * A's, and J^-1 = A^-1 + a b^T / (1 - g a), b = g A^-1. */
EP_INLINE w_3 w_answer(const w_linear *l, const w_surface *j, w_f f_s, w_f f_t, w_f f_h)
{
    const w_f d_s = w_fnma(l->tt, f_s, l->st * f_t) * l->inverse, d_t = w_fnma(l->ss, f_t, l->ts * f_s) * l->inverse;
    const w_f x = w_fma(j->dt.z, d_t, w_fma(j->ds.z, d_s, f_h)) * l->over;
    return (w_3){w_fma(l->a_s, x, d_s), w_fma(l->a_t, x, d_t), x};
}

EP_INLINE w_linear w_solve_grazing(const w_visit *v, const w_surface *j)
{
    const w_f one = w_set(1.0f);
    w_linear l = {.ss = j->ds.x, .st = j->dt.x, .ts = j->ds.y, .tt = j->dt.y};
    const w_f det = w_fnma(l.st, l.ts, l.ss * l.tt);
    const w_f det_a_s = w_fnma(l.st, v->p_t, l.tt * v->p_s), det_a_t = w_fnma(l.ts, v->p_s, l.ss * v->p_t);
    /* 1 - g a, times the determinant: one quotient does not wait for the other */
    const w_f over = one / w_fnma(j->dt.z, det_a_t, w_fnma(j->ds.z, det_a_s, det));
    l.inverse = one / det;
    l.a_s = det_a_s * l.inverse;
    l.a_t = det_a_t * l.inverse;
    l.over = det * over;
    const w_f b_s = w_fnma(j->dt.z, l.ts, j->ds.z * l.tt) * l.inverse;
    const w_f b_t = w_fnma(j->ds.z, l.st, j->dt.z * l.ss) * l.inverse;
    const w_f per = one / w_fma(v->p_t, v->p_t, w_fma(v->p_s, v->p_s, one));
    const w_f near = w_fma(v->p_t, j->at.y, w_fma(v->p_s, j->at.x, j->at.z)) * per;
    const w_3 c = w_answer(&l, j, w_fnma(v->p_s, near, j->at.x), w_fnma(v->p_t, near, j->at.y), j->at.z - near);
    l.c_s = c.x;
    l.c_t = c.y;
    l.height = near + c.z;
    const w_f q_s = det_a_s * over, q_t = det_a_t * over;
    l.i = w_max(w_abs(w_fma(q_s, b_s, l.tt * l.inverse)) + w_abs(w_fma(q_s, b_t, -l.st * l.inverse)),
                w_abs(w_fma(q_t, b_s, -l.ts * l.inverse)) + w_abs(w_fma(q_t, b_t, l.ss * l.inverse)));
    l.q = w_max(w_abs(q_s), w_abs(q_t));
    return l;
}

/* G, T and the noise of leaf.h, and the noise of heights. */
typedef struct w_bounds {
    w_f bend, twist, noise, noise_h;
} w_bounds;

/* |J^-1| st + |q| h */
EP_INLINE w_f w_spread(const w_linear *l, w_f st, w_f h)
{
    return w_fma(l->q, h, l->i * st);
}

EP_INLINE w_bounds w_bounds_grazing(const ep_leaf *leaf, const w_visit *v, const w_linear *l)
{
    return (w_bounds){w_spread(l, w_set(leaf->bend_st), w_set(leaf->bend_h)),
                      w_spread(l, w_set(leaf->twist_st), w_set(leaf->twist_h)), w_spread(l, v->noise_st, v->noise_h),
                      v->noise_h};
}

/* The same with less: J = B - p g^T, B = I + R, has cofactors that are linear in J, and those of p g^T take p to zero,
 * so |det J| |q| = |cof B p| <= sigma |p|. Noise grows with the way through the prism. */
EP_INLINE w_bounds w_bounds_of(const ep_leaf *leaf, const w_visit *v, const w_linear *l)
{
    const w_f inverse = w_abs(l->inverse), q = w_set(leaf->sigma) * v->p_max, more = w_set(leaf->reach) * v->way;
    const w_f i = w_max(w_abs(l->tt) + w_abs(l->st), w_abs(l->ts) + w_abs(l->ss));
    const w_f still = w_fma(q, w_set(leaf->noise_h), i * w_set(leaf->noise_st)) * inverse;
    return (w_bounds){w_fma(q, w_set(leaf->bend_h), i * w_set(leaf->bend_st)) * inverse,
                      w_fma(q, w_set(leaf->twist_h), i * w_set(leaf->twist_st)) * inverse,
                      w_fma((i + q) * more, inverse, still), w_set(leaf->noise_h) + more};
}

/* `o`, `d`: origin relative to the leaf's centre (rounded) and direction, in leaf coordinates; `d_sum`: the
 * direction's sum norm in space. Most rays that only touch the leaf's box end here. */
EP_INLINE w_visit w_enter(const ep_leaf *leaf, int triangle, w_3 o, w_3 d, w_f d_sum, w_f tnear, w_f tfar, w_m active)
{
    w_visit v;
    v.inverse = w_set(1.0f) / d.z;
    v.moved = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    const w_f s = w_fma(v.moved, d.x, o.x), t = w_fma(v.moved, d.y, o.y);

    /* the prism, and what rounding adds to it: a root is within reach_s, reach_t of (s, t) */
    const w_f far = w_abs(v.moved) * d_sum, per = w_set(leaf->reach);
    const w_f rim = w_fma(far, per, w_set(leaf->rim)), height = w_fma(far, per, w_set(leaf->height));
    const w_f p_s = w_abs(v.p_s), p_t = w_abs(v.p_t);
    const w_f reach_s = w_fma(p_s, height, rim), reach_t = w_fma(p_t, height, rim);
    const w_f reach = w_abs(v.inverse) * height;
    w_m out;
    if (triangle)
        out = w_or(w_or(w_lt(reach_s, -s), w_lt(reach_t, -t)), w_lt((reach_s + reach_t) - w_set(EP_THIRD), s + t));
    else out = w_or(w_lt(reach_s, w_abs(s)), w_lt(reach_t, w_abs(t)));
    out = w_or(out, w_or(w_lt(tfar, v.moved - reach), w_lt(v.moved + reach, tnear)));
    /* where the height of a direction is so large that floats have no inverse of it nothing is known; a NaN is never
     * out */
    const w_m across = w_lt(w_set(0.0f), w_abs(v.inverse)), in = w_andnot(active, w_and(out, across));

    v.p_max = w_max(p_s, p_t);
    v.far = far;
    v.way = d_sum * reach;
    v.live = w_and(in, w_and(across, w_and(w_lt(v.p_max, w_set(EP_STEEP)), w_lt(far * per, w_set(EP_ASTRAY)))));
    v.slow = w_andnot(in, v.live);
    v.s = s;
    v.t = t;
    return v;
}

/* The surface's own jet, and with it the improved Newton point c' and what follows from it. Lanes that it decides leave
 * v->live; `hit` are those with a root, at (s, t) and `height` above the moved origin. `grazing`, a constant: whether
 * rays may be as good as parallel to the leaf. */
EP_INLINE w_step w_advance(const ep_leaf *leaf, w_visit *v, int triangle, int grazing, const w_surface *j)
{
    w_step r;
    const w_f one = w_set(1.0f), half = w_set(0.5f);
    const w_linear l = grazing ? w_solve_grazing(v, j) : w_solve(v, j);
    /* det² v, which does not wait for the division */
    const w_f s = grazing ? l.c_s : l.d_s, t = grazing ? l.c_t : l.d_t, c_ss = s * s, c_st = s * t, c_tt = t * t;
    const w_3 curve = {w_fma(j->st.x, c_st, w_fma(j->tt.x, c_tt, j->ss.x * c_ss)),
                       w_fma(j->st.y, c_st, w_fma(j->tt.y, c_tt, j->ss.y * c_ss)),
                       w_fma(j->st.z, c_st, w_fma(j->tt.z, c_tt, j->ss.z * c_ss))};
    if (grazing) {
        const w_3 more = w_answer(&l, j, curve.x, curve.y, curve.z);
        r.step_s = l.c_s + more.x;
        r.step_t = l.c_t + more.y;
        r.height = l.height + more.z;
    } else {
        const w_f v_s = w_fnma(v->p_s, curve.z, curve.x), v_t = w_fnma(v->p_t, curve.z, curve.y);
        const w_f square = l.inverse * l.inverse;
        r.step_s = w_fma(w_fnma(l.tt, v_s, l.st * v_t), square, l.d_s) * l.inverse;
        r.step_t = w_fma(w_fnma(l.ss, v_t, l.ts * v_s), square, l.d_t) * l.inverse;
        r.height = w_fma(j->dt.z, r.step_t, w_fma(j->ds.z, r.step_s, w_fma(curve.z, square, j->at.z)));
    }
    r.s = v->s + r.step_s;
    r.t = v->t + r.step_t;

    const w_bounds b = grazing ? w_bounds_grazing(leaf, v, &l) : w_bounds_of(leaf, v, &l);
    const w_f bend = b.bend, twist = b.twist, noise = b.noise;
    const w_f length = w_max(w_abs(l.c_s), w_abs(l.c_t));
    const w_f way = length + noise, turn = bend * v->radius, steps = bend * way;
    const w_m unique =
        w_and(w_le(steps, w_set(EP_STEPS)), w_le(w_fma(w_set(EP_TURNS_LESS), steps, turn), w_set(EP_TURNS)));
    /* never below the noise, so that G n <= G e */
    const w_f e = w_select(unique, w_fma(w_set(EP_GROWS) * steps, way, way), v->radius + noise), ge = bend * e;
    const w_f third = w_fma(w_set(0.25f), ge, one),
              bound = (half * e) * e * w_fma(twist, e, bend * w_fma(ge, third, w_set(EP_CURVE)));
    const w_f displaced = w_fma(ge, w_fma(half, ge, w_set(1.5f)), one) * noise;
    const w_f margin = displaced + bound, outside = w_outside(triangle, r.s, r.t);
    /* errors add up in s + t, and in clamping to the triangle */
    r.radius = triangle ? margin + margin : margin;
    /* no root in D, or none in the neighbourhood */
    const w_m beside = w_lt(r.radius, outside);
    const w_m apart = w_lt(v->radius + margin, w_max(w_abs(r.step_s), w_abs(r.step_t)));
    const w_m near = w_le(bound, w_max(w_set(EP_REMAINDER) * noise, w_set(EP_ACCEPT * leaf->noise_st)));
    /* from c', too, Newton's method in double goes to this root */
    const w_m sure = w_and(unique, w_le(ge, w_set(EP_SURE)));
    const w_m done = w_and(w_and(w_le(length, w_set(EP_NEAR)), near), sure);
    r.rim = w_le(-outside, r.radius);
    r.vague = w_or(w_lt(w_set(EP_FLAT), margin), w_and(w_lt(w_set(EP_SHARP), r.radius), r.rim));
    /* the height's derivatives, at y and by how they turn, times how far the root may be from c', and what the model
     * leaves of it there: like b', of the height alone */
    const w_f far = length + margin, slope = w_fma(w_set(leaf->bend_h), far, w_abs(j->ds.z) + w_abs(j->dt.z));
    const w_f slack = w_fma(w_set(leaf->twist_h), e, w_set(leaf->bend_h) * w_fma(ge, third, w_set(EP_CURVE)));
    const w_f lift = (half * e) * e * slack;
    r.late = w_fma(slope, margin, b.noise_h) + lift;
    if (grazing) {
        /* along the leaf: |p| (tau - tau') is |A| |x* - c'| and what F_st is off by, which J^-1, of at least 1 / |A|,
         * takes to no more than the margin */
        const w_f rows = w_max(w_abs(l.ss) + w_abs(l.st), w_abs(l.ts) + w_abs(l.tt));
        const w_f a = w_fma(w_set(leaf->bend_st), far, rows);
        r.late = w_min((margin + margin) * a / v->p_max, r.late);
    }
    r.late = r.late * w_abs(v->inverse);
    const w_m shrinks = w_lt(r.radius, w_set(0.75f) * v->radius);
    r.hit = w_andnot(w_and(v->live, done), beside);
    v->live = w_andnot(v->live, w_or(w_or(beside, apart), done));
    r.stuck = w_andnot(v->live, shrinks);
    v->live = w_and(v->live, shrinks);
    w_f x[2] = {r.s, r.t};
    w_clamp(triangle, &x[0], &x[1]);
    v->s = w_select(shrinks, x[0], v->s);
    v->t = w_select(shrinks, x[1], v->t);
    v->radius = w_select(shrinks, r.radius, v->radius);
    return r;
}

/* How far t, `base` of it being the moved origin's, may be from that of a step's root. */
EP_INLINE w_f w_late(const w_step *step, w_f base, w_f t)
{
    return w_fma(w_set(EP_TERMS), w_abs(base) + w_abs(t), step->late);
}

/* May the root be between `after` and `before`? */
EP_INLINE w_m w_nearly(w_f t, w_f late, w_f after, w_f before)
{
    return w_and(w_lt(after, t + late), w_le(t - late, before));
}

/* Is a vague root certainly there, and in the leaf? */
EP_INLINE w_m w_surely(const w_step *step, w_f t, w_f late, w_f after, w_f before)
{
    return w_andnot(w_and(w_lt(after, t - late), w_le(t + late, before)), step->rim);
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

/* Ng at the Newton point: the tangents' change over the step comes from the second derivatives. */
EP_INLINE void w_normal(const ep_leaf *leaf, const w_surface *j, const w_step *r, w_f ng[3])
{
    const w_f twice_s = r->step_s + r->step_s, twice_t = r->step_t + r->step_t;
    const w_3 a = {w_fma(j->st.x, r->step_t, w_fma(j->ss.x, twice_s, j->ds.x)),
                   w_fma(j->st.y, r->step_t, w_fma(j->ss.y, twice_s, j->ds.y)),
                   w_fma(j->st.z, r->step_t, w_fma(j->ss.z, twice_s, j->ds.z))};
    const w_3 b = {w_fma(j->tt.x, twice_t, w_fma(j->st.x, r->step_s, j->dt.x)),
                   w_fma(j->tt.y, twice_t, w_fma(j->st.y, r->step_s, j->dt.y)),
                   w_fma(j->tt.z, twice_t, w_fma(j->st.z, r->step_s, j->dt.z))};
    const w_f volume = w_set(leaf->volume);
    const w_3 cross = w_cross(a, b), n = {volume * cross.x, volume * cross.y, volume * cross.z};
    for (int c = 0; c < 3; ++c)
        ng[c] =
            w_fma(w_set(leaf->frame[c][2]), n.z, w_fma(w_set(leaf->frame[c][1]), n.y, w_set(leaf->frame[c][0]) * n.x));
}
