/* approach_tmpl.h - a nearly tangent ray's way through a leaf's prism.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Such a ray meets the leaf's plane far from the leaf, or never, and is long between the prism's two parallel planes.
 * So its origin is moved to where it is nearest to the leaf's middle, and its way is what all of the prism leaves,
 * never longer than that is wide: what rounding of the direction adds to F grows with the way. */

/* Narrows [*from, *to] to where x + k d is between `low` and `high`. */
EP_INLINE void w_clip_slab(w_f x, w_f d, w_f low, w_f high, w_f *from, w_f *to)
{
    /* along the slab, or all but, the quotients say nothing and all of the way is kept */
    const w_m across = w_lt(w_set(0x1p-100f), w_abs(d));
    const w_f inverse = w_set(1.0f) / d, a = (low - x) * inverse, b = (high - x) * inverse;
    *from = w_select(across, w_max(w_min(a, b), *from), *from);
    *to = w_select(across, w_min(w_max(a, b), *to), *to);
}

/* ... and to where (s + k ds, t + k dt) is within `margin` of the domain. */
EP_INLINE void w_clip_domain(int triangle, w_f s, w_f t, w_f ds, w_f dt, w_f margin, w_f *from, w_f *to)
{
    const w_f edge = w_set(triangle ? EP_THIRD : EP_HALF) + margin;
    const w_f high = triangle ? edge + edge : edge;
    w_clip_slab(s, ds, -edge, high, from, to);
    w_clip_slab(t, dt, -edge, high, from, to);
    if (triangle) w_clip_slab(s + t, ds + dt, -high, edge + margin, from, to);
}

/* A direction without height gets this part of its length. */
#define EP_LEVEL 0x1p-40f

/* Beyond these lengths of a direction, in leaf coordinates, its terms or what is made of it may over- or underflow. */
#define EP_SHORTEST 0x1p-80f
#define EP_LONGEST 0x1p80f

/* Where a ray is in the prism, from tnear on: between `from` and `to`, in t relative to where its origin is moved. */
typedef struct w_way {
    w_f from, to;
    w_3 d; /* its direction in leaf coordinates */
} w_way;

/* May rounding have taken a hit's t, which is a rest of what the origin was moved by, out of the prism, as it may where
 * the leaf is flat? It is found again in double: the same ray, if it ends right behind the hit, has to enter the leaf.
 */
EP_INLINE w_m w_is_astray(const ep_leaf *leaf, const w_visit *v)
{
    return w_lt(w_set(leaf->height) * w_abs(v->inverse), w_set(EP_TERMS) * w_abs(v->moved));
}

/* Sums of the magnitudes that make up the leaf coordinates of x. */
EP_INLINE void w_terms(const ep_leaf *leaf, const w_f x[3], w_f sum[3])
{
    for (int c = 0; c < 3; ++c)
        sum[c] =
            w_fma(w_set(fabsf(leaf->frame[2][c])), w_abs(x[2]),
                  w_fma(w_set(fabsf(leaf->frame[1][c])), w_abs(x[1]), w_set(fabsf(leaf->frame[0][c])) * w_abs(x[0])));
}

/* Lanes are slow where leaf coordinates are mostly rounding, or directions out of range.
 *
 * How far the origin is moved may be rounded, but the point there is right to two roundings of itself, and to those of
 * what w_move puts back. From there a root in the prism is at |t| <= (extent + |o| + noise) / (|d| - its rounding) in
 * the coordinate that the direction is longest in, below `limit` if rounding is at most |d| / 32 and the noise extent
 * / 64.
 */
EP_INLINE w_visit w_approach(const ep_leaf *leaf, int triangle, const w_rays *r, w_m active, w_way *way)
{
    const float room = ep_leaf_room(leaf, triangle), extent = room > leaf->height ? room : leaf->height;
    const w_f one = w_set(1.0f);
    const w_3 far = w_origin(leaf, r);
    w_3 d = w_to_leaf(leaf, r->dir);
    w_visit v;

    const w_f size = w_max(w_max(w_abs(d.x), w_abs(d.y)), w_abs(d.z)), over = one / size;
    const w_3 e = {d.x * over, d.y * over, d.z * over};
    const w_f ee = w_fma(e.z, e.z, w_fma(e.y, e.y, e.x * e.x));
    v.moved = -w_fma(far.z, e.z, w_fma(far.y, e.y, far.x * e.x)) / ee * over;
    v.o = w_move(leaf, r, v.moved);
    const w_f o = w_max(w_max(w_abs(v.o.x), w_abs(v.o.y)), w_abs(v.o.z)), reach = w_set(extent) + o;
    const w_f limit = w_set(1.0625f) * reach * over;
    /* What rounding adds to a unit of way: 3 eps of the terms of d, two of what is along the leaf in p, and 5 for the
     * moved origin, which is on the way; the leaf's noise takes it for the hit. */
    w_f terms[3];
    w_terms(leaf, r->dir, terms);
    const w_f per_st = w_set(10 * 0x1p-24f) * w_max(terms[0], terms[1]), per_h = w_set(0x1p-21f) * terms[2];
    w_f low[3];
    for (int c = 0; c < 3; ++c)
        low[c] = w_set(0x1p-23f) * w_fma(w_set(0x1p-24f), w_abs(r->o[c]), w_set(fabsf(leaf->centre_low[c])));
    w_terms(leaf, low, terms);
    /* the leaf's noise takes the origin for one in its plane; and a direction may be made less level */
    const w_f noise_st = w_set(leaf->noise_st) + w_max(terms[0], terms[1]);
    const w_f noise_h =
        w_fma(w_set(2 * EP_LEVEL), reach, w_fma(w_set(0x1p-21f), w_abs(v.o.z), w_set(leaf->noise_h))) + terms[2];
    const w_m sane = w_and(w_and(w_le(w_set(32.0f) * w_max(per_st, per_h), size),
                                 w_le(w_set(64.0f) * w_max(noise_st, noise_h), w_set(extent))),
                           w_and(w_le(w_set(EP_SHORTEST), size), w_le(size, w_set(EP_LONGEST))));
    v.live = w_and(active, sane);
    v.slow = w_andnot(active, sane);

    /* rounding of quotients is as that of what is divided */
    const w_f little = w_set(EP_TERMS) * reach;
    const w_f astray = w_abs(w_fma(v.o.z, e.z, w_fma(v.o.y, e.y, v.o.x * e.x))) * over, most = limit + astray;
    const w_f side = w_fma(per_st, most, w_set(ep_leaf_side(leaf, triangle)) + noise_st) + little;
    const w_f height = w_fma(per_h, most, w_set(leaf->height) + noise_h) + little;
    way->from = -limit;
    way->to = limit;
    w_clip_slab(v.o.z, d.z, -height, height, &way->from, &way->to);
    w_clip_domain(triangle, v.o.x, v.o.y, d.x, d.y, side, &way->from, &way->to);
    way->from = w_max((r->tnear - v.moved) - w_set(EP_TERMS) * (w_abs(r->tnear) + w_abs(v.moved)), way->from);
    v.live = w_andnot(v.live, w_lt(way->to, way->from));

    const w_f longest = w_max(w_abs(way->from), w_abs(way->to)) + astray;
    v.noise_st = w_fma(per_st, longest, noise_st);
    v.noise_h = w_fma(per_h, longest, noise_h);
    const w_f least = w_set(EP_LEVEL) * size;
    d.z = w_select(w_lt(w_abs(d.z), least), least, d.z);
    v.inverse = one / d.z;
    v.p_s = d.x * v.inverse;
    v.p_t = d.y * v.inverse;
    v.p_max = w_max(w_abs(v.p_s), w_abs(v.p_t));
    v.way = v.far = v.radius = v.first = v.last = v.parts = w_set(0.0f);
    v.tnear = r->tnear;
    v.tfar = r->tfar;
    v.s = v.o.x;
    v.t = v.o.y;
    way->d = d;
    return v;
}
