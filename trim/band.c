/* band.c - see band.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Why corners tell for either side of a band. One side of a parabola is convex, so what it has of the cell is in one
 * piece. The other side is the cell but for a convex set: any point there can be parted from the set by a line, and the
 * half of the cell beyond that line is convex and has a corner. So every piece of a side that has more than one, has a
 * corner of the cell; when no curve is on that side, and its corners agree, all of it is as they are. */
#include "trim/band.h"
#include "trim/arcs.h"

typedef struct band {
    int a, b, c, lo, hi;
} band;

static void put(band s, uint32_t words[2])
{
    words[0] = (uint32_t)s.a << 20 | ((uint32_t)s.b & 0xFFF) << 8 | ((uint32_t)s.c & 0xFF);
    words[1] = (uint32_t)s.hi << 16 | ((uint32_t)s.lo & 0xFFFF);
}

void ep_band_even(bool inside, uint32_t words[2])
{
    put(inside ? (band){.lo = -INT16_MAX, .hi = -1} : (band){.lo = 1, .hi = INT16_MAX}, words);
}

static double value(const band *s, double x, double y)
{
    const double t = s->b * x - s->a * y;
    return s->a * x + s->b * y + s->c * (double)EP_BAND_BEND * t * t;
}

/* Least squares: with h along n and s across it, h = k0 + k1 s + k2 s². */
static void fit_parabola(const ep_arcs *arcs, const double n[2], double *k1, double *k2)
{
    const double count = arcs->count;
    double s1 = 0, s2 = 0, s3 = 0, s4 = 0, h0 = 0, h1 = 0, h2 = 0;
    for (unsigned i = 0; i < arcs->count; ++i) {
        const double *p = arcs->point[i], h = n[0] * p[0] + n[1] * p[1], s = n[1] * p[0] - n[0] * p[1];
        s1 += s, s2 += s * s, s3 += s * s * s, s4 += s * s * s * s;
        h0 += h, h1 += h * s, h2 += h * s * s;
    }
    const double a = s2 - s1 * s1 / count, b = s3 - s1 * s2 / count, c = s4 - s2 * s2 / count;
    const double e = h1 - h0 * s1 / count, f = h2 - h0 * s2 / count, det = a * c - b * b;
    *k1 = *k2 = 0;
    if (!(det > 0)) return;
    *k1 = (e * c - f * b) / det, *k2 = (f * a - e * b) / det;
}

/* The parabola h = k1 s + k2 s² has, where it passes the middle, another normal and this curvature. */
static band band_along(const ep_arcs *arcs)
{
    const ep_strip strip = ep_strip_around(arcs->point, arcs->count);
    double k1, k2;
    fit_parabola(arcs, strip.n, &k1, &k2);
    const double length = sqrt(1 + k1 * k1), size = EP_BAND_NORMAL / length;
    const double c = -k2 / (length * length * length) / (EP_BAND_NORMAL * (double)EP_BAND_BEND);
    return (band){.a = (int)rint(size * (strip.n[0] - k1 * strip.n[1])),
                  .b = (int)rint(size * (strip.n[1] + k1 * strip.n[0])),
                  .c = (int)rint(fmin(fmax(c, -EP_BAND_MOST_BEND), EP_BAND_MOST_BEND))};
}

/* From where to where q goes on the arcs. What is squared has, over the weights of an arc's points, a mean and a
 * variance, which is a quarter of the square of its range at most: q lies by no more than that beyond its values at the
 * points, on the side where the square counts against it. */
static void range_on(const ep_trim *t, const ep_arcs *arcs, const band *s, double *lo, double *hi)
{
    double widest = 0;
    *lo = INFINITY, *hi = -INFINITY;
    for (unsigned i = 0; i < arcs->pieces; ++i) {
        const unsigned points = t->pieces[arcs->piece[i]].degree + 1;
        for (unsigned first = arcs->first[i]; first < arcs->first[i + 1]; first += points) {
            double least = INFINITY, most = -INFINITY;
            for (unsigned k = first; k < first + points; ++k) {
                const double *p = arcs->point[k], w = s->b * p[0] - s->a * p[1], q = value(s, p[0], p[1]);
                least = fmin(least, w), most = fmax(most, w);
                *lo = fmin(*lo, q), *hi = fmax(*hi, q);
            }
            widest = fmax(widest, most - least);
        }
    }
    const double off = s->c * (double)EP_BAND_BEND * widest * widest / 4;
    *lo -= fmax(off, 0), *hi += fmax(-off, 0);
}

/* In units; one that is out of range is out of reach. */
static int line(double q)
{
    return (int)fmin(fmax(q, -INT16_MAX), INT16_MAX);
}

void ep_band_fit(const ep_trim *t, const ep_trim_part *part, const ep_trim_domain *cell, uint32_t side,
                 uint32_t words[2])
{
    put((band){.lo = -INT16_MAX, .hi = INT16_MAX}, words);
    ep_arcs arcs;
    ep_point2 low, high, centre;
    const ep_trim_domain settled = ep_domain_settle(cell, t->scale);
    if (!ep_arcs_find(t, part, &settled, &arcs) || !arcs.count) return;
    ep_domain_bounds(cell, low, high);
    ep_domain_centre(cell, centre);
    for (unsigned i = 0; i < arcs.count; ++i)
        for (int c = 0; c < 2; ++c) arcs.point[i][c] = (arcs.point[i][c] - centre[c]) / (high[c] - low[c]);
    band s = band_along(&arcs);
    double lo, hi;
    range_on(t, &arcs, &s, &lo, &hi);

    /* is an outer corner below (above) that is outside (inside)? */
    bool below[2] = {false, false}, above[2] = {false, false};
    for (int i = 0; i < 4; ++i) {
        double at[2], x[2];
        for (int c = 0; c < 2; ++c) {
            at[c] = i >> c & 1 ? high[c] + 0.95 * cell->margin : low[c] - 0.95 * cell->margin;
            x[c] = (at[c] - centre[c]) / (high[c] - low[c]);
        }
        const double q = value(&s, x[0], x[1]);
        if (q < lo) below[ep_trim_inside_one(t, part->words, 0, at[0], at[1])] = true;
        if (q > hi) above[ep_trim_inside_one(t, part->words, 0, at[0], at[1])] = true;
    }
    /* the sum is off by less than a unit in float, and the point in either coordinate by four roundings; |dq/dx| and
     * |dq/dy| are together below 2^14. Of two sides that are alike one has to do. */
    const double pad = 2 + 0x1p-22 * side * (0x1p14 / (double)EP_BAND_FINE);
    const bool has_above = above[0] != above[1],
               has_below = below[0] != below[1] && !(has_above && below[1] == above[1]);
    s.lo = has_below ? line(floor(lo / (double)EP_BAND_FINE - pad)) : -INT16_MAX;
    s.hi = has_above ? line(ceil(hi / (double)EP_BAND_FINE + pad)) : INT16_MAX;
    if (has_above ? above[0] : below[1])
        s = (band){-s.a, -s.b, -s.c, has_above ? -s.hi : -INT16_MAX, has_below ? -s.lo : INT16_MAX};
    put(s, words);
}
