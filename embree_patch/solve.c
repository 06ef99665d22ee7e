/* solve.c - see solve.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The ray is the intersection of two planes, and the leaf's homogeneous net turns into the nets of four functions on
 * its domain: the numerators f1, f2 of the distances to the planes, that of t, and the weight. All are polynomials, so
 * hulls of their coefficients bound them [Nishita, Sederberg, Kakimoto 1990]. A cell of the domain is
 *
 *   excluded    when f1, f2 or a combination of them keeps its sign there, or t lies outside the interval asked for;
 *   certified   when, multiplied by the inverse of the Jacobian J at its middle, the derivative of f is within e <= 1/8
 *               of the identity. Any mean A of Jacobians in the cell, and J(y) for any y in it, then differ from J by
 *               at most e relative to J; so k = |J(y)^-1 A - I| <= 2e/(1-e) <= 2/7, f is injective, and a root x* in
 *               the cell satisfies |x* - c| <= k |x* - y| <= k/(1-k) |c - y| <= 2/5 |c - y| for the Newton point c of
 *               y. So Newton from the middle either leaves the cell by more than that, or its steps shrink: no root,
 *               or the root;
 *   a root      when it holds the ray and is smaller than floats can tell: a tangency or a pole;
 *   split       otherwise, along the side on which f changes more.
 *
 * Cells are visited nearest first and those behind the nearest root are dropped, so that even a ray that runs within a
 * flat patch ends after one path down. */
#include "embree_patch/solve.h"

#include "embree_patch/line.h"

#include <string.h>

enum {
    MAX_POINTS = (EP_MAX_DEGREE + 1) * (EP_MAX_DEGREE + 1),
    MAX_STACK = 512,
    /* A cell that is still open after this many others becomes the hit: nothing nearer was left out. It takes a
     * surface that doubles cannot tell from the ray. That cell is a small one; what else waits may be large, and gets a
     * few more cells of its own, as often as that. */
    MAX_CELLS = 1 << 14,
    MORE_CELLS = 1 << 11,
    MORE_TIMES = 8,
};

typedef struct cell {
    ep_domain d; /* part of the leaf's unit domain */
    double t_low;
} cell;

typedef struct problem {
    const ep_kind *kind;
    unsigned m, n;
    bool triangle;
    ep_point net[MAX_POINTS]; /* f1, f2, numerator of t, w over the leaf's unit domain */
    double t0, speed;         /* t of the moved origin, |d| */
    double noise;             /* rounding error of f1, f2 */
    double rounding;          /* ... divided by w */
    double small, small_t;    /* extent in f and in t of what floats cannot tell from a point */
} problem;

/* Two unit vectors perpendicular to d, one of them along the leaf where that makes sense. */
static void planes(const ep_leaf *leaf, ep_vec3 d, ep_vec3 *n1, ep_vec3 *n2)
{
    const ep_vec3 unit = ep_scale(1 / ep_length(d), d);
    ep_vec3 up = ep_v3(leaf->frame[0][2], leaf->frame[1][2], leaf->frame[2][2]);
    up = ep_scale(1 / ep_length(up), up); /* NaN where the leaf has no frame */
    *n1 = ep_cross(unit, up);
    if (!(ep_length(*n1) > 0x1p-10)) {
        up = fabs(unit.x) < fabs(unit.y) ? ep_v3(1, 0, 0) : ep_v3(0, 1, 0);
        *n1 = ep_cross(unit, up);
    }
    *n1 = ep_scale(1 / ep_length(*n1), *n1);
    *n2 = ep_cross(unit, *n1);
}

/* Derivatives of f1 (k = 0), f2, t's numerator and w over a cell's net, in the cell's coordinates. */
typedef struct slopes {
    ep_range s[4], t[4];
} slopes;

static slopes net_slopes(const problem *p, const ep_point *net)
{
    const ep_range nothing = EP_NOTHING;
    slopes r = {{nothing, nothing, nothing, nothing}, {nothing, nothing, nothing, nothing}};
    for (unsigned j = 0; j <= p->n; ++j)
        for (unsigned i = 0; i <= p->m; ++i) {
            const size_t at = p->kind->index(p->m, p->n, i, j);
            if (at == SIZE_MAX) continue;
            const size_t is = p->kind->index(p->m, p->n, i + 1, j), it = p->kind->index(p->m, p->n, i, j + 1);
            for (int k = 0; k < 4; ++k) {
                if (is != SIZE_MAX) ep_include(&r.s[k], p->m * (net[is][k] - net[at][k]));
                if (it != SIZE_MAX) ep_include(&r.t[k], p->n * (net[it][k] - net[at][k]));
            }
        }
    return r;
}

/* e of the certificate: the deviation of the Jacobian from its middle, relative to the middle; infinity if singular. */
static double deviation(const problem *p, const slopes *g)
{
    const double a = ep_mid(g->s[0]), b = ep_mid(g->t[0]), c = ep_mid(g->s[1]), d = ep_mid(g->t[1]);
    const double det = a * d - b * c;
    if (det == 0) return INFINITY;
    const double es = 2 * p->m * p->noise, et = 2 * p->n * p->noise; /* rounding of differences of the net */
    const double ra = ep_half(g->s[0]) + es, rb = ep_half(g->t[0]) + et, rc = ep_half(g->s[1]) + es,
                 rd = ep_half(g->t[1]) + et;
    const double row0 = fabs(d) * (ra + rb) + fabs(b) * (rc + rd);
    const double row1 = fabs(c) * (ra + rb) + fabs(a) * (rc + rd);
    return fmax(row0, row1) / fabs(det);
}

/* A cell's two sides as the ray sees them, the longer one first: unit vectors e along it and across, and what x = f / w
 * and t change by along both, times w. */
typedef struct aspect {
    double e[2][2];
    double more[2], less[2]; /* along e */
    double t_more, t_less;
} aspect;

/* at: x and t over the cell. False when x does not change by more than its rounding. */
static bool look(const problem *p, const slopes *g, const ep_range at[3], aspect *a)
{
    double side[2][2], by[2];
    for (int k = 0; k < 2; ++k) {
        side[0][k] = ep_mid(g->s[k]) - ep_mid(at[k]) * ep_mid(g->s[3]);
        side[1][k] = ep_mid(g->t[k]) - ep_mid(at[k]) * ep_mid(g->t[3]);
    }
    by[0] = ep_mid(g->s[2]) - ep_mid(at[2]) * ep_mid(g->s[3]);
    by[1] = ep_mid(g->t[2]) - ep_mid(at[2]) * ep_mid(g->t[3]);
    const int m = hypot(side[1][0], side[1][1]) > hypot(side[0][0], side[0][1]);
    const double length = hypot(side[m][0], side[m][1]);
    if (!(length > p->noise)) return false;
    const double e[2] = {side[m][0] / length, side[m][1] / length}, *less = side[!m];
    *a = (aspect){.e = {{e[0], e[1]}, {-e[1], e[0]}},
                  .more = {length, 0},
                  .less = {e[0] * less[0] + e[1] * less[1], e[0] * less[1] - e[1] * less[0]},
                  .t_more = by[m],
                  .t_less = by[!m]};
    return true;
}

/* Hull of x f1 + y f2 + z t over a cell. */
static ep_range hull_of(const ep_point *net, size_t count, double x, double y, double z)
{
    ep_range r = EP_NOTHING;
    for (size_t i = 0; i < count; ++i) ep_include(&r, (x * net[i][0] + y * net[i][1] + z * net[i][2]) / net[i][3]);
    return r;
}

/* Does a cell miss the ray, seen along its longer side and across? That knows a surface which degenerates to a curve
 * from one that does not. */
static bool misses(const problem *p, const ep_point *net, size_t count, const aspect *a)
{
    for (int k = 0; k < 2; ++k) {
        const ep_range r = hull_of(net, count, a->e[k][0], a->e[k][1], 0);
        if (r.lo > 2 * p->rounding || r.hi < -2 * p->rounding) return true;
    }
    return false;
}

/* Narrows the range of t to that over the roots in a cell. There t - x f1 - y f2 is t: with x, y such that it does not
 * change along the longer side, and then along neither, its range is of the second order in the cell's size. The first
 * of these is of use even where the surface is a curve, all of whose preimage is one root. */
static void narrow(const problem *p, const ep_point *net, size_t count, const aspect *a, ep_range *t)
{
    double x = a->t_more / a->more[0], y = 0;
    for (int k = 0; k < 2; ++k) {
        const double f1 = x * a->e[0][0] + y * a->e[1][0], f2 = x * a->e[0][1] + y * a->e[1][1];
        const ep_range r = hull_of(net, count, -f1, -f2, 1);
        const double noise = (fabs(f1) + fabs(f2)) * p->rounding;
        t->lo = fmax(t->lo, r.lo - noise);
        t->hi = fmin(t->hi, r.hi + noise);
        if (!(fabs(a->less[1]) > 0x1p-20 * a->more[0])) return;
        y = (a->t_less - x * a->less[0]) / a->less[1];
    }
}

/* Length of a side of a triangular cell in space: of its control polygon from (i, j) on, in steps (di, dj). */
static double side_length(const problem *p, const ep_point *net, unsigned i, unsigned j, int di, int dj)
{
    double sum = 0, last[3] = {0};
    for (unsigned k = 0; k <= p->m; ++k, i += (unsigned)di, j += (unsigned)dj) {
        const double *q = net[p->kind->index(p->m, p->n, i, j)];
        const double x[3] = {q[0] / q[3], q[1] / q[3], q[2] / q[3] * p->speed};
        if (k)
            sum += sqrt((x[0] - last[0]) * (x[0] - last[0]) + (x[1] - last[1]) * (x[1] - last[1]) +
                        (x[2] - last[2]) * (x[2] - last[2]));
        memcpy(last, x, sizeof last);
    }
    return sum;
}

/* By how much f1, f2 (or t's numerator) change along a side at most. */
static double change(const ep_range *slope, int first, int end)
{
    double sum = 0;
    for (int k = first; k < end; ++k) sum += fmax(fabs(slope[k].lo), fabs(slope[k].hi));
    return sum;
}

/* Halves a cell: rectangles along the side on which f changes more; where it no longer does, because the ray lies in
 * the surface, that on which t does; triangles through the middle of their longest side in space, so that a collapsed
 * side does not double the number of cells at each level. Returns the number of parts. */
static unsigned halve(const problem *p, const ep_point *net, const slopes *g, const ep_domain *d, ep_domain part[2])
{
    if (!p->triangle) {
        const double s = change(g->s, 0, 2), t = change(g->t, 0, 2);
        if (fmax(s, t) > p->small) return p->kind->split(d, t > s, part);
        return p->kind->split(d, change(g->t, 2, 3) > change(g->s, 2, 3), part);
    }
    const double s = side_length(p, net, 0, 0, 1, 0), t = side_length(p, net, 0, 0, 0, 1),
                 across = side_length(p, net, p->m, 0, -1, 1);
    part[0] = part[1] = *d;
    if (across >= s && across >= t) { /* between the ends of both sides */
        part[0].uv = part[1].uu = (d->uu + d->uv) / 2;
        part[0].vv = part[1].vu = (d->vu + d->vv) / 2;
    } else if (s >= t) {
        part[0].uu = d->uu / 2, part[0].vu = d->vu / 2;
        part[1] = (ep_domain){d->u0 + d->uu / 2, d->v0 + d->vu / 2, d->uu / 2,
                              d->uv - d->uu / 2, d->vu / 2,         d->vv - d->vu / 2};
    } else {
        part[0].uv = d->uv / 2, part[0].vv = d->vv / 2;
        part[1] = (ep_domain){d->u0 + d->uv / 2, d->v0 + d->vv / 2, d->uu - d->uv / 2,
                              d->uv / 2,         d->vu - d->vv / 2, d->vv / 2};
    }
    return 2;
}

typedef enum verdict { NO_ROOT, ROOT, UNDECIDED } verdict;

/* Newton in a certified cell, from its middle. Rounding of f displaces roots by up to `slack`, which is much of a cell
 * next to a pole: a root that is outside by no more may be one that the cell beside it takes for this one's. In other
 * directions rounding may displace it by much less, so a root is where f is zero as far as it tells; if it is not at
 * the nearest point of the cell, smaller cells have to decide. */
static verdict newton(const problem *p, const ep_point *net, double *s, double *t)
{
    *s = p->kind->middle;
    *t = p->kind->middle;
    for (int k = 0; k < 64; ++k) {
        ep_jet j;
        p->kind->eval(net, p->m, p->n, *s, *t, &j);
        const double det = j.pu[0] * j.pv[1] - j.pv[0] * j.pu[1];
        const double ds = (j.pv[0] * j.p[1] - j.pv[1] * j.p[0]) / det;
        const double dt = (j.pu[1] * j.p[0] - j.pu[0] * j.p[1]) / det;
        const double step = fmax(fabs(ds), fabs(dt)), out = ep_outside(p->triangle, *s + ds, *t + dt);
        const double size = fmax(fabs(j.pu[0]) + fabs(j.pu[1]), fabs(j.pv[0]) + fabs(j.pv[1]));
        const double slack = (p->triangle ? 2 : 1) * size * p->noise / fabs(det) + 0x1p-24;
        if (out > (p->triangle ? 0.8 : 0.4) * step + slack) return NO_ROOT; /* two sides' errors add up in s + t */
        *s += ds;
        *t += dt;
        ep_clamp(p->triangle, s, t);
        if (step > slack) continue;
        if (out > slack) return NO_ROOT;
        p->kind->eval(net, p->m, p->n, *s, *t, &j);
        if (fmax(fabs(j.p[0]), fabs(j.p[1])) <= 2 * p->noise) return ROOT;
        if (out > 0) return UNDECIDED;
    }
    return UNDECIDED;
}

static void normal(const ep_patch *patch, const ep_leaf *leaf, double u, double v, double ng[3])
{
    const ep_kind *kind = &ep_kinds[patch->kind];
    const ep_domain d = ep_leaf_domain(leaf);
    const double cu = d.u0 + kind->middle * (d.uu + d.uv);
    const double cv = d.v0 + kind->middle * (d.vu + d.vv);
    ep_vec3 n = ep_v3(0, 0, 0);
    for (double inward = 0; inward <= 1; inward = inward ? 32 * inward : 0x1p-30) {
        ep_jet jet;
        kind->eval(patch->points, patch->degree_u, patch->degree_v, u + inward * (cu - u), v + inward * (cv - v), &jet);
        const ep_frame f = ep_project(&jet);
        n = ep_cross(f.pu, f.pv);
        /* regular as far as the rounding of the tangents, relative to the patch, lets us see */
        const double rounding = 0x1p-44 * patch->radius;
        if (ep_length(n) > rounding * (ep_length(f.pu) + ep_length(f.pv)) + rounding * rounding) break;
    }
    ng[0] = n.x, ng[1] = n.y, ng[2] = n.z;
}

/* Returns the part of the leaf's unit domain that the ray can meet. */
static ep_domain set_up(const ep_patch *patch, const ep_leaf *leaf, const ep_line *l, double after, double before,
                        problem *p)
{
    const ep_vec3 o = l->o, d = l->d;
    const ep_domain domain = ep_leaf_domain(leaf);
    ep_point local[MAX_POINTS];
    ep_vec3 n1, n2;
    p->t0 = l->t0;
    p->kind = &ep_kinds[patch->kind];
    p->m = patch->degree_u;
    p->n = patch->degree_v;
    p->triangle = patch->kind == EP_KIND_TRIANGLE;
    planes(leaf, d, &n1, &n2);
    const double dd = ep_dot(d, d);
    p->speed = sqrt(dd);
    ep_patch_local(patch, local);
    const ep_domain part = ep_line_part(patch, leaf, local, l, after, before);
    const size_t count = p->kind->point_count(p->m, p->n);
    double largest = 0;
    for (size_t i = 0; i < count; ++i) {
        const double w = local[i][3];
        const ep_vec3 x = ep_sub(ep_v3(local[i][0], local[i][1], local[i][2]), ep_scale(w, o));
        local[i][0] = ep_dot(n1, x);
        local[i][1] = ep_dot(n2, x);
        local[i][2] = ep_dot(d, x) / dd;
        largest = fmax(largest, w * (patch->radius + ep_length(o)));
    }
    p->kind->restrict_to(local, p->m, p->n, &domain, p->net);
    p->noise = (p->m + p->n + 4) * 16 * EP_EPS_D * largest;
    p->rounding = p->noise / patch->weight_min;
    p->small = fmax(p->noise, 0x1p-30 * patch->weight_min * patch->radius);
    p->small_t = 0x1p-30 * (patch->radius / sqrt(dd) + fabs(p->t0));
    return part;
}

bool ep_solve(const ep_patch *patch, const ep_leaf *leaf, const float org[3], const float dir[3], double after,
              double before, ep_root *root)
{
    ep_line l;
    problem p;
    if (!ep_line_of(patch, org, dir, &l)) return false;
    const ep_domain part = set_up(patch, leaf, &l, after, before, &p);
    const double t0 = l.t0;
    const size_t count = p.kind->point_count(p.m, p.n);
    cell stack[MAX_STACK];
    ep_point net[MAX_POINTS];
    unsigned depth = 0, most = MAX_CELLS;
    bool found = false, crossing = false;
    double best_s = 0, best_t = 0;
    stack[depth++] = (cell){part, -INFINITY};
    for (unsigned cells = 0; depth; ++cells) {
        const cell at = stack[--depth];
        if (at.t_low >= before - found * p.small_t) continue;
        p.kind->restrict_to(p.net, p.m, p.n, &at.d, net);
        const ep_range nothing = EP_NOTHING;
        ep_range f1 = nothing, f2 = nothing, seen[3] = {nothing, nothing, nothing};
        for (size_t i = 0; i < count; ++i) {
            ep_include(&f1, net[i][0]);
            ep_include(&f2, net[i][1]);
            for (int k = 0; k < 3; ++k) ep_include(&seen[k], net[i][k] / net[i][3]);
        }
        ep_range t = seen[2];
        if (f1.lo > p.noise || f1.hi < -p.noise || f2.lo > p.noise || f2.hi < -p.noise) continue;
        if (t0 + t.hi <= after || t0 + t.lo >= before - found * p.small_t) continue;

        const slopes g = net_slopes(&p, net);
        aspect a;
        if (look(&p, &g, seen, &a)) {
            if (misses(&p, net, count, &a)) continue;
            narrow(&p, net, count, &a, &t);
        }
        if (t0 + t.hi <= after || t0 + t.lo >= before - found * p.small_t) continue;

        double s = p.kind->middle, r = p.kind->middle;
        verdict v = UNDECIDED;
        const double largest = fmax(fmax(-f1.lo, f1.hi), fmax(-f2.lo, f2.hi));
        const double width = fmax(fabs(at.d.uu) + fabs(at.d.uv), fabs(at.d.vu) + fabs(at.d.vv));
        if (deviation(&p, &g) <= 0.125) v = newton(&p, net, &s, &r);
        const bool point = largest <= p.small && t.hi - t.lo <= p.small_t;
        const bool certified = v == ROOT;
        if (v == UNDECIDED && (point || width <= 0x1p-50 || cells >= most || depth + 4 > MAX_STACK)) {
            v = ROOT;
            if (cells >= most && most < MAX_CELLS + MORE_TIMES * MORE_CELLS) most += MORE_CELLS;
        }
        if (v == ROOT) {
            ep_jet jet;
            p.kind->eval(net, p.m, p.n, s, r, &jet);
            const double hit = t0 + jet.p[2] / jet.p[3];
            if (hit > after && hit < before) {
                before = hit;
                found = true;
                crossing = certified;
                best_s = at.d.u0 + s * at.d.uu + r * at.d.uv;
                best_t = at.d.v0 + s * at.d.vu + r * at.d.vv;
            }
        }
        if (v != UNDECIDED) continue;

        ep_domain part[2];
        const unsigned parts = halve(&p, net, &g, &at.d, part);
        /* The part whose middle is nearest along the ray goes on top; t is taken as linear between the corners, for
         * this is a guess that saves work and nothing else. */
        const size_t right = p.kind->index(p.m, p.n, p.m, 0), top = p.kind->index(p.m, p.n, 0, p.n);
        const double corner = net[0][2] / net[0][3];
        const double by_s = net[right][2] / net[right][3] - corner, by_t = net[top][2] / net[top][3] - corner;
        const double middle = p.kind->middle;
        const double det = at.d.uu * at.d.vv - at.d.uv * at.d.vu;
        cell c[2];
        for (unsigned k = 0; k < parts; ++k) {
            const double du = part[k].u0 + middle * (part[k].uu + part[k].uv) - at.d.u0;
            const double dv = part[k].v0 + middle * (part[k].vu + part[k].vv) - at.d.v0;
            const double key = (by_s * (du * at.d.vv - dv * at.d.uv) + by_t * (dv * at.d.uu - du * at.d.vu)) / det;
            unsigned to = k;
            for (; to > 0 && c[to - 1].t_low < key; --to) c[to] = c[to - 1];
            c[to] = (cell){part[k], key};
        }
        for (unsigned k = 0; k < parts; ++k) {
            c[k].t_low = t0 + t.lo; /* all that is proved until the cell's own hull is known */
            stack[depth++] = c[k];
        }
    }
    if (!found) return false;
    const ep_domain dom = ep_leaf_domain(leaf);
    root->t = before;
    root->crossing = crossing;
    root->u = fmin(fmax(dom.u0 + best_s * dom.uu + best_t * dom.uv, 0), 1);
    root->v = fmin(fmax(dom.v0 + best_s * dom.vu + best_t * dom.vv, 0), p.triangle ? 1 - root->u : 1);
    normal(patch, leaf, root->u, root->v, root->ng);
    return true;
}
