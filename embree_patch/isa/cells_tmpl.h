/* cells_tmpl.h - nearly tangent rays against one leaf: their ways through the prism, cut into a cell a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Where the tangent kernel has not decided, in coarse leaves and where there are more than two roots, the ray's way
 * through the prism is cut into EP_CELLS, with the origin moved to the middle of each, and the certificate holds, or
 * fails, for each on its own; fold_tmpl.h shrinks what is left. Four rays at a time with sixteen lanes; a ray always
 * gets the same cells, whoever else is in the packet.
 *
 * Where the ray is in s, t, the root is r_st(x*) away, and r_st(y) is known once S(y) is. With |Dr_st| <= stretch over
 * D and any y in D,
 *
 *     |x* - (y - S_st(y) + o_st)| <= stretch |x* - y| + half the cell's way along the leaf,
 *     (1 - stretch) |x* - y| <= |S_st(y) - o_st| + that. */

/* Rays of a vector. */
#define EP_CELL_RAYS (EP_LANES / EP_CELLS)

/* Field `field` of the rays, each in all lanes of its cells. */
EP_INLINE w_f w_spread_rays(const float *ray, unsigned n, unsigned field, const unsigned *lane)
{
    float x[EP_LANES];
    for (unsigned k = 0; k < EP_LANES; ++k) x[k] = ray[field * n + lane[k / EP_CELLS]];
    return w_load(x, EP_LANES);
}

/* Where the rays are in the prism: from and to, in t relative to where they meet the leaf's plane. o: approximately
 * their origins. */
EP_INLINE w_f w_clip(const ep_leaf *leaf, int triangle, w_3 o, w_3 d, w_f d_sum, w_f *from, w_f *to)
{
    const w_f inverse = w_set(1.0f) / d.z, t_plane = -o.z * inverse, far = w_abs(t_plane) * d_sum;
    const w_f side = w_fma(w_set(leaf->reach_st), far, w_set(leaf->side));
    const w_f reach = w_abs(inverse) * w_fma(w_set(leaf->reach_h), far, w_set(leaf->height));
    const w_f s = w_fma(t_plane, d.x, o.x), t = w_fma(t_plane, d.y, o.y);
    *from = -reach;
    *to = reach;
    w_clip_domain(triangle, s, t, d.x, d.y, side, from, to);
    return t_plane;
}

EP_INLINE void w_cells(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays, const unsigned *lanes,
                       unsigned count, const float *from, const float *to, ep_cells *out, int triangle, unsigned m,
                       unsigned n, int rational)
{
    const float stretch = (float)leaf->stretch / EP_STRETCH + leaf->noise_st;
    const w_f one = w_set(1.0f), half = w_set(0.5f);
    out->hit = out->vague = out->more = out->open = out->hopeless = 0;
    for (unsigned first = 0, base = 0; first < count; first += EP_CELL_RAYS, base += EP_LANES) {
        unsigned lane[EP_CELL_RAYS];
        float centre[EP_LANES], length[EP_LANES]; /* of the cells, relative to half the way */
        uint32_t all = 0;
        for (unsigned r = 0; r < EP_CELL_RAYS; ++r) {
            const unsigned k = first + r < count ? first + r : first;
            lane[r] = lanes[k];
            if (k == first + r) all |= ((1u << EP_CELLS) - 1) << r * EP_CELLS;
            for (unsigned c = 0; c < EP_CELLS; ++c) {
                length[r * EP_CELLS + c] = (to[k] - from[k]) / (2 * EP_CELLS);
                centre[r * EP_CELLS + c] = from[k] + (to[k] - from[k]) * ((float)c + 0.5f) / EP_CELLS;
            }
        }
        w_f org[3], dir[3], o[3], near[3];
        for (unsigned c = 0; c < 3; ++c) {
            org[c] = w_spread_rays(ray, rays, EP_RAY_ORG + c, lane);
            dir[c] = w_spread_rays(ray, rays, EP_RAY_DIR + c, lane);
        }
        const w_f tnear = w_spread_rays(ray, rays, EP_RAY_TNEAR, lane);
        const w_f tfar = w_spread_rays(ray, rays, EP_RAY_TFAR, lane);
        w_relative(leaf, org, o);
        for (int c = 0; c < 3; ++c) near[c] = o[c] - w_set(leaf->centre_low[c]);
        const w_3 d = w_to_leaf(leaf, dir);
        const w_f d_sum = (w_abs(dir[0]) + w_abs(dir[1])) + w_abs(dir[2]);
        w_f begin, end;
        const w_f t_plane = w_clip(leaf, triangle, w_to_leaf(leaf, near), d, d_sum, &begin, &end);
        const w_f middle = t_plane + half * (begin + end);
        /* and the rounding of the middle and of what it is made of */
        const w_f way = w_fma(half, end - begin, w_set(0x1p-21f) * ((w_abs(t_plane) + w_abs(begin)) + w_abs(end)));
        const w_f cell = way * w_load(centre, EP_LANES), reach = w_set(0x1.00001p0f) * way * w_load(length, EP_LANES);
        w_store(out->middle + base, ~0u, middle + cell);
        w_store(out->reach + base, ~0u, reach);
        const w_3 moved = w_move(leaf, org, o, dir, middle);

        w_visit v;
        v.o = (w_3){w_fma(cell, d.x, moved.x), w_fma(cell, d.y, moved.y), w_fma(cell, d.z, moved.z)};
        v.inverse = one / d.z;
        v.p_s = d.x * v.inverse;
        v.p_t = d.y * v.inverse;
        v.way = d_sum * way;
        v.noise_st = w_fma(w_set(leaf->reach_st), v.way, w_set(leaf->noise_st));
        v.noise_h = w_fma(w_set(leaf->reach_h), v.way, w_set(leaf->noise_h));
        const w_m missed = w_lt(end, begin);
        const w_m beside = w_or(w_or(missed, w_lt(tfar, ((middle + cell) - reach) - reach)),
                                w_lt(((middle + cell) + reach) + reach, tnear));
        const w_m steep =
            w_andnot(w_mask(all), w_lt(w_max(w_abs(v.p_s), w_abs(v.p_t)), w_set(stretch < 1 ? EP_STEEP : 0.0f)));
        out->hopeless |= w_bits(w_andnot(steep, missed)) << base;
        v.live = w_andnot(w_andnot(w_mask(all), steep), beside);
        v.slow = w_mask(0);
        w_stack wait = w_empty();

        /* the model says where S_st is o */
        const w_f u[2] = {v.o.x, v.o.y};
        w_f at[2];
        for (int c = 0; c < 2; ++c) {
            const w_f form[3] = {w_set(leaf->half[0][c]), w_set(leaf->half[1][c]), w_set(leaf->half[2][c])};
            at[c] = u[c] - w_form(form, u, u);
        }
        v.s = at[0];
        v.t = at[1];
        w_clamp(triangle, &v.s, &v.t);
        w_jet jet = w_jet_at(net, &v, triangle, m, n, rational);
        const w_f along = w_fma(w_max(w_abs(d.x), w_abs(d.y)), reach, v.noise_st);
        v.radius = w_min((w_max(w_abs(jet.at.x), w_abs(jet.at.y)) + along) / w_set(1 - stretch), one);

        const w_f height = w_abs(d.z) * reach + v.noise_h;
        /* advance would not decide: the whole leaf's certificate has not */
        const w_m fresh = v.live;
        v.live = w_mask(0);
        w_near here = w_here(&v);
        w_fold(leaf, &v, &wait, triangle, &here, &jet, -height, height, fresh);
        uint32_t live = w_bits(v.live), hit = 0;
        while (live) {
            jet = w_jet_at(net, &v, triangle, m, n, rational);
            here = w_here(&v);
            const w_step step = w_advance(leaf, &v, triangle, &jet);
            if (w_bits(step.stuck)) w_fold(leaf, &v, &wait, triangle, &here, &jet, -height, height, step.stuck);
            const w_f t = middle + w_fma(step.height, v.inverse, cell);
            const w_m found = w_and(step.hit, w_nearly(&step, middle, t, tnear, tfar));
            const uint32_t bits = w_bits(found);
            if (bits) {
                hit |= bits;
                out->vague |= w_bits(w_and(found, step.vague)) << base;
                w_store(out->t + base, bits, t);
                w_store(out->radius + base, bits, step.radius);
                w_put_hit(leaf, triangle, &jet, &step, out->fields + base, EP_PACKET, bits);
            }
            w_next(&v, &wait, w_mask(~hit));
            live = w_bits(v.live);
        }
        out->hit |= hit << base;
        out->more |= (w_bits(wait.full[0]) & hit) << base;
        out->open |= w_bits(v.slow) << base;
    }
}
