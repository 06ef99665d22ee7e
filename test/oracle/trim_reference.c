/* trim_reference.c - see trim_reference.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/trim_reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef double point[3]; /* wx, wy, w */

enum { MOST_DEGREE = 25, MOST_HALVINGS = 200 };

trim_shape *shape_new(shape_kind kind)
{
    trim_shape *s = calloc(1, sizeof *s);
    if (s) s->kind = kind;
    return s;
}

void shape_free(trim_shape *s)
{
    if (!s) return;
    for (size_t i = 0; i < s->count && s->child; ++i) shape_free(s->child[i]);
    for (size_t i = 0; i < s->count && s->segment; ++i) segment_free(s->segment[i]);
    free(s->child);
    free(s->segment);
    free(s->curves);
    free(s->points);
    free(s);
}

trim_segment *segment_new(segment_kind kind, unsigned degree, size_t count)
{
    trim_segment *g = calloc(1, sizeof *g);
    if (!g) return NULL;
    *g = (trim_segment){kind, degree, count, calloc(count + 1, sizeof *g->points),
                        calloc(count + degree + 1, sizeof *g->knots)};
    for (size_t i = 0; i < count && g->points; ++i) g->points[i][2] = 1;
    if (g->points && g->knots) return g;
    segment_free(g);
    return NULL;
}

void segment_free(trim_segment *g)
{
    if (!g) return;
    free(g->points);
    free(g->knots);
    free(g);
}

/* Room for one more in an array that doubles when its size is a power of two. */
static void *grown(void *array, size_t count, size_t size)
{
    return count & (count - 1) ? array : realloc(array, (count ? 2 * count : 1) * size);
}

bool shape_add(trim_shape *s, trim_shape *child)
{
    trim_shape **more = child ? grown(s->child, s->count, sizeof *s->child) : NULL;
    if (!more) return shape_free(child), false;
    s->child = more;
    s->child[s->count++] = child;
    return true;
}

bool shape_add_segment(trim_shape *s, trim_segment *g)
{
    trim_segment **more = g ? grown(s->segment, s->count, sizeof *s->segment) : NULL;
    if (!more) return segment_free(g), false;
    s->segment = more;
    s->segment[s->count++] = g;
    return true;
}

bool shape_add_points(trim_shape *s, segment_kind kind, unsigned degree, const double *knots, size_t count,
                      const double *points, size_t each)
{
    trim_segment *g = segment_new(kind, degree, count);
    for (size_t i = 0; g && i < count; ++i) memcpy(g->points[i], points + each * i, each * sizeof *points);
    if (g && knots) memcpy(g->knots, knots, (count + degree + 1) * sizeof *knots);
    return shape_add_segment(s, g);
}

/* Borders */

static void apply(const double m[6], const double p[2], double out[2])
{
    const double x = p[0], y = p[1];
    out[0] = m[0] * x + m[2] * y + m[4];
    out[1] = m[1] * x + m[3] * y + m[5];
}

/* Homogeneous points in the shape's own coordinates, and the ends as the neighbours have them. */
static bool add_curve(trim_shape *s, unsigned degree, const point *p, const double from[2], const double to[2])
{
    shape_curve *curves = grown(s->curves, s->curve_count, sizeof *s->curves);
    if (!curves) return false;
    s->curves = curves;
    shape_curve *curve = &s->curves[s->curve_count++];
    *curve = (shape_curve){.first = s->point_count, .degree = degree};
    apply(s->place, from, curve->end[0]);
    apply(s->place, to, curve->end[1]);
    for (unsigned i = 0; i <= degree; ++i) {
        point *points = grown(s->points, s->point_count, sizeof *s->points);
        if (!points) return false;
        s->points = points;
        const double own[2] = {p[i][0] / p[i][2], p[i][1] / p[i][2]};
        double *q = s->points[s->point_count++];
        apply(s->place, own, q);
        for (int c = 0; c < 2; ++c) q[c] *= p[i][2];
        q[2] = p[i][2];
    }
    return true;
}

static bool add_line(trim_shape *s, const double a[2], const double b[2])
{
    if (a[0] == b[0] && a[1] == b[1]) return true;
    return add_curve(s, 1, (const point[2]){{a[0], a[1], 1}, {b[0], b[1], 1}}, a, b);
}

/* The blossom of a spline of degree n in the span from k[i], at n arguments [Ramshaw 1989]; d holds points i-n to i. */
static void blossom(const double *k, size_t i, unsigned n, const double *arguments, point *d)
{
    for (unsigned r = 1; r <= n; ++r)
        for (unsigned q = n; q >= r; --q) {
            const double left = k[i + q - n], right = k[i + 1 + q - r];
            const double f = (arguments[r - 1] - left) / (right - left);
            for (int c = 0; c < 3; ++c) d[q][c] = (1 - f) * d[q - 1][c] + f * d[q][c];
        }
}

static void homogeneous(const double p[3], point out)
{
    out[0] = p[0] * p[2], out[1] = p[1] * p[2], out[2] = p[2];
}

static void project(const point p, double out[2])
{
    out[0] = p[0] / p[2], out[1] = p[1] / p[2];
}

/* The border goes on from `at`, or begins there, when `begun` is false. */
static bool go_to(trim_shape *s, const double p[2], bool *begun, double start[2], double at[2])
{
    const bool done = !*begun || add_line(s, at, p);
    if (!*begun) memcpy(start, p, 2 * sizeof *p);
    memcpy(at, p, 2 * sizeof *p);
    *begun = true;
    return done;
}

static bool add_spans(trim_shape *s, const trim_segment *g, unsigned n, const double *knots, bool *begun,
                      double start[2], double at[2])
{
    for (size_t i = n; i < g->count; ++i) {
        if (!(knots[i] < knots[i + 1])) continue;
        point bezier[MOST_DEGREE + 1], d[MOST_DEGREE + 1];
        for (unsigned j = 0; j <= n; ++j) {
            double arguments[MOST_DEGREE];
            for (unsigned r = 0; r < n; ++r) arguments[r] = r < n - j ? knots[i] : knots[i + 1];
            for (unsigned q = 0; q <= n; ++q) homogeneous(g->points[i - n + q], d[q]);
            blossom(knots, i, n, arguments, d);
            memcpy(bezier[j], d[n], sizeof d[n]);
        }
        double from[2];
        project(bezier[0], from);
        if (!go_to(s, from, begun, start, at)) return false;
        project(bezier[n], at);
        if (!add_curve(s, n, bezier, from, at)) return false;
    }
    return true;
}

static bool follow_polygon(trim_shape *s)
{
    bool begun = false;
    double start[2] = {0, 0}, at[2] = {0, 0};
    for (size_t i = 0; i < s->count; ++i) {
        const trim_segment *g = s->segment[i];
        if (g->kind == SEGMENT_LINE) {
            for (size_t k = 0; k < g->count; ++k)
                if (!go_to(s, g->points[k], &begun, start, at)) return false;
            continue;
        }
        double bezier[2 * MOST_DEGREE + 2];
        for (size_t k = 0; k < 2 * MOST_DEGREE + 2; ++k) bezier[k] = k >= g->count;
        const bool nurbs = g->kind == SEGMENT_NURBS;
        const unsigned degree = nurbs ? g->degree : (unsigned)g->count - 1;
        if (!add_spans(s, g, degree, nurbs ? g->knots : bezier, &begun, start, at)) return false;
    }
    return add_line(s, at, start);
}

static bool follow_square(trim_shape *s)
{
    static const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    bool done = true;
    for (int i = 0; i < 4; ++i) done = done && add_line(s, corner[i], corner[i + 1]);
    return done;
}

static bool follow_circle(trim_shape *s)
{
    bool done = true;
    for (int i = 0; i < 4; ++i) {
        const double x = i == 0 ? 1 : i == 2 ? -1 : 0, y = i == 1 ? 1 : i == 3 ? -1 : 0, w = sqrt(0.5);
        const point p[3] = {{x, y, 1}, {w * (x - y), w * (y + x), w}, {-y, x, 1}};
        done = done && add_curve(s, 2, p, p[0], p[2]);
    }
    return done;
}

static bool prepare(trim_shape *s, const double outer[6])
{
    static const double identity[6] = {1, 0, 0, 1, 0, 0};
    const double *t = s->transformed ? s->transform : identity;
    for (int i = 0; i < 6; i += 2) apply(outer, t + i, s->place + i);
    for (int i = 0; i < 4; ++i) s->place[i] -= outer[4 + i % 2];
    if (s->kind == SHAPE_POLYGON) return follow_polygon(s);
    if (s->kind == SHAPE_SQUARE) return follow_square(s);
    if (s->kind == SHAPE_CIRCLE) return follow_circle(s);
    bool done = true;
    for (size_t i = 0; i < s->count; ++i) done = done && prepare(s->child[i], s->place);
    return done;
}

bool shape_prepare(trim_shape *root)
{
    return prepare(root, (const double[6]){1, 0, 0, 1, 0, 0});
}

/* Points */

typedef struct question {
    double x, y, band;
    bool odd, near; /* crossings of the ray towards +y; is a border closer than the band? */
} question;

static void halve(const point *p, unsigned n, point *left, point *right)
{
    memcpy(right, p, (n + 1) * sizeof *p);
    for (unsigned i = 0; i <= n; ++i) {
        memcpy(left[i], right[0], sizeof *p);
        for (unsigned k = 0; k < n - i; ++k)
            for (int c = 0; c < 3; ++c) right[k][c] = 0.5 * (right[k][c] + right[k + 1][c]);
    }
}

static void ask(question *q, const point *p, unsigned n, const double from[2], const double to[2], int halvings)
{
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY}, middle[2];
    for (unsigned i = 0; i <= n; ++i) {
        double e[2];
        project(p[i], e);
        for (int c = 0; c < 2; ++c) lo[c] = fmin(lo[c], e[c]), hi[c] = fmax(hi[c], e[c]);
    }
    const double away = fmax(fmax(lo[0] - q->x, q->x - hi[0]), fmax(lo[1] - q->y, q->y - hi[1]));
    if (away > q->band) {
        if (q->y < lo[1]) q->odd ^= (from[0] <= q->x) != (to[0] <= q->x);
        return;
    }
    if (hypot(hi[0] - lo[0], hi[1] - lo[1]) < 0.1 * q->band || halvings == MOST_HALVINGS) {
        q->near = true;
        return;
    }
    point left[MOST_DEGREE + 1], right[MOST_DEGREE + 1];
    halve(p, n, left, right);
    project(right[0], middle);
    ask(q, left, n, from, middle, halvings + 1);
    if (!q->near) ask(q, right, n, middle, to, halvings + 1);
}

/* In the contour's own coordinates, where that is simple. */
static bool primitive_has(const trim_shape *s, double x, double y)
{
    const double *m = s->place, det = m[0] * m[3] - m[1] * m[2], dx = x - m[4], dy = y - m[5];
    const double u = (m[3] * dx - m[2] * dy) / det, v = (m[0] * dy - m[1] * dx) / det;
    return s->kind == SHAPE_CIRCLE ? u * u + v * v < 1 : u > 0 && u < 1 && v > 0 && v < 1;
}

static shape_side contour_at(const trim_shape *s, double x, double y, double band)
{
    question q = {x, y, band, false, false};
    for (size_t i = 0; i < s->curve_count && !q.near; ++i) {
        const shape_curve *c = &s->curves[i];
        ask(&q, (const point *)s->points + c->first, c->degree, c->end[0], c->end[1], 0);
    }
    if (q.near) return SHAPE_NEAR;
    return (s->kind == SHAPE_POLYGON ? q.odd : primitive_has(s, x, y)) ? SHAPE_IN : SHAPE_OUT;
}

shape_side shape_at(const trim_shape *s, double x, double y, double band)
{
    if (s->kind >= SHAPE_POLYGON) return contour_at(s, x, y, band);
    bool in = s->kind == SHAPE_INTERSECTION;
    for (size_t i = 0; i < s->count; ++i) {
        const shape_side side = shape_at(s->child[i], x, y, band);
        const bool has = side == SHAPE_IN;
        if (side == SHAPE_NEAR) return SHAPE_NEAR;
        switch (s->kind) {
        case SHAPE_UNION: in |= has; break;
        case SHAPE_INTERSECTION: in &= has; break;
        case SHAPE_DIFFERENCE: in = i ? in && !has : has; break;
        default: in ^= has;
        }
    }
    return in ? SHAPE_IN : SHAPE_OUT;
}

bool shape_border(const trim_shape *s, rng *r, double *x, double *y)
{
    if (s->kind < SHAPE_POLYGON) return s->count && shape_border(s->child[rng_below(r, (unsigned)s->count)], r, x, y);
    if (!s->curve_count) return false;
    const shape_curve *c = &s->curves[rng_below(r, (unsigned)s->curve_count)];
    const double t = rng_unit(r);
    point p[MOST_DEGREE + 1];
    memcpy(p, s->points + c->first, (c->degree + 1) * sizeof *p);
    for (unsigned n = c->degree; n; --n)
        for (unsigned i = 0; i < n; ++i)
            for (int k = 0; k < 3; ++k) p[i][k] = (1 - t) * p[i][k] + t * p[i + 1][k];
    *x = p[0][0] / p[0][2], *y = p[0][1] / p[0][2];
    return true;
}
