/* fold_tmpl.h - a nearly tangent ray: two small neighbourhoods for a large one, by a quadratic equation.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Where a ray is nearly tangent F folds the leaf over: along the ray's way J is almost singular, there may be two
 * roots, and no neighbourhood that holds both shrinks. But F is nearly singular in that one direction only. With A = I
 * + R the part of J without the ray, g the height's gradient and H the second derivatives at y, all roots y + d in the
 * neighbourhood |d| <= e of y satisfy, tau being the height above the moved origin at which the ray meets them,
 *
 *     A d = p tau - S_st(y) + o_st - H_st d²/2 - rho_st,      tau = S_h(y) - o_h + g d + H_h d²/2 + rho_h,
 *
 * |rho| <= warp |d|²/2 + noise, warp = twist e and the rounding of H. Let tau0 be where the ray comes closest to y's
 * foot, and tau = tau0 + x. A is nearly I. So d = l + q with l = d0 + a x, a = A^-1 p, d0 = -A^-1 f, f = (S - o)_st -
 * p tau0, and |q| <= |A^-1| (bend_st |d|²/2 + noise_st), which is Q for |d| = e. Put into the second equation, with
 * b = g A^-1 and K = H_h - b H_st,
 *
 *     |c0 + c1 x + c2 x²| <= N + W |d|²/2,
 *     c0 = (S - o)_h - tau0 - b f + K d0²/2,  c1 = g a - 1 + K d0 a,  c2 = K a²/2,
 *     W = warp_h + |b| warp_st + |K| |A^-1| bend_st (e + 3/2 Q),  N = noise_h + |b| noise_st + what noise_st does in W,
 *
 * because K (d² - l²)/2 is K l q + K q²/2, and |l| <= |d| + |q|. And |d| is at most (|l| + |A^-1| noise_st) / (1 - z),
 * z = |A^-1| bend_st e/2; so with W' = W/(1 - z)², from (k + l)² <= 5/4 k² + 5 l²,
 *
 *     W |d|²/2 <= 5/8 W' |a|² x² + 5/2 W' (|d0| + |A^-1| noise_st)²,
 *
 * small where the ray is near y, as the quadratic equation itself: tangent and all but tangent rays are told apart at
 * once. Where c2 is not much larger than 5/8 W' |a|², W e²/2 has to do. That is no x at all, and the ray is certain to
 * miss; one interval; or two, and then, with x at an interval's middle and h half its length,
 *
 *     |d - l| <= |a| h + Q,   and with q2 = -A^-1 H_st l²/2
 *     |d - (l + q2)| <= |a| h (1 + |A^-1| bend_st (e + Q + |a| h/2))
 *                       + |A^-1| (warp_st e²/2 + noise_st + bend_st Q (e + 3/2 Q)),
 *
 * for l there is within |a| h of the root's. Intervals end where l leaves the domain or the old neighbourhood by more
 * than Q, and where that ends along the ray. If one is left that is no smaller it is halved. */

/* K x y of a quadratic form. */
EP_INLINE w_f w_form(const w_f k[3], const w_f x[2], const w_f y[2])
{
    return w_fma(k[2], x[1] * y[1], w_fma(k[1], w_fma(x[0], y[1], x[1] * y[0]), k[0] * (x[0] * y[0])));
}

/* Parts of a ray's way; `two`: from[1] to to[1] is another. */
typedef struct w_parts {
    w_f from[2], to[2];
    w_m none, two;
} w_parts;

/* Where |c0 + c1 x + c2 x²| <= p + w x², w < |c2| or zero: c2 > 0 given, between the roots of c0 - p + c1 x + (c2 - w)
 * x², but not between those of c0 + p + c1 x + (c2 + w) x². The parts in ascending order, or descending. */
EP_INLINE w_parts w_quadratic(w_f c0, w_f c1, w_f c2, w_f p, w_f w, w_m descending)
{
    w_parts r;
    const w_f zero = w_set(0.0f), one = w_set(1.0f), little = w_set(0x1p-20f);
    const w_m falls = w_lt(c2, zero);
    const w_f size = w_abs(c2), least = (size - w) + (size - w), most = (size + w) + (size + w);
    c0 = w_select(falls, -c0, c0);
    c1 = w_select(falls, -c1, c1);
    const w_f outer = w_fnma(least + least, c0 - p, c1 * c1), inner = w_fnma(most + most, c0 + p, c1 * c1);
    const w_f wide = w_sqrt(w_max(outer, zero)), narrow = w_sqrt(w_max(inner, zero)), c = w_abs(c1);
    const w_f by_least = one / least, by_most = one / most;
    const w_f inexact = little * ((wide + c) * by_least);
    const w_f first = w_fnma(wide + c1, by_least, -inexact), last = w_fma(wide - c1, by_least, inexact);
    const w_f gap = w_fma(-narrow - c1, by_most, inexact), end = w_fma(narrow - c1, by_most, -inexact);
    r.none = w_lt(outer, zero);
    r.two = w_lt(zero, inner);
    const w_m turned = w_and(r.two, descending);
    r.from[0] = w_select(turned, end, first);
    r.to[0] = w_select(r.two, w_select(descending, last, gap), last);
    r.from[1] = w_select(descending, first, end);
    r.to[1] = w_select(descending, gap, last);
    return r;
}

/* A neighbourhood: all roots are within `radius` of (s, t), and between these heights above the moved origin. */
typedef struct w_near {
    w_f s, t, radius, first, last;
    w_m none; /* certainly no root there */
} w_near;

/* The one that a ray is at. */
EP_INLINE w_near w_here(const w_visit *v)
{
    return (w_near){v->s, v->t, v->radius, v->first, v->last, w_mask(0)};
}

/* What the neighbourhoods of both parts share. */
typedef struct w_folded {
    w_f s, t, e;                   /* the old neighbourhood     */
    w_f near, from, to;            /* tau0, all of the way      */
    w_f a[2], d0[2];               /* l                         */
    w_f bend[2][3];                /* A^-1 H_st / 2             */
    w_f along, q;                  /* radius = along h + q about l ...                       */
    w_f per_square, per_tau, rest; /* ... or per_square h² + per_tau h + rest about l + q2   */
} w_folded;

EP_INLINE w_near w_unfold(const w_folded *f, int triangle, w_f from, w_f to)
{
    w_near n;
    const w_f half = w_set(0.5f);
    from = w_max(from, f->from);
    to = w_min(to, f->to);
    const w_f x = half * (from + to), h = w_fma(half, to - from, w_set(0x1p-20f) * (w_abs(from) + w_abs(to)));
    const w_f l[2] = {w_fma(f->a[0], x, f->d0[0]), w_fma(f->a[1], x, f->d0[1])};
    const w_f straight = w_fma(f->along, h, f->q), curved = w_fma(w_fma(f->per_square, h, f->per_tau), h, f->rest);
    const w_m curve = w_lt(curved, straight);
    const w_f d_s = w_select(curve, l[0] - w_form(f->bend[0], l, l), l[0]);
    const w_f d_t = w_select(curve, l[1] - w_form(f->bend[1], l, l), l[1]);
    const w_f ends = w_set(0x1p-20f) * (w_abs(f->near) + w_max(w_abs(from), w_abs(to)));
    n.first = (f->near + from) - ends;
    n.last = (f->near + to) + ends;
    n.s = f->s + d_s;
    n.t = f->t + d_t;
    n.radius = w_min(straight, curved);
    if (triangle) n.radius = n.radius + n.radius;
    n.none = w_or(w_lt(to, from), w_or(w_lt(n.radius, w_outside(triangle, n.s, n.t)),
                                       w_lt(f->e + n.radius, w_max(w_abs(d_s), w_abs(d_t)))));
    w_clamp(triangle, &n.s, &n.t);
    return n;
}

/* Neighbourhoods that wait, the next one first: no more of them than the steps in which one may be divided. */
#define EP_WAITING 3
typedef struct w_stack {
    w_near near[EP_WAITING];
    w_f parts[EP_WAITING];
    w_m full[EP_WAITING];
} w_stack;

EP_INLINE w_stack w_empty(void)
{
    w_stack wait;
    const w_f zero = w_set(0.0f);
    for (int k = 0; k < EP_WAITING; ++k) {
        wait.near[k] = (w_near){zero, zero, zero, zero, zero, w_mask(0)};
        wait.parts[k] = zero;
        wait.full[k] = w_mask(0);
    }
    return wait;
}

EP_INLINE w_near w_choose(w_m m, const w_near *a, const w_near *b)
{
    return (w_near){w_select(m, a->s, b->s),           w_select(m, a->t, b->t),
                    w_select(m, a->radius, b->radius), w_select(m, a->first, b->first),
                    w_select(m, a->last, b->last),     w_or(w_and(m, a->none), w_andnot(b->none, m))};
}

/* The lanes in `on` are at `near`. */
EP_INLINE void w_be_at(w_visit *v, const w_near *near, w_f parts, w_m on)
{
    v->live = w_or(v->live, on);
    v->s = w_select(on, near->s, v->s);
    v->t = w_select(on, near->t, v->t);
    v->radius = w_select(on, near->radius, v->radius);
    v->first = w_select(on, near->first, v->first);
    v->last = w_select(on, near->last, v->last);
    v->parts = w_select(on, parts, v->parts);
}

/* The lanes in `open` go on with what is in `near`; where that is two neighbourhoods, with the first. Those that have
 * been divided too often are slow. */
EP_INLINE void w_go_on(w_visit *v, w_stack *wait, const w_near near[2], w_m open)
{
    const w_m two = w_andnot(w_andnot(open, near[0].none), near[1].none);
    const w_m over = w_and(two, w_le(w_set(EP_WAITING), v->parts)), push = w_andnot(two, over);
    const w_near next = w_choose(near[0].none, &near[1], &near[0]);
    const w_f parts = w_select(push, v->parts + w_set(1.0f), v->parts);
    v->slow = w_or(v->slow, over);
    w_be_at(v, &next, parts, w_andnot(open, over));
    if (!w_bits(push)) return;
    for (int k = EP_WAITING - 1; k > 0; --k) {
        wait->near[k] = w_choose(push, &wait->near[k - 1], &wait->near[k]);
        wait->parts[k] = w_select(push, wait->parts[k - 1], wait->parts[k]);
        wait->full[k] = w_or(w_and(push, wait->full[k - 1]), w_andnot(wait->full[k], push));
    }
    wait->near[0] = w_choose(push, &near[1], &wait->near[0]);
    wait->parts[0] = w_select(push, parts, wait->parts[0]);
    wait->full[0] = w_or(wait->full[0], push);
}

/* Takes the next one away, where it is in `pop`. */
EP_INLINE void w_pop(w_stack *wait, w_m pop)
{
    for (int k = 0; k < EP_WAITING; ++k) {
        const int from = k + 1 < EP_WAITING ? k + 1 : k;
        wait->near[k] = w_choose(pop, &wait->near[from], &wait->near[k]);
        wait->parts[k] = w_select(pop, wait->parts[from], wait->parts[k]);
        wait->full[k] = w_or(from > k ? w_and(pop, wait->full[from]) : w_mask(0), w_andnot(wait->full[k], pop));
    }
}

/* Those in `done` that have no neighbourhood any more go on with the next one. */
EP_INLINE void w_next(w_visit *v, w_stack *wait, w_m done)
{
    const w_m pop = w_andnot(w_and(done, wait->full[0]), w_or(v->live, v->slow));
    if (!w_bits(pop)) return;
    w_be_at(v, &wait->near[0], wait->parts[0], pop);
    w_pop(wait, pop);
}

/* Both are smaller than `limit`, or have no root. */
EP_INLINE w_m w_shrinks(const w_near near[2], w_f limit)
{
    return w_and(w_or(near[0].none, w_lt(near[0].radius, limit)), w_or(near[1].none, w_lt(near[1].radius, limit)));
}

/* For the lanes in `stuck`, whose neighbourhood `here` does not shrink, `j` being the jet there: goes on with what is
 * left of it, the nearer part along the ray first. If that is one part and does not shrink it is halved. Lanes without
 * any leave; those that this does not help are slow. */
EP_INLINE void w_fold(const ep_leaf *leaf, w_visit *v, w_stack *wait, int triangle, const w_near *here,
                      const w_surface *j, w_m stuck)
{
    const w_f zero = w_set(0.0f), one = w_set(1.0f), half = w_set(0.5f), outward = w_set(EP_OUTWARD);
    const w_f little = w_set(0x1p-20f);
    w_folded f = {.s = here->s, .t = here->t, .e = here->radius};
    const w_f inverse = one / w_fnma(j->dt.x, j->ds.y, j->ds.x * j->dt.y), size = w_abs(inverse);
    const w_f i = w_max(w_abs(j->dt.y) + w_abs(j->dt.x), w_abs(j->ds.y) + w_abs(j->ds.x)) * size * outward;
    /* where the ray comes nearest to y's foot */
    const w_f per = one / w_fma(v->p_t, v->p_t, v->p_s * v->p_s);
    const w_f near = w_fma(v->p_t, j->at.y, v->p_s * j->at.x) * per;
    const w_f beside_s = w_fnma(v->p_s, near, j->at.x), beside_t = w_fnma(v->p_t, near, j->at.y);
    f.a[0] = w_fnma(j->dt.x, v->p_t, j->dt.y * v->p_s) * inverse;
    f.a[1] = w_fnma(j->ds.y, v->p_s, j->ds.x * v->p_t) * inverse;
    f.d0[0] = w_fnma(j->dt.y, beside_s, j->dt.x * beside_t) * inverse;
    f.d0[1] = w_fnma(j->ds.x, beside_t, j->ds.y * beside_s) * inverse;
    const w_f b_s = w_fnma(j->dt.z, j->ds.y, j->ds.z * j->dt.y) * inverse;
    const w_f b_t = w_fnma(j->ds.z, j->dt.x, j->dt.z * j->ds.x) * inverse;
    const w_f b = (w_abs(b_s) + w_abs(b_t)) * outward;
    w_f k[3];
    const w_3 form[3] = {j->ss, {half * j->st.x, half * j->st.y, half * j->st.z}, j->tt};
    for (int c = 0; c < 3; ++c) {
        const w_f s = form[c].x, t = form[c].y;
        k[c] = w_fnma(b_t, t, w_fnma(b_s, s, form[c].z));
        f.bend[0][c] = w_fnma(j->dt.x, t, j->dt.y * s) * inverse;
        f.bend[1][c] = w_fnma(j->ds.y, s, j->ds.x * t) * inverse;
    }
    const w_f c0 = w_form(k, f.d0, f.d0) + w_fnma(b_t, beside_t, w_fnma(b_s, beside_s, j->at.z - near));
    const w_f mixed = w_form(k, f.d0, f.a);
    const w_f c1 = (mixed + mixed) + w_fma(j->ds.z, f.a[0], w_fma(j->dt.z, f.a[1], -one));
    const w_f c2 = w_form(k, f.a, f.a), curved = (w_abs(k[0]) + w_abs(k[2]) + w_abs(k[1] + k[1])) * (outward + outward);

    /* tangents err by no more than twice the degree times what the point does */
    const w_f wide = w_fma(w_set(2.0f * (float)(leaf->degree_s + leaf->degree_t)), f.e, one) * outward;
    const w_f noise_st = wide * v->noise_st, noise_h = wide * v->noise_h;
    const w_f bend_st = w_set(leaf->bend_st);
    const w_f a = w_max(w_abs(f.a[0]), w_abs(f.a[1])), d0 = w_max(w_abs(f.d0[0]), w_abs(f.d0[1]));

    /* l is within q of the domain, and of the old neighbourhood */
    w_f q = i * w_fma(bend_st, half * outward * (f.e * f.e), noise_st);
    f.near = near;
    f.from = here->first - near;
    f.to = here->last - near;
    const w_f slack = q + w_fma(little, d0, little);
    w_clip_domain(triangle, f.s + f.d0[0], f.t + f.d0[1], f.a[0], f.a[1], slack, &f.from, &f.to);
    w_clip_slab(f.d0[0], f.a[0], -f.e - slack, f.e + slack, &f.from, &f.to);
    w_clip_slab(f.d0[1], f.a[1], -f.e - slack, f.e + slack, &f.from, &f.to);
    const w_f ends[2][2] = {{w_abs(w_fma(f.a[0], f.from, f.d0[0])), w_abs(w_fma(f.a[1], f.from, f.d0[1]))},
                            {w_abs(w_fma(f.a[0], f.to, f.d0[0])), w_abs(w_fma(f.a[1], f.to, f.d0[1]))}};
    const w_f l_max = w_max(w_max(ends[0][0], ends[0][1]), w_max(ends[1][0], ends[1][1])) * outward;
    f.e = w_min(l_max + q, f.e);
    const w_f half_e2 = half * outward * (f.e * f.e);
    const w_f warp_st = w_fma(w_set(leaf->twist_st), f.e, w_set(leaf->bend_st * EP_CURVE));
    const w_f warp_h = w_fma(w_set(leaf->twist_h), f.e, w_set(leaf->bend_h * EP_CURVE));
    q = i * w_fma(bend_st, half_e2, noise_st);
    const w_f most = w_fma(w_set(1.5f), q, f.e) * outward, cross = q * most;
    f.along = a * outward;
    f.q = q;
    f.rest = i * w_fma(bend_st, cross, w_fma(warp_st, half_e2, noise_st));
    const w_f reach = f.e + q;
    f.per_tau = a * w_fma(i * bend_st, reach, one) * outward;
    f.per_square = half * outward * (i * bend_st) * (a * a);
    /* what rounding adds to the equation: each of a dozen terms is below one of these */
    const w_f along = d0 + reach, l = along + d0;
    const w_f at = w_fma(v->p_max, w_abs(near), w_max(w_abs(j->at.x), w_abs(j->at.y)));
    const w_f terms = w_fma(curved * l, l, w_abs(j->at.z) + w_abs(near)) +
                      w_fma(w_fma(curved, i * l, b), at, along * (b + b + one / a));

    const w_f warp = w_fma(curved * i * bend_st, most, w_fma(b, warp_st, warp_h));
    const w_f error = w_fma(curved * i * noise_st, most, w_fma(b, noise_st, noise_h)) + little * terms;
    const w_f z = i * bend_st * (half * f.e), grow = w_fma(z, w_set(2.0f), one); /* 1 / (1 - z) is less, if z <= 1/2 */
    const w_f strong = warp * grow * grow * outward;
    const w_f w2 = w_set(0.625f) * strong * (a * a), off = w_fma(i, noise_st, d0);
    const w_m relative = w_and(w_lt(z, half), w_lt(w2, w_set(0.75f) * w_abs(c2)));
    const w_f p = w_select(relative, w_fma(w_set(2.5f) * strong, off * off, error), w_fma(warp, half_e2, error));
    const w_m descending = w_lt(v->inverse, zero);
    const w_parts parts = w_quadratic(c0, c1, c2, p, w_select(relative, w2, zero), descending);
    w_near both[2] = {w_unfold(&f, triangle, parts.from[0], parts.to[0]),
                      w_unfold(&f, triangle, parts.from[1], parts.to[1])};
    both[1].none = w_or(both[1].none, w_andnot(stuck, parts.two));
    w_m left = w_andnot(stuck, w_or(parts.none, w_and(both[0].none, both[1].none)));
    const w_f limit = w_set(0.75f) * here->radius;
    w_m shrinks = w_shrinks(both, limit);
    const w_m alone = w_andnot(w_andnot(left, shrinks), w_andnot(w_andnot(left, both[0].none), both[1].none));
    if (w_bits(alone)) {
        const w_f from = w_max(w_select(both[0].none, parts.from[1], parts.from[0]), f.from);
        const w_f to = w_min(w_select(both[0].none, parts.to[1], parts.to[0]), f.to), middle = half * (from + to);
        const w_near lower = w_unfold(&f, triangle, from, middle), upper = w_unfold(&f, triangle, middle, to);
        const w_near nearer = w_choose(descending, &upper, &lower), other = w_choose(descending, &lower, &upper);
        both[0] = w_choose(alone, &nearer, &both[0]);
        both[1] = w_choose(alone, &other, &both[1]);
        shrinks = w_shrinks(both, limit);
        left = w_andnot(left, w_and(both[0].none, both[1].none));
    }
    v->slow = w_or(v->slow, w_andnot(left, shrinks));
    w_go_on(v, wait, both, w_and(left, shrinks));
}
