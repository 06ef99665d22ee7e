/* single_tmpl.h - one ray against one leaf, the lanes across the coordinates of a point.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Operation for operation what packet_tmpl.h does to one of its lanes. */

/* A vector of space in leaf coordinates. */
EP_INLINE f4 s_to_leaf(const f4 *frame, f4 x)
{
    return f4_fma(frame[2], f4_lane(x, 2), f4_fma(frame[1], f4_lane(x, 1), frame[0] * f4_lane(x, 0)));
}

EP_INLINE s_jet s_jet_at(const float *net, const s_visit *v, int triangle, unsigned m, unsigned n, int rational)
{
    f4 p, ds, dt;
    s_series(net, rational ? 4 : 3, triangle, m, n, f4_set(v->s), f4_set(v->t), &p, &ds, &dt);
    s_jet j;
    if (rational) {
        const f4 inverse = f4_set(1.0f) / f4_lane(p, 3);
        p = p * inverse;
        ds = f4_fnma(p, f4_lane(ds, 3), ds) * inverse;
        dt = f4_fnma(p, f4_lane(dt, 3), dt) * inverse;
        j.at = (s_3){p[0] - v->o.x, p[1] - v->o.y, p[2] - v->o.z};
        j.ds = (s_3){ds[0], ds[1], ds[2]};
        j.dt = (s_3){dt[0], dt[1], dt[2]};
    } else {
        j.at = (s_3){(v->s - v->o.x) + p[0], (v->t - v->o.y) + p[1], p[2] - v->o.z};
        j.ds = (s_3){ds[0] + 1.0f, ds[1], ds[2]};
        j.dt = (s_3){dt[0], dt[1] + 1.0f, dt[2]};
    }
    return j;
}

EP_INLINE ep_outcome s_single(const ep_leaf *leaf, const float *net, const float *ray, float *t_out, float *hit_out,
                              EPCounters *counters, int triangle, unsigned m, unsigned n, int rational)
{
    const f4 org = f4_load(ray + EP_RAY_ORG), dir = f4_load(ray + EP_RAY_DIR);
    const float tnear = ray[EP_RAY_TNEAR], tfar = ray[EP_RAY_TFAR];
    const f4 centre = f4_load(leaf->centre), centre_low = f4_load(leaf->centre_low), o = org - centre;
    const f4 frame[3] = {f4_load(leaf->frame[0]), f4_load(leaf->frame[1]), f4_load(leaf->frame[2])};
    const f4 lo = s_to_leaf(frame, o - centre_low), ld = s_to_leaf(frame, dir), da = f4_abs(dir);
    s_visit visit = s_enter(leaf, triangle, (s_3){lo[0], lo[1], lo[2]}, (s_3){ld[0], ld[1], ld[2]},
                            (da[0] + da[1]) + da[2], tnear, tfar, 1);
    ++counters->visits;
    if (!visit.live) {
        counters->solves += visit.slow;
        return (ep_outcome){0, 0, 0, visit.slow};
    }
    ++counters->solves;

    const f4 back = o - org, low = ((org - (o - back)) - (centre + back)) - centre_low;
    const f4 moved = s_to_leaf(frame, f4_fma(f4_set(visit.t_plane), dir, o) + low);
    s_start(leaf, &visit, triangle, (s_3){moved[0], moved[1], moved[2]});
    while (visit.live) {
        const s_jet jet = s_jet_at(net, &visit, triangle, m, n, rational);
        ++counters->evaluations;
        const s_step step = s_advance(leaf, &visit, triangle, &jet);
        visit.slow = visit.slow | step.stuck;
        const float t = visit.t_plane + step.distance;
        if (!(step.hit && ((tnear < t && t <= tfar) || step.vague))) continue;
        *t_out = t;
        s_normal(leaf, &jet, &step, hit_out + EP_HIT_NG);
        s_parameters(leaf, triangle, step.s, step.t, &hit_out[EP_HIT_U], &hit_out[EP_HIT_V]);
        return (ep_outcome){1, t == tfar, step.vague, 0};
    }
    return (ep_outcome){0, 0, 0, visit.slow};
}
