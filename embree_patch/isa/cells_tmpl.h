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

EP_INLINE void w_cells(const ep_leaf *leaf, const float *net, const float *ray, unsigned rays, const unsigned *lanes,
                       unsigned count, const float *from, const float *to, ep_cells *out, int triangle, unsigned m,
                       unsigned n, int rational)
{
    const float stretch = ep_leaf_stretch(leaf);
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
        w_rays r;
        for (unsigned k = 0; k < 3; ++k) {
            r.org[k] = w_spread_rays(ray, rays, EP_RAY_ORG + k, lane);
            r.dir[k] = w_spread_rays(ray, rays, EP_RAY_DIR + k, lane);
            r.o[k] = r.org[k] - w_set(leaf->centre[k]);
        }
        r.tnear = w_spread_rays(ray, rays, EP_RAY_TNEAR, lane);
        r.tfar = w_spread_rays(ray, rays, EP_RAY_TFAR, lane);
        w_way through;
        w_visit v = w_approach(leaf, triangle, &r, w_mask(all), &through);
        const w_f way = half * (through.to - through.from);
        const w_f cell = w_fma(way, w_load(centre, EP_LANES), half * (through.from + through.to));
        /* and the rounding of that */
        const w_f reach =
            w_fma(way, w_load(length, EP_LANES), w_set(0x1p-20f) * w_max(w_abs(through.from), w_abs(through.to)));
        const w_f middle = v.moved + cell, far = w_fma(w_set(EP_TERMS), w_abs(middle), reach + reach);
        w_store(out->middle + base, ~0u, middle);
        w_store(out->reach + base, ~0u, reach);
        v.o.x = w_fma(cell, through.d.x, v.o.x);
        v.o.y = w_fma(cell, through.d.y, v.o.y);
        v.o.z = w_fma(cell, through.d.z, v.o.z);
        const w_m beside = w_or(w_lt(r.tfar, middle - far), w_lt(middle + far, r.tnear));
        out->hopeless |= (stretch < 1 ? w_bits(v.slow) : all) << base;
        v.live = w_andnot(v.live, w_or(beside, w_mask(stretch < 1 ? 0 : all)));
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
        w_surface jet = w_surface_at(net, &v, triangle, m, n, rational);
        const w_f along = w_fma(w_max(w_abs(through.d.x), w_abs(through.d.y)), reach, v.noise_st);
        v.radius = w_min((w_max(w_abs(jet.at.x), w_abs(jet.at.y)) + along) / w_set(1 - stretch), one);

        const w_f height = w_abs(through.d.z) * reach + v.noise_h;
        /* advance would not decide: the whole leaf's certificate has not */
        const w_m fresh = v.live;
        v.live = w_mask(0);
        v.first = -height;
        v.last = height;
        w_near here = w_here(&v);
        w_fold(leaf, &v, &wait, triangle, &here, &jet, fresh);
        uint32_t live = w_bits(v.live), hit = 0, vague = 0;
        while (live) {
            jet = w_surface_at(net, &v, triangle, m, n, rational);
            here = w_here(&v);
            const w_step step = w_advance(leaf, &v, triangle, 1, &jet);
            if (w_bits(step.stuck)) w_fold(leaf, &v, &wait, triangle, &here, &jet, step.stuck);
            const w_f t = v.moved + w_fma(step.height, v.inverse, cell);
            const w_m found = w_and(step.hit, w_nearly(t, w_late(&step, v.moved, t), r.tnear, w_set(INFINITY)));
            const uint32_t bits = w_bits(found);
            if (bits) {
                hit |= bits;
                vague |= w_bits(w_and(found, w_or(step.vague, w_is_astray(leaf, &v))));
                w_store(out->t + base, bits, t);
                w_store(out->radius + base, bits, step.radius);
                w_put_hit(leaf, triangle, &jet, &step, out->fields + base, EP_PACKET, bits);
            }
            w_next(&v, &wait, w_mask(~hit));
            live = w_bits(v.live);
        }
        out->hit |= (hit & ~vague) << base;
        out->vague |= vague << base;
        out->more |= (w_bits(wait.full[0]) & hit) << base;
        out->open |= w_bits(v.slow) << base;
    }
}
