/* line.c - see line.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Where the line is in a leaf's prism is a matter of six planes. Where it can then meet the leaf follows from how the
 * leaf is parametrised. In leaf coordinates S_st(x) = x + r_st(x) with |Dr_st| <= stretch < 1 over the convex domain D
 * (leaf.h). Of a line whose (s, t) is o give or take `way`, a point x that it meets has S_st(x) in there, too, so for
 * any y in D
 *
 *     (1 - stretch) |x - y| <= |S_st(x) - S_st(y)| <= |S_st(y) - o| + way.
 *
 * y - (S_st(y) - o) brings y nearer: the fixed-point iteration of Banach's, whose steps shrink by stretch. */
#include "embree_patch/line.h"

bool ep_line_of(const ep_patch *patch, const float org[3], const float dir[3], ep_line *l)
{
    l->d = ep_v3(dir[0], dir[1], dir[2]);
    const double *c = patch->centre;
    const ep_vec3 o = ep_v3(org[0] - c[0], org[1] - c[1], org[2] - c[2]);
    const double dd = ep_dot(l->d, l->d);
    l->t0 = -ep_dot(o, l->d) / dd;
    l->o = ep_add(o, ep_scale(l->t0, l->d));
    return dd > 0 && dd < INFINITY && fabs(l->t0) < INFINITY;
}

double ep_leaf_corners(const ep_leaf *leaf)
{
    const ep_domain d = ep_leaf_domain(leaf);
    return 0x1p-23 * (fabs(d.uu) + fabs(d.uv) + fabs(d.vu) + fabs(d.vv)) / fabs(d.uu * d.vv - d.uv * d.vu);
}

void ep_clamp(bool triangle, double *s, double *t)
{
    *s = fmin(fmax(*s, 0), 1);
    *t = fmin(fmax(*t, 0), 1);
    const double excess = triangle ? fmax(*s + *t - 1, 0) / 2 : 0;
    *s -= excess;
    *t -= excess;
}

/* What points relative to the patch's centre have to be moved by before the leaf's frame is applied. */
static ep_vec3 to_leaf(const ep_patch *patch, const ep_leaf *leaf)
{
    const double *c = patch->centre;
    return ep_v3((c[0] - leaf->centre[0]) - leaf->centre_low[0], (c[1] - leaf->centre[1]) - leaf->centre_low[1],
                 (c[2] - leaf->centre[2]) - leaf->centre_low[2]);
}

static ep_vec3 row_of(const ep_leaf *leaf, int c)
{
    return ep_v3(leaf->frame[0][c], leaf->frame[1][c], leaf->frame[2][c]);
}

/* Does it pass a piece without a frame at more than the distance that all of that has from a line of its own? The two
 * are |o n| / |n| apart, n being across both. */
static bool is_far(const ep_leaf *leaf, ep_vec3 o, ep_vec3 d)
{
    const ep_vec3 n = ep_cross(d, row_of(leaf, 0));
    return fabs(ep_dot(o, n)) > (double)leaf->foot * ep_length(n) + 0x1p-48 * ep_norm1(o) * ep_norm1(d);
}

bool ep_line_clip(const ep_patch *patch, const ep_leaf *leaf, const ep_line *l, double *lo, double *hi)
{
    const ep_vec3 o = ep_add(l->o, to_leaf(patch, leaf));
    if (!(leaf->height < INFINITY)) return !is_far(leaf, o, l->d);
    const bool triangle = patch->kind == EP_KIND_TRIANGLE;
    double a[3], b[3], from = *lo - l->t0, to = *hi - l->t0;
    for (int c = 0; c < 3; ++c) {
        a[c] = ep_dot(row_of(leaf, c), o);
        b[c] = ep_dot(row_of(leaf, c), l->d);
    }
    const double side = ep_leaf_side(leaf, triangle), height = leaf->height, edge = ep_kinds[patch->kind].middle + side;
    const struct {
        double a, b, limit; /* a + t b <= limit */
    } plane[6] = {
        {a[2], b[2], height},
        {-a[2], -b[2], height},
        {-a[0], -b[0], edge},
        {-a[1], -b[1], edge},
        {triangle ? a[0] + a[1] : a[0], triangle ? b[0] + b[1] : b[0], triangle ? edge + side : edge},
        {triangle ? -a[1] : a[1], triangle ? -b[1] : b[1], edge},
    };
    for (int k = 0; k < 6; ++k) {
        const double room = plane[k].limit - plane[k].a;
        if (plane[k].b > 0) to = fmin(to, room / plane[k].b);
        else if (plane[k].b < 0) from = fmax(from, room / plane[k].b);
        else if (room < 0) return false;
    }
    const double rounding = 0x1p-40 * (fabs(from) + fabs(to)); /* of the quotients */
    *lo = fmax(*lo, l->t0 + from - rounding);
    *hi = fmin(*hi, l->t0 + to + rounding);
    return *lo <= *hi;
}

/* Steps that bring y to where the line's piece is as wide as y is off, as a rule. */
enum { STEPS = 12 };

ep_domain ep_line_part(const ep_patch *patch, const ep_leaf *leaf, const ep_point *local, const ep_line *l, double lo,
                       double hi)
{
    static const ep_domain all = {0, 0, 1, 0, 0, 1};
    const ep_kind *kind = &ep_kinds[patch->kind];
    const bool triangle = patch->kind == EP_KIND_TRIANGLE;
    const double corners = ep_leaf_corners(leaf);
    const double left = 1 - ep_leaf_stretch(leaf) - 2 * (1 + (double)leaf->bend_st) * corners;
    if (!(leaf->height < INFINITY && leaf->stretch < EP_STRETCH && left > 0)) return all;
    const ep_domain d = ep_leaf_domain(leaf);
    const ep_vec3 move = to_leaf(patch, leaf), row[2] = {row_of(leaf, 0), row_of(leaf, 1)};
    const double k = 0.5 * (lo + hi) - l->t0;
    const ep_vec3 middle = ep_add(ep_add(l->o, ep_scale(k, l->d)), move);
    const double o[2] = {ep_dot(row[0], middle), ep_dot(row[1], middle)};
    const double along = fmax(fabs(ep_dot(row[0], l->d)), fabs(ep_dot(row[1], l->d)));
    /* rounding of the surface, as in solve.c, of the line, and of t */
    const double size = patch->weight_max / patch->weight_min * patch->radius + ep_norm1(middle);
    const double noise =
        16 * EP_EPS_D * fmax(ep_norm1(row[0]), ep_norm1(row[1])) *
        ((patch->degree_u + patch->degree_v + 4) * size + (fabs(l->t0) + fabs(lo) + fabs(hi)) * ep_norm1(l->d));
    const double way = 0.5 * (hi - lo) * along + noise;

    double s = o[0] + kind->middle, t = o[1] + kind->middle, off = INFINITY, best_s = 0, best_t = 0;
    for (int step = 0; step < STEPS && off > 0.25 * way; ++step) {
        ep_clamp(triangle, &s, &t);
        ep_jet jet;
        kind->eval(local, patch->degree_u, patch->degree_v, d.u0 + s * d.uu + t * d.uv, d.v0 + s * d.vu + t * d.vv,
                   &jet);
        const ep_vec3 at = ep_add(ep_project(&jet).p, move);
        const double by[2] = {ep_dot(row[0], at) - o[0], ep_dot(row[1], at) - o[1]};
        const double now = fmax(fabs(by[0]), fabs(by[1]));
        if (!(now < off)) break;
        off = now;
        best_s = s, best_t = t;
        s -= by[0];
        t -= by[1];
    }
    const double radius = (off + way) / left;
    if (!(radius < 1)) return all;
    const double s0 = fmax(best_s - radius, 0), t0 = fmax(best_t - radius, 0);
    if (!triangle) return (ep_domain){s0, t0, fmin(best_s + radius, 1) - s0, 0, 0, fmin(best_t + radius, 1) - t0};
    const double length = fmin(best_s + best_t + 2 * radius, 1) - s0 - t0;
    return (ep_domain){s0, t0, length, 0, 0, length};
}
