/* leave_tmpl.h - rays that start on a leaf, or a little above it, and leave it: shadow rays, and what bounces.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * They cross the surface just before they start, or are nearly tangent there, and the graph's equation, which is right
 * to `graph` only, cannot tell whether that is before or behind. The surface under the start can, at half of what an
 * iteration costs. Let P be the point at tnear, d the direction, y the leaf's point near P's foot, f = S(y) - P and n =
 * S_s x S_t there. The leaf deviates from the plane that touches it at y by at most
 *
 *     n (S(y + x) - S(y)) <= B |x|²,   B = (n_h bend_h + (|n_s| + |n_t|) bend_st) / 2,
 *
 * and a hit at P + k d over y + x has |x| <= (k |d_st| + |f_st|) / (1 - stretch), for x + r_st(x) moves at least by 1 -
 * stretch times what x does. So with gap = -n f, rise = n d there is none, for k from 0 to `last`, if
 *
 *     gap + k rise > B (k |d_st| + |f_st|)² / (1 - stretch)²
 *
 * at both ends, the right side being convex. And beyond `last` there is none because there the graph's equation has
 * c0 + c1 k + c2 k² > graph, up to where the ray has left the prism. A ray that starts below goes down: all signs
 * change. */

/* Directions that are longer or shorter in leaf coordinates are left to others: their squares may be no floats. */
#define EP_SHORT 0x1p-40f
#define EP_LONG 0x1p40f

/* Bounds are computed in the arithmetic whose rounding they bound: this much is added. */
#define EP_OUTWARD (1 + 0x1p-10f)

/* How far apart points of the leaf are when their feet are one apart; infinite where the parametrisation may fold. */
static inline float ep_leaf_apart(const ep_leaf *leaf)
{
    const float left = 1 - ep_leaf_stretch(leaf);
    return left > 0 ? EP_OUTWARD / left : INFINITY;
}

/* Those that this is worth a try for: where they start is in the prism, more or less. */
EP_INLINE w_m w_starts_within(const ep_leaf *leaf, int triangle, w_3 o, w_3 d, w_f tnear)
{
    const w_f rim = w_set(triangle ? 2 * leaf->rim : leaf->rim);
    const w_m st = w_and(w_le(w_abs(w_fma(tnear, d.x, o.x)), rim), w_le(w_abs(w_fma(tnear, d.y, o.y)), rim));
    return w_and(st, w_le(w_abs(w_fma(tnear, d.z, o.z)), w_set(leaf->height)));
}

/* The rays that miss the leaf for that reason: P = p, their directions' sum norms being d_sum. */
EP_INLINE w_m w_leaves(const ep_leaf *leaf, const float *net, w_3 p, w_3 d, w_f d_sum, int triangle, unsigned m,
                       unsigned n, int rational)
{
    const w_f zero = w_set(0.0f), outward = w_set(EP_OUTWARD), graph = w_set(leaf->graph * EP_OUTWARD);
    const w_f room = w_set(ep_leaf_room(leaf, triangle));
    const w_f level = w_max(w_abs(d.x), w_abs(d.y)), size = w_max(level, w_abs(d.z));
    const w_f per = w_set(2 * leaf->reach) * d_sum; /* what a direction is right to */

    /* where the model has the ray above the graph */
    w_f by_s, by_t, way_s, way_t;
    w_visit v = {.o = p};
    w_form_of(leaf, 0, p.x, p.y, &by_s, &by_t);
    v.s = w_fnma(by_t, p.y, w_fnma(by_s, p.x, p.x));
    w_form_of(leaf, 1, p.x, p.y, &by_s, &by_t);
    v.t = w_fnma(by_t, p.y, w_fnma(by_s, p.x, p.y));
    w_clamp(triangle, &v.s, &v.t);
    w_form_of(leaf, 2, p.x, p.y, &by_s, &by_t);
    w_form_of(leaf, 2, d.x, d.y, &way_s, &way_t);
    const w_f mixed = w_fma(way_t, p.y, way_s * p.x), slope = d.z - (mixed + mixed);
    const w_f height = w_fnma(by_t, p.y, w_fnma(by_s, p.x, p.z - w_set(leaf->middle)));
    const w_f turn = w_fma(way_t, d.y, way_s * d.x);
    const w_m down = w_lt(slope, zero);
    const w_f c0 = w_select(down, -height, height), c1 = w_abs(slope) - per, c2 = w_select(down, turn, -turn);
    const w_f below = w_max(graph - c0, zero), four = (c2 + c2) + (c2 + c2), d2 = w_fma(four, below, c1 * c1);
    const w_f last = (below + below) / (c1 + w_sqrt(w_max(d2, zero)));
    const w_f far = room + w_max(w_abs(p.x), w_abs(p.y)), square = level * level;
    const w_f beyond = w_fma(c0, square, far * w_fma(c2, far, c1 * level)); /* at k = far / level, times that² */
    const w_m clear = w_or(w_le(zero, c2), w_lt(graph * square, beyond));
    const w_m sane = w_and(w_le(w_set(EP_SHORT), size), w_le(size, w_set(EP_LONG)));

    /* the plane that touches it */
    const w_surface j = w_surface_at(net, &v, triangle, m, n, rational);
    const w_3 normal = w_cross(j.ds, j.dt);
    const w_f n_s = normal.x, n_t = normal.y, n_h = normal.z, n_st = w_abs(n_s) + w_abs(n_t);
    const w_f f = w_fma(n_s, j.at.x, w_fma(n_t, j.at.y, n_h * j.at.z)), gap = w_select(down, f, -f);
    const w_f up = w_fma(n_s, d.x, w_fma(n_t, d.y, n_h * d.z)), rise = w_fnma(n_h + n_st, per, w_select(down, -up, up));
    const w_f bend = w_fma(n_h, w_set(0.5f * leaf->bend_h), n_st * w_set(0.5f * leaf->bend_st));
    const w_f apart = w_set(ep_leaf_apart(leaf));
    const w_f off = (w_max(w_abs(j.at.x), w_abs(j.at.y)) + w_set(2 * leaf->noise_st)) * apart;
    const w_f e = w_fma(last * apart, level + per, off);
    /* that of the origin's parts, and of tangents: no more than twice the degree times what the point errs by */
    const w_f wide = w_fma(w_set(2.0f * (float)(leaf->degree_s + leaf->degree_t)), e, w_set(2.0f));
    const w_f noise = w_fma(n_h, w_set(leaf->noise_h), n_st * w_set(leaf->noise_st)) * wide;
    const w_m first = w_lt(w_fma(bend * off, off, noise) * outward, gap);
    const w_m then = w_lt(w_fma(bend * e, e, noise) * outward, w_fma(last, rise, gap));
    return w_and(w_and(w_and(sane, clear), w_and(w_lt(zero, c1), w_le(zero, d2))),
                 w_and(w_lt(zero, n_h), w_and(first, then)));
}

EP_INLINE bool f4_starts_within(const ep_leaf *leaf, int triangle, f4 o, f4 d, float tnear)
{
    const f4 box = f4_load(&leaf->rim), rim = f4_lane(box, 0), height = f4_lane(box, 1);
    return !(f4_lt(f4_third(triangle ? rim + rim : rim, height), f4_abs(f4_fma(f4_set(tnear), d, o))) & 7);
}

EP_INLINE bool f4_leaves(const ep_leaf *leaf, const float *net, f4 p, f4 d, float d_sum, int triangle, unsigned m,
                         unsigned n, int rational)
{
    const float graph = leaf->graph * EP_OUTWARD;
    const float room = ep_leaf_room(leaf, triangle);
    const float level = f4_norm(d), size = f1_max(level, f1_abs(d[2])), per = (2 * leaf->reach) * d_sum;

    const f4 ss = f4_load(leaf->half[0]), st = f4_load(leaf->half[1]), tt = f4_load(leaf->half[2]);
    const f4 s = f4_lane(p, 0), t = f4_lane(p, 1), d_s = f4_lane(d, 0), d_t = f4_lane(d, 1);
    const f4 by_s = f4_fma(st, t, ss * s), by_t = f4_fma(tt, t, st * s);
    const f4 way_s = f4_fma(st, d_t, ss * d_s), way_t = f4_fma(tt, d_t, st * d_s);
    const f4 over = f4_fnma(by_t, t, f4_fnma(by_s, s, f4_third(p, p - f4_set(leaf->middle))));
    const f4 y = f4_clamp(triangle, over), mixed = f4_fma(way_t, t, way_s * s), turn = f4_fma(way_t, d_t, way_s * d_s);
    const float height = over[2], slope = d[2] - (mixed[2] + mixed[2]);
    const bool down = slope < 0;
    const float c0 = down ? -height : height, c1 = f1_abs(slope) - per, c2 = down ? turn[2] : -turn[2];
    const float below = f1_max(graph - c0, 0.0f), d2 = f1_fma((c2 + c2) + (c2 + c2), below, c1 * c1);
    const float last = (below + below) / (c1 + f1_sqrt(f1_max(d2, 0.0f)));
    const float far = room + f4_norm(p), square = level * level;
    const float beyond = f1_fma(c0, square, far * f1_fma(c2, far, c1 * level));
    if (!(c1 > 0 && d2 >= 0 && (c2 >= 0 || graph * square < beyond) && EP_SHORT <= size && size <= EP_LONG))
        return false;

    const f4_jet j = f4_surface_at(net, y, p, triangle, m, n, rational);
    const f4 normal = f4_cross(j.s, j.t);
    const float n_s = normal[0], n_t = normal[1], n_h = normal[2], n_st = f1_abs(n_s) + f1_abs(n_t);
    const float f = f1_fma(n_s, j.f[0], f1_fma(n_t, j.f[1], n_h * j.f[2])), gap = down ? f : -f;
    const float up = f1_fma(n_s, d[0], f1_fma(n_t, d[1], n_h * d[2])),
                rise = f1_fma(-(n_h + n_st), per, down ? -up : up);
    const float bend = f1_fma(n_h, 0.5f * leaf->bend_h, n_st * (0.5f * leaf->bend_st));
    const float apart = ep_leaf_apart(leaf), off = (f4_norm(j.f) + 2 * leaf->noise_st) * apart;
    const float e = f1_fma(last * apart, level + per, off);
    const float wide = f1_fma(2.0f * (float)(leaf->degree_s + leaf->degree_t), e, 2.0f);
    const float noise = f1_fma(n_h, leaf->noise_h, n_st * leaf->noise_st) * wide;
    return n_h > 0 && f1_fma(bend * off, off, noise) * EP_OUTWARD < gap &&
           f1_fma(bend * e, e, noise) * EP_OUTWARD < f1_fma(last, rise, gap);
}
