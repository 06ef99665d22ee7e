/* newton_tmpl.h - enter a leaf, take a Newton step, decide. leaf.h derives every bound used here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included twice per instruction set, with X(name) giving w_name (one ray a lane) and s_name (one ray): the packet and
 * the single-ray kernel share this text, and so their bits. */

/* A hit is taken once its point is within this of where the tangents were evaluated, in leaf coordinates, so that Ng is
 * right to 2^-10 of what the normal turns over a leaf; the point itself is then right to rounding. */
#ifndef EP_NEAR
#define EP_NEAR 0x1p-10f
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
    X(f) bend_s, bend_t; /* Lipschitz constants of the rows of DF            */
    X(f) noise;         /* rounding error of F                              */
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
    X(m) hit;
    X(f) s, t, distance; /* the root, and its t relative to the moved origin */
} X(step);

/* The nearest point of the domain, or close to it. */
static inline void X(clamp)(int triangle, X(f) *s, X(f) *t)
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

/* `o`, `d`: origin relative to the patch's centre (rounded) and direction, in leaf coordinates (o with, d without the
 * frame's offset). `o_sum`, `d_sum`: their sum norms in space. */
static inline X(visit) X(enter)(const ep_leaf *leaf, int triangle, X(3) o, X(3) d, X(f) o_sum, X(f) d_sum, X(f) tnear,
                                X(f) tfar, X(m) active)
{
    X(visit) v;
    const X(f) zero = X(set)(0.0f), one = X(set)(1.0f);
    v.inverse = one / d.z;
    v.t_plane = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    v.s = X(fma)(v.t_plane, d.x, o.x);
    v.t = X(fma)(v.t_plane, d.y, o.y);

    /* the prism, and what rounding adds to it: a root is within reach_s, reach_t of (s, t) */
    const X(f) scale = X(fma)(X(abs)(v.t_plane), d_sum, o_sum);
    const X(f) height = X(fma)(X(set)(leaf->reach_h), scale, X(set)(leaf->height));
    const X(f) p_s = X(abs)(v.p_s), p_t = X(abs)(v.p_t), p = X(max)(p_s, p_t);
    const X(f) reach_s = X(fma)(p_s, height, X(fma)(X(set)(leaf->reach_st), scale, X(set)(leaf->side_s)));
    const X(f) reach_t = X(fma)(p_t, height, X(fma)(X(set)(leaf->reach_st), scale, X(set)(leaf->side_t)));
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

    v.bend_s = X(fma)(X(set)(leaf->bend_h), p_s, X(set)(leaf->bend_s));
    v.bend_t = X(fma)(X(set)(leaf->bend_h), p_t, X(set)(leaf->bend_t));
    v.noise = X(fma)(X(set)(leaf->noise_h), p, X(set)(leaf->noise_st));
    /* Clamping to a rectangle never moves away from a point in it; to the triangle, by at most as much again. */
    v.radius = X(min)(X(set)(triangle ? 2.0f : 1.0f) * X(max)(reach_s, reach_t), one);

    v.live = X(and)(in, X(lt)(v.noise, one));
    v.slow = X(andnot)(in, v.live);
    X(clamp)(triangle, &v.s, &v.t);
    return v;
}

/* One Newton step from (v->s, v->t), whose jet is `j`. Lanes that it decides leave v->live. */
static inline X(step) X(advance)(X(visit) *v, int triangle, const X(jet) *j)
{
    X(step) r;
    const X(f) one = X(set)(1.0f);
    const X(f) f_s = X(fnma)(v->p_s, j->at.z, j->at.x), f_t = X(fnma)(v->p_t, j->at.z, j->at.y);
    const X(f) ss = X(fnma)(v->p_s, j->ds.z, j->ds.x), st = X(fnma)(v->p_s, j->dt.z, j->dt.x);
    const X(f) ts = X(fnma)(v->p_t, j->ds.z, j->ds.y), tt = X(fnma)(v->p_t, j->dt.z, j->dt.y);
    const X(f) inverse = one / X(fnma)(st, ts, ss * tt);
    const X(f) step_s = X(fnma)(tt, f_s, st * f_t) * inverse, step_t = X(fnma)(ss, f_t, ts * f_s) * inverse;
    r.s = v->s + step_s;
    r.t = v->t + step_t;
    r.distance = X(fma)(j->dt.z, step_t, X(fma)(j->ds.z, step_s, j->at.z)) * v->inverse;

    const X(f) i = X(abs)(inverse), i_ss = X(abs)(tt) * i, i_st = X(abs)(st) * i, i_ts = X(abs)(ts) * i,
               i_tt = X(abs)(ss) * i;
    const X(f) bend = X(max)(X(fma)(i_ss, v->bend_s, i_st * v->bend_t), X(fma)(i_ts, v->bend_s, i_tt * v->bend_t));
    const X(f) noise = X(max)(i_ss + i_st, i_ts + i_tt) * v->noise;
    const X(f) length = X(max)(X(abs)(step_s), X(abs)(step_t));
    const X(f) twice = X(set)(2.0f) * (length + noise);
    const X(m) unique = X(le)(bend * v->radius, one);
    const X(f) error = X(select)(unique, X(min)(v->radius, twice), v->radius);
    const X(f) bound = (bend * X(set)(0.5f)) * (error * error);
    const X(f) outside = triangle ? X(max)(X(max)(-r.s, -r.t), (r.s + r.t) - one)
                                  : X(max)(X(max)(-r.s, -r.t), X(max)(r.s, r.t) - one);
    const X(f) margin = X(fma)(X(set)(4.0f), noise, bound);
    /* no root in D, or none in the neighbourhood */
    const X(m) miss = X(or)(X(lt)(triangle ? margin + margin : margin, outside), X(lt)(v->radius + margin, length));
    const X(m) done = X(and)(X(and)(X(le)(length, X(set)(EP_NEAR)), X(le)(bound, noise)), unique);
    r.hit = X(andnot)(X(and)(v->live, done), miss);
    v->live = X(andnot)(v->live, X(or)(miss, done));

    /* a lane goes on only while the roots' neighbourhood shrinks */
    const X(f) next = triangle ? margin + margin : margin;
    const X(m) shrinks = X(lt)(next, X(set)(0.75f) * v->radius);
    v->slow = X(or)(v->slow, X(andnot)(v->live, shrinks));
    v->live = X(and)(v->live, shrinks);
    v->radius = next;
    v->s = r.s;
    v->t = r.t;
    X(clamp)(triangle, &v->s, &v->t);
    return r;
}

/* Bernstein polynomials of degree n at t: binomial * ((1-t)^(n-i) * t^i). */
static inline __attribute__((always_inline)) void X(bernstein)(unsigned n, X(f) t, X(f) complement, X(f) *b)
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
