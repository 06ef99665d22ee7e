/* fold_tmpl.h - a nearly tangent ray: two small neighbourhoods for a large one, by a quadratic equation.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Where a ray is nearly tangent F folds the leaf over: along the ray's way J is almost singular, there may be two
 * roots, and no neighbourhood that holds both shrinks. But F is nearly singular in that one direction only. With A = I
 * + R the part of J without the ray, g the height's gradient and H the model's second derivatives, all roots y + d in
 * the neighbourhood |d| <= e of y satisfy, tau being the height above the moved origin at which the ray meets them,
 *
 *     A d = p tau - S_st(y) + o_st - H_st d²/2 - rho_st,      tau = S_h(y) - o_h + g d + H_h d²/2 + rho_h,
 *
 * |rho| <= warp e²/2 + noise. A is nearly I. So d = l + q with l = d0 + a tau, a = A^-1 p, d0 = -A^-1 (S - o)_st, and
 * |q| <= Q = |A^-1| (bend_st e²/2 + noise_st). Put into the second equation, with b = g A^-1 and K = H_h - b H_st,
 *
 *     |c0 + c1 tau + c2 tau²/2| <= P,   c0 = (S - o)_h - b (S - o)_st + K d0²/2,  c1 = g a - 1 + K d0 a,  c2 = K a²,
 *     P = (warp_h + |b| warp_st) e²/2 + noise_h + |b| noise_st + (bend_h + |b| bend_st) Q (e + 3/2 Q),
 *
 * because |l| <= e + Q. That is no tau at all, and the ray is certain to miss; one interval; or two, and then
 *
 *     |d - (l + q2)| <= |a| h (1 + |A^-1| bend_st (e + Q + |a| h/2))
 *                       + |A^-1| (warp_st e²/2 + noise_st + bend_st Q (e + 3/2 Q))
 *
 * with tau, q2 = -A^-1 H_st l²/2 at the interval's middle, and h half its length: l there is within |a| h of the
 * root's. Or without q2 and by Q + |a| h, if that is less. Intervals end where l leaves the domain by more than Q, and
 * with the ray's cell. P goes with the cube of e as leaves go, h with P over the distance of the two roots:
 * neighbourhoods shrink faster than they would by bisection, even for a tangent ray, down to the noise. */

/* Bounds are computed in the arithmetic whose rounding they bound: this much is added. */
#define EP_OUTWARD (1 + 0x1p-10f)

/* K x y of a quadratic form. */
EP_INLINE w_f w_form(const w_f k[3], const w_f x[2], const w_f y[2])
{
    return w_fma(k[2], x[1] * y[1], w_fma(k[1], w_fma(x[0], y[1], x[1] * y[0]), k[0] * (x[0] * y[0])));
}

/* Narrows [*from, *to] to where x + k d <= limit. */
EP_INLINE void w_clip_side(w_f x, w_f d, w_f limit, w_f *from, w_f *to)
{
    const w_f zero = w_set(0.0f), k = (limit - x) / d;
    *to = w_select(w_lt(zero, d), w_min(k, *to), *to);
    *from = w_select(w_lt(d, zero), w_max(k, *from), *from);
    *to = w_select(w_and(w_le(w_abs(d), zero), w_lt(limit, x)), w_set(-INFINITY), *to);
}

/* ... and to where (s + k ds, t + k dt) is within `margin` of the domain. */
EP_INLINE void w_clip_domain(int triangle, w_f s, w_f t, w_f ds, w_f dt, w_f margin, w_f *from, w_f *to)
{
    const w_f edge = w_set(triangle ? EP_THIRD : EP_HALF) + margin;
    w_clip_side(-s, -ds, edge, from, to);
    w_clip_side(-t, -dt, edge, from, to);
    if (triangle) {
        w_clip_side(s + t, ds + dt, edge + margin, from, to);
    } else {
        w_clip_side(s, ds, edge, from, to);
        w_clip_side(t, dt, edge, from, to);
    }
}

typedef struct w_near {
    w_f s, t, radius;
    w_m none; /* certainly no root there */
} w_near;

/* What the neighbourhoods of both intervals share. */
typedef struct w_folded {
    w_f s, t, e;                   /* the old neighbourhood     */
    w_f from, to;                  /* all of tau                */
    w_f a[2], d0[2];               /* l                         */
    w_f bend[2][3];                /* A^-1 H_st                 */
    w_f curve;                     /* of q2: 1/2, or 0 where l alone is closer */
    w_f per_square, per_tau, rest; /* radius = per_square h² + per_tau h + rest */
} w_folded;

EP_INLINE w_near w_unfold(const w_folded *f, int triangle, w_f from, w_f to)
{
    w_near n;
    const w_f half = w_set(0.5f);
    from = w_max(from, f->from);
    to = w_min(to, f->to);
    const w_f tau = half * (from + to), h = w_fma(half, to - from, w_set(0x1p-20f) * (w_abs(from) + w_abs(to)));
    const w_f l[2] = {w_fma(f->a[0], tau, f->d0[0]), w_fma(f->a[1], tau, f->d0[1])};
    const w_f d_s = w_fnma(f->curve, w_form(f->bend[0], l, l), l[0]);
    const w_f d_t = w_fnma(f->curve, w_form(f->bend[1], l, l), l[1]);
    n.s = f->s + d_s;
    n.t = f->t + d_t;
    n.radius = w_fma(w_fma(f->per_square, h, f->per_tau), h, f->rest);
    if (triangle) n.radius = n.radius + n.radius;
    n.none = w_or(w_lt(to, from), w_or(w_lt(n.radius, w_outside(triangle, n.s, n.t)),
                                       w_lt(f->e + n.radius, w_max(w_abs(d_s), w_abs(d_t)))));
    w_clamp(triangle, &n.s, &n.t);
    return n;
}

/* For the lanes in `stuck`, whose neighbourhood does not shrink and whose jet is `j`, and roots with |tau| <= `height`:
 * goes on with what is left of it, the nearer part along the ray first, the other in v->other. Lanes without any leave;
 * those that this does not help are slow. */
EP_INLINE void w_fold(const ep_leaf *leaf, w_visit *v, int triangle, const w_jet *j, w_f height, w_m stuck)
{
    const w_f zero = w_set(0.0f), one = w_set(1.0f), half = w_set(0.5f), outward = w_set(EP_OUTWARD);
    w_folded f = {.s = v->s, .t = v->t, .e = v->radius};
    const w_f inverse = one / w_fnma(j->dt.x, j->ds.y, j->ds.x * j->dt.y), size = w_abs(inverse);
    const w_f i = w_max(w_abs(j->dt.y) + w_abs(j->dt.x), w_abs(j->ds.y) + w_abs(j->ds.x)) * size * outward;
    f.a[0] = w_fnma(j->dt.x, v->p_t, j->dt.y * v->p_s) * inverse;
    f.a[1] = w_fnma(j->ds.y, v->p_s, j->ds.x * v->p_t) * inverse;
    f.d0[0] = w_fnma(j->dt.y, j->at.x, j->dt.x * j->at.y) * inverse;
    f.d0[1] = w_fnma(j->ds.x, j->at.y, j->ds.y * j->at.x) * inverse;
    const w_f b_s = w_fnma(j->dt.z, j->ds.y, j->ds.z * j->dt.y) * inverse;
    const w_f b_t = w_fnma(j->ds.z, j->dt.x, j->dt.z * j->ds.x) * inverse;
    const w_f b = (w_abs(b_s) + w_abs(b_t)) * outward;
    w_f k[3];
    for (int c = 0; c < 3; ++c) {
        const w_f s = w_set(leaf->second[c][0]), t = w_set(leaf->second[c][1]);
        k[c] = w_fnma(b_t, t, w_fnma(b_s, s, w_set(leaf->second[c][2])));
        f.bend[0][c] = w_fnma(j->dt.x, t, j->dt.y * s) * inverse;
        f.bend[1][c] = w_fnma(j->ds.y, s, j->ds.x * t) * inverse;
    }
    const w_f c0 = w_fma(half, w_form(k, f.d0, f.d0), w_fnma(b_t, j->at.y, w_fnma(b_s, j->at.x, j->at.z)));
    const w_f c1 = w_form(k, f.d0, f.a) + w_fma(j->ds.z, f.a[0], w_fma(j->dt.z, f.a[1], -one));
    const w_f c2 = w_form(k, f.a, f.a);

    /* tangents err by no more than twice the degree times what the point does */
    const w_f wide = w_fma(w_set(2.0f * (float)(leaf->degree_s + leaf->degree_t)), f.e, one) * outward;
    const w_f noise_st = wide * v->noise_st, noise_h = wide * v->noise_h;
    const w_f bend_st = w_set(leaf->bend_st), warp_st = w_set(leaf->warp_st);

    const w_f a = w_max(w_abs(f.a[0]), w_abs(f.a[1])), d0 = w_max(w_abs(f.d0[0]), w_abs(f.d0[1]));

    /* l is within q of the domain, and of the old neighbourhood's size */
    w_f q = i * w_fma(bend_st, half * outward * (f.e * f.e), noise_st);
    f.from = -height;
    f.to = height;
    w_clip_domain(triangle, f.s + f.d0[0], f.t + f.d0[1], f.a[0], f.a[1],
                  q + w_fma(w_set(0x1p-20f), d0, w_set(0x1p-20f)), &f.from, &f.to);
    const w_f ends[2][2] = {{w_abs(w_fma(f.a[0], f.from, f.d0[0])), w_abs(w_fma(f.a[1], f.from, f.d0[1]))},
                            {w_abs(w_fma(f.a[0], f.to, f.d0[0])), w_abs(w_fma(f.a[1], f.to, f.d0[1]))}};
    const w_f l_max = w_max(w_max(ends[0][0], ends[0][1]), w_max(ends[1][0], ends[1][1])) * outward;
    f.e = w_min(l_max + q, f.e);
    const w_f half_e2 = half * outward * (f.e * f.e);
    q = i * w_fma(bend_st, half_e2, noise_st);
    const w_f cross = q * w_fma(w_set(1.5f), q, f.e) * outward;
    const w_f curved = w_fma(b, bend_st, w_set(leaf->bend_h));
    const w_f rest = i * w_fma(bend_st, cross, w_fma(warp_st, half_e2, noise_st));
    f.rest = w_min(rest, q);
    f.curve = w_select(w_lt(rest, q), half, zero);
    const w_f reach = f.e + q;
    f.per_tau = a * w_fma(i * bend_st, reach, one) * outward;
    f.per_square = half * outward * (i * bend_st) * (a * a);
    /* what rounding adds to c0 + c1 tau + c2 tau²/2: each of a dozen terms is below one of these */
    const w_f along = d0 + reach, l = along + d0;
    const w_f terms = w_fma(curved * l, l, w_abs(j->at.z)) +
                      w_fma(b, w_max(w_abs(j->at.x), w_abs(j->at.y)), along * (b + b + one / a));
    const w_f p =
        w_fma(curved, cross, w_fma(w_fma(b, warp_st, w_set(leaf->warp_h)), half_e2, w_fma(b, noise_st, noise_h))) +
        w_set(0x1p-20f) * terms;

    /* The solutions are where x = |c2 tau + c1| is between `from` and `to`. Two intervals if from > 0. */
    const w_f twice = c2 + c2, inner = w_fnma(twice, c0, c1 * c1), width = w_abs(twice) * p;
    const w_f outer = inner + width;
    const w_m none = w_lt(outer, zero), both = w_lt(width, inner);
    const w_f to = w_sqrt(w_max(outer, zero)), from = w_sqrt(w_max(inner - width, zero));
    const w_f scale = one / w_abs(c2), middle = -c1 / c2;
    const w_f inexact = w_set(0x1p-20f) * w_fma(to, scale, w_abs(middle));
    const w_f farther = w_fma(to, scale, inexact), closer = w_fnma(from, scale, inexact);
    const w_m down = w_lt(v->inverse, zero);
    const w_f lower_from = middle - farther, lower_to = w_select(both, middle + closer, middle + farther);
    const w_f upper_from = middle - closer, upper_to = middle + farther;
    const w_near first = w_unfold(&f, triangle, w_select(w_and(both, down), upper_from, lower_from),
                                  w_select(w_and(both, down), upper_to, lower_to));
    w_near second = w_unfold(&f, triangle, w_select(down, lower_from, upper_from), w_select(down, lower_to, upper_to));
    second.none = w_or(second.none, w_andnot(stuck, both));

    const w_m left = w_andnot(stuck, w_or(none, w_and(first.none, second.none)));
    const w_m two = w_andnot(w_andnot(left, first.none), second.none);
    const w_f limit = w_set(0.75f) * v->radius;
    const w_m shrinks =
        w_and(w_or(first.none, w_lt(first.radius, limit)), w_or(second.none, w_lt(second.radius, limit)));
    const w_m live = w_andnot(w_and(left, shrinks), w_and(two, v->more));
    v->live = w_or(v->live, live);
    v->slow = w_or(v->slow, w_andnot(left, live));
    v->s = w_select(stuck, w_select(first.none, second.s, first.s), v->s);
    v->t = w_select(stuck, w_select(first.none, second.t, first.t), v->t);
    v->radius = w_select(stuck, w_select(first.none, second.radius, first.radius), v->radius);
    const w_m store = w_and(two, live);
    v->more = w_or(v->more, store);
    v->other_s = w_select(store, second.s, v->other_s);
    v->other_t = w_select(store, second.t, v->other_t);
    v->other_radius = w_select(store, second.radius, v->other_radius);
}

/* Lanes that are done with their neighbourhood and have another go on with that. */
EP_INLINE void w_other(w_visit *v, w_m done)
{
    const w_m next = w_andnot(w_and(done, v->more), w_or(v->live, v->slow));
    v->s = w_select(next, v->other_s, v->s);
    v->t = w_select(next, v->other_t, v->t);
    v->radius = w_select(next, v->other_radius, v->radius);
    v->live = w_or(v->live, next);
    v->more = w_andnot(v->more, next);
}
