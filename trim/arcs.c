/* arcs.c - see arcs.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/arcs.h"

bool ep_arcs_find(const ep_trim *t, const ep_trim_part *part, const ep_trim_domain *d, ep_arcs *a)
{
    a->pieces = a->count = 0;
    if (part->pieces > EP_ARC_PIECES) return false;
    const ep_trim_edges edges = ep_domain_edges(d);
    const size_t n = ep_trim_part_pieces(part->words, a->piece);
    for (size_t i = 0; i < n; ++i) {
        const ep_piece *p = &t->pieces[a->piece[i]];
        a->first[i] = a->count;
        if (!ep_edges_arcs(&edges, p, t->points + p->first, a->point, EP_ARC_POINTS, &a->count)) return false;
    }
    a->pieces = (unsigned)n;
    a->first[n] = a->count;
    return true;
}

void ep_strip_extent(const double n[2], const ep_point2 *p, unsigned count, double *lo, double *hi)
{
    *lo = INFINITY, *hi = -INFINITY;
    for (unsigned i = 0; i < count; ++i) {
        const double h = n[0] * p[i][0] + n[1] * p[i][1];
        *lo = fmin(*lo, h), *hi = fmax(*hi, h);
    }
}

ep_strip ep_strip_around(const ep_point2 *p, unsigned count)
{
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (unsigned i = 0; i < count; ++i) x += p[i][0] / count, y += p[i][1] / count;
    for (unsigned i = 0; i < count; ++i) {
        const double dx = p[i][0] - x, dy = p[i][1] - y;
        xx += dx * dx, xy += dx * dy, yy += dy * dy;
    }
    const double angle = 0.5 * atan2(2 * xy, xx - yy);
    ep_strip s = {.n = {-sin(angle), cos(angle)}};
    ep_strip_extent(s.n, p, count, &s.lo, &s.hi);
    return s;
}
