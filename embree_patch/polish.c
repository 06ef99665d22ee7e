/* polish.c - see polish.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/polish.h"

#include "embree_patch/line.h"

/* Newton's steps with the second-order term that they leave, of which three take a root that is right to 2^-8 to the
 * rounding of doubles, with one to spare. If that term is no more than 2^-26 and the step no more than 2^-16, what is
 * left is below 2 (2^-26)² / 2^-16, and the surface's third derivatives times 2^-50. */
enum { POLISH_STEPS = 4 };
static const double last_term = 0x1p-26, last_step = 0x1p-16;

/* r + pu du + pv dv = d dk by Cramer's rule: with n = pu x pv, dk is n r / n d, and what is left of r, l = d dk - r,
 * lies in the plane of pu and pv, where l by_u is du and l by_v is dv. */
typedef struct tangents {
    ep_vec3 n, by_u, by_v;
    double inverse; /* 1 / n d */
} tangents;

typedef struct polish_step {
    double du, dv, dk;
} polish_step;

static tangents tangents_of(const ep_frame *f, ep_vec3 d)
{
    const ep_vec3 n = ep_cross(f->pu, f->pv);
    const double over = 1 / ep_dot(n, n);
    return (tangents){n, ep_scale(over, ep_cross(f->pv, n)), ep_scale(over, ep_cross(n, f->pu)), 1 / ep_dot(n, d)};
}

static polish_step solve_step(const tangents *p, ep_vec3 d, ep_vec3 r)
{
    const double dk = ep_dot(p->n, r) * p->inverse;
    const ep_vec3 left = ep_sub(ep_scale(dk, d), r);
    return (polish_step){ep_dot(left, p->by_u), ep_dot(left, p->by_v), dk};
}

static ep_vec3 combine(double a, ep_vec3 x, double b, ep_vec3 y)
{
    return ep_add(ep_scale(a, x), ep_scale(b, y));
}

static bool within(double a, double b, double limit)
{
    return fabs(a) <= limit && fabs(b) <= limit;
}

static bool is_beside(const ep_leaf *leaf, bool triangle, double u, double v)
{
    const ep_domain d = ep_leaf_domain(leaf);
    const double over = 1 / (d.uu * d.vv - d.uv * d.vu), x = u - d.u0, y = v - d.v0;
    return ep_outside(triangle, (x * d.vv - y * d.uv) * over, (y * d.uu - x * d.vu) * over) >
           (double)EP_SHARP + ep_leaf_corners(leaf);
}

ep_polished ep_polish(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], float *t,
                      float field[5], double exact[2])
{
    ep_line l;
    if (!ep_line_of(patch, org, dir, &l)) return EP_POLISHED_LOST;
    const bool triangle = patch->kind == EP_KIND_TRIANGLE;
    ep_point local[EP_NET_POINTS];
    ep_patch_local(patch, local);
    double u = field[3], v = field[4], k = *t - l.t0;
    ep_vec3 n = ep_v3(0, 0, 0);
    bool done = false;
    for (int i = 0; i < POLISH_STEPS && !done; ++i) {
        ep_jet jet;
        ep_kinds[patch->kind].eval(local, patch->degree_u, patch->degree_v, u, v, &jet);
        const ep_frame f = ep_project(&jet);
        const tangents p = tangents_of(&f, l.d);
        const polish_step a = solve_step(&p, l.d, ep_sub(f.p, ep_add(l.o, ep_scale(k, l.d))));
        const ep_vec3 turn_u = combine(a.du, f.puu, a.dv, f.puv), turn_v = combine(a.du, f.puv, a.dv, f.pvv);
        const polish_step b = solve_step(&p, l.d, combine(0.5 * a.du, turn_u, 0.5 * a.dv, turn_v));
        u += a.du + b.du;
        v += a.dv + b.dv;
        k += a.dk + b.dk;
        n = ep_cross(ep_add(f.pu, turn_u), ep_add(f.pv, turn_v));
        done = within(b.du, b.dv, last_term) && within(a.du, a.dv, last_step);
        if (!within(u - field[3], v - field[4], 0x1p-8)) return EP_POLISHED_LOST;
    }
    if (!done) return EP_POLISHED_LOST; /* a double root, nearly */
    *t = (float)(l.t0 + k);
    exact[0] = u, exact[1] = v;
    if (ep_outside(triangle, u, v) > EP_BORDER || is_beside(leaf, triangle, u, v)) return EP_POLISHED_AWAY;
    field[0] = (float)n.x, field[1] = (float)n.y, field[2] = (float)n.z;
    field[3] = (float)fmin(fmax(u, 0), 1);
    field[4] = (float)fmin(fmax(v, 0), triangle ? 1 - field[3] : 1);
    return EP_POLISHED;
}
