/* rays_tmpl.h - the rays of a packet, one a lane, in a leaf's coordinates, and the leaf's surface there.
 *
 * SPDX-License-Identifier: Apache-2.0 */

/* A vector of space in leaf coordinates. */
EP_INLINE w_3 w_to_leaf(const ep_leaf *leaf, const w_f *x)
{
    w_f r[3];
    for (int c = 0; c < 3; ++c)
        r[c] = w_fma(w_set(leaf->frame[2][c]), x[2],
                     w_fma(w_set(leaf->frame[1][c]), x[1], w_set(leaf->frame[0][c]) * x[0]));
    return (w_3){r[0], r[1], r[2]};
}

/* Rays, one a lane; o: org - centre, rounded. */
typedef struct w_rays {
    w_f org[3], dir[3], o[3], tnear, tfar;
} w_rays;

/* The next rays of a packet of `rays`, of which there are `left`. */
EP_INLINE w_rays w_load_rays(const ep_leaf *leaf, const float *ray, unsigned rays, unsigned left)
{
    w_rays r;
    for (unsigned c = 0; c < 3; ++c) {
        r.org[c] = w_load(ray + (EP_RAY_ORG + c) * rays, left);
        r.dir[c] = w_load(ray + (EP_RAY_DIR + c) * rays, left);
        r.o[c] = r.org[c] - w_set(leaf->centre[c]);
    }
    r.tnear = w_load(ray + EP_RAY_TNEAR * rays, left);
    r.tfar = w_load(ray + EP_RAY_TFAR * rays, left);
    return r;
}

/* The origin in leaf coordinates, roughly. */
EP_INLINE w_3 w_origin(const ep_leaf *leaf, const w_rays *r)
{
    w_f near[3];
    for (int c = 0; c < 3; ++c) near[c] = r->o[c] - w_set(leaf->centre_low[c]);
    return w_to_leaf(leaf, near);
}

/* The direction's sum norm. */
EP_INLINE w_f w_direction_sum(const w_rays *r)
{
    return (w_abs(r->dir[0]) + w_abs(r->dir[1])) + w_abs(r->dir[2]);
}

/* The origin moved by t, in leaf coordinates: right to two roundings of itself, however far the ray has come, because
 * the rounding of o = org - centre is put back (Knuth's two-sum). */
EP_INLINE w_3 w_move(const ep_leaf *leaf, const w_rays *r, w_f t)
{
    w_f moved[3];
    for (int c = 0; c < 3; ++c) {
        const w_f back = r->o[c] - r->org[c];
        const w_f low = ((r->org[c] - (r->o[c] - back)) - (w_set(leaf->centre[c]) + back)) - w_set(leaf->centre_low[c]);
        moved[c] = w_fma(t, r->dir[c], r->o[c]) + low;
    }
    return w_to_leaf(leaf, moved);
}

/* S - o at (v->s, v->t). A quotient P = N / W has P_s = (N_s - P W_s) / W, P_ss = (N_ss - 2 P_s W_s - P W_ss) / W. */
EP_INLINE w_surface w_surface_at(const float *net, const w_visit *v, int triangle, unsigned m, unsigned n, int rational)
{
    const int stride = rational ? 4 : 3;
    w_jet p[4];
    for (int c = 0; c < stride; ++c) p[c] = w_series(net + c, stride, triangle, m, n, v->s, v->t);
    if (rational) {
        const w_f inverse = w_set(1.0f) / p[3].f;
        for (int c = 0; c < 3; ++c) {
            p[c].f = p[c].f * inverse;
            p[c].s = w_fnma(p[c].f, p[3].s, p[c].s) * inverse;
            p[c].t = w_fnma(p[c].f, p[3].t, p[c].t) * inverse;
            p[c].ss = w_fnma(p[c].f, p[3].ss, w_fnma(p[c].s, p[3].s, p[c].ss)) * inverse;
            p[c].tt = w_fnma(p[c].f, p[3].tt, w_fnma(p[c].t, p[3].t, p[c].tt)) * inverse;
            p[c].st = w_fnma(p[c].f, p[3].st, w_fnma(p[c].t, p[3].s, w_fnma(p[c].s, p[3].t, p[c].st))) * inverse;
        }
    }
    w_surface j = {
        .ss = {p[0].ss, p[1].ss, p[2].ss}, .st = {p[0].st, p[1].st, p[2].st}, .tt = {p[0].tt, p[1].tt, p[2].tt}};
    if (rational) {
        j.at = (w_3){p[0].f - v->o.x, p[1].f - v->o.y, p[2].f - v->o.z};
        j.ds = (w_3){p[0].s, p[1].s, p[2].s};
        j.dt = (w_3){p[0].t, p[1].t, p[2].t};
    } else {
        const w_f one = w_set(1.0f);
        j.at = (w_3){(v->s - v->o.x) + p[0].f, (v->t - v->o.y) + p[1].f, p[2].f - v->o.z};
        j.ds = (w_3){p[0].s + one, p[1].s, p[2].s};
        j.dt = (w_3){p[0].t, p[1].t + one, p[2].t};
    }
    return j;
}
