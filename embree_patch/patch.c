/* patch.c - the two kinds of patch, and what they have in common. See patch.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/patch.h"
#include "embree_patch/twofold.h"

static ep_range sum(ep_range a, ep_range b)
{
    return (ep_range){a.lo + b.lo, a.hi + b.hi};
}
static ep_range common(ep_range a, ep_range b)
{
    return (ep_range){a.lo > b.lo ? a.lo : b.lo, a.hi < b.hi ? a.hi : b.hi};
}
static ep_range times(double c, double lo, double hi)
{
    return c < 0 ? (ep_range){c * hi, c * lo} : (ep_range){c * lo, c * hi};
}
static ep_range hull(const double *b, int n)
{
    ep_range r = {b[0], b[0]};
    for (int i = 1; i < n; ++i) ep_include(&r, b[i]);
    return r;
}

/* Rectangles: leaf coordinates in [-1/2, 1/2]². */

static size_t tensor_point_count(unsigned m, unsigned n)
{
    return (size_t)(m + 1) * (n + 1);
}

static void tensor_restrict(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, ep_point *out)
{
    ep_tensor_restrict(net, m, n, d->u0, d->u0 + d->uu, d->v0, d->v0 + d->vv, out);
}

static void tensor_series(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, bool twofold, ep_point *out)
{
    (twofold ? ep_twofold_tensor_series : ep_tensor_series)(net, m, n, d->u0 + d->uu / 2, d->uu, d->v0 + d->vv / 2,
                                                            d->vv, out);
}

/* The i-th difference of points doubles their roundings i times: binomial(m, i) (2 |uu s|)^i add up to (1 + 2 |uu
 * s|)^m, and |s| is a half at most. */
static double tensor_growth(unsigned m, unsigned n, const ep_domain *d)
{
    return ep_power(1 + fabs(d->uu), m) * ep_power(1 + fabs(d->vv), n);
}

static unsigned tensor_split(const ep_domain *d, unsigned along, ep_domain part[4])
{
    part[0] = part[1] = *d;
    if (along == 0) {
        part[0].uu = part[1].uu = d->uu / 2;
        part[1].u0 = d->u0 + d->uu / 2;
    } else {
        part[0].vv = part[1].vv = d->vv / 2;
        part[1].v0 = d->v0 + d->vv / 2;
    }
    return 2;
}

static size_t tensor_index(unsigned m, unsigned n, unsigned i, unsigned j)
{
    return i <= m && j <= n ? (size_t)j * (m + 1) + i : SIZE_MAX;
}

/* Term by term, s² is in [0, 1/4]; the control points of degree (2, 2), where it is in [-1/4, 1/4], know that it grows
 * where s does. */
static ep_range tensor_quadratic(const double c[6])
{
    static const double x[3] = {-0.5, 0, 0.5}, xx[3] = {0.25, -0.25, 0.25};
    double b[9];
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
            b[3 * j + i] = c[0] + c[1] * x[i] + c[2] * x[j] + c[3] * xx[i] + c[4] * x[i] * x[j] + c[5] * xx[j];
    ep_range r = {c[0], c[0]};
    r = sum(r, sum(times(c[1], -0.5, 0.5), times(c[2], -0.5, 0.5)));
    r = sum(r, sum(times(c[3], 0, 0.25), sum(times(c[4], -0.25, 0.25), times(c[5], 0, 0.25))));
    return common(r, hull(b, 9));
}

static double tensor_monomial(unsigned i, unsigned j)
{
    return ep_power(0.5, i + j);
}

/* Triangles: leaf coordinates with corners (-1/3, -1/3), (2/3, -1/3), (-1/3, 2/3). */

static size_t tri_point_count(unsigned n, unsigned unused)
{
    return (void)unused, ep_tri_count(n);
}

static size_t tri_index(unsigned n, unsigned unused, unsigned i, unsigned j)
{
    return (void)unused, i + j <= n ? ep_tri_index(n, i, j) : SIZE_MAX;
}

static void tri_eval(const ep_point *net, unsigned n, unsigned unused, double u, double v, ep_jet *jet)
{
    (void)unused;
    ep_tri_eval(net, n, u, v, jet);
}

static void tri_restrict(const ep_point *net, unsigned n, unsigned unused, const ep_domain *d, ep_point *out)
{
    (void)unused;
    const double W[2] = {d->u0, d->v0};
    const double U[2] = {d->u0 + d->uu, d->v0 + d->vu};
    const double V[2] = {d->u0 + d->uv, d->v0 + d->vv};
    ep_tri_restrict(net, n, U, V, W, out);
}

static void tri_series(const ep_point *net, unsigned n, unsigned unused, const ep_domain *d, bool twofold,
                       ep_point *out)
{
    (void)unused;
    const double X[2] = {d->u0 + (d->uu + d->uv) / 3, d->v0 + (d->vu + d->vv) / 3};
    const double U[2] = {d->uu, d->vu}, V[2] = {d->uv, d->vv};
    (twofold ? ep_twofold_tri_series : ep_tri_series)(net, n, X, U, V, out);
}

/* A step along s counts roundings as often as the magnitudes of its weights add up to, a, one along t b times; n!/(i!
 * j! k!) a^i |s|^i b^j |t|^j add up to (1 + a |s| + b |t|)^n, most in one of the corners. */
static double tri_growth(unsigned n, unsigned unused, const ep_domain *d)
{
    (void)unused;
    const double a = fabs(d->uu) + fabs(d->vu) + fabs(d->uu + d->vu);
    const double b = fabs(d->uv) + fabs(d->vv) + fabs(d->uv + d->vv);
    return ep_power(1 + (a + b + fmax(a, b)) / 3, n);
}

static unsigned tri_split(const ep_domain *d, unsigned along, ep_domain part[4])
{
    (void)along;
    const ep_domain h = {d->u0, d->v0, d->uu / 2, d->uv / 2, d->vu / 2, d->vv / 2};
    part[0] = part[1] = part[2] = part[3] = h;
    part[1].u0 += h.uu, part[1].v0 += h.vu;
    part[2].u0 += h.uv, part[2].v0 += h.vv;
    /* the middle one stands on its head: its origin is the midpoint of the side opposite the origin */
    part[3] = (ep_domain){d->u0 + h.uu + h.uv, d->v0 + h.vu + h.vv, -h.uu, -h.uv, -h.vu, -h.vv};
    return 4;
}

/* As above; the control points of degree 2 are blossoms at pairs of corners, and st is in [-2/9, 1/9]. */
static ep_range tri_quadratic(const double c[6])
{
    static const double corner[3][2] = {{-1.0 / 3, -1.0 / 3}, {2.0 / 3, -1.0 / 3}, {-1.0 / 3, 2.0 / 3}};
    double b[6], at[3];
    int n = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            const double *x = corner[i], *y = corner[j];
            b[n++] = c[0] + c[1] * (x[0] + y[0]) / 2 + c[2] * (x[1] + y[1]) / 2 + c[3] * x[0] * y[0] +
                     c[4] * (x[0] * y[1] + x[1] * y[0]) / 2 + c[5] * x[1] * y[1];
        }
    for (int i = 0; i < 3; ++i) at[i] = c[0] + c[1] * corner[i][0] + c[2] * corner[i][1];
    const ep_range second = sum(times(c[3], 0, 4.0 / 9), sum(times(c[4], -2.0 / 9, 1.0 / 9), times(c[5], 0, 4.0 / 9)));
    return common(sum(hull(at, 3), second), hull(b, 6));
}

/* Where |s| > 1/3, t is within 1/3 of zero, and the other way round. */
static double tri_monomial(unsigned i, unsigned j)
{
    return ep_power(2.0 / 3, i > j ? i : j) * ep_power(1.0 / 3, i > j ? j : i);
}

const ep_kind ep_kinds[2] = {
    [EP_KIND_TENSOR] = {"tensor",
                        tensor_point_count,
                        ep_tensor_eval,
                        tensor_restrict,
                        tensor_series,
                        tensor_growth,
                        tensor_split,
                        tensor_index,
                        tensor_quadratic,
                        tensor_monomial,
                        1,
                        1.0 / 2,
                        1.0 / 2,
                        {3.0 / 16, 0, 1.0 / 8}},
    [EP_KIND_TRIANGLE] = {"triangle",
                          tri_point_count,
                          tri_eval,
                          tri_restrict,
                          tri_series,
                          tri_growth,
                          tri_split,
                          tri_index,
                          tri_quadratic,
                          tri_monomial,
                          2,
                          1.0 / 3,
                          2.0 / 3,
                          {1.0 / 3, -0.1096, 0.0848}},
};

static ep_vec3 quotient(const ep_point n, double inverse)
{
    return ep_v3(n[0] * inverse, n[1] * inverse, n[2] * inverse);
}

/* N = w P, so N' = w'P + wP' and N'' = w''P + 2w'P' + wP'', solved for the derivatives of P; w: the weight's inverse.
 */
ep_frame ep_project(const ep_jet *jet)
{
    const double w = 1 / jet->p[3], wu = jet->pu[3] * w, wv = jet->pv[3] * w;
    ep_frame f;
    f.p = quotient(jet->p, w);
    f.pu = ep_sub(quotient(jet->pu, w), ep_scale(wu, f.p));
    f.pv = ep_sub(quotient(jet->pv, w), ep_scale(wv, f.p));
    f.puu = ep_sub(quotient(jet->puu, w), ep_add(ep_scale(jet->puu[3] * w, f.p), ep_scale(2 * wu, f.pu)));
    f.puv = ep_sub(quotient(jet->puv, w),
                   ep_add(ep_scale(jet->puv[3] * w, f.p), ep_add(ep_scale(wu, f.pv), ep_scale(wv, f.pu))));
    f.pvv = ep_sub(quotient(jet->pvv, w), ep_add(ep_scale(jet->pvv[3] * w, f.p), ep_scale(2 * wv, f.pv)));
    return f;
}

void ep_patch_local(const ep_patch *p, ep_point *out)
{
    const size_t count = ep_kinds[p->kind].point_count(p->degree_u, p->degree_v);
    for (size_t i = 0; i < count; ++i) {
        const double w = p->points[i][3];
        for (int c = 0; c < 3; ++c) out[i][c] = p->points[i][c] - w * p->centre[c];
        out[i][3] = w;
    }
}

void ep_hull(const ep_point *points, size_t count, ep_range box[3])
{
    for (int c = 0; c < 3; ++c) {
        box[c] = EP_NOTHING;
        for (size_t i = 0; i < count; ++i) ep_include(&box[c], points[i][c] / points[i][3]);
    }
}

void ep_patch_measure(ep_patch *p)
{
    const size_t count = ep_kinds[p->kind].point_count(p->degree_u, p->degree_v);
    ep_range box[3];
    ep_hull(p->points, count, box);
    p->weight_min = INFINITY, p->weight_max = 0;
    for (size_t i = 0; i < count; ++i) {
        const double w = p->points[i][3];
        p->weight_min = fmin(p->weight_min, w);
        p->weight_max = fmax(p->weight_max, w);
    }
    p->radius = 0;
    for (int c = 0; c < 3; ++c) {
        p->centre[c] = box[c].lo + (box[c].hi - box[c].lo) / 2;
        p->radius = fmax(p->radius, fmax(box[c].hi - p->centre[c], p->centre[c] - box[c].lo));
    }
}
