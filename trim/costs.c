/* costs.c - see costs.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/costs.h"
#include "trim/arcs.h"
#include "trim/node.h"

#include <time.h>

/* Measured with gcc 12 -O3 on a two-core Xeon that others used, too. */
const ep_trim_costs ep_trim_usual_costs = {5, 8, 15, 2.5, 3, 400};

double ep_trim_expect(const ep_trim *trim, const ep_trim_part *part, const ep_trim_domain *domain,
                      const ep_trim_costs *c)
{
    if (part->state != EP_TRIM_CROSSED) return 0;
    ep_arcs arcs;
    double share = 1, pieces = c->curved * (double)part->pieces;
    if (ep_arcs_find(trim, part, domain, &arcs) && arcs.count) {
        const ep_strip s = ep_strip_around(arcs.point, arcs.count);
        double lo, hi;
        ep_strip_extent(s.n, domain->corner, domain->count, &lo, &hi);
        if (hi > lo) share = fmin((s.hi - s.lo) / (hi - lo), 1);
        pieces = 0;
        for (unsigned i = 0; i < arcs.pieces; ++i) {
            const ep_piece *p = &trim->pieces[arcs.piece[i]];
            pieces += p->degree == 1 ? c->straight : c->curved + c->degree * p->degree;
        }
    }
    return c->strip + share * pieces;
}

enum { POINTS = 4096, ROUNDS = 5 };

typedef struct samples {
    float u[POINTS], v[POINTS];
} samples;

/* Evenly spread in the unit square [Roberts 2018, the R2 sequence]. */
static void spread(samples *s)
{
    double u = 0.5, v = 0.5;
    for (int i = 0; i < POINTS; ++i) {
        u += 0.7548776662466927, v += 0.5698402909980532;
        u -= floor(u), v -= floor(v);
        s->u[i] = (float)u, s->v[i] = (float)v;
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

/* Something the compiler cannot leave out. */
static volatile uint32_t sink;

static double time_node(const ep_trim *t, const uint32_t *words, uint32_t node, const samples *s)
{
    double best = INFINITY;
    for (int round = 0; round < ROUNDS; ++round) {
        const double start = now();
        for (int i = 0; i < POINTS; i += 16) sink = ep_trim_inside(t, words, node, 16, s->u + i, s->v + i, 0xffff);
        best = fmin(best, (now() - start) / POINTS);
    }
    return best;
}

static double time_method(const ep_trim_tester *t, const samples *s)
{
    double best = INFINITY;
    for (int round = 0; round < ROUNDS; ++round) {
        const double start = now();
        for (int i = 0; i < POINTS; ++i) sink = ep_trim_tester_has_point(t, s->u[i], s->v[i]);
        best = fmin(best, (now() - start) / POINTS);
    }
    return best;
}

/* A closed curve that runs through the square from below to above, along a parabola of that degree, and back outside
 * of it. */
static EPStatus add_sweep(ep_region *r, unsigned degree, double shift, ep_message *m)
{
    ep_point2w p[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= degree; ++i) {
        const double t = (double)i / degree;
        p[i][0] = shift + 0.3 * t + 0.2 * t * t, p[i][1] = -0.01 + 1.02 * t, p[i][2] = 1;
    }
    EPStatus s = ep_region_begin(r, EP_REGION_POLYGON, NULL, m);
    if (!s) s = ep_region_bezier(r, degree + 1, p, m);
    const ep_point2 back[2] = {{-1, 1.01}, {-1, -0.01}};
    if (!s) s = ep_region_line(r, 2, back, m);
    return s ? s : ep_region_end(r, m);
}

/* The list, and the whole stored node, of `sweeps` sweeps. */
static EPStatus time_sweeps(unsigned degree, int sweeps, const samples *points, double *list, double *node, double *cut,
                            ep_message *m)
{
    ep_trim *t = NULL;
    ep_trim_part part = {0};
    ep_trim_store store = {0};
    uint32_t at;
    ep_region *r = ep_region_new();
    if (!r) return ep_fail(m, EP_NO_MEMORY, "no memory to measure trims");
    EPStatus s = ep_region_begin(r, EP_REGION_UNION, NULL, m);
    for (int i = 0; i < sweeps && !s; ++i) s = add_sweep(r, degree, 0.2 + 0.1 * i, m);
    if (!s) s = ep_region_end(r, m);
    if (!s) s = ep_trim_new(r, &t, m);
    const ep_trim_domain d = ep_domain_rectangle(0, 1, 0, 1, 0);
    const double start = now();
    if (!s) s = ep_trim_cut(t, &t->root, &d, &part, m);
    if (!s) *cut = (now() - start) / (double)t->piece_count;
    if (!s) s = ep_trim_keep(t, &part, &d, &store, &at, m);
    if (!s) {
        *list = time_node(t, part.words, 0, points);
        *node = time_node(t, store.words, at, points);
    }
    ep_free(store.words);
    ep_trim_part_free(&part);
    ep_trim_free(t);
    ep_region_free(r);
    return s;
}

EPStatus ep_trim_measure(ep_trim_costs *c, ep_message *m)
{
    samples points;
    double straight = 0, strip = 0, two = 0, low = 0, high = 0, cut = 0, unused;
    spread(&points);
    EPStatus s = time_sweeps(1, 1, &points, &straight, &strip, &cut, m);
    if (!s) s = time_sweeps(1, 2, &points, &two, &unused, &unused, m);
    if (!s) s = time_sweeps(3, 1, &points, &low, &unused, &unused, m);
    if (!s) s = time_sweeps(9, 1, &points, &high, &unused, &cut, m);
    if (s) return s;
    const double degree = fmax((high - low) / 6, 0);
    /* half of the points are settled by the first of the two */
    *c = (ep_trim_costs){strip, straight, fmax(low - 3 * degree, 0), degree, fmax(two - 1.5 * straight, 0), cut};
    return EP_OK;
}

/* What a row of the table measures: `curves` segments of a closed wavy contour, or so many circles. */
typedef struct object {
    const char *name;
    enum { SQUARE, CIRCLES, STRAIGHT, BEZIER, RATIONAL, NURBS } kind;
    unsigned curves, degree;
} object;

static const object objects[EP_TRIM_COST_ROWS] = {
    {"square", SQUARE, 1, 1},
    {"circle", CIRCLES, 1, 2},
    {"union of 2 circles", CIRCLES, 2, 2},
    {"union of 16 circles", CIRCLES, 16, 2},
    {"polygon, 8 straight", STRAIGHT, 8, 1},
    {"polygon, 64 straight", STRAIGHT, 64, 1},
    {"polygon, 1024 straight", STRAIGHT, 1024, 1},
    {"polygon, 8 Bezier, degree 2", BEZIER, 8, 2},
    {"polygon, 8 Bezier, degree 3", BEZIER, 8, 3},
    {"polygon, 8 Bezier, degree 6", BEZIER, 8, 6},
    {"polygon, 8 rational, degree 3", RATIONAL, 8, 3},
    {"NURBS of 32 points, degree 3", NURBS, 32, 3},
};

/* Point k of n around a contour with seven waves. */
static void wave(double k, double n, ep_point2w out)
{
    const double a = 6.283185307179586 * k / n, radius = 0.35 + 0.08 * cos(7 * a);
    out[0] = 0.5 + radius * cos(a), out[1] = 0.5 + radius * sin(a), out[2] = 1;
}

static EPStatus add_waves(ep_region *r, const object *o, ep_message *m)
{
    ep_point2w p[EP_CURVE_POINTS * 2];
    EPStatus s = ep_region_begin(r, EP_REGION_POLYGON, NULL, m);
    if (o->kind == NURBS) {
        double knots[EP_CURVE_POINTS * 3];
        for (unsigned i = 0; i < o->curves; ++i) wave(i, o->curves - 1, p[i]);
        for (unsigned i = 0; i <= o->curves + o->degree; ++i)
            knots[i] = fmin(fmax((double)i - o->degree, 0), o->curves - o->degree);
        if (!s) s = ep_region_nurbs(r, o->degree, o->curves + o->degree + 1, knots, o->curves, p, m);
    }
    for (unsigned k = 0; k < o->curves && o->kind != NURBS && !s; ++k) {
        for (unsigned i = 0; i <= o->degree; ++i) {
            wave(k + (double)i / o->degree, o->curves, p[i]);
            if (o->kind == RATIONAL && i % 3) p[i][2] = 2;
        }
        s = ep_region_bezier(r, o->degree + 1, p, m);
    }
    return s ? s : ep_region_end(r, m);
}

static EPStatus add_circles(ep_region *r, unsigned count, ep_message *m)
{
    const unsigned side = (unsigned)ceil(sqrt(count));
    EPStatus s = ep_region_begin(r, EP_REGION_UNION, NULL, m);
    for (unsigned i = 0; i < count && !s; ++i) {
        const double f = 0.4 / side, place[6] = {f, 0, 0, f, (i % side + 0.5) / side, (i / side + 0.5) / side};
        s = ep_region_circle(r, place, m);
    }
    return s ? s : ep_region_end(r, m);
}

/* What the paper's Table 3 makes of it; curved segments take two iterations. */
static double paper_cost(const object *o)
{
    const double points = o->degree + 1.0, order = points, n = o->curves;
    switch (o->kind) {
    case SQUARE: return 270;
    case CIRCLES: return 390 + (n - 1) * (510 + 0.5 * 390);
    case STRAIGHT: return 300 + 45 * n;
    case BEZIER: return 300 + 2 * n * (6950 + 70 * points);
    case RATIONAL: return 300 + 2 * n * (11635 + 310 * order * order);
    default: return 300 + 2 * (11635 + 310 * order * order);
    }
}

static EPStatus add_object(ep_region *r, const object *o, ep_message *m)
{
    static const double smaller[6] = {0.8, 0, 0, 0.8, 0.1, 0.1};
    if (o->kind == SQUARE) return ep_region_square(r, smaller, m);
    return o->kind == CIRCLES ? add_circles(r, o->curves, m) : add_waves(r, o, m);
}

static EPStatus measure_row(const object *o, const samples *points, ep_trim_cost_row *row, ep_message *m)
{
    row->object = o->name;
    row->paper = paper_cost(o);
    ep_trim *t = NULL;
    ep_region *r = ep_region_new();
    if (!r) return ep_fail(m, EP_NO_MEMORY, "no memory to measure trims");
    EPStatus s = add_object(r, o, m);
    if (!s) s = ep_trim_new(r, &t, m);
    for (int i = 0; i < EP_TRIM_METHODS && !s; ++i) {
        ep_trim_tester *tester;
        s = ep_trim_tester_new(r, t, (ep_trim_method)i, &tester, m);
        if (s) break;
        row->ns[i] = time_method(tester, points);
        row->bytes[i] = ep_trim_tester_bytes(tester);
        ep_trim_tester_free(tester);
    }
    ep_trim_free(t);
    ep_region_free(r);
    return s;
}

EPStatus ep_trim_measure_rows(ep_trim_cost_row rows[EP_TRIM_COST_ROWS], ep_message *m)
{
    samples points;
    spread(&points);
    EPStatus s = EP_OK;
    for (int i = 0; i < EP_TRIM_COST_ROWS && !s; ++i) s = measure_row(&objects[i], &points, &rows[i], m);
    return s;
}
