/* newton_tmpl.h - enter a leaf, take a Newton step, decide. leaf.h derives every bound used here.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Included twice per instruction set, with X(name) giving w_name (one ray a lane) and s_name (one ray): the packet and
 * the single-ray kernel share this text, and so their bits. X(v) is what a series is evaluated in: one coordinate of
 * all rays, or all coordinates of the one. */

/* A hit is taken once its point is within this of where the tangents were evaluated, in leaf coordinates. The point is
 * then right to rounding; the tangents, carried over by the model's second derivatives, to 2^-8 of those' range. */
#ifndef EP_NEAR
#define EP_NEAR 0x1p-7f
#endif

/* ... and once what is left is certain to be below its rounding error, or below this many times that of a ray that
 * meets the leaf squarely. The bound is a worst case, often ten times what really is left. */
#ifndef EP_ACCEPT
#define EP_ACCEPT 4.0f
#endif

/* A root that rounding may have displaced by more than EP_FLAT along a leaf, where the ray is nearly tangent, is found
 * again in double; and so is one that may be farther than EP_SHARP on either side of the leaf's border. */
#ifndef EP_FLAT
#define EP_FLAT 0x1p-16f
#define EP_SHARP 0x1p-18f
#endif

#ifndef EP_INLINE
#define EP_INLINE static inline __attribute__((always_inline))
#endif

/* A ray so nearly parallel to the leaf's plane that 1 / h(d) is mostly rounding. */
#ifndef EP_STEEP
#define EP_STEEP 0x1p12f
#endif

/* The domain in leaf coordinates: |s|, |t| <= 1/2, or s, t >= -1/3 and s + t <= 1/3. */
#ifndef EP_HALF
#define EP_HALF 0.5f
#define EP_THIRD (1.0f / 3)
#endif

/* Vectors of three, one component a register. */
typedef struct X(3) {
    X(f) x, y, z;
} X(3);

/* What is known of a ray once it has entered a leaf. */
typedef struct X(visit) {
    X(f) p_s, p_t;          /* leaf.h: motion along the leaf per unit of height            */
    X(f) inverse;           /* 1 / (direction's height)                                    */
    X(f) t_plane;           /* where the ray meets the leaf's plane, and is moved to       */
    X(f) way;               /* |t| |d| in the sum norm on its way through the prism        */
    X(3) o;                 /* the moved origin                                            */
    X(f) noise_st, noise_h; /* rounding of F                                           */
    X(f) s, t;              /* where to evaluate next                                      */
    X(f) radius;            /* all roots are within this of it                             */
    X(m) live;              /* neither certified to miss nor slow                          */
    X(m) slow;
    X(m) more;              /* there is another such neighbourhood, farther along the ray  */
    X(f) other_s, other_t, other_radius;
} X(visit);

/* The surface at (s, t), in leaf coordinates: S - o, and its derivatives. */
typedef struct X(jet) {
    X(3) at, ds, dt;
} X(jet);

typedef struct X(step) {
    X(f) s, t, step_s, step_t; /* the improved Newton point, and the way there */
    X(f) radius;               /* the roots are within this of it              */
    X(f) distance;             /* the root's t relative to the moved origin    */
    X(m) hit, vague;           /* vague: float says that there is one, double has to say where */
    X(m) stuck;                /* neither, and the neighbourhood does not shrink               */
} X(step);

/* The nearest point of the domain, or close to it. */
EP_INLINE void X(clamp)(int triangle, X(f) * s, X(f) * t)
{
    const X(f) low = X(set)(triangle ? -EP_THIRD : -EP_HALF), high = X(set)(triangle ? 2 * EP_THIRD : EP_HALF);
    *s = X(max)(*s, low);
    *t = X(max)(*t, low);
    if (triangle) {
        const X(f) third = X(set)(EP_THIRD);
        const X(f) excess = X(max)((*s + *t) - third, X(set)(0.0f)) * X(set)(0.5f);
        *s = X(min)(X(max)(*s - excess, low), high);
        *t = X(min)(X(max)(*t - excess, low), third - *s);
    } else {
        *s = X(min)(*s, high);
        *t = X(min)(*t, high);
    }
}

/* How far outside the domain; negative inside. */
EP_INLINE X(f) X(outside)(int triangle, X(f) s, X(f) t)
{
    if (!triangle) return X(max)(X(abs)(s), X(abs)(t)) - X(set)(EP_HALF);
    return X(max)(X(max)(-s, -t), s + t) - X(set)(EP_THIRD);
}

/* Point and derivatives of a polynomial, row by row in s, then in t; derivatives by the same scheme. */
EP_INLINE void X(series)(const float *net, int stride, int triangle, unsigned m, unsigned n, X(v) s, X(v) t, X(v) * f,
                         X(v) * fs, X(v) * ft)
{
    const float *row = net + (size_t)stride * (triangle ? (n + 1) * (n + 2) / 2 : (m + 1) * (n + 1));
    X(v) value = X(v_load)(net), ds = value, dt = value;
    for (unsigned j = n + 1; j-- > 0;) {
        const unsigned count = triangle ? n - j : m;
        row -= (size_t)stride * (count + 1);
        X(v) a = X(v_load)(row + (size_t)stride * count), as = a;
        if (count > 0) a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * (count - 1)));
        for (unsigned i = count - 1; count > 1 && i-- > 0;) {
            as = X(v_fma)(as, s, a);
            a = X(v_fma)(a, s, X(v_load)(row + (size_t)stride * i));
        }
        if (j == n) {
            value = a;
        } else {
            dt = j == n - 1 ? value : X(v_fma)(dt, t, value);
            value = X(v_fma)(value, t, a);
        }
        if (count > 0) ds = j + (triangle ? 1u : 0u) == n ? as : X(v_fma)(ds, t, as);
    }
    *f = value;
    *fs = ds;
    *ft = dt;
}

/* A Newton step: its Jacobian, the way to c, and the magnitudes of J^-1 and q = J^-1 p. */
typedef struct X(linear) {
    X(f) ss, st, ts, tt, inverse, c_s, c_t, i, q; /* c - y */
} X(linear);

EP_INLINE X(linear) X(solve)(const X(visit) * v, const X(jet) * j)
{
    X(linear) l;
    const X(f) f_s = X(fnma)(v->p_s, j->at.z, j->at.x), f_t = X(fnma)(v->p_t, j->at.z, j->at.y);
    l.ss = X(fnma)(v->p_s, j->ds.z, j->ds.x);
    l.st = X(fnma)(v->p_s, j->dt.z, j->dt.x);
    l.ts = X(fnma)(v->p_t, j->ds.z, j->ds.y);
    l.tt = X(fnma)(v->p_t, j->dt.z, j->dt.y);
    l.inverse = X(set)(1.0f) / X(fnma)(l.st, l.ts, l.ss * l.tt);
    l.c_s = X(fnma)(l.tt, f_s, l.st * f_t) * l.inverse;
    l.c_t = X(fnma)(l.ss, f_t, l.ts * f_s) * l.inverse;
    const X(f) size = X(abs)(l.inverse);
    l.i = X(max)(X(abs)(l.tt) + X(abs)(l.st), X(abs)(l.ts) + X(abs)(l.ss)) * size;
    l.q = X(max)(X(abs)(X(fnma)(l.st, v->p_t, l.tt * v->p_s)), X(abs)(X(fnma)(l.ts, v->p_s, l.ss * v->p_t))) * size;
    return l;
}

/* |J^-1| st + |q| h */
EP_INLINE X(f) X(spread)(const X(linear) * l, X(f) st, X(f) h)
{
    return X(fma)(l->q, h, l->i * st);
}

/* `o`, `d`: origin relative to the leaf's centre (rounded) and direction, in leaf coordinates; `d_sum`: the
 * direction's sum norm in space. Most rays that only touch the leaf's box end here. */
EP_INLINE X(visit)
    X(enter)(const ep_leaf *leaf, int triangle, X(3) o, X(3) d, X(f) d_sum, X(f) tnear, X(f) tfar, X(m) active)
{
    X(visit) v;
    const X(f) edge = X(set)(triangle ? EP_THIRD : EP_HALF);
    v.inverse = X(set)(1.0f) / d.z;
    v.t_plane = -o.z * v.inverse;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    const X(f) s = X(fma)(v.t_plane, d.x, o.x), t = X(fma)(v.t_plane, d.y, o.y);

    /* the prism, and what rounding adds to it: a root is within reach_s, reach_t of (s, t) */
    const X(f) far = X(abs)(v.t_plane) * d_sum;
    const X(f) side = X(fma)(X(set)(leaf->reach_st), far, X(set)(leaf->side));
    const X(f) height = X(fma)(X(set)(leaf->reach_h), far, X(set)(leaf->height));
    const X(f) p_s = X(abs)(v.p_s), p_t = X(abs)(v.p_t);
    const X(f) reach_s = X(fma)(p_s, height, side), reach_t = X(fma)(p_t, height, side);
    const X(f) reach = X(abs)(v.inverse) * height;
    X(m) out;
    if (triangle)
        out = X(or)(X(or)(X(lt)(edge + reach_s, -s), X(lt)(edge + reach_t, -t)),
                    X(lt)(edge + (reach_s + reach_t), s + t));
    else out = X(or)(X(lt)(edge + reach_s, X(abs)(s)), X(lt)(edge + reach_t, X(abs)(t)));
    out = X(or)(out, X(or)(X(lt)(tfar, v.t_plane - reach), X(lt)(v.t_plane + reach, tnear)));
    const X(m) in = X(andnot)(active, out); /* a NaN is never out */

    /* Clamping to a rectangle never moves away from a point in it; to the triangle, by at most as much again. */
    v.radius = X(min)(X(set)(triangle ? 2.0f : 1.0f) * X(max)(reach_s, reach_t), X(set)(1.0f));
    v.way = d_sum * reach;
    v.live = X(and)(in, X(lt)(X(max)(p_s, p_t), X(set)(EP_STEEP)));
    v.slow = X(andnot)(in, v.live);
    return v;
}

/* The origin moved to the plane, in leaf coordinates, is where iteration starts: with a Newton step on the leaf's
 * model, whose error stands in for rounding. M's rounding of the direction counts over the way through the prism. */
EP_INLINE void X(start)(const ep_leaf *leaf, X(visit) * v, int triangle, X(3) o)
{
    v->o = o;
    v->noise_st = X(fma)(X(set)(leaf->reach_st), v->way, X(set)(leaf->noise_st));
    v->noise_h = X(fma)(X(set)(leaf->reach_h), v->way, X(set)(leaf->noise_h));
    X(f) s = o.x, t = o.y;
    X(clamp)(triangle, &s, &t);

    X(f) at[3], ds[3], dt[3];
    for (int c = 0; c < 3; ++c) {
        const X(f) ss = X(set)(leaf->second[0][c]), st = X(set)(leaf->second[1][c]), tt = X(set)(leaf->second[2][c]);
        ds[c] = X(fma)(st, t, ss * s);
        dt[c] = X(fma)(tt, t, st * s);
        at[c] = X(fma)(dt[c], t, ds[c] * s) * X(set)(0.5f);
    }
    const X(f) one = X(set)(1.0f);
    const X(jet) j = {{at[0] + (s - o.x), at[1] + (t - o.y), at[2] + (X(set)(leaf->middle) - o.z)},
                      {ds[0] + one, ds[1], ds[2]},
                      {dt[0], dt[1] + one, dt[2]}};
    const X(linear) l = X(solve)(v, &j);
    v->s = s + l.c_s;
    v->t = t + l.c_t;
    X(clamp)(triangle, &v->s, &v->t);
    const X(f) error = X(spread)(&l, X(set)(leaf->model_st) + v->noise_st, X(set)(leaf->model_h) + v->noise_h);
    const X(f) bend = X(spread)(&l, X(set)(leaf->bend_st), X(set)(leaf->bend_h));
    const X(f) bound = X(fma)(X(set)(0.5f) * bend, v->radius * v->radius, error);
    v->radius = X(min)(triangle ? bound + bound : bound, v->radius + X(max)(X(abs)(v->s - s), X(abs)(v->t - t)));
}

/* The surface's own jet, and with it the improved Newton point c' and what follows from it. Lanes that it decides leave
 * v->live; `hit` are those with a root, at (s, t) and `distance` along the ray from the moved origin. */
EP_INLINE X(step) X(advance)(const ep_leaf *leaf, X(visit) * v, int triangle, const X(jet) * j)
{
    X(step) r;
    const X(f) one = X(set)(1.0f), half = X(set)(0.5f);
    const X(linear) l = X(solve)(v, j);
    const X(f) half_ss = half * (l.c_s * l.c_s), both = l.c_s * l.c_t, half_tt = half * (l.c_t * l.c_t);
    X(f) curve[3];
    for (int c = 0; c < 3; ++c)
        curve[c] = X(fma)(X(set)(leaf->second[2][c]), half_tt,
                          X(fma)(X(set)(leaf->second[1][c]), both, X(set)(leaf->second[0][c]) * half_ss));
    const X(f) v_s = X(fnma)(v->p_s, curve[2], curve[0]), v_t = X(fnma)(v->p_t, curve[2], curve[1]);
    r.step_s = X(fma)(X(fnma)(l.tt, v_s, l.st * v_t), l.inverse, l.c_s);
    r.step_t = X(fma)(X(fnma)(l.ss, v_t, l.ts * v_s), l.inverse, l.c_t);
    r.s = v->s + r.step_s;
    r.t = v->t + r.step_t;
    r.distance = (X(fma)(j->dt.z, r.step_t, X(fma)(j->ds.z, r.step_s, j->at.z)) + curve[2]) * v->inverse;

    const X(f) bend = X(spread)(&l, X(set)(leaf->bend_st), X(set)(leaf->bend_h));
    const X(f) warp = X(spread)(&l, X(set)(leaf->warp_st), X(set)(leaf->warp_h));
    const X(f) noise = X(spread)(&l, v->noise_st, v->noise_h);
    const X(f) length = X(max)(X(abs)(l.c_s), X(abs)(l.c_t));
    const X(f) way = length + noise, turn = bend * v->radius;
    const X(m) unique = X(le)(turn, one);
    const X(f) e = X(select)(unique, X(min)(v->radius, X(fma)(turn, way, way)), v->radius), ge = bend * e;
    const X(f) bound = half * e * X(fma)(ge * ge, X(fma)(X(set)(0.25f), ge, one), warp * e);
    const X(f) displaced = X(fma)(noise, X(fma)(half, X(fma)(ge, ge, bend * noise), ge), noise);
    const X(f) margin = displaced + bound, outside = X(outside)(triangle, r.s, r.t);
    /* errors add up in s + t, and in clamping to the triangle */
    r.radius = triangle ? margin + margin : margin;
    /* no root in D, or none in the neighbourhood */
    const X(m) miss =
        X(or)(X(lt)(r.radius, outside), X(lt)(v->radius + margin, X(max)(X(abs)(r.step_s), X(abs)(r.step_t))));
    const X(m) near = X(le)(bound, X(max)(noise, X(set)(EP_ACCEPT * leaf->noise_st)));
    /* from c', too, Newton's method in double goes to this root: rounding may have displaced it by more than e */
    const X(m) sure = X(and)(unique, X(le)(bend * margin, one));
    const X(m) done = X(and)(X(and)(X(le)(length, X(set)(EP_NEAR)), near), sure);
    r.vague =
        X(or)(X(lt)(X(set)(EP_FLAT), noise), X(and)(X(lt)(X(set)(EP_SHARP), r.radius), X(le)(-outside, r.radius)));
    const X(m) shrinks = X(lt)(r.radius, X(set)(0.75f) * v->radius);
    r.hit = X(andnot)(X(and)(v->live, done), miss);
    v->live = X(andnot)(v->live, X(or)(miss, done));
    r.stuck = X(andnot)(v->live, shrinks);
    v->live = X(and)(v->live, shrinks);
    X(f) s = r.s, t = r.t;
    X(clamp)(triangle, &s, &t);
    v->s = X(select)(shrinks, s, v->s);
    v->t = X(select)(shrinks, t, v->t);
    v->radius = X(select)(shrinks, r.radius, v->radius);
    return r;
}

/* The patch's parameters at (s, t) of a leaf. */
EP_INLINE void X(parameters)(const ep_leaf *leaf, int triangle, X(f) s, X(f) t, X(f) * u, X(f) * v)
{
    const float *d = leaf->domain;
    const X(f) edge = X(set)(triangle ? EP_THIRD : EP_HALF), zero = X(set)(0.0f), one = X(set)(1.0f);
    const X(f) x = s + edge, y = t + edge;
    *u = X(fma)(x, X(set)(d[2]), triangle ? X(fma)(y, X(set)(d[4]), X(set)(d[0])) : X(set)(d[0]));
    *v = X(fma)(y, X(set)(d[3]), triangle ? X(fma)(x, X(set)(d[5]), X(set)(d[1])) : X(set)(d[1]));
    *u = X(min)(X(max)(*u, zero), one);
    *v = X(min)(X(max)(*v, zero), triangle ? one - *u : one);
}

/* Ng at the Newton point: the tangents' change over the step comes from the model's second derivatives. */
EP_INLINE void X(normal)(const ep_leaf *leaf, const X(jet) * j, const X(step) * r, X(f) ng[3])
{
    const X(f) jds[3] = {j->ds.x, j->ds.y, j->ds.z}, jdt[3] = {j->dt.x, j->dt.y, j->dt.z};
    X(f) a[3], b[3], n[3];
    for (int c = 0; c < 3; ++c) {
        const X(f) ss = X(set)(leaf->second[0][c]), st = X(set)(leaf->second[1][c]), tt = X(set)(leaf->second[2][c]);
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
