/* cells_tmpl.h - one nearly tangent ray against one leaf: its way through the prism, cut into a cell a lane.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Newton from the leaf's plane covers all of the ray's way through the prism at once; near tangency that is too long
 * for the certificate, and there may be two roots. A cell covers a sixteenth of the way: the origin is moved to its
 * middle, and a root whose t lies in the cell is within side + half the cell's length of the origin's (s, t). The
 * certificate then holds, or fails, for each cell on its own.
 *
 * `side` bounds r_st over the whole leaf, and would soon be most of that distance. But where the ray is in s, t, the
 * root is r_st(x*) away, and r_st(y) is known once S(y) is: with |Dr_st| <= stretch over D and any y in D,
 *
 *     |x* - (y - S_st(y) + o_st)| <= stretch |x* - y| + half the cell's way along the leaf,
 *     (1 - stretch) |x* - y| <= |S_st(y) - o_st| + that. */

EP_INLINE void w_cells(const ep_leaf *leaf, const float *net, const float *ray, double lo, double hi, ep_cells *out,
                       int triangle, unsigned m, unsigned n, int rational)
{
    const double length = (hi - lo) / EP_PACKET;
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    w_f org[3], dir[3], o[3];
    for (int c = 0; c < 3; ++c) {
        org[c] = w_set(ray[EP_RAY_ORG + c]);
        dir[c] = w_set(ray[EP_RAY_DIR + c]);
    }
    w_relative(leaf, org, o);
    const w_3 d = w_to_leaf(leaf, dir);
    const w_f d_sum = (w_abs(dir[0]) + w_abs(dir[1])) + w_abs(dir[2]);
    /* half a cell, and the rounding of its middle */
    const float half = (float)(0.5000001 * length + 0x1p-22 * fmax(fabs(lo), fabs(hi)));
    /* Dr is zero at the middle of the leaf, to rounding, and changes by bend_st */
    const float stretch = leaf->bend_st * (triangle ? 2 * EP_THIRD : EP_HALF) + leaf->noise_st;
    const w_f twice = w_set(triangle ? 2.0f : 1.0f);
    out->hit = out->vague = out->open = 0;
    for (unsigned base = 0; base < EP_PACKET; base += EP_LANES) {
        float middle[EP_LANES];
        for (unsigned k = 0; k < EP_LANES; ++k) middle[k] = (float)(lo + length * (base + k + 0.5));
        w_visit v;
        v.t_plane = w_load(middle, EP_LANES);
        v.o = w_move(leaf, org, o, dir, v.t_plane);
        v.inverse = w_set(1.0f) / d.z;
        v.p_s = d.x * v.inverse;
        v.p_t = d.y * v.inverse;
        v.way = d_sum * w_set(half);
        v.noise_st = w_fma(w_set(leaf->reach_st), v.way, w_set(leaf->noise_st));
        v.noise_h = w_fma(w_set(leaf->reach_h), v.way, w_set(leaf->noise_h));
        v.s = v.o.x;
        v.t = v.o.y;
        const w_f way = w_fma(w_max(w_abs(d.x), w_abs(d.y)), w_set(half), v.noise_st);
        w_clamp(triangle, &v.s, &v.t);
        v.radius = twice * (way + w_set(leaf->side));
        w_jet jet = w_jet_at(net, &v, triangle, m, n, rational);
        for (int k = 0; k < 3 && stretch < 1; ++k) {
            v.s = v.s - jet.at.x;
            v.t = v.t - jet.at.y;
            w_clamp(triangle, &v.s, &v.t);
            jet = w_jet_at(net, &v, triangle, m, n, rational);
            const w_f residual = (w_max(w_abs(jet.at.x), w_abs(jet.at.y)) + way) / w_set(1 - stretch);
            v.radius = w_min(residual, twice * w_fma(w_set(stretch), v.radius, way));
        }
        v.live = w_and(w_le(w_set(0.0f), v.radius), w_lt(w_max(w_abs(v.p_s), w_abs(v.p_t)), w_set(EP_STEEP)));
        v.slow = w_andnot(w_mask(~0u), v.live);

        uint32_t live = w_bits(v.live);
        while (live) {
            const w_step step = w_advance(leaf, &v, triangle, &jet);
            const w_f t = v.t_plane + step.distance;
            const w_m within = w_and(w_lt(w_set(tnear), t), w_le(t, w_set(tfar)));
            const w_m hit = w_and(step.hit, w_or(within, step.vague));
            const uint32_t found = w_bits(hit);
            if (found) {
                out->hit |= found << base;
                out->vague |= w_bits(w_and(hit, step.vague)) << base;
                w_store(out->t + base, found, t);
                w_store(out->s + base, found, step.s);
                w_store(out->r + base, found, step.t);
                w_store(out->radius + base, found, step.radius);
                w_put_hit(leaf, triangle, &jet, &step, out->fields + base, EP_PACKET, found);
            }
            live = w_bits(v.live);
            if (live) jet = w_jet_at(net, &v, triangle, m, n, rational);
        }
        out->open |= w_bits(v.slow) << base;
    }
}
