/* leaf.c - fits a leaf's frame, prism and certificate to a piece of a patch. See leaf.h for what they mean.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Everything follows from the piece's power series about the middle of its domain. In leaf coordinates its remainder
 * is r = R/W with R_st = M_st N - x W and R_h = M_h N, W being one in the middle; so bounds on the coefficients bound r
 * and its derivatives over the whole piece: the terms up to the second order by their range, those above by their
 * magnitudes, which fall off with the powers of the piece's size. What dividing by W adds is of the third order.
 * The frame is tangent to the piece at the middle, where the derivative of r is therefore zero, moved so that r_h's
 * range is centred on zero, and rounded to float before the bounds are taken: they hold for the frame that the kernels
 * use. */
#include "embree_patch/leaf.h"
#include "embree_patch/taylor.h"

#include <string.h>

/* The linear map of space to leaf coordinates, and its inverse's columns. */
typedef struct frame {
    ep_vec3 row[3], column[3];
} frame;

static ep_range widen(ep_range r, double e)
{
    return (ep_range){r.lo - e, r.hi + e};
}
static ep_range about(double x, double e)
{
    return (ep_range){x - e, x + e};
}

/* Bounds on a function and its derivatives over the piece. */
typedef struct bounds {
    ep_range value, ds, dt, dss, dst, dtt;
} bounds;

/* Degree of the series of r W. */
static unsigned rest_m(const ep_fit *f)
{
    return f->m + f->raised;
}
static unsigned rest_n(const ep_fit *f)
{
    return f->n + f->raised;
}

static double monomial(const ep_fit *f, unsigned i, unsigned j)
{
    return f->monomial[f->kind->index(rest_m(f), rest_n(f), i, j)];
}

/* R N - x W as a series; N and W are those of `series`. */
static void make_rest(ep_fit *f)
{
    const ep_kind *kind = f->kind;
    const unsigned m = rest_m(f), n = rest_n(f);
    memset(f->rest, 0, kind->point_count(m, n) * sizeof(ep_point));
    for (unsigned j = 0; j <= f->n; ++j)
        for (unsigned i = 0; i <= f->m; ++i) {
            const size_t from = kind->index(f->m, f->n, i, j);
            if (from == SIZE_MAX) continue;
            double *to = f->rest[kind->index(m, n, i, j)];
            for (int c = 0; c < 4; ++c) to[c] += f->series[from][c];
            /* the weight of a polynomial is one but for its rounding */
            const double w = f->raised ? f->series[from][3] : i + j == 0;
            if (w == 0) continue;
            f->rest[kind->index(m, n, i + 1, j)][0] -= w;
            f->rest[kind->index(m, n, i, j + 1)][1] -= w;
        }
}

/* Range of a x + rest[.] . b over the piece, a being linear. */
static ep_range linear_range(const ep_fit *f, const double a[2], const double b[4])
{
    const ep_kind *kind = f->kind;
    const unsigned m = rest_m(f), n = rest_n(f);
    double low[6] = {0, a[0], a[1], 0, 0, 0}, high = 0;
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = kind->index(m, n, i, j);
            if (at == SIZE_MAX) continue;
            const double *r = f->rest[at], x = b[0] * r[0] + b[1] * r[1] + b[2] * r[2] + b[3] * r[3];
            static const int place[3][3] = {{0, 1, 3}, {2, 4}, {5}};
            if (i + j <= 2) low[place[j][i]] += x;
            else high += fabs(x) * f->monomial[at];
        }
    return widen(kind->quadratic(low), high);
}

static bounds series_bounds(const ep_fit *f, int c)
{
    const ep_kind *kind = f->kind;
    const unsigned m = rest_m(f), n = rest_n(f);
    const double none[2] = {0, 0}, pick[4] = {c == 0, c == 1, c == 2, c == 3};
    double at_middle[5] = {0}, spread[5] = {0}; /* s, t, ss, st, tt */
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = kind->index(m, n, i, j);
            if (at == SIZE_MAX) continue;
            const double x = f->rest[at][c];
            const unsigned di[5] = {1, 0, 2, 1, 0}, dj[5] = {0, 1, 0, 1, 2};
            const double factor[5] = {i, j, i * (i - 1.0), i * (double)j, j * (j - 1.0)};
            for (int k = 0; k < 5; ++k) {
                if (i < di[k] || j < dj[k]) continue;
                if (i == di[k] && j == dj[k]) at_middle[k] = factor[k] * x;
                else spread[k] += factor[k] * fabs(x) * monomial(f, i - di[k], j - dj[k]);
            }
        }
    return (bounds){linear_range(f, none, pick),    about(at_middle[0], spread[0]), about(at_middle[1], spread[1]),
                    about(at_middle[2], spread[2]), about(at_middle[3], spread[3]), about(at_middle[4], spread[4])};
}

/* What W does to a quotient. */
typedef struct weight {
    double low;                   /* W >= low */
    double off;                   /* |1 - W| / low */
    double ds, dt, dss, dst, dtt; /* magnitudes of its derivatives, over low */
} weight;

static weight weight_bounds(const ep_fit *f, double least)
{
    const bounds w = series_bounds(f, 3);
    const double low = fmax(w.value.lo, least);
    return (weight){low,
                    fmax(1 - w.value.lo, w.value.hi - 1) / low,
                    ep_mag(w.ds) / low,
                    ep_mag(w.dt) / low,
                    ep_mag(w.dss) / low,
                    ep_mag(w.dst) / low,
                    ep_mag(w.dtt) / low};
}

/* r = R/W = R + R (1-W)/W, r' = (R' - r W')/W, r'' = (R'' - r'W' - W'r' - r W'')/W. */
static bounds quotient_bounds(bounds b, const weight *w)
{
    bounds q;
    q.value = widen(b.value, ep_mag(b.value) * w->off);
    const double v = ep_mag(q.value);
    q.ds = widen(b.ds, ep_mag(b.ds) * w->off + v * w->ds);
    q.dt = widen(b.dt, ep_mag(b.dt) * w->off + v * w->dt);
    const double vs = ep_mag(q.ds), vt = ep_mag(q.dt);
    q.dss = widen(b.dss, ep_mag(b.dss) * w->off + 2 * vs * w->ds + v * w->dss);
    q.dst = widen(b.dst, ep_mag(b.dst) * w->off + vs * w->dt + vt * w->ds + v * w->dst);
    q.dtt = widen(b.dtt, ep_mag(b.dtt) * w->off + 2 * vt * w->dt + v * w->dtt);
    return q;
}

/* The frame whose plane touches the piece where its tangents are ds, dt, with these as sides. */
static bool tangent_frame(ep_vec3 ds, ep_vec3 dt, frame *f)
{
    const ep_vec3 n = ep_cross(ds, dt);
    const double area = ep_length(n);
    /* Sides shorter than 2^-40 of each other, or as parallel, are a pole or a cusp as far as doubles can tell. */
    if (!(area > 0x1p-40 * (ep_dot(ds, ds) + ep_dot(dt, dt)))) return false;
    const ep_vec3 unit = ep_scale(1 / area, n);
    f->row[0] = ep_scale(1 / area, ep_cross(dt, unit));
    f->row[1] = ep_scale(1 / area, ep_cross(unit, ds));
    f->row[2] = ep_scale(1 / sqrt(area), unit); /* heights in units of the piece's width */
    return true;
}

static void round_frame(frame *f, ep_leaf *leaf)
{
    for (int c = 0; c < 3; ++c) {
        leaf->frame[0][c] = (float)f->row[c].x;
        leaf->frame[1][c] = (float)f->row[c].y;
        leaf->frame[2][c] = (float)f->row[c].z;
        f->row[c] = ep_v3(leaf->frame[0][c], leaf->frame[1][c], leaf->frame[2][c]);
    }
    const double det = ep_dot(f->row[0], ep_cross(f->row[1], f->row[2]));
    for (int c = 0; c < 3; ++c) f->column[c] = ep_scale(1 / det, ep_cross(f->row[(c + 1) % 3], f->row[(c + 2) % 3]));
}

/* The series in the frame about a point of space, and with it the remainder's. */
static void change_coordinates(ep_fit *f, const ep_point *q, const frame *g, ep_vec3 origin)
{
    const size_t count = f->kind->point_count(f->m, f->n);
    for (size_t k = 0; k < count; ++k) {
        const double w = q[k][3];
        const ep_vec3 x = ep_sub(ep_v3(q[k][0], q[k][1], q[k][2]), ep_scale(w, origin));
        for (int c = 0; c < 3; ++c) f->series[k][c] = ep_dot(g->row[c], x);
        f->series[k][3] = w;
    }
    make_rest(f);
}

/* A piece without a frame is a box around its control points. */
static void irregular(const ep_patch *p, const ep_point *local, const ep_domain *d, ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    const size_t count = f->kind->point_count(f->m, f->n);
    f->kind->restrict_to(local, f->m, f->n, d, f->series);
    for (int c = 0; c < 3; ++c) {
        f->lower[c] = INFINITY, f->upper[c] = -INFINITY;
        for (size_t k = 0; k < count; ++k) {
            const double x = p->centre[c] + f->series[k][c] / f->series[k][3];
            f->lower[c] = fmin(f->lower[c], x);
            f->upper[c] = fmax(f->upper[c], x);
        }
        leaf->centre[c] = (float)p->centre[c];
    }
    leaf->height = leaf->side = INFINITY;
    leaf->degree_s = leaf->degree_t = 0;
    leaf->rational = leaf->shape = 0;
    f->regular = false;
    f->thickness = f->distortion = INFINITY;
    f->net_floats = 0;
    f->error = 0;
}

/* Sum of |coefficient c| times its monomial's maximum. */
static double magnitude(const ep_fit *f, const ep_point *net, unsigned m, unsigned n, int c)
{
    double sum = 0;
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = f->kind->index(m, n, i, j);
            if (at != SIZE_MAX) sum += fabs(net[at][c]) * monomial(f, i, j);
        }
    return sum;
}

/* The largest contribution to a coordinate of the terms that a series of degree (m, n) has no place for. */
static double beyond(const ep_fit *f, unsigned m, unsigned n)
{
    double largest = 0;
    for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (unsigned j = 0; j <= f->n; ++j)
            for (unsigned i = 0; i <= f->m; ++i) {
                const size_t at = f->kind->index(f->m, f->n, i, j);
                if (at == SIZE_MAX || f->kind->index(m, n, i, j) != SIZE_MAX) continue;
                sum += fabs(f->series[at][c]) * monomial(f, i, j);
            }
        largest = fmax(largest, sum);
    }
    return largest;
}

/* The kernel needs no term that is lost in one rounding of a coordinate: small pieces of surfaces of high degree, and
 * of surfaces that are less curved than their degree allows, get by with fewer. Returns what is left out. */
static double reduce(ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    const bool triangle = f->kind == &ep_kinds[EP_KIND_TRIANGLE];
    unsigned m = f->m, n = f->n;
    while (m > 1 && beyond(f, m - 1, triangle ? m - 1 : n) <= EP_EPS_F) --m;
    if (triangle) n = m;
    while (!triangle && n > 1 && beyond(f, m, n - 1) <= EP_EPS_F) --n;
    const double lost = beyond(f, m, n);
    /* a weight that is one to within a rounding is one */
    const double off = magnitude(f, f->series, f->m, f->n, 3) - 1;
    if (leaf->rational && off <= EP_EPS_F) leaf->rational = 0;
    const unsigned special = m > n ? m : n;
    if (special <= EP_SPECIAL_DEGREES) m = n = special;
    leaf->degree_s = (uint8_t)m;
    leaf->degree_t = (uint8_t)n;
    leaf->shape = (uint8_t)((triangle * 2u + leaf->rational) * (EP_SPECIAL_DEGREES + 1) +
                            (special <= EP_SPECIAL_DEGREES ? special : 0));
    f->net_floats = ep_leaf_stride(leaf) * f->kind->point_count(m, n) + 1; /* the last one is read as if of four */
    return lost + fmax(off, 0) * !leaf->rational;
}

/* Coordinate c of `series` as far as its terms go. */
static ep_taylor taylor_of(const ep_fit *f, int c)
{
    ep_taylor a = {{0}, 0};
    for (unsigned j = 0; j <= f->n; ++j)
        for (unsigned i = 0; i <= f->m; ++i) {
            const size_t at = f->kind->index(f->m, f->n, i, j);
            if (at == SIZE_MAX) continue;
            if (i + j <= EP_TAYLOR_DEGREE) a.c[ep_taylor_index(i, j)] = f->series[at][c];
            else a.rest += fabs(f->series[at][c]) * monomial(f, i, j);
        }
    return a;
}

/* H x²/2 for the second derivatives of coordinate c; squares: x_s², x_s x_t, x_t². */
static ep_taylor half_form(const ep_leaf *leaf, int c, const ep_taylor squares[3])
{
    const ep_taylor none = {{0}, 0};
    ep_taylor r = ep_taylor_add(&none, leaf->second[0][c] / 2.0, &squares[0]);
    r = ep_taylor_add(&r, leaf->second[1][c], &squares[1]);
    return ep_taylor_add(&r, leaf->second[2][c] / 2.0, &squares[2]);
}

static void square(const ep_taylor x[2], const ep_monomials *m, ep_taylor squares[3])
{
    squares[0] = ep_taylor_multiply(&x[0], &x[0], m);
    squares[1] = ep_taylor_multiply(&x[0], &x[1], m);
    squares[2] = ep_taylor_multiply(&x[1], &x[1], m);
}

/* The model is r's middle and its second derivatives there. The graph: r_h - middle - H_h u²/2 over the feet u = x +
 * r_st. The foot: x less what w_start makes of u. Bounds on r's derivatives would not do: what distortion adds to r_h
 * is in u too, and cancels. */
static void model(const ep_fit *f, const bounds b[3], const weight *w, double lost, ep_leaf *leaf)
{
    static const ep_monomials square_piece = {.corners = 4, .corner = {{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}}},
                              triangle_piece = {
                                  .corners = 3,
                                  .corner = {{-1.0 / 3, -1.0 / 3}, {2.0 / 3, -1.0 / 3}, {-1.0 / 3, 2.0 / 3}}};
    ep_monomials m = f->kind == &ep_kinds[EP_KIND_TRIANGLE] ? triangle_piece : square_piece;
    for (unsigned d = 0, n = 0; d <= EP_TAYLOR_DEGREE; ++d)
        for (unsigned j = 0; j <= d; ++j, ++n) m.max[n] = f->kind->monomial(d - j, j);
    leaf->middle = (float)f->rest[0][2];
    for (int c = 0; c < 3; ++c) {
        leaf->second[0][c] = (float)ep_mid(b[c].dss);
        leaf->second[1][c] = (float)ep_mid(b[c].dst);
        leaf->second[2][c] = (float)ep_mid(b[c].dtt);
    }

    ep_taylor surface[3], squares[3];
    for (int c = 0; c < 3; ++c) surface[c] = taylor_of(f, c);
    if (leaf->rational) {
        const ep_taylor weight = taylor_of(f, 3);
        for (int c = 0; c < 3; ++c) surface[c] = ep_taylor_divide(&surface[c], &weight, w->low, &m);
    }
    square(surface, &m, squares);
    const ep_taylor arc = half_form(leaf, 2, squares);
    ep_taylor left = ep_taylor_add(&surface[2], -1, &arc);
    left.c[0] -= leaf->middle;
    leaf->graph = ep_round_up(ep_taylor_bound(&left, &m) + lost);

    const ep_taylor m_u[2] = {half_form(leaf, 0, squares), half_form(leaf, 1, squares)};
    ep_taylor products[2][2];
    for (int k = 0; k < 4; ++k) products[k / 2][k % 2] = ep_taylor_multiply(&surface[k / 2], &m_u[k % 2], &m);
    double foot = 0;
    for (unsigned c = 0; c < 2; ++c) {
        ep_taylor x = ep_taylor_add(&surface[c], -1, &m_u[c]);
        x = ep_taylor_add(&x, leaf->second[0][c], &products[0][0]);
        x = ep_taylor_add(&x, leaf->second[1][c], &products[0][1]);
        x = ep_taylor_add(&x, leaf->second[1][c], &products[1][0]);
        x = ep_taylor_add(&x, leaf->second[2][c], &products[1][1]);
        x.c[ep_taylor_index(1 - c, c)] -= 1;
        foot = fmax(foot, ep_taylor_bound(&x, &m));
    }
    /* and what the kernels' arithmetic adds to two dozen terms below this */
    leaf->foot = ep_round_up(foot + lost + 32 * EP_EPS_F * (1 + ep_mag(b[0].value) + ep_mag(b[1].value)));
}

/* Rounding of F in leaf coordinates; eps = 2^-24.
 *
 * A Horner scheme of degree (m, n) with coefficients rounded once errs by at most (2m + 2n + 3) eps times the sum of
 * the terms' magnitudes; a quotient adds the same for its denominator, times the value, which is at most one, and two.
 * The moved origin is right to 2 eps of itself and no farther than 3/2 of the piece's sides; M adds 3 eps of
 * the terms that it adds up. Adding x - M(o') and r takes 2 eps of two at most, each. */
static void rounding(const ep_patch *p, ep_fit *f, const frame *g, const weight *w, double lost, ep_leaf *leaf)
{
    const unsigned m = leaf->degree_s, n = leaf->degree_t;
    const double horner = (2.0 * (m + n) + 3) * EP_EPS_F;
    double error[3], moved[3], total[3];
    for (int c = 0; c < 3; ++c) {
        if (leaf->rational)
            error[c] =
                horner * (magnitude(f, f->series, f->m, f->n, c) + magnitude(f, f->series, f->m, f->n, 3)) / w->low +
                2 * EP_EPS_F;
        else error[c] = horner * magnitude(f, f->rest, rest_m(f), rest_n(f), c);
    }
    const double *a = &g->column[0].x, *b = &g->column[1].x;
    for (int k = 0; k < 3; ++k) moved[k] = 1.5 * (fabs(a[k]) + fabs(b[k]));
    /* the series was computed in double from points of the size of the patch, anywhere in space */
    const double far = fabs(p->centre[0]) + fabs(p->centre[1]) + fabs(p->centre[2]);
    const double made = 16 * EP_EPS_D * far + f->loss * p->radius;
    for (int c = 0; c < 3; ++c) {
        const double row[3] = {fabs(g->row[c].x), fabs(g->row[c].y), fabs(g->row[c].z)};
        const double frame_sum = row[0] * moved[0] + row[1] * moved[1] + row[2] * moved[2];
        total[c] = error[c] + lost + 5 * EP_EPS_F * frame_sum + ep_norm1(g->row[c]) * made;
        if (c < 2) total[c] += 4 * EP_EPS_F;
        total[c] *= 1 + 0x1p-10;
    }
    leaf->noise_st = ep_round_up(fmax(total[0], total[1]));
    leaf->noise_h = ep_round_up(total[2]);
    f->error =
        (ep_norm1(g->column[0]) + ep_norm1(g->column[1])) * leaf->noise_st + ep_norm1(g->column[2]) * leaf->noise_h;
    /* The plane's point from the unmoved origin: both o and t d are in it, 5 eps each; o is as long as t d but for
     * the piece's size. */
    const double st = fmax(ep_norm1(g->row[0]), ep_norm1(g->row[1])), h = ep_norm1(g->row[2]);
    leaf->reach_st = ep_round_up(12 * EP_EPS_F * st);
    leaf->reach_h = ep_round_up(12 * EP_EPS_F * h);
    leaf->side = ep_round_up(leaf->side + 2 * leaf->noise_st);
    leaf->height = ep_round_up(leaf->height + 2 * leaf->noise_h);
}

void ep_leaf_fit(const ep_patch *p, const ep_point *local, const ep_domain *d, ep_fit *f)
{
    const ep_kind *kind = &ep_kinds[p->kind];
    ep_leaf *leaf = &f->leaf;
    f->kind = kind;
    f->m = p->degree_u;
    f->n = p->degree_v;
    memset(leaf, 0, sizeof *leaf);
    leaf->rational = p->rational != 0;
    f->raised = p->rational;
    leaf->domain[0] = (float)d->u0, leaf->domain[1] = (float)d->v0;
    leaf->domain[2] = (float)d->uu, leaf->domain[3] = (float)d->vv;
    leaf->domain[4] = (float)d->uv, leaf->domain[5] = (float)d->vu;
    for (unsigned j = 0; j <= rest_n(f); ++j)
        for (unsigned i = 0; i <= rest_m(f); ++i) {
            const size_t at = kind->index(rest_m(f), rest_n(f), i, j);
            if (at != SIZE_MAX) f->monomial[at] = kind->monomial(i, j);
        }

    ep_point q[EP_NET_POINTS];
    kind->series(local, f->m, f->n, d, q);
    const size_t count = kind->point_count(f->m, f->n), s = kind->index(f->m, f->n, 1, 0),
                 t = kind->index(f->m, f->n, 0, 1);
    const double w0 = q[0][3], side = fmax(fabs(d->uu) + fabs(d->uv), fabs(d->vu) + fabs(d->vv));
    f->loss = 16 * EP_EPS_D * (f->m + f->n) * pow(1 + side, f->m + f->n); /* of binomials times powers of the side */
    for (size_t k = 0; k < count; ++k)
        for (int c = 0; c < 4; ++c) q[k][c] /= w0;
    const ep_vec3 at = ep_v3(q[0][0], q[0][1], q[0][2]);
    const ep_vec3 ds = ep_sub(ep_v3(q[s][0], q[s][1], q[s][2]), ep_scale(q[s][3], at));
    const ep_vec3 dt = ep_sub(ep_v3(q[t][0], q[t][1], q[t][2]), ep_scale(q[t][3], at));
    f->turn[0] = ep_length(ds);
    f->turn[1] = ep_length(dt);
    frame g;
    if (!tangent_frame(ds, dt, &g)) {
        irregular(p, local, d, f);
        return;
    }
    round_frame(&g, leaf);
    change_coordinates(f, q, &g, at);
    const weight w = weight_bounds(f, p->weight_min / w0);
    ep_vec3 origin = ep_add(at, ep_scale(ep_mid(quotient_bounds(series_bounds(f, 2), &w).value), g.column[2]));
    double *o = &origin.x;
    for (int c = 0; c < 3; ++c) {
        const double x = p->centre[c] + o[c];
        leaf->centre[c] = (float)x;
        leaf->centre_low[c] = (float)(x - leaf->centre[c]);
        o[c] = ((double)leaf->centre[c] - p->centre[c]) + leaf->centre_low[c];
    }
    change_coordinates(f, q, &g, origin);
    bounds b[3];
    for (int c = 0; c < 3; ++c) b[c] = quotient_bounds(series_bounds(f, c), &w);

    leaf->bend_st = leaf->warp_st = 0;
    for (int c = 0; c < 3; ++c) {
        float *bend = c < 2 ? &leaf->bend_st : &leaf->bend_h, *warp = c < 2 ? &leaf->warp_st : &leaf->warp_h;
        *bend = fmaxf(*bend, ep_round_up(ep_mag(b[c].dss) + 2 * ep_mag(b[c].dst) + ep_mag(b[c].dtt)));
        *warp = fmaxf(*warp, ep_round_up(ep_half(b[c].dss) + 2 * ep_half(b[c].dst) + ep_half(b[c].dtt) +
                                         EP_EPS_F * *bend)); /* the model's rounding */
    }
    leaf->side = ep_round_up(fmax(ep_mag(b[0].value), ep_mag(b[1].value)));
    leaf->height = ep_round_up(ep_mag(b[2].value));
    f->regular = leaf->height < INFINITY && leaf->side < INFINITY;
    f->thickness = 2 * ep_mag(b[2].value);
    f->distortion = fmax(ep_mag(b[0].ds) + ep_mag(b[0].dt), ep_mag(b[1].ds) + ep_mag(b[1].dt));
    leaf->stretch = (uint8_t)fmin(ceil(EP_STRETCH * f->distortion), EP_STRETCH);
    const double lost = reduce(f);
    model(f, b, &w, lost, leaf);
    rounding(p, f, &g, &w, lost, leaf);
    /* For the frame's matrix M, M a x M b = det M M^-T (a x b); and S_s x S_t = (uu vv - uv vu) S_u x S_v. */
    leaf->volume = (float)(1 / (ep_dot(g.row[0], ep_cross(g.row[1], g.row[2])) * (d->uu * d->vv - d->uv * d->vu)));

    for (int k = 0; k < 3; ++k) {
        const double a[2] = {(&g.column[0].x)[k], (&g.column[1].x)[k]}, none[2] = {0, 0};
        const double r[4] = {a[0], a[1], (&g.column[2].x)[k], 0};
        const ep_range x = widen(linear_range(f, a, r), ep_mag(linear_range(f, none, r)) * w.off);
        const double centre = (double)leaf->centre[k] + leaf->centre_low[k];
        f->lower[k] = centre + x.lo;
        f->upper[k] = centre + x.hi;
    }

    /* Halving the first side quarters what r'' in s adds to the height, and halves what it adds to E. The mixed term of
     * r_t behaves like that too, while that of r_s, a fan, does not care how wide it is and asks for the other side.
     * Twist and a little of everything goes by length, so that pieces stay square. */
    const double longer = fmax(f->turn[0], f->turn[1]), square = ep_mag(b[2].dst) + 0x1p-10;
    f->turn[0] =
        ep_mag(b[2].dss) + ep_mag(b[0].dss) + ep_mag(b[1].dss) + ep_mag(b[1].dst) + square * f->turn[0] / longer;
    f->turn[1] =
        ep_mag(b[2].dtt) + ep_mag(b[0].dtt) + ep_mag(b[1].dtt) + ep_mag(b[0].dst) + square * f->turn[1] / longer;
}

void ep_leaf_pack(const ep_fit *f, float *net)
{
    const ep_leaf *leaf = &f->leaf;
    if (!f->net_floats) return;
    const unsigned m = leaf->degree_s, n = leaf->degree_t, stride = ep_leaf_stride(leaf);
    memset(net, 0, f->net_floats * sizeof *net);
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t to = f->kind->index(m, n, i, j), from = f->kind->index(f->m, f->n, i, j);
            if (to == SIZE_MAX || from == SIZE_MAX) continue;
            double x[4];
            memcpy(x, f->series[from], sizeof x);
            if (!leaf->rational) {
                x[0] -= i == 1 && j == 0;
                x[1] -= i == 0 && j == 1;
            }
            for (unsigned c = 0; c < stride; ++c) net[stride * to + c] = (float)x[c];
        }
}
