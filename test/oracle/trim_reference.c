/* trim_reference.c - see trim_reference.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/trim_reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

trim_shape *shape_new(shape_kind kind)
{
    trim_shape *s = calloc(1, sizeof *s);
    s->kind = kind;
    return s;
}

void shape_free(trim_shape *s)
{
    if (!s) return;
    for (unsigned i = 0; i < SHAPE_CHILDREN; ++i) {
        shape_free(s->child[i]);
        free(s->segment[i]);
    }
    free(s->chord);
    free(s);
}

/* The basis function N(i,p) of Cox and de Boor's recursion, from its definition, in a span of knots. */
static double basis(const double *k, size_t i, unsigned p, double t, size_t span)
{
    if (p == 0) return i == span;
    double sum = 0;
    if (k[i + p] > k[i]) sum += (t - k[i]) / (k[i + p] - k[i]) * basis(k, i, p - 1, t, span);
    if (k[i + p + 1] > k[i + 1])
        sum += (k[i + p + 1] - t) / (k[i + p + 1] - k[i + 1]) * basis(k, i + 1, p - 1, t, span);
    return sum;
}

/* The point at t in the span, in the segment's own coordinates. */
static void evaluate(const trim_segment *g, size_t span, double t, double out[2])
{
    double sum[3] = {0, 0, 0};
    for (unsigned i = 0; i < g->count; ++i) {
        double b;
        if (g->kind == SEGMENT_NURBS) {
            b = i + g->degree >= span && i <= span ? basis(g->knots, i, g->degree, t, span) : 0;
        } else {
            const unsigned n = g->count - 1;
            b = exp(lgamma(n + 1.0) - lgamma(i + 1.0) - lgamma(n - i + 1.0)) * pow(t, i) * pow(1 - t, n - i);
        }
        sum[0] += b * g->points[i][2] * g->points[i][0];
        sum[1] += b * g->points[i][2] * g->points[i][1];
        sum[2] += b * g->points[i][2];
    }
    out[0] = sum[0] / sum[2], out[1] = sum[1] / sum[2];
}

static void apply(const double m[6], const double p[2], double out[2])
{
    const double x = p[0], y = p[1];
    out[0] = m[0] * x + m[2] * y + m[4];
    out[1] = m[1] * x + m[3] * y + m[5];
}

static void add_point(trim_shape *s, const double p[2])
{
    if (s->chords == s->room) {
        s->room = s->room ? 2 * s->room : 256;
        s->chord = realloc(s->chord, s->room * sizeof *s->chord);
    }
    apply(s->place, p, s->chord[s->chords++]);
}

/* Halves until three points between the ends lie on the chord. */
static void follow(trim_shape *s, const trim_segment *g, size_t span, double t0, const double p0[2], double t1,
                   const double p1[2], int depth)
{
    double off = 0, mid[2] = {0, 0};
    for (int i = 1; i < 4; ++i) {
        double q[2];
        evaluate(g, span, t0 + i * 0.25 * (t1 - t0), q);
        if (i == 2) memcpy(mid, q, sizeof mid);
        const double dx = p1[0] - p0[0], dy = p1[1] - p0[1], length = hypot(dx, dy);
        const double ex = q[0] - p0[0], ey = q[1] - p0[1];
        const double along = length > 0 ? fmin(fmax((ex * dx + ey * dy) / (length * length), 0), 1) : 0;
        off = fmax(off, hypot(ex - along * dx, ey - along * dy));
    }
    if (depth >= 4 && (off < 2e-7 || depth > 24)) {
        add_point(s, p1);
        return;
    }
    const double tm = 0.5 * (t0 + t1);
    follow(s, g, span, t0, p0, tm, mid, depth + 1);
    follow(s, g, span, tm, mid, t1, p1, depth + 1);
}

static void follow_segment(trim_shape *s, const trim_segment *g)
{
    double p0[2], p1[2];
    if (g->kind == SEGMENT_LINE) {
        for (unsigned i = 0; i < g->count; ++i) add_point(s, g->points[i]);
        return;
    }
    const size_t first = g->kind == SEGMENT_NURBS ? g->degree : 0;
    const size_t last = g->kind == SEGMENT_NURBS ? g->count : 1;
    for (size_t i = first; i < last; ++i) {
        const double t0 = g->kind == SEGMENT_NURBS ? g->knots[i] : 0,
                     t1 = g->kind == SEGMENT_NURBS ? g->knots[i + 1] : 1;
        if (!(t0 < t1)) continue;
        evaluate(g, i, t0, p0);
        evaluate(g, i, t1, p1);
        add_point(s, p0);
        follow(s, g, i, t0, p0, t1, p1, 0);
    }
}

static void prepare(trim_shape *s, const double outer[6])
{
    static const double identity[6] = {1, 0, 0, 1, 0, 0};
    const double *t = s->transformed ? s->transform : identity;
    for (int i = 0; i < 6; i += 2) apply(outer, t + i, s->place + i);
    for (int i = 0; i < 4; ++i) s->place[i] -= outer[4 + i % 2];
    if (s->kind <= SHAPE_LOOPS)
        for (unsigned i = 0; i < s->count; ++i) prepare(s->child[i], s->place);
    else if (s->kind == SHAPE_POLYGON)
        for (unsigned i = 0; i < s->count; ++i) follow_segment(s, s->segment[i]);
    else if (s->kind == SHAPE_SQUARE)
        for (int i = 0; i < 4; ++i) add_point(s, (const double[2]){i == 1 || i == 2, i >= 2});
    else
        for (int i = 0; i < 16384; ++i)
            add_point(s, (const double[2]){cos(i * (6.283185307179586 / 16384)), sin(i * (6.283185307179586 / 16384))});
}

void shape_prepare(trim_shape *root)
{
    prepare(root, (const double[6]){1, 0, 0, 1, 0, 0});
}

/* Crossings of the ray towards +y. */
static bool chain_has(const trim_shape *s, double x, double y)
{
    bool in = false;
    for (size_t i = 0; i < s->chords; ++i) {
        const double *a = s->chord[i], *b = s->chord[i + 1 < s->chords ? i + 1 : 0];
        if ((a[0] <= x) == (b[0] <= x)) continue;
        in ^= a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0])) > y;
    }
    return in;
}

bool shape_has(const trim_shape *s, double x, double y)
{
    bool in = s->kind == SHAPE_INTERSECTION;
    if (s->kind == SHAPE_POLYGON) return chain_has(s, x, y);
    if (s->kind >= SHAPE_SQUARE) {
        const double *m = s->place, det = m[0] * m[3] - m[1] * m[2];
        const double dx = x - m[4], dy = y - m[5];
        const double u = (m[3] * dx - m[2] * dy) / det, v = (m[0] * dy - m[1] * dx) / det;
        return s->kind == SHAPE_CIRCLE ? u * u + v * v < 1 : u > 0 && u < 1 && v > 0 && v < 1;
    }
    for (unsigned i = 0; i < s->count; ++i) {
        const bool has = shape_has(s->child[i], x, y);
        switch (s->kind) {
        case SHAPE_UNION: in |= has; break;
        case SHAPE_INTERSECTION: in &= has; break;
        case SHAPE_DIFFERENCE: in = i ? in && !has : has; break;
        default: in ^= has;
        }
    }
    return in;
}

double shape_distance(const trim_shape *s, double x, double y)
{
    double least = INFINITY;
    if (s->kind <= SHAPE_LOOPS)
        for (unsigned i = 0; i < s->count; ++i) least = fmin(least, shape_distance(s->child[i], x, y));
    for (size_t i = 0; i < s->chords; ++i) {
        const double *a = s->chord[i], *b = s->chord[i + 1 < s->chords ? i + 1 : 0];
        const double dx = b[0] - a[0], dy = b[1] - a[1], ll = dx * dx + dy * dy;
        const double t = ll > 0 ? fmin(fmax(((x - a[0]) * dx + (y - a[1]) * dy) / ll, 0), 1) : 0;
        const double ex = x - a[0] - t * dx, ey = y - a[1] - t * dy, dd = ex * ex + ey * ey;
        if (dd < least * least) least = sqrt(dd);
    }
    return least;
}
