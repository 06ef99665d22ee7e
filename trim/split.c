/* split.c - see split.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The paper's secant and parallel tangent of a curve are the two lines of the narrowest strip around it whose direction
 * is the secant's; of a straight edge they are one. So one rule, a strip, does for one segment and, where they follow
 * one another smoothly, for several. */
#include "trim/split.h"
#include "trim/arcs.h"

#include <string.h>

static double twice_area(const ep_point2 a, const ep_point2 b, const ep_point2 c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double squared(const ep_point2 a, const ep_point2 b)
{
    const double x = b[0] - a[0], y = b[1] - a[1];
    return x * x + y * y;
}

/* Height over longest side. */
static double thickness(const ep_point2 a, const ep_point2 b, const ep_point2 c)
{
    const double longest = fmax(squared(a, b), fmax(squared(b, c), squared(c, a)));
    return longest > 0 ? fabs(twice_area(a, b, c)) / longest : 0;
}

static void put(ep_trim_triangles *out, const ep_point2 a, const ep_point2 b, const ep_point2 c)
{
    const double *p[3] = {a, b, c};
    for (int i = 0; i < 3; ++i) memcpy(out->corner[out->count][i], p[i], sizeof(ep_point2));
    ++out->count;
}

void ep_trim_split_regular(const ep_point2 triangle[3], ep_trim_triangles *out)
{
    ep_point2 mid[3]; /* opposite of each corner */
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 2; ++c) mid[i][c] = 0.5 * (triangle[(i + 1) % 3][c] + triangle[(i + 2) % 3][c]);
    out->count = 0;
    for (int i = 0; i < 3; ++i) put(out, triangle[i], mid[(i + 2) % 3], mid[(i + 1) % 3]);
    put(out, mid[0], mid[1], mid[2]);
}

typedef struct zone {
    unsigned count;
    ep_point2 p[EP_DOMAIN_CORNERS];
} zone;

static void add(zone *z, const ep_point2 p)
{
    /* a line through a corner meets two sides there */
    if (z->count && !memcmp(z->p[z->count - 1], p, sizeof(ep_point2))) return;
    if (z->count < EP_DOMAIN_CORNERS) memcpy(z->p[z->count++], p, sizeof(ep_point2));
}

/* The triangle below, between and above the lines. Neighbours share corners, bit for bit. */
static void cut_zones(const ep_point2 triangle[3], const ep_strip *s, zone z[3])
{
    const double line[2] = {s->lo, s->hi};
    double h[3];
    int at[3];
    for (int i = 0; i < 3; ++i) {
        h[i] = s->n[0] * triangle[i][0] + s->n[1] * triangle[i][1];
        at[i] = h[i] < s->lo ? 0 : h[i] <= s->hi ? 1 : 2;
    }
    for (int i = 0; i < 3; ++i) z[i].count = 0;
    for (int i = 0; i < 3; ++i) {
        const int k = (i + 1) % 3;
        const int step = at[k] > at[i] ? 1 : -1;
        add(&z[at[i]], triangle[i]);
        for (int from = at[i]; from != at[k]; from += step) {
            const double f = (line[step > 0 ? from : from - 1] - h[i]) / (h[k] - h[i]);
            const ep_point2 p = {triangle[i][0] + f * (triangle[k][0] - triangle[i][0]),
                                 triangle[i][1] + f * (triangle[k][1] - triangle[i][1])};
            add(&z[from], p);
            add(&z[from + step], p);
        }
    }
}

/* The fan whose thinnest triangle is thickest; returns that one's thickness. */
static double put_fan(const zone *z, ep_trim_triangles *out)
{
    unsigned best = 0;
    double thickest = -1;
    for (unsigned k = 0; k < z->count; ++k) {
        double thinnest = INFINITY;
        for (unsigned i = 1; i + 1 < z->count; ++i)
            thinnest = fmin(thinnest, thickness(z->p[k], z->p[(k + i) % z->count], z->p[(k + i + 1) % z->count]));
        if (thinnest > thickest) thickest = thinnest, best = k;
    }
    for (unsigned i = 1; i + 1 < z->count; ++i)
        put(out, z->p[best], z->p[(best + i) % z->count], z->p[(best + i + 1) % z->count]);
    return z->count < 3 ? INFINITY : thickest;
}

static double longest_side(const ep_point2 t[3])
{
    return sqrt(fmax(squared(t[0], t[1]), fmax(squared(t[1], t[2]), squared(t[2], t[0]))));
}

/* The triangle on either side of a line; corners nearer to it than `near` are on it. */
static void cut_sides(const ep_point2 triangle[3], const double n[2], double line, double near, zone z[2])
{
    double h[3];
    for (int i = 0; i < 3; ++i) {
        h[i] = n[0] * triangle[i][0] + n[1] * triangle[i][1] - line;
        if (fabs(h[i]) <= near) h[i] = 0;
    }
    z[0].count = z[1].count = 0;
    for (int i = 0; i < 3; ++i) {
        const int k = (i + 1) % 3;
        if (h[i] <= 0) add(&z[0], triangle[i]);
        if (h[i] >= 0) add(&z[1], triangle[i]);
        if (h[i] * h[k] >= 0) continue;
        const double f = h[i] / (h[i] - h[k]);
        const ep_point2 p = {triangle[i][0] + f * (triangle[k][0] - triangle[i][0]),
                             triangle[i][1] + f * (triangle[k][1] - triangle[i][1])};
        add(&z[0], p);
        add(&z[1], p);
    }
}

/* A strip no wider than this, against the triangle, is a straight line but for what rounds. */
static const double straight = 0x1p-42;

/* The triangle cut along the strip. False when a part would be too thin, or the strip leaves too little beside it. */
static bool cut_along(const ep_point2 triangle[3], ep_strip s, double thinnest, ep_trim_triangles *out)
{
    double lo, hi;
    ep_strip_extent(s.n, triangle, 3, &lo, &hi);
    const double size = longest_side(triangle);
    zone z[3] = {0};
    if (s.hi - s.lo <= straight * size) {
        cut_sides(triangle, s.n, 0.5 * (s.lo + s.hi), straight * size, z);
    } else {
        /* a little wider, so that the curve does not touch the lines; and no thinner than allowed */
        const double more = fmax(1.1 * thinnest * size - (s.hi - s.lo), 0.02 * (s.hi - s.lo));
        s.lo -= 0.5 * more, s.hi += 0.5 * more;
        if (s.hi - s.lo > 0.5 * (hi - lo)) return false;
        cut_zones(triangle, &s, z);
    }
    out->count = 0;
    for (int i = 0; i < 3; ++i)
        if (put_fan(&z[i], out) < thinnest) return false;
    return out->count > 1;
}

/* How far from the middles of the sides that it meets a strip is: the smaller, the better it halves the triangle. */
static double imbalance(const ep_point2 triangle[3], const ep_strip *s)
{
    double lo, hi;
    ep_strip_extent(s->n, triangle, 3, &lo, &hi);
    return fabs(s->lo + s->hi - lo - hi) / (hi - lo);
}

bool ep_trim_split_triangle(const ep_trim *trim, const ep_trim_part *part, const ep_point2 triangle[3], double thinnest,
                            ep_trim_triangles *out)
{
    const ep_trim_domain d = ep_domain_polygon(3, triangle, 0);
    ep_arcs arcs;
    if (ep_arcs_find(trim, part, &d, &arcs) && arcs.count) {
        if (cut_along(d.corner, ep_strip_around(arcs.point, arcs.count), thinnest, out)) return true;
        ep_trim_triangles best;
        double least = INFINITY;
        for (unsigned i = 0; i < arcs.pieces && arcs.pieces <= 4; ++i) {
            const unsigned count = arcs.first[i + 1] - arcs.first[i];
            if (!count) continue;
            const ep_strip s = ep_strip_around(arcs.point + arcs.first[i], count);
            const double f = imbalance(triangle, &s);
            if (f < least && cut_along(d.corner, s, thinnest, &best)) least = f, *out = best;
        }
        if (least < INFINITY) return true;
    }
    ep_trim_split_regular(d.corner, out);
    return false;
}

void ep_trim_split_rectangle(const ep_trim *trim, const ep_trim_part *part, const ep_point2 lo, const ep_point2 hi,
                             double thinnest, int *axis, double *at)
{
    const ep_trim_domain d = ep_domain_rectangle(lo[0], hi[0], lo[1], hi[1], 0);
    ep_arcs arcs;
    *axis = hi[1] - lo[1] > hi[0] - lo[0];
    *at = 0.5 * (lo[*axis] + hi[*axis]);
    if (!ep_arcs_find(trim, part, &d, &arcs) || !arcs.count) return;
    /* the widest band that no curve enters, if it is wide enough to be worth a cut */
    double widest = 0.2;
    for (int c = 0; c < 2; ++c) {
        double n[2] = {c == 0, c == 1}, from, to;
        ep_strip_extent(n, arcs.point, arcs.count, &from, &to);
        const double width = hi[c] - lo[c], least = thinnest * (hi[!c] - lo[!c]);
        const double before = fmin(from - 0.01 * width, hi[c] - least) - lo[c];
        const double after = hi[c] - fmax(to + 0.01 * width, lo[c] + least);
        if (before > fmax(widest * width, least)) widest = before / width, *axis = c, *at = lo[c] + before;
        if (after > fmax(widest * width, least)) widest = after / width, *axis = c, *at = hi[c] - after;
    }
}
