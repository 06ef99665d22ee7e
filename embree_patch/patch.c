/* patch.c - the two kinds of patch, and what they have in common. See patch.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/patch.h"

#include <string.h>

static void put(float *to, const ep_point p)
{
    for (int c = 0; c < 4; ++c) to[c] = (float)p[c];
}

static size_t tensor_point_count(unsigned m, unsigned n) { return (size_t)(m + 1) * (n + 1); }
static size_t tensor_block_count(unsigned m, unsigned n) { return (size_t)m * n; }

static void tensor_restrict(const ep_point *net, unsigned m, unsigned n, const ep_domain *d, ep_point *out)
{
    ep_tensor_restrict(net, m, n, d->u0, d->u0 + d->uu, d->v0, d->v0 + d->vv, out);
}

static void tensor_pack(const ep_point *net, unsigned m, unsigned n, float *blocks)
{
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i < m; ++i, blocks += 16) {
            const ep_point *p = net + j * (m + 1) + i;
            put(blocks, p[0]);
            put(blocks + 4, p[m + 1]);
            put(blocks + 8, p[1]);
            put(blocks + 12, p[m + 2]);
        }
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

static void tensor_raise(const ep_point *net, unsigned m, unsigned n, ep_point *out, double *sw, double *tw)
{
    for (unsigned j = 0; j <= n + 1; ++j)
        for (unsigned i = 0; i <= m + 1; ++i, ++out, ++sw, ++tw) {
            const double s = i / (m + 1.0), t = j / (n + 1.0);
            memset(*out, 0, sizeof *out);
            *sw = *tw = 0;
            for (unsigned b = 0; b < 2; ++b)
                for (unsigned a = 0; a < 2; ++a) { /* a, b: this factor lowers i, j */
                    const double f = (a ? s : 1 - s) * (b ? t : 1 - t);
                    if (f == 0) continue;
                    const double *p = net[tensor_index(m, n, i - a, j - b)];
                    for (int c = 0; c < 4; ++c) (*out)[c] += f * p[c];
                    if (a) *sw += f * p[3];
                    if (b) *tw += f * p[3];
                }
        }
}

static size_t tri_point_count(unsigned n, unsigned unused) { return (void)unused, ep_tri_count(n); }
static size_t tri_block_count(unsigned n, unsigned unused) { return (void)unused, ep_tri_count(n - 1); }

static size_t tri_index(unsigned n, unsigned unused, unsigned i, unsigned j)
{
    return (void)unused, i + j <= n ? ep_tri_index(n, i, j) : SIZE_MAX;
}

static void tri_raise(const ep_point *net, unsigned n, unsigned unused, ep_point *out, double *sw, double *tw)
{
    (void)unused;
    for (unsigned j = 0; j <= n + 1; ++j)
        for (unsigned i = 0; i <= n + 1 - j; ++i, ++out, ++sw, ++tw) {
            const double s = i / (n + 1.0), t = j / (n + 1.0);
            static const ep_point zero = { 0 };
            const double *ps = i ? net[ep_tri_index(n, i - 1, j)] : zero, *pt = j ? net[ep_tri_index(n, i, j - 1)] : zero,
                         *p = i + j <= n ? net[ep_tri_index(n, i, j)] : zero;
            for (int c = 0; c < 4; ++c) (*out)[c] = s * ps[c] + t * pt[c] + (1 - s - t) * p[c];
            *sw = s * ps[3];
            *tw = t * pt[3];
        }
}

static void tri_eval(const ep_point *net, unsigned n, unsigned unused, double u, double v, ep_jet *jet)
{
    (void)unused;
    ep_tri_eval(net, n, u, v, jet);
}

static void tri_restrict(const ep_point *net, unsigned n, unsigned unused, const ep_domain *d, ep_point *out)
{
    (void)unused;
    const double W[2] = { d->u0, d->v0 };
    const double U[2] = { d->u0 + d->uu, d->v0 + d->vu };
    const double V[2] = { d->u0 + d->uv, d->v0 + d->vv };
    ep_tri_restrict(net, n, U, V, W, out);
}

static void tri_pack(const ep_point *net, unsigned n, unsigned unused, float *blocks)
{
    static const ep_point zero = { 0 };
    (void)unused;
    for (unsigned j = 0; j < n; ++j)
        for (unsigned i = 0; i < n - j; ++i, blocks += 16) {
            put(blocks, net[ep_tri_index(n, i, j)]);
            put(blocks + 4, net[ep_tri_index(n, i, j + 1)]);
            put(blocks + 8, net[ep_tri_index(n, i + 1, j)]);
            put(blocks + 12, zero);
        }
}

static unsigned tri_split(const ep_domain *d, unsigned along, ep_domain part[4])
{
    (void)along;
    const ep_domain h = { d->u0, d->v0, d->uu / 2, d->uv / 2, d->vu / 2, d->vv / 2 };
    part[0] = part[1] = part[2] = part[3] = h;
    part[1].u0 += h.uu, part[1].v0 += h.vu;
    part[2].u0 += h.uv, part[2].v0 += h.vv;
    /* the middle one stands on its head: its origin is the midpoint of the side opposite the origin */
    part[3] = (ep_domain){ d->u0 + h.uu + h.uv, d->v0 + h.vu + h.vv, -h.uu, -h.uv, -h.vu, -h.vv };
    return 4;
}

const ep_kind ep_kinds[2] = {
    [EP_KIND_TENSOR] = { "tensor", tensor_point_count, tensor_block_count, ep_tensor_eval, tensor_restrict,
                         tensor_pack, tensor_split, tensor_index, tensor_raise, 1, 0, { 0.5, 0.5 }, 1.0 / 4, 1.0 / 4 },
    [EP_KIND_TRIANGLE] = { "triangle", tri_point_count, tri_block_count, tri_eval, tri_restrict, tri_pack, tri_split,
                           tri_index, tri_raise, 1, -1, { 1.0 / 3, 1.0 / 3 }, 4.0 / 9, 2.0 / 9 },
};

static ep_vec3 quotient(const ep_point n, double w) { return ep_v3(n[0] / w, n[1] / w, n[2] / w); }

/* N = w P, so N' = w'P + wP' and N'' = w''P + 2w'P' + wP'', solved for the derivatives of P. */
ep_frame ep_project(const ep_jet *jet)
{
    const double w = jet->p[3], wu = jet->pu[3] / w, wv = jet->pv[3] / w;
    ep_frame f;
    f.p = quotient(jet->p, w);
    f.pu = ep_sub(quotient(jet->pu, w), ep_scale(wu, f.p));
    f.pv = ep_sub(quotient(jet->pv, w), ep_scale(wv, f.p));
    f.puu = ep_sub(quotient(jet->puu, w), ep_add(ep_scale(jet->puu[3] / w, f.p), ep_scale(2 * wu, f.pu)));
    f.puv = ep_sub(quotient(jet->puv, w),
                   ep_add(ep_scale(jet->puv[3] / w, f.p), ep_add(ep_scale(wu, f.pv), ep_scale(wv, f.pu))));
    f.pvv = ep_sub(quotient(jet->pvv, w), ep_add(ep_scale(jet->pvv[3] / w, f.p), ep_scale(2 * wv, f.pv)));
    return f;
}

void ep_patch_local(const ep_patch *p, ep_point *out)
{
    const size_t count = ep_kinds[p->kind].point_count(p->degree_u, p->degree_v);
    for (size_t i = 0; i < count; ++i) {
        const double w = p->points[i][3];
        for (int c = 0; c < 3; ++c)
            out[i][c] = p->points[i][c] - w * ((double)p->centre[c] + (double)p->centre_low[c]);
        out[i][3] = w;
    }
}

void ep_patch_pack(ep_patch *p, float *net)
{
    const ep_kind *kind = &ep_kinds[p->kind];
    const size_t count = kind->point_count(p->degree_u, p->degree_v);
    ep_point local[(EP_MAX_DEGREE + 1) * (EP_MAX_DEGREE + 1)];
    double lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };
    p->weight_max = 1;
    for (size_t i = 0; i < count; ++i) {
        const double w = p->points[i][3];
        p->weight_max = fmaxf(p->weight_max, ep_round_up(w));
        for (int c = 0; c < 3; ++c) {
            lo[c] = fmin(lo[c], p->points[i][c] / w);
            hi[c] = fmax(hi[c], p->points[i][c] / w);
        }
    }
    double radius = 0;
    for (int c = 0; c < 3; ++c) {
        const double middle = lo[c] + (hi[c] - lo[c]) / 2;
        p->centre[c] = (float)middle;
        p->centre_low[c] = (float)(middle - p->centre[c]);
        radius = fmax(radius, fmax(hi[c] - middle, middle - lo[c]) + fabs(middle) * 0x1p-46);
    }
    p->radius = ep_round_up(radius);
    ep_patch_local(p, local);
    kind->pack(local, p->degree_u, p->degree_v, net);
    p->net = net;
}
