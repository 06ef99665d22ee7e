/* domain.c - see domain.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/domain.h"

#include <float.h>
#include <string.h>

ep_trim_domain ep_domain_polygon(unsigned count, const ep_point2 *corners, double margin)
{
    ep_trim_domain d = {.count = count, .margin = margin};
    double area = 0;
    for (unsigned i = 1; i + 1 < count; ++i)
        area += (corners[i][0] - corners[0][0]) * (corners[i + 1][1] - corners[0][1]) -
                (corners[i][1] - corners[0][1]) * (corners[i + 1][0] - corners[0][0]);
    for (unsigned i = 0; i < count; ++i) memcpy(d.corner[i], corners[area < 0 ? count - 1 - i : i], sizeof(ep_point2));
    return d;
}

ep_trim_domain ep_domain_rectangle(double u0, double u1, double v0, double v1, double margin)
{
    return (ep_trim_domain){4, {{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}}, margin};
}

double ep_domain_scale(const ep_trim_domain *d)
{
    double scale = 0;
    for (unsigned i = 0; i < d->count; ++i) scale = fmax(scale, fmax(fabs(d->corner[i][0]), fabs(d->corner[i][1])));
    return scale;
}

/* Less than 2^8 roundings, up to degree 25. */
double ep_domain_rounding(const ep_trim_domain *d, double scale)
{
    return fmax(0x1p-45 * fmax(scale, ep_domain_scale(d)), DBL_MIN);
}

/* The least distance between two parallels that hold the polygon. */
static double height(const ep_trim_domain *d)
{
    double least = INFINITY;
    for (unsigned i = 0; i < d->count; ++i) {
        const double *a = d->corner[i], *b = d->corner[(i + 1) % d->count];
        const double x = b[0] - a[0], y = b[1] - a[1], length = sqrt(x * x + y * y);
        double most = 0;
        for (unsigned k = 0; k < d->count; ++k)
            most = fmax(most, x * (d->corner[k][1] - a[1]) - y * (d->corner[k][0] - a[0]));
        if (length > 0) least = fmin(least, most / length);
    }
    return least < INFINITY ? least : 0;
}

ep_trim_domain ep_domain_settle(const ep_trim_domain *d, double scale)
{
    ep_trim_domain out = *d;
    if (out.margin < 0) out.margin = fmax(out.margin, -0x1p-4 * height(d));
    out.margin += ep_domain_rounding(d, scale);
    return out;
}

void ep_domain_bounds(const ep_trim_domain *d, ep_point2 lo, ep_point2 hi)
{
    for (int c = 0; c < 2; ++c) {
        lo[c] = hi[c] = d->corner[0][c];
        for (unsigned i = 1; i < d->count; ++i) {
            lo[c] = fmin(lo[c], d->corner[i][c]);
            hi[c] = fmax(hi[c], d->corner[i][c]);
        }
    }
}

void ep_domain_centre(const ep_trim_domain *d, ep_point2 out)
{
    for (int c = 0; c < 2; ++c) {
        out[c] = 0;
        for (unsigned i = 0; i < d->count; ++i) out[c] += d->corner[i][c] / d->count;
    }
}

bool ep_domain_clip(const ep_trim_domain *d, int axis, double c, bool above, ep_trim_domain *out)
{
    const double sign = above ? 1 : -1;
    ep_trim_domain q = {.margin = d->margin};
    bool inside = false;
    for (unsigned i = 0; i < d->count; ++i) {
        const double *a = d->corner[i], *b = d->corner[(i + 1) % d->count];
        const double ha = sign * (a[axis] - c), hb = sign * (b[axis] - c);
        if (q.count + 2 > EP_DOMAIN_CORNERS) return false;
        if (ha >= 0) memcpy(q.corner[q.count++], a, sizeof(ep_point2));
        if (ha > 0) inside = true;
        if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) {
            double *p = q.corner[q.count++];
            p[axis] = c;
            p[!axis] = a[!axis] + (b[!axis] - a[!axis]) * (ha / (ha - hb));
        }
    }
    *out = q;
    return inside && q.count >= 3;
}

ep_trim_edges ep_domain_edges(const ep_trim_domain *d)
{
    ep_trim_edges e = {.domain = d};
    for (unsigned i = 0; i < d->count; ++i) {
        const double *a = d->corner[i], *b = d->corner[(i + 1) % d->count];
        const double nx = b[1] - a[1], ny = a[0] - b[0];
        if (nx == 0 && ny == 0) continue;
        e.edge[e.count++] = (ep_trim_edge){a[0], a[1], nx, ny, d->margin * (fabs(nx) + fabs(ny))};
    }
    ep_domain_bounds(d, e.lo, e.hi);
    e.size = fmax(e.hi[0] - e.lo[0], e.hi[1] - e.lo[1]) + 2 * fabs(d->margin);
    for (int c = 0; c < 2; ++c) e.lo[c] -= d->margin, e.hi[c] += d->margin;
    return e;
}

/* Compared with the middle of what the margin leaves of the domain on that level. */
ep_beyond ep_edges_beyond(const ep_trim_edges *e, const ep_point2 end)
{
    if (end[1] < e->lo[1] || end[1] > e->hi[1]) return EP_BEYOND_LEFT_OF;
    double left = e->lo[0], right = e->hi[0];
    for (unsigned k = 0; k < e->count; ++k) {
        const ep_trim_edge *s = &e->edge[k];
        const double x = s->x + (s->offset - s->ny * (end[1] - s->y)) / s->nx;
        if (s->nx > 0) right = fmin(right, x);
        if (s->nx < 0) left = fmax(left, x);
    }
    return end[0] > 0.5 * (left + right) ? EP_BEYOND_ALWAYS : EP_BEYOND_NEVER;
}

static double outside(const ep_trim_edge *e, const ep_point2h p)
{
    return e->nx * (p[0] - e->x * p[2]) + e->ny * (p[1] - e->y * p[2]) - e->offset * p[2];
}

static bool is_within(const ep_trim_edges *e, const ep_point2h p)
{
    for (unsigned k = 0; k < e->count; ++k)
        if (outside(&e->edge[k], p) > 0) return false;
    return true;
}

/* Is the hull beyond one of the domain's edges, or the domain beyond the strip along the hull's chord? */
static bool is_apart(const ep_trim_edges *e, const ep_point2h *p, unsigned n)
{
    for (unsigned k = 0; k < e->count; ++k) {
        unsigned out = 0;
        while (out <= n && outside(&e->edge[k], p[out]) > 0) ++out;
        if (out == n + 1) return true;
    }
    const ep_trim_domain *d = e->domain;
    const double x = p[0][0] / p[0][2], y = p[0][1] / p[0][2];
    const double nx = y - p[n][1] / p[n][2], ny = p[n][0] / p[n][2] - x;
    /* what lies within the margin goes no further out than its corners; a seam's inner border is rounded by less */
    const double reach = d->margin * (d->margin > 0 ? fabs(nx) + fabs(ny) : sqrt(nx * nx + ny * ny));
    double lo = 0, hi = 0, dlo = INFINITY, dhi = -INFINITY;
    for (unsigned i = 1; i < n; ++i) {
        const double h = nx * (p[i][0] / p[i][2] - x) + ny * (p[i][1] / p[i][2] - y);
        lo = fmin(lo, h), hi = fmax(hi, h);
    }
    for (unsigned i = 0; i < d->count; ++i) {
        const double h = nx * (d->corner[i][0] - x) + ny * (d->corner[i][1] - y);
        dlo = fmin(dlo, h), dhi = fmax(dhi, h);
    }
    return dlo - reach > hi || dhi + reach < lo;
}

static double extent(const ep_point2h *p, unsigned n)
{
    return fmax(fabs(p[n][0] / p[n][2] - p[0][0] / p[0][2]), fabs(p[n][1] / p[n][2] - p[0][1] / p[0][2]));
}

/* Halves until an end is within the domain or the parts are apart from it. Parts much smaller than the domain that are
 * still neither pass a corner at next to no distance, and count as in. */
static bool enters(const ep_trim_edges *e, const ep_point2h *p, unsigned n)
{
    if (is_within(e, p[0]) || is_within(e, p[n])) return true;
    if (is_apart(e, p, n)) return false;
    if (extent(p, n) <= 0x1p-8 * e->size) return true;
    ep_point2h left[EP_CURVE_POINTS], right[EP_CURVE_POINTS];
    ep_curve_halve(p, n, left, right);
    return enters(e, left, n) || enters(e, right, n);
}

/* The part [t[0],t[1]] of a straight piece that the edges leave; what rounds is less than the margin. */
static bool clip_segment(const ep_trim_edges *e, const ep_point2h *p, double t[2])
{
    t[0] = 0, t[1] = 1;
    for (unsigned k = 0; k < e->count; ++k) {
        const double a = outside(&e->edge[k], p[0]), b = outside(&e->edge[k], p[1]);
        if (a > 0 && b > 0) return false;
        if (a > 0) t[0] = fmax(t[0], a / (a - b));
        if (b > 0) t[1] = fmin(t[1], a / (a - b));
    }
    return t[0] <= t[1];
}

static bool boxes_meet(const ep_trim_edges *e, const ep_piece *p)
{
    return fmin(p->low[0], p->high[0]) <= e->hi[0] && fmax(p->low[0], p->high[0]) >= e->lo[0] &&
           p->low[1] <= e->hi[1] && p->high[1] >= e->lo[1];
}

bool ep_edges_meet(const ep_trim_edges *e, const ep_piece *p, const ep_point2h *points)
{
    if (!boxes_meet(e, p)) return false;
    double t[2];
    return p->degree == 1 ? clip_segment(e, points, t) : enters(e, points, p->degree);
}

typedef struct arcs {
    const ep_trim_edges *edges;
    ep_point2 *out;
    unsigned room, count;
} arcs;

/* Parts of a sixteenth of the domain: their hulls are wider than the curve by 1/256 of what it bends there. */
static bool gather(arcs *a, const ep_point2h *p, unsigned n)
{
    if (is_apart(a->edges, p, n)) return true;
    if (extent(p, n) > 0x1p-4 * a->edges->size) {
        ep_point2h left[EP_CURVE_POINTS], right[EP_CURVE_POINTS];
        ep_curve_halve(p, n, left, right);
        return gather(a, left, n) && gather(a, right, n);
    }
    if (a->room - a->count < n + 1) return false;
    for (unsigned i = 0; i <= n; ++i, ++a->count)
        for (int c = 0; c < 2; ++c) a->out[a->count][c] = p[i][c] / p[i][2];
    return true;
}

bool ep_edges_arcs(const ep_trim_edges *e, const ep_piece *p, const ep_point2h *points, ep_point2 *out, unsigned room,
                   unsigned *count)
{
    if (!boxes_meet(e, p)) return true;
    arcs a = {.edges = e, .out = out, .room = room, .count = *count};
    bool fits;
    if (p->degree == 1) {
        double t[2];
        if (!clip_segment(e, points, t)) return true;
        fits = room - a.count >= 2;
        for (int i = 0; i < 2 && fits; ++i) ep_curve_eval(points, 1, t[i], out[a.count++]);
    } else {
        fits = gather(&a, points, p->degree);
    }
    *count = a.count;
    return fits;
}
