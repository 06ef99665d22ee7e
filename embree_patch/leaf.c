/* leaf.c - fits a leaf's frame and prism to a piece of a patch. See leaf.h for what they mean.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Everything follows from the piece's power series about the middle of its domain. In leaf coordinates its remainder
 * is r = R/W with R_st = M_st N - x W and R_h = M_h N, W being one in the middle; so bounds on the coefficients bound r
 * and its derivatives over the whole piece: the terms up to the second order by their range, those above by their
 * magnitudes, which fall off with the powers of the piece's size. What dividing by W adds is of the third order.
 * The frame is tangent to the piece at the middle, where the derivative of r is therefore zero, but for what the model
 * gains from (level), moved so that r_h's range is centred on zero, and rounded to float before the bounds are taken:
 * they hold for the frame that the kernels use. */
#include "embree_patch/leaf.h"

#include <string.h>

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
    double third; /* |dsss| + 3 |dsst| + 3 |dstt| + |dttt| */
} bounds;

/* R N - x W as a series; N and W are those of `series`. */
static void make_rest(ep_fit *f)
{
    const ep_kind *kind = f->kind;
    if (!f->raised) { /* the weight of a polynomial is one but for its rounding */
        memcpy(f->rest, f->series, f->terms * sizeof(ep_point));
        f->rest[f->low[1]][0] -= f->series[0][3];
        f->rest[f->low[2]][1] -= f->series[0][3];
        return;
    }
    const unsigned m = ep_rest_m(f), n = ep_rest_n(f);
    memset(f->rest, 0, f->terms * sizeof(ep_point));
    for (unsigned j = 0; j <= f->n; ++j)
        for (unsigned i = 0; i <= f->m; ++i) {
            const size_t from = kind->index(f->m, f->n, i, j);
            if (from == SIZE_MAX) continue;
            double *to = f->rest[kind->index(m, n, i, j)];
            for (int c = 0; c < 4; ++c) to[c] += f->series[from][c];
            f->rest[kind->index(m, n, i + 1, j)][0] -= f->series[from][3];
            f->rest[kind->index(m, n, i, j + 1)][1] -= f->series[from][3];
        }
}

static bounds series_bounds(const ep_fit *f, int c)
{
    double low[6], high = 0, third = 0, spread[5] = {0};
    for (int k = 0; k < 6; ++k) low[k] = f->low[k] != SIZE_MAX ? f->rest[f->low[k]][c] : 0;
    for (size_t k = 0; k < f->terms; ++k) {
        const double x = fabs(f->rest[k][c]);
        high += x * f->high[k];
        third += x * f->third[k];
        for (int d = 0; d < 5; ++d) spread[d] += x * f->spread[k][d];
    }
    return (bounds){widen(f->kind->quadratic(low), high),
                    about(low[1], spread[0]),
                    about(low[2], spread[1]),
                    about(2 * low[3], spread[2]),
                    about(low[4], spread[3]),
                    about(2 * low[5], spread[4]),
                    third};
}

/* What W does to a quotient. */
typedef struct weight {
    double low;                          /* W >= low */
    double off;                          /* |1 - W| / low */
    double ds, dt, dss, dst, dtt, third; /* magnitudes of its derivatives, over low */
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
                    ep_mag(w.dtt) / low,
                    w.third / low};
}

/* r = R/W = R + R (1-W)/W, r' = (R' - r W')/W, r'' = (R'' - r'W' - W'r' - r W'')/W; and for norms r''' = (R''' + 3 r''
 * W' + 3 r' W'' + r W''')/W. */
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
    const double second = ep_mag(q.dss) + 2 * ep_mag(q.dst) + ep_mag(q.dtt), w_second = w->dss + 2 * w->dst + w->dtt;
    q.third = b.third * (1 + w->off) + 3 * second * (w->ds + w->dt) + 3 * (vs + vt) * w_second + v * w->third;
    return q;
}

/* The frame whose plane touches the piece where its tangents are ds, dt, with these as sides. */
static bool tangent_frame(ep_vec3 ds, ep_vec3 dt, ep_fit *f)
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

static void round_frame(ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
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
static void change_coordinates(ep_fit *f, const ep_point *q, ep_vec3 origin)
{
    const size_t count = f->kind->point_count(f->m, f->n);
    for (size_t k = 0; k < count; ++k) {
        const double w = q[k][3];
        const ep_vec3 x = ep_sub(ep_v3(q[k][0], q[k][1], q[k][2]), ep_scale(w, origin));
        for (int c = 0; c < 3; ++c) f->series[k][c] = ep_dot(f->row[c], x);
        f->series[k][3] = w;
    }
    make_rest(f);
}

/* What the linear terms are that cancel as much of cubic ones as linear terms can: three quarters of s³, half of s²t.
 */
static ep_vec3 cancelling(const ep_fit *f, const double cubic[4])
{
    const double *level = f->kind->level;
    const double s = level[0] * cubic[0] + level[1] * cubic[1] + level[2] * cubic[2];
    const double t = level[0] * cubic[3] + level[1] * cubic[2] + level[2] * cubic[1];
    return ep_add(ep_scale(s, f->row[0]), ep_scale(t, f->row[1]));
}

/* Turns the frame so that what the model leaves has linear terms that cancel cubic ones. With H the second derivatives,
 * the foot of x being x + r_st(x), those are the cubic terms of r - H(x, r_st), of the height over its foot and of the
 * way back from it. */
static void level(ep_fit *f)
{
    double cubic[3][4] = {{0}}, quadratic[3][3] = {{0}}, weight[2] = {0};
    for (unsigned j = 0; j <= 3; ++j) {
        const size_t at = f->kind->index(ep_rest_m(f), ep_rest_n(f), 3 - j, j);
        for (int c = 0; c < 3 && at != SIZE_MAX; ++c) cubic[c][j] = f->rest[at][c];
    }
    for (unsigned j = 0; j <= 2; ++j)
        for (int c = 0; c < 3 && f->low[3 + j] != SIZE_MAX; ++c) quadratic[c][j] = f->rest[f->low[3 + j]][c];
    if (f->raised)
        for (unsigned j = 0; j <= 1; ++j) weight[j] = f->rest[f->low[1 + j]][3];
    double by[3][2][2]; /* H(x, .) */
    for (int c = 0; c < 3; ++c) {
        by[c][0][0] = 2 * quadratic[c][0], by[c][1][1] = 2 * quadratic[c][2];
        by[c][0][1] = by[c][1][0] = quadratic[c][1];
    }
    for (int j = 0; j <= 2; ++j)
        for (int k = 0; k <= 1; ++k) {
            for (int c = 0; c < 3; ++c) cubic[c][j + k] -= quadratic[c][j] * weight[k];
            for (int c = 0; c < 3; ++c)
                for (int d = 0; d < 2; ++d) cubic[c][j + k] -= quadratic[d][j] * by[c][d][k];
        }
    ep_vec3 off[3];
    for (int c = 0; c < 3; ++c) off[c] = cancelling(f, cubic[c]);
    for (int c = 0; c < 3; ++c) f->row[c] = ep_sub(f->row[c], off[c]);
}

/* The quadratic terms of the way from feet u back to heights and to x. Those of r at the middle are q; there u = (I +
 * L) x + q_st(x), so with A = (I + L)^-1 they are q_h(A u) and A q_st(A u). */
static void choose_model(ep_fit *f, const bounds b[3])
{
    double l[2][2], a[2][2], q[3][2][2], r[3][2][2] = {{{0}}};
    for (int c = 0; c < 2; ++c) {
        l[c][0] = (c == 0) + ep_mid(b[c].ds);
        l[c][1] = (c == 1) + ep_mid(b[c].dt);
    }
    const double det = l[0][0] * l[1][1] - l[0][1] * l[1][0];
    a[0][0] = l[1][1] / det, a[0][1] = -l[0][1] / det;
    a[1][0] = -l[1][0] / det, a[1][1] = l[0][0] / det;
    for (int c = 0; c < 3; ++c) {
        q[c][0][0] = 0.5 * ep_mid(b[c].dss);
        q[c][0][1] = q[c][1][0] = 0.5 * ep_mid(b[c].dst);
        q[c][1][1] = 0.5 * ep_mid(b[c].dtt);
    }
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 4; ++k)
            for (int n = 0; n < 4; ++n) r[c][k / 2][k % 2] += a[n / 2][k / 2] * q[c][n / 2][n % 2] * a[n % 2][k % 2];
    for (int j = 0; j < 3; ++j) {
        const double s = r[0][j / 2][(j + 1) / 2], t = r[1][j / 2][(j + 1) / 2];
        f->leaf.half[j][0] = (float)(a[0][0] * s + a[0][1] * t);
        f->leaf.half[j][1] = (float)(a[1][0] * s + a[1][1] * t);
        f->leaf.half[j][2] = (float)r[2][j / 2][(j + 1) / 2];
    }
}

/* Are all points of the series, but for rounding, on a line through the one in the middle? */
static bool is_line(const ep_fit *f, const ep_point *q, size_t count, ep_vec3 at)
{
    double longest = 0;
    ep_vec3 along = ep_v3(0, 0, 0), v[EP_NET_POINTS];
    for (size_t k = 0; k < count; ++k) {
        v[k] = ep_sub(ep_v3(q[k][0], q[k][1], q[k][2]), ep_scale(q[k][3], at));
        if (ep_length(v[k]) <= longest) continue;
        longest = ep_length(v[k]);
        along = v[k];
    }
    const double rounding = 0x1p-44 * f->patch->radius + 0x1p-36 * longest;
    for (size_t k = 0; k < count; ++k)
        if (ep_length(ep_cross(along, v[k])) > longest * rounding) return false;
    return true;
}

/* A piece without a frame is left to subdivision. */
static void irregular(ep_fit *f)
{
    ep_leaf *leaf = &f->leaf;
    leaf->height = leaf->rim = INFINITY;
    leaf->degree_s = leaf->degree_t = 0;
    leaf->rational = leaf->shape = 0;
    memset(leaf->frame, 0, sizeof leaf->frame);
    f->regular = false;
    f->thickness = f->distortion = INFINITY;
    f->net_floats = 0;
    f->error = 0;
}

void ep_leaf_put_centre(ep_fit *f, ep_vec3 *at)
{
    ep_leaf *leaf = &f->leaf;
    double *x = &at->x;
    for (int c = 0; c < 3; ++c) {
        const double sum = f->patch->centre[c] + x[c];
        leaf->centre[c] = (float)sum;
        leaf->centre_low[c] = (float)(sum - leaf->centre[c]);
        x[c] = ((double)leaf->centre[c] - f->patch->centre[c]) + leaf->centre_low[c];
    }
}

void ep_leaf_begin(const ep_patch *p, ep_fit *f)
{
    const ep_kind *kind = &ep_kinds[p->kind];
    f->patch = p;
    f->kind = kind;
    f->m = p->degree_u;
    f->n = p->degree_v;
    f->raised = p->rational;
    ep_patch_local(p, f->local);
    const unsigned m = ep_rest_m(f), n = ep_rest_n(f);
    f->terms = kind->point_count(m, n);
    for (unsigned j = 0, k = 0; j <= 2; ++j)
        for (unsigned i = 0; i + j <= 2; ++i, ++k) {
            static const unsigned place[6] = {0, 1, 3, 2, 4, 5};
            f->low[place[k]] = kind->index(m, n, i, j);
        }
    for (unsigned j = 0; j <= n; ++j)
        for (unsigned i = 0; i <= m; ++i) {
            const size_t at = kind->index(m, n, i, j);
            if (at == SIZE_MAX) continue;
            f->monomial[at] = kind->monomial(i, j);
            f->high[at] = i + j > 2 ? f->monomial[at] : 0;
            const unsigned di[5] = {1, 0, 2, 1, 0}, dj[5] = {0, 1, 0, 1, 2};
            const double factor[5] = {i, j, i * (i - 1.0), i * (double)j, j * (j - 1.0)};
            for (int d = 0; d < 5; ++d)
                f->spread[at][d] = i < di[d] || j < dj[d] || (i == di[d] && j == dj[d])
                                       ? 0
                                       : factor[d] * kind->monomial(i - di[d], j - dj[d]);
            f->third[at] = 0;
            for (unsigned d = 0; d <= 3; ++d) { /* by s 3 - d times, by t d times */
                static const double times[4] = {1, 3, 3, 1};
                if (i < 3 - d || j < d) continue;
                double size = times[d];
                for (unsigned k = 0; k < 3 - d; ++k) size *= i - k;
                for (unsigned k = 0; k < d; ++k) size *= j - k;
                f->third[at] += size * kind->monomial(i - (3 - d), j - d);
            }
        }
}

/* A series that would lose more than this of the patch in double is computed in twice the digits. */
static const double max_loss = 0x1p-26;

/* The largest |term| of each place, added up, in units of the largest point. */
static double terms_of(const ep_fit *f, const ep_point *q)
{
    const double scale[4] = {f->patch->radius, f->patch->radius, f->patch->radius, 1};
    double total = 0;
    for (unsigned j = 0; j <= f->n; ++j)
        for (unsigned i = 0; i <= f->m; ++i) {
            const size_t at = f->kind->index(f->m, f->n, i, j);
            double largest = 0;
            for (int c = 0; c < 4 && at != SIZE_MAX; ++c) largest = fmax(largest, fabs(q[at][c]) / scale[c]);
            if (largest > 0) total += largest * ep_monomial(f, i, j);
        }
    return total / f->patch->weight_max;
}

/* The piece's series, and its `loss`. An eps of the largest point is lost at most four times a degree on the way to a
 * coefficient of w S, and as often when the frame is moved, and twice a degree where the middle is rounded; the same of
 * w, at a point of the patch: 16 a degree, as often as points count. Twice the digits square that; what is left then is
 * the rounding of coefficients, which count as much as they are. */
static void make_series(ep_fit *f, const ep_domain *d, ep_point *q)
{
    const ep_patch *p = f->patch;
    const double eps = 16 * EP_EPS_D * (f->m + f->n), in_double = eps * f->kind->growth(f->m, f->n, d);
    const bool twofold = !(in_double * p->weight_max <= max_loss * p->weight_min);
    f->kind->series(f->local, f->m, f->n, d, twofold, q);
    f->loss = twofold ? eps * (1 + terms_of(f, q) + in_double) : in_double;
}

void ep_leaf_fit(const ep_domain *d, ep_fit *f)
{
    const ep_patch *p = f->patch;
    const ep_kind *kind = f->kind;
    ep_leaf *leaf = &f->leaf;
    memset(leaf, 0, sizeof *leaf);
    leaf->rational = p->rational != 0;
    f->area = d->uu * d->vv - d->uv * d->vu;
    leaf->domain[0] = (float)d->u0, leaf->domain[1] = (float)d->v0;
    leaf->domain[2] = (float)d->uu, leaf->domain[3] = (float)d->vv;
    leaf->domain[4] = (float)d->uv, leaf->domain[5] = (float)d->vu;

    ep_point q[EP_NET_POINTS];
    make_series(f, d, q);
    const size_t count = kind->point_count(f->m, f->n), s = kind->index(f->m, f->n, 1, 0),
                 t = kind->index(f->m, f->n, 0, 1);
    const double w0 = q[0][3];
    for (size_t k = 0; k < count; ++k)
        for (int c = 0; c < 4; ++c) q[k][c] /= w0;
    const ep_vec3 at = ep_v3(q[0][0], q[0][1], q[0][2]);
    const ep_vec3 ds = ep_sub(ep_v3(q[s][0], q[s][1], q[s][2]), ep_scale(q[s][3], at));
    const ep_vec3 dt = ep_sub(ep_v3(q[t][0], q[t][1], q[t][2]), ep_scale(q[t][3], at));
    f->turn[0] = ep_length(ds);
    f->turn[1] = ep_length(dt);
    f->line = false;
    if (!tangent_frame(ds, dt, f)) {
        irregular(f);
        f->line = is_line(f, q, count, at);
        return;
    }
    change_coordinates(f, q, at);
    level(f);
    round_frame(f);
    change_coordinates(f, q, at);
    const weight w = weight_bounds(f, p->weight_min / w0);
    f->loss *= p->weight_max / (w0 * w.low);
    ep_vec3 origin = ep_add(at, ep_scale(ep_mid(quotient_bounds(series_bounds(f, 2), &w).value), f->column[2]));
    ep_leaf_put_centre(f, &origin);
    change_coordinates(f, q, origin);
    bounds b[3];
    for (int c = 0; c < 3; ++c) b[c] = quotient_bounds(series_bounds(f, c), &w);

    choose_model(f, b);
    leaf->bend_st = leaf->twist_st = 0;
    for (int c = 0; c < 3; ++c) {
        float *bend = c < 2 ? &leaf->bend_st : &leaf->bend_h, *twist = c < 2 ? &leaf->twist_st : &leaf->twist_h;
        *bend = fmaxf(*bend, ep_round_up(ep_mag(b[c].dss) + 2 * ep_mag(b[c].dst) + ep_mag(b[c].dtt)));
        /* and bounds of the model's */
        const double form = fabs(leaf->half[0][c]) + 2 * fabs(leaf->half[1][c]) + fabs(leaf->half[2][c]);
        *bend = fmaxf(*bend, ep_round_up(2 * form));
        *twist = fmaxf(*twist, ep_round_up(b[c].third / 3));
    }
    f->side = fmax(ep_mag(b[0].value), ep_mag(b[1].value));
    leaf->height = ep_round_up(ep_mag(b[2].value));
    leaf->sigma = ep_round_up(1 + fmax(ep_mag(b[0].ds) + ep_mag(b[1].ds), ep_mag(b[0].dt) + ep_mag(b[1].dt)));
    f->regular = leaf->height < INFINITY && f->side < INFINITY;
    if (!f->regular) {
        irregular(f);
        return;
    }
    f->thickness = 2 * ep_mag(b[2].value);
    f->distortion = fmax(ep_mag(b[0].ds) + ep_mag(b[0].dt), ep_mag(b[1].ds) + ep_mag(b[1].dt));
    leaf->stretch = (uint8_t)fmin(ceil(EP_STRETCH * f->distortion), EP_STRETCH);
    f->weight_low = w.low;

    /* Halving the first side quarters what r'' in s adds to the height, and halves what it adds to E. The mixed term of
     * r_t behaves like that too, while that of r_s, a fan, does not care how wide it is and asks for the other side.
     * Twist and a little of everything goes by length, so that pieces stay square. */
    const double longer = fmax(f->turn[0], f->turn[1]), square = ep_mag(b[2].dst) + 0x1p-10;
    f->turn[0] =
        ep_mag(b[2].dss) + ep_mag(b[0].dss) + ep_mag(b[1].dss) + ep_mag(b[1].dst) + square * f->turn[0] / longer;
    f->turn[1] =
        ep_mag(b[2].dtt) + ep_mag(b[0].dtt) + ep_mag(b[1].dtt) + ep_mag(b[0].dst) + square * f->turn[1] / longer;
}

/* That of the piece's control points, whose surface is a quarter of a percent above the least for pieces as flat as
 * these, and a bit more for roots just beyond the border. */
void ep_leaf_box(const ep_fit *f, const ep_domain *d, double lower[3], double upper[3])
{
    const ep_patch *p = f->patch;
    ep_point net[EP_NET_POINTS];
    f->kind->restrict_to(f->local, f->m, f->n, d, net);
    ep_range box[3];
    ep_hull(net, f->kind->point_count(f->m, f->n), box);
    for (int c = 0; c < 3; ++c) {
        const double way = f->regular ? fabs((&f->column[0].x)[c]) + fabs((&f->column[1].x)[c]) : 0;
        lower[c] = p->centre[c] + box[c].lo - (double)EP_SHARP * way;
        upper[c] = p->centre[c] + box[c].hi + (double)EP_SHARP * way;
    }
}
