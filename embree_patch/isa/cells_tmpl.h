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
 * root is r_st(x*) away, and r_st(y) is known once S(y) is: y - (s, t)(S(y) - o') is within half a cell's length plus
 * stretch times y's own distance of the root. Twice that, and what is left is mostly the cell. */

EP_INLINE void w_cells(const ep_leaf *leaf, const ep_patch *patch, const float *ray, double lo, double hi, ep_cells *out,
                       int triangle, unsigned m, unsigned n, int rational)
{
    const double length = (hi - lo) / EP_PACKET;
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    w_f org[3], dir[3], moved[3];
    for (int c = 0; c < 3; ++c) {
        org[c] = w_set(ray[EP_RAY_ORG + c]);
        dir[c] = w_set(ray[EP_RAY_DIR + c]);
    }
    const w_3 d = w_to_leaf(leaf, dir);
    /* half a cell, and the rounding of its middle */
    const float half = (float)(0.5000001 * length + 0x1p-22 * fmax(fabs(lo), fabs(hi)));
    const w_f zero = w_set(0.0f), one = w_set(1.0f);
    out->hit = out->open = 0;
    for (unsigned base = 0; base < EP_PACKET; base += EP_LANES) {
        float middle[EP_LANES];
        for (unsigned k = 0; k < EP_LANES; ++k) middle[k] = (float)(lo + length * (base + k + 0.5));
        w_visit v;
        v.t_plane = w_load(middle, EP_LANES);
        w_move(patch, org, dir, v.t_plane, moved);
        const w_3 o = w_to_leaf(leaf, moved);
        v.inverse = one / d.z;
        v.p_s = d.x * v.inverse;
        v.p_t = d.y * v.inverse;
        v.s = o.x + w_set(leaf->frame[3][0]);
        v.t = o.y + w_set(leaf->frame[3][1]);
        const w_f way = w_max(w_abs(d.x), w_abs(d.y)) * w_set(half);
        v.radius = w_set(triangle ? 2.0f : 1.0f) * (way + w_set(fmaxf(leaf->side_s, leaf->side_t) + leaf->noise_st));
        w_clamp(triangle, &v.s, &v.t);
        const w_f twice = w_set(triangle ? 2.0f : 1.0f);
        for (int k = 0; k < 2 && leaf->stretch < 0.5f; ++k) {
            const w_jet j = w_jet_at(leaf, patch, triangle, m, n, rational, v.s, v.t, moved);
            v.s = v.s - j.at.x;
            v.t = v.t - j.at.y;
            w_clamp(triangle, &v.s, &v.t);
            v.radius = twice * w_fma(w_set(leaf->stretch), v.radius, way + w_set(2.0f * leaf->noise_st));
        }
        v.live = w_and(w_le(zero, v.radius), w_lt(w_max(w_abs(v.p_s), w_abs(v.p_t)), w_set(EP_STEEP)));
        v.slow = w_andnot(w_mask(~0u), v.live);

        uint32_t live = w_bits(v.live);
        while (live) {
            const w_jet jet = w_jet_at(leaf, patch, triangle, m, n, rational, v.s, v.t, moved);
            const w_step step = w_advance(leaf, &v, triangle, &jet);
            const w_f t = v.t_plane + step.distance;
            const uint32_t found = w_bits(w_and(step.hit, w_and(w_lt(w_set(tnear), t), w_le(t, w_set(tfar)))));
            if (found) {
                out->hit |= found << base;
                w_store(out->t + base, found, t);
                w_store(out->s + base, found, step.s);
                w_store(out->r + base, found, step.t);
                w_store(out->radius + base, found, step.radius);
                w_put_hit(leaf, triangle, &jet, &step, out->fields + base, EP_PACKET, found);
            }
            live = w_bits(v.live);
        }
        out->open |= w_bits(v.slow) << base;
    }
}
