/* newton_tmpl.h - enter a leaf, take a Newton step, decide. leaf.h derives every bound used here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included twice per instruction set, with X(name) giving w_name (one ray a lane) and s_name (one ray): the packet and
 * the single-ray kernel share this text, and so their bits. */

/* A hit is taken once its point is within this of where the tangents were evaluated, in leaf coordinates. The point is
 * then right to rounding; the tangents, carried over by the model's second derivatives, to 2^-8 of those' range. */
#ifndef EP_NEAR
#define EP_NEAR 0x1p-7f
#endif

#ifndef EP_INLINE
#define EP_INLINE static inline __attribute__((always_inline))
#endif

/* A ray so nearly parallel to the leaf's plane that 1 / h(d) is mostly rounding. */
#ifndef EP_STEEP
#define EP_STEEP 0x1p12f
#endif

/* Vectors of three, one component a register. */
typedef struct X(3) {
    X(f) x, y, z;
} X(3);

/* What is known of a ray once it has entered a leaf. */
typedef struct X(visit) {
    X(f) p_s, p_t;      /* leaf.h: motion along the leaf per unit of height */
    X(f) inverse;       /* 1 / (direction's height)                         */
    X(f) t_plane;       /* where the ray meets the leaf's plane             */
    X(f) plane_s, plane_t;         /* where it does                           */
    X(f) rounding_st, rounding_h;  /* of that                                 */
    X(f) s, t;          /* where to evaluate next                           */
    X(f) radius;        /* all roots are within this of it                  */
    X(m) live;          /* neither certified to miss nor slow               */
    X(m) slow;
} X(visit);

/* The surface at (s, t), in leaf coordinates: S - o', and its derivatives in the leaf's own parameters. */
typedef struct X(jet) {
    X(3) at, ds, dt;
} X(jet);

typedef struct X(step) {
    X(f) s, t, step_s, step_t, length; /* the improved Newton point, and the way there */
    X(f) curve;                        /* what the model bends over that way          */
    X(f) noise, bound, radius;         /* where the roots are about it                */
    X(m) unique, miss, shrinks, hit;
    X(f) distance;                     /* the root's t relative to the moved origin   */
} X(step);

/* Magnitudes of J^-1 and of q = J^-1 p. */
typedef struct X(inverse) {
    X(f) ss, st, ts, tt, q_s, q_t;
} X(inverse);

/* The nearest point of the domain, or close to it. */
EP_INLINE void X(clamp)(int triangle, X(f) *s, X(f) *t)
{
    const X(f) zero = X(set)(0.0f), one = X(set)(1.0f);
    *s = X(max)(*s, zero);
    *t = X(max)(*t, zero);
    if (triangle) {
        const X(f) excess = X(max)((*s + *t) - one, zero) * X(set)(0.5f);
        *s = X(min)(X(max)(*s - excess, zero), one);
        *t = X(min)(X(max)(*t - excess, zero), one - *s);
    } else {
        *s = X(min)(*s, one);
        *t = X(min)(*t, one);
    }
}

/* max over the rows of |J^-1| (c_s, c_t)^T + |q| c_h. */
EP_INLINE X(f) X(spread)(const X(inverse) *i, const float c[3])
{
    const X(f) c_s = X(set)(c[0]), c_t = X(set)(c[1]), c_h = X(set)(c[2]);
    return X(max)(X(fma)(i->q_s, c_h, X(fma)(i->ss, c_s, i->st * c_t)),
                  X(fma)(i->q_t, c_h, X(fma)(i->ts, c_s, i->tt * c_t)));
}

/* The improved Newton point c' of (v->s, v->t), whose jet is `j`, and what follows from it when F is known to within
 * `noise_st` in its rows and `noise_h` in the height, and DF changes by `warp` beyond the model's second derivatives. */
EP_INLINE X(step) X(newton)(const ep_leaf *leaf, const X(visit) *v, int triangle, const X(jet) *j, X(f) noise_st,
                            X(f) noise_h, const float warp[3])
{
    X(step) r;
    const X(f) one = X(set)(1.0f), half = X(set)(0.5f);
    const X(f) f_s = X(fnma)(v->p_s, j->at.z, j->at.x), f_t = X(fnma)(v->p_t, j->at.z, j->at.y);
    const X(f) ss = X(fnma)(v->p_s, j->ds.z, j->ds.x), st = X(fnma)(v->p_s, j->dt.z, j->dt.x);
    const X(f) ts = X(fnma)(v->p_t, j->ds.z, j->ds.y), tt = X(fnma)(v->p_t, j->dt.z, j->dt.y);
    const X(f) inverse = one / X(fnma)(st, ts, ss * tt);
    const X(f) c_s = X(fnma)(tt, f_s, st * f_t) * inverse, c_t = X(fnma)(ss, f_t, ts * f_s) * inverse;

    const X(f) half_ss = half * (c_s * c_s), both = c_s * c_t, half_tt = half * (c_t * c_t);
    X(f) curve[3];
    for (int c = 0; c < 3; ++c)
        curve[c] = X(fma)(X(set)(leaf->model[3][c]), half_tt,
                          X(fma)(X(set)(leaf->model[2][c]), both, X(set)(leaf->model[1][c]) * half_ss));
    const X(f) v_s = X(fnma)(v->p_s, curve[2], curve[0]), v_t = X(fnma)(v->p_t, curve[2], curve[1]);
    r.curve = curve[2];
    r.step_s = X(fma)(X(fnma)(tt, v_s, st * v_t), inverse, c_s);
    r.step_t = X(fma)(X(fnma)(ss, v_t, ts * v_s), inverse, c_t);
    r.s = v->s + r.step_s;
    r.t = v->t + r.step_t;

    const X(f) size = X(abs)(inverse);
    const X(inverse) i = { X(abs)(tt) * size, X(abs)(st) * size, X(abs)(ts) * size, X(abs)(ss) * size,
                           X(abs)(X(fnma)(st, v->p_t, tt * v->p_s)) * size,
                           X(abs)(X(fnma)(ts, v->p_s, ss * v->p_t)) * size };
    r.noise = X(max)(X(fma)(i.q_s, noise_h, (i.ss + i.st) * noise_st), X(fma)(i.q_t, noise_h, (i.ts + i.tt) * noise_st));
    r.length = X(max)(X(abs)(c_s), X(abs)(c_t));
    const X(f) bend = X(spread)(&i, leaf->bend), way = r.length + r.noise, turn = bend * v->radius;
    r.unique = X(le)(turn, one);
    const X(f) e = X(select)(r.unique, X(min)(v->radius, X(fma)(turn, way, way)), v->radius), ge = bend * e;
    r.bound = half * e * X(fma)(ge, ge, X(spread)(&i, warp) * e);
    const X(f) outside = triangle ? X(max)(X(max)(-r.s, -r.t), (r.s + r.t) - one)
                                  : X(max)(X(max)(-r.s, -r.t), X(max)(r.s, r.t) - one);
    const X(f) margin = X(fma)(X(set)(4.0f), r.noise, r.bound);
    /* errors add up in s + t, and in clamping to the triangle */
    r.radius = triangle ? margin + margin : margin;
    /* no root in D, or none in the neighbourhood */
    r.miss = X(or)(X(lt)(r.radius, outside),
                   X(lt)(v->radius + margin, X(max)(X(abs)(r.step_s), X(abs)(r.step_t))));
    r.shrinks = X(lt)(r.radius, X(set)(0.75f) * v->radius);
    return r;
}

/* From the plane's start to the zero of the leaf's quadratic model, where that is certain to be nearer. */
EP_INLINE void X(start)(const ep_leaf *leaf, X(visit) *v, int triangle)
{
    const X(f) ds = v->s - X(set)(triangle ? 1.0f / 3 : 0.5f), dt = v->t - X(set)(triangle ? 1.0f / 3 : 0.5f);
    const X(f) half_ss = X(set)(0.5f) * (ds * ds), both = ds * dt, half_tt = X(set)(0.5f) * (dt * dt);
    X(f) at[3], s[3], t[3];
    for (int c = 0; c < 3; ++c) {
        const X(f) ss = X(set)(leaf->model[1][c]), st = X(set)(leaf->model[2][c]), tt = X(set)(leaf->model[3][c]);
        at[c] = X(fma)(tt, half_tt, X(fma)(st, both, X(fma)(ss, half_ss, X(set)(leaf->model[0][c]))));
        s[c] = X(fma)(st, dt, ss * ds);
        t[c] = X(fma)(tt, dt, st * ds);
    }
    static const float exact[3] = { 0, 0, 0 };
    const X(f) one = X(set)(1.0f);
    const X(jet) j = { { at[0] + (v->s - v->plane_s), at[1] + (v->t - v->plane_t), at[2] },
                       { s[0] + one, s[1], s[2] },
                       { t[0], t[1] + one, t[2] } };
    const X(step) r = X(newton)(leaf, v, triangle, &j, X(set)(leaf->model_st) + v->rounding_st,
                                X(set)(leaf->model_h) + v->rounding_h, exact);
    X(f) to_s = r.s, to_t = r.t;
    X(clamp)(triangle, &to_s, &to_t);
    v->live = X(andnot)(v->live, r.miss);
    v->s = X(select)(r.shrinks, to_s, v->s);
    v->t = X(select)(r.shrinks, to_t, v->t);
    v->radius = X(select)(r.shrinks, r.radius, v->radius);
}

/* `o`, `d`: origin relative to the patch's centre (rounded) and direction, in leaf coordinates (o with, d without the
 * frame's offset). `o_sum`, `d_sum`: their sum norms in space. */
EP_INLINE X(visit) X(enter)(const ep_leaf *leaf, int triangle, X(3) o, X(3) d, X(f) o_sum, X(f) d_sum, X(f) tnear,
                                X(f) tfar, X(m) active)
{
    X(visit) v;
    const X(f) zero = X(set)(0.0f), one = X(set)(1.0f);
    v.inverse = one / d.z;
    v.t_plane = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    v.s = v.plane_s = X(fma)(v.t_plane, d.x, o.x);
    v.t = v.plane_t = X(fma)(v.t_plane, d.y, o.y);

    /* the prism, and what rounding adds to it: a root is within reach_s, reach_t of (s, t) */
    const X(f) scale = X(fma)(X(abs)(v.t_plane), d_sum, o_sum);
    v.rounding_st = X(set)(leaf->reach_st) * scale;
    v.rounding_h = X(set)(leaf->reach_h) * scale;
    const X(f) height = X(set)(leaf->height) + v.rounding_h;
    const X(f) p_s = X(abs)(v.p_s), p_t = X(abs)(v.p_t), p = X(max)(p_s, p_t);
    const X(f) reach_s = X(fma)(p_s, height, X(set)(leaf->side_s) + v.rounding_st);
    const X(f) reach_t = X(fma)(p_t, height, X(set)(leaf->side_t) + v.rounding_st);
    const X(f) reach = X(abs)(v.inverse) * height;
    X(m) out = X(or)(X(lt)(v.s + reach_s, zero), X(lt)(v.t + reach_t, zero));
    if (triangle) {
        out = X(or)(out, X(lt)(one + (reach_s + reach_t), v.s + v.t));
    } else {
        out = X(or)(out, X(lt)(one + reach_s, v.s));
        out = X(or)(out, X(lt)(one + reach_t, v.t));
    }
    out = X(or)(out, X(lt)(tfar, v.t_plane - reach));
    out = X(or)(out, X(lt)(v.t_plane + reach, tnear));
    const X(m) in = X(andnot)(active, out); /* a NaN is never out */

    /* Clamping to a rectangle never moves away from a point in it; to the triangle, by at most as much again. */
    v.radius = X(min)(X(set)(triangle ? 2.0f : 1.0f) * X(max)(reach_s, reach_t), one);

    v.live = X(and)(in, X(lt)(p, X(set)(EP_STEEP)));
    v.slow = X(andnot)(in, v.live);
    X(clamp)(triangle, &v.s, &v.t);
    X(start)(leaf, &v, triangle);
    return v;
}

/* One step with the surface's own jet. Lanes that it decides leave v->live; `hit` are those with a root, at (s, t) and
 * `distance` along the ray from the moved origin. */
EP_INLINE X(step) X(advance)(const ep_leaf *leaf, X(visit) *v, int triangle, const X(jet) *j)
{
    X(step) r = X(newton)(leaf, v, triangle, j, X(set)(leaf->noise_st), X(set)(leaf->noise_h), leaf->warp);
    const X(m) done = X(and)(X(and)(X(le)(r.length, X(set)(EP_NEAR)), X(le)(r.bound, r.noise)), r.unique);
    r.distance = (X(fma)(j->dt.z, r.step_t, X(fma)(j->ds.z, r.step_s, j->at.z)) + r.curve) * v->inverse;
    r.hit = X(andnot)(X(and)(v->live, done), r.miss);
    v->live = X(andnot)(v->live, X(or)(r.miss, done));
    v->slow = X(or)(v->slow, X(andnot)(v->live, r.shrinks));
    v->live = X(and)(v->live, r.shrinks);
    v->radius = r.radius;
    v->s = r.s;
    v->t = r.t;
    X(clamp)(triangle, &v->s, &v->t);
    return r;
}

/* Ng at the Newton point: the tangents' change over the step comes from the model's second derivatives. */
EP_INLINE void X(normal)(const ep_leaf *leaf, const X(jet) *j, const X(step) *r, X(f) ng[3])
{
    const X(f) jds[3] = { j->ds.x, j->ds.y, j->ds.z }, jdt[3] = { j->dt.x, j->dt.y, j->dt.z };
    X(f) a[3], b[3], n[3];
    for (int c = 0; c < 3; ++c) {
        const X(f) ss = X(set)(leaf->model[1][c]), st = X(set)(leaf->model[2][c]), tt = X(set)(leaf->model[3][c]);
        a[c] = X(fma)(st, r->step_t, X(fma)(ss, r->step_s, jds[c]));
        b[c] = X(fma)(tt, r->step_t, X(fma)(st, r->step_s, jdt[c]));
    }
    for (int c = 0; c < 3; ++c) {
        const int k = (c + 1) % 3, l = (c + 2) % 3;
        n[c] = X(set)(leaf->volume) * X(fnma)(a[l], b[k], a[k] * b[l]);
    }
    for (int c = 0; c < 3; ++c)
        ng[c] = X(fma)(X(set)(leaf->frame[c][2]), n[2],
                       X(fma)(X(set)(leaf->frame[c][1]), n[1], X(set)(leaf->frame[c][0]) * n[0]));
}

/* Bernstein polynomials of degree n at t: binomial * ((1-t)^(n-i) * t^i). */
EP_INLINE void X(bernstein)(unsigned n, X(f) t, X(f) complement, X(f) *b)
{
    X(f) ps[EP_MAX_DEGREE + 1], pt[EP_MAX_DEGREE + 1];
    ps[0] = pt[0] = X(set)(1.0f);
    for (unsigned i = 1; i <= n; ++i) {
        ps[i] = ps[i - 1] * complement;
        pt[i] = pt[i - 1] * t;
    }
    float binomial = 1;
    for (unsigned i = 0; i <= n; ++i) {
        b[i] = X(set)(binomial) * (ps[n - i] * pt[i]);
        binomial = binomial * (float)(n - i) / (float)(i + 1);
    }
}
