/* leaf.c - fits a leaf's frame, prism and certificate to a piece of a patch. See leaf.h for what they mean.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * In leaf coordinates the remainder of a rational piece is r = R/W with R_st = M_st N - x W and R_h = M_h N: Bézier
 * polynomials, so hulls of their coefficients, differences and second differences bound r and its derivatives over
 * the whole piece. Everything that is bounded here is of second order in the size of the piece, which is why plain
 * interval quotients are tight enough. The frame is tangent to the piece at the middle of its domain, where the
 * derivative of r is therefore zero, moved so that the remainders' ranges are centred on zero, and rounded to float
 * before the bounds are taken, so they hold for the frame that the kernels use. */
#include "embree_patch/leaf.h"

#include <string.h>

enum { MAX_POINTS = (EP_NET_DEGREE + 1) * (EP_NET_DEGREE + 1) };

/* The affine map of space to leaf coordinates; row[i] . x + offset[i]. */
typedef struct frame {
    ep_vec3 row[3];
    double offset[3];
} frame;

typedef struct range {
    double lo, hi;
} range;

static const range nothing = { INFINITY, -INFINITY };
static void include(range *r, double x)
{
    r->lo = fmin(r->lo, x);
    r->hi = fmax(r->hi, x);
}
static double mid(range r) { return r.lo / 2 + r.hi / 2; }
static double half(range r) { return r.hi / 2 - r.lo / 2; }
static double mag(range r) { return fmax(-r.lo, r.hi); }

/* Bounds on one remainder r_s, r_t or r_h over the piece. */
typedef struct bounds {
    range value, ds, dt, dss, dst, dtt;
} bounds;

/* The nets of (R_s, R_t, R_h, W). */
typedef struct rest {
    const ep_kind *kind;
    unsigned m, n;
    ep_point net[MAX_POINTS];
} rest;

static void make_remainder(const ep_kind *kind, unsigned m, unsigned n, bool rational, const ep_point *q,
                           const frame *f, rest *r)
{
    double sw[MAX_POINTS], tw[MAX_POINTS];
    r->kind = kind;
    r->m = m;
    r->n = n;
    if (rational) {
        kind->raise(q, m, n, r->net, sw, tw);
        ++r->m;
        ++r->n;
    } else {
        memcpy(r->net, q, kind->point_count(m, n) * sizeof(ep_point));
        for (unsigned j = 0; j <= n; ++j)
            for (unsigned i = 0; i <= m; ++i) {
                const size_t k = kind->index(m, n, i, j);
                if (k == SIZE_MAX) continue;
                sw[k] = i / (double)m; /* Greville abscissae: the coefficients of s and t themselves */
                tw[k] = j / (double)n;
            }
    }
    const size_t count = kind->point_count(r->m, r->n);
    for (size_t k = 0; k < count; ++k) {
        double *p = r->net[k];
        const ep_vec3 x = ep_v3(p[0], p[1], p[2]);
        for (int c = 0; c < 3; ++c) p[c] = ep_dot(f->row[c], x) + f->offset[c] * p[3];
        p[0] -= sw[k];
        p[1] -= tw[k];
    }
}

static range quotient_range(const ep_point *net, size_t count, int c)
{
    range r = nothing;
    for (size_t k = 0; k < count; ++k) include(&r, net[k][c] / net[k][3]);
    return r;
}

/* Bounds on the coefficient c of the net itself, not divided by W. */
static bounds net_bounds(const rest *r, int c)
{
    const ep_kind *kind = r->kind;
    const unsigned m = r->m, n = r->n;
    const double fst = kind->mixed * m * n + kind->mixed_one * m;
    bounds b = { nothing, nothing, nothing, nothing, nothing, nothing };
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = kind->index(m, n, i, j);
            if (at == SIZE_MAX) continue;
            const size_t s = kind->index(m, n, i + 1, j), t = kind->index(m, n, i, j + 1),
                         ss = kind->index(m, n, i + 2, j), st = kind->index(m, n, i + 1, j + 1),
                         tt = kind->index(m, n, i, j + 2);
            const double p = r->net[at][c];
            include(&b.value, p);
            if (s != SIZE_MAX) include(&b.ds, m * (r->net[s][c] - p));
            if (t != SIZE_MAX) include(&b.dt, n * (r->net[t][c] - p));
            if (ss != SIZE_MAX) include(&b.dss, m * (m - 1.0) * (r->net[ss][c] - 2 * r->net[s][c] + p));
            if (st != SIZE_MAX) include(&b.dst, fst * (r->net[st][c] - r->net[s][c] - r->net[t][c] + p));
            if (tt != SIZE_MAX) include(&b.dtt, n * (n - 1.0) * (r->net[tt][c] - 2 * r->net[t][c] + p));
        }
    /* a degree of one has no second difference: the derivative is zero */
    if (m == 1) include(&b.dss, 0);
    if (n == 1) include(&b.dtt, 0);
    if (!(b.dst.lo <= b.dst.hi)) include(&b.dst, 0);
    return b;
}

/* [lo, hi] / [w.lo, w.hi] for positive w, widened by e. */
static range divide(range a, range w, double e)
{
    return (range){ fmin(a.lo / w.lo, a.lo / w.hi) - e, fmax(a.hi / w.lo, a.hi / w.hi) + e };
}

/* r = R/W: r' = (R' - r W') / W and r'' = (R'' - r'W' - W'r' - r W'') / W. */
static void remainder_bounds(const rest *r, bool rational, bounds b[3])
{
    const size_t count = r->kind->point_count(r->m, r->n);
    for (int c = 0; c < 3; ++c) b[c] = net_bounds(r, c);
    if (!rational) return;
    const bounds w = net_bounds(r, 3);
    const double w0 = w.value.lo, ws = mag(w.ds), wt = mag(w.dt);
    for (int c = 0; c < 3; ++c) {
        bounds q;
        q.value = quotient_range(r->net, count, c);
        const double v = mag(q.value);
        q.ds = divide(b[c].ds, w.value, v * ws / w0);
        q.dt = divide(b[c].dt, w.value, v * wt / w0);
        const double vs = mag(q.ds), vt = mag(q.dt);
        q.dss = divide(b[c].dss, w.value, (2 * vs * ws + v * mag(w.dss)) / w0);
        q.dst = divide(b[c].dst, w.value, (vs * wt + vt * ws + v * mag(w.dst)) / w0);
        q.dtt = divide(b[c].dtt, w.value, (2 * vt * wt + v * mag(w.dtt)) / w0);
        b[c] = q;
    }
}

/* The frame whose plane touches the piece at the middle of its domain, with the tangents there as sides. */
static bool tangent_frame(const ep_frame *at, const double middle[2], frame *f)
{
    const ep_vec3 n = ep_cross(at->pu, at->pv);
    const double area = ep_length(n);
    /* Sides shorter than 2^-40 of each other, or as parallel, are a pole or a cusp as far as doubles can tell. */
    if (!(area > 0x1p-40 * (ep_dot(at->pu, at->pu) + ep_dot(at->pv, at->pv)))) return false;
    const ep_vec3 unit = ep_scale(1 / area, n);
    f->row[0] = ep_scale(1 / area, ep_cross(at->pv, unit));
    f->row[1] = ep_scale(1 / area, ep_cross(unit, at->pu));
    f->row[2] = ep_scale(1 / sqrt(area), unit); /* heights in units of the piece's width */
    for (int c = 0; c < 3; ++c) f->offset[c] = (c < 2 ? middle[c] : 0) - ep_dot(f->row[c], at->p);
    return true;
}

static void round_frame(frame *f, float columns[4][3])
{
    for (int c = 0; c < 3; ++c) {
        columns[0][c] = (float)f->row[c].x;
        columns[1][c] = (float)f->row[c].y;
        columns[2][c] = (float)f->row[c].z;
        columns[3][c] = (float)f->offset[c];
        f->row[c] = ep_v3(columns[0][c], columns[1][c], columns[2][c]);
        f->offset[c] = columns[3][c];
    }
}

/* The quarters of the unit domain. */
static unsigned quarters(const ep_kind *kind, ep_domain part[4])
{
    const ep_domain unit = { 0, 0, 1, 0, 0, 1 };
    ep_domain half[4], two[4];
    const unsigned n = kind->split(&unit, 0, half);
    if (n == 4) {
        memcpy(part, half, sizeof half);
        return 4;
    }
    for (unsigned k = 0; k < 2; ++k) {
        kind->split(&half[k], 1, two);
        part[2 * k] = two[0];
        part[2 * k + 1] = two[1];
    }
    return 4;
}

static void point_box(const ep_point *q, size_t count, double lower[3], double upper[3])
{
    for (size_t k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c) {
            const double x = q[k][c] / q[k][3];
            lower[c] = fmin(lower[c], x);
            upper[c] = fmax(upper[c], x);
        }
}

static void irregular(ep_leaf *leaf, ep_fit_info *info)
{
    memset(leaf->frame, 0, sizeof leaf->frame);
    leaf->height = leaf->side_s = leaf->side_t = INFINITY;
    for (int c = 0; c < 3; ++c) leaf->bend[c] = leaf->warp[c] = INFINITY;
    leaf->noise_st = leaf->noise_h = leaf->stretch = INFINITY;
    leaf->reach_st = leaf->reach_h = 0;
    info->regular = false;
    info->thickness = info->distortion = INFINITY;
}

/* Rounding of F, in leaf coordinates; eps = 2^-24, R the patch's radius.
 *
 * A weight B_i(u) is a binomial times two powers: m+2 roundings; a sum of m+1 terms by fused multiply-adds: m+1 more;
 * likewise in v; the points carry one rounding, and two levels of linear mixing add at most 6 eps R. All sums are
 * convex, so |dS| <= (2(m+n) + 14) eps R; a rational point is a quotient of two such sums, whose error grows by at
 * most twice the ratio of the largest weight to the smallest W here. The moved origin adds 5 eps R. The frame then
 * multiplies by the sum norm of its rows and adds 4 eps; u = u0 + s uu rounds by eps, which is eps/uu in s. */
static void rounding(const ep_patch *p, const ep_domain *d, const frame *f, double w_min, ep_leaf *leaf)
{
    const double ratio = p->rational ? 2 * p->weight_max / w_min : 1;
    const double ds = ((2.0 * (p->degree_u + p->degree_v) + 14) * ratio + 5) * EP_EPS_F * p->radius;
    const double n_st = fmax(ep_norm1(f->row[0]), ep_norm1(f->row[1])), n_h = ep_norm1(f->row[2]);
    const double det = fabs(d->uu * d->vv - d->uv * d->vu);
    const double longest = fmax(fmax(fabs(d->uu), fabs(d->uv)), fmax(fabs(d->vu), fabs(d->vv)));
    const double shortest = det / longest; /* at most the domain's smaller width */
    leaf->noise_st = ep_round_up(n_st * ds + 4 * EP_EPS_F + 3 * EP_EPS_F / shortest);
    leaf->noise_h = ep_round_up(n_h * ds + 4 * EP_EPS_F);
    leaf->reach_st = ep_round_up(8 * EP_EPS_F * n_st);
    leaf->reach_h = ep_round_up(8 * EP_EPS_F * n_h);
    /* M(o) also rounds its offset */
    const double o_st = 8 * EP_EPS_F * fmax(fabs(f->offset[0]), fabs(f->offset[1]));
    const double o_h = 8 * EP_EPS_F * fabs(f->offset[2]);
    leaf->side_s = ep_round_up(leaf->side_s + o_st);
    leaf->side_t = ep_round_up(leaf->side_t + o_st);
    leaf->model_st = ep_round_up(leaf->model_st + o_st);
    leaf->height = ep_round_up(leaf->height + o_h);
    leaf->model_h = ep_round_up(leaf->model_h + o_h);
}

/* The quadratic with r's value at the middle of the domain, no slope there, and the middle of the range of each second
 * derivative. By Taylor's theorem with integral remainder about the middle x0, |r - model| <= |Dr(x0)| |x - x0| +
 * (half range of r_ss) (s-s0)²/2 + (of r_st) |s-s0||t-t0| + (of r_tt) (t-t0)²/2; Dr(x0) is the frame's rounding. */
static void model(const ep_kind *kind, const ep_frame *at, const frame *f, const bounds b[3], ep_leaf *leaf)
{
    double error[3];
    for (int c = 0; c < 3; ++c) {
        const double middle = c < 2 ? kind->centre[c] : 0;
        leaf->model[0][c] = (float)(ep_dot(f->row[c], at->p) + f->offset[c] - middle);
        leaf->model[1][c] = (float)mid(b[c].dss);
        leaf->model[2][c] = (float)mid(b[c].dst);
        leaf->model[3][c] = (float)mid(b[c].dtt);
        const double ds = fabs(ep_dot(f->row[c], at->pu) - (c == 0)), dt = fabs(ep_dot(f->row[c], at->pv) - (c == 1));
        error[c] = ds + dt + half(b[c].dss) * kind->square / 2 + half(b[c].dst) * kind->product +
                   half(b[c].dtt) * kind->square / 2;
        /* and what the kernels' arithmetic adds to a handful of terms below this */
        error[c] += 16 * EP_EPS_F * (1 + mag(b[c].dss) + mag(b[c].dst) + mag(b[c].dtt));
    }
    leaf->model_st = ep_round_up(fmax(error[0], error[1]));
    leaf->model_h = ep_round_up(error[2]);
}

/* For the frame's matrix M, M a x M b = det M M^-T (a x b); and S_s x S_t = (uu vv - uv vu) S_u x S_v. */
static void volume(const ep_domain *d, const frame *f, ep_leaf *leaf)
{
    const double det = ep_dot(f->row[0], ep_cross(f->row[1], f->row[2]));
    leaf->volume = (float)(1 / (det * (d->uu * d->vv - d->uv * d->vu)));
}

void ep_leaf_fit(const ep_patch *p, const ep_point *local, const ep_domain *d, bool tighten, ep_leaf *leaf,
                 ep_fit_info *info)
{
    const ep_kind *kind = &ep_kinds[p->kind];
    const unsigned m = p->degree_u, n = p->degree_v;
    const size_t count = kind->point_count(m, n);
    const bool rational = p->rational;
    ep_point q[MAX_POINTS], part_net[MAX_POINTS];
    ep_domain part[4];
    const unsigned parts = tighten ? quarters(kind, part) : 0;

    leaf->domain[0] = (float)d->u0, leaf->domain[1] = (float)d->v0;
    leaf->domain[2] = (float)d->uu, leaf->domain[3] = (float)d->vv;
    leaf->domain[4] = (float)d->uv, leaf->domain[5] = (float)d->vu;

    kind->restrict_to(local, m, n, d, q);
    for (int c = 0; c < 3; ++c) info->lower[c] = INFINITY, info->upper[c] = -INFINITY;
    if (!tighten) point_box(q, count, info->lower, info->upper);
    for (unsigned k = 0; k < parts; ++k) {
        kind->restrict_to(q, m, n, &part[k], part_net);
        point_box(part_net, count, info->lower, info->upper);
    }

    ep_jet jet;
    kind->eval(q, m, n, kind->centre[0], kind->centre[1], &jet);
    const ep_frame at = ep_project(&jet);
    info->turn[0] = ep_length(at.pu);
    info->turn[1] = ep_length(at.pv);
    frame f;
    rest r;
    bounds b[3];
    if (!tangent_frame(&at, kind->centre, &f)) {
        irregular(leaf, info);
        return;
    }
    make_remainder(kind, m, n, rational, q, &f, &r);
    for (int c = 0; c < 3; ++c) f.offset[c] -= mid(quotient_range(r.net, kind->point_count(r.m, r.n), c));
    round_frame(&f, leaf->frame);
    make_remainder(kind, m, n, rational, q, &f, &r);
    remainder_bounds(&r, rational, b);

    range value[3] = { b[0].value, b[1].value, b[2].value };
    if (tighten) {
        value[0] = value[1] = value[2] = nothing;
        for (unsigned k = 0; k < parts; ++k) {
            kind->restrict_to(r.net, r.m, r.n, &part[k], part_net);
            for (int c = 0; c < 3; ++c) {
                const range v = quotient_range(part_net, kind->point_count(r.m, r.n), c);
                include(&value[c], v.lo);
                include(&value[c], v.hi);
            }
        }
    }

    for (int c = 0; c < 3; ++c) {
        leaf->bend[c] = ep_round_up(mag(b[c].dss) + 2 * mag(b[c].dst) + mag(b[c].dtt));
        leaf->warp[c] = ep_round_up(half(b[c].dss) + 2 * half(b[c].dst) + half(b[c].dtt) +
                                    EP_EPS_F * leaf->bend[c]); /* the model's rounding */
    }
    leaf->side_s = ep_round_up(mag(value[0]));
    leaf->side_t = ep_round_up(mag(value[1]));
    leaf->height = ep_round_up(mag(value[2]));
    double w_min = INFINITY;
    for (size_t k = 0; k < count; ++k) w_min = fmin(w_min, q[k][3]);
    info->regular = true;
    info->thickness = 2 * mag(value[2]);
    info->distortion = fmax(mag(b[0].ds) + mag(b[0].dt), mag(b[1].ds) + mag(b[1].dt));
    leaf->stretch = ep_round_up(info->distortion);
    model(kind, &at, &f, b, leaf);
    volume(d, &f, leaf);
    rounding(p, d, &f, w_min, leaf);

    /* Halving the first side quarters what r'' in s adds to the height, and halves what it adds to E. The mixed term of
     * r_t behaves like that too, while that of r_s, a fan, does not care how wide it is and asks for the other side.
     * Twist and a little of everything goes by length, so that pieces stay square. */
    const double longer = fmax(info->turn[0], info->turn[1]), square = mag(b[2].dst) + 0x1p-10;
    info->turn[0] = mag(b[2].dss) + mag(b[0].dss) + mag(b[1].dss) + mag(b[1].dst) + square * info->turn[0] / longer;
    info->turn[1] = mag(b[2].dtt) + mag(b[0].dtt) + mag(b[1].dtt) + mag(b[0].dst) + square * info->turn[1] / longer;
}
