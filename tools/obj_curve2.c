/* obj_curve2.c - see obj_curve2.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_curve2.h"
#include "tools/array.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char out_of_memory[] = "out of memory";

const char *obj_curves_add(obj_curves *c, obj_net *n)
{
    void *all = c->all;
    if (!array_grow(&all, &c->capacity, c->count, 1, sizeof *c->all)) return obj_net_free(n), out_of_memory;
    c->all = all;
    c->all[c->count++] = *n;
    *n = (obj_net){0};
    return NULL;
}

static bool copy(obj_net *to, const obj_net *from)
{
    const size_t knots = from->count[0] + from->degree[0] + 1;
    *to = *from;
    to->points = malloc(from->count[0] * sizeof *to->points);
    to->knots[0] = malloc(knots * sizeof *to->knots[0]);
    if (!to->points || !to->knots[0]) return obj_net_free(to), false;
    memcpy(to->points, from->points, from->count[0] * sizeof *to->points);
    memcpy(to->knots[0], from->knots[0], knots * sizeof *to->knots[0]);
    return true;
}

static void swap(double *a, double *b)
{
    const double t = *a;
    *a = *b;
    *b = t;
}

static void turn_round(obj_net *n)
{
    const size_t count = n->count[0], knots = count + n->degree[0] + 1;
    for (size_t i = 0; i < count / 2; ++i)
        for (int c = 0; c < 4; ++c) swap(&n->points[i][c], &n->points[count - 1 - i][c]);
    for (size_t i = 0; i < knots / 2; ++i) swap(&n->knots[0][i], &n->knots[0][knots - 1 - i]);
    for (size_t i = 0; i < knots; ++i) n->knots[0][i] = -n->knots[0][i];
}

/* Points `first` to `end`, which the curve has in one piece. */
static const char *add_run(const obj_net *n, size_t first, size_t end, double (*points)[3], loops *l)
{
    const size_t count = end - first;
    for (size_t i = 0; i < count; ++i) {
        const double *p = n->points[first + i];
        points[i][0] = p[0], points[i][1] = p[1], points[i][2] = p[3];
    }
    return loops_add_curve(l, n->degree[0], count + n->degree[0] + 1, n->knots[0] + first, count,
                           (const double(*)[3])points);
}

/* A knot that repeats once more than the degree tears a curve, or may. */
static const char *add_runs(const obj_net *n, loops *l)
{
    const unsigned p = n->degree[0];
    const double *knots = n->knots[0];
    double(*points)[3] = malloc(n->count[0] * sizeof *points);
    const char *problem = points ? NULL : out_of_memory;
    for (size_t first = 0, end = p + 1; end <= n->count[0] && !problem; ++end) {
        if (end < n->count[0] && knots[end] < knots[end + p]) continue;
        problem = add_run(n, first, end, points, l);
        first = end;
        end += p;
    }
    free(points);
    return problem;
}

const char *obj_curves_piece(obj_curves *c, size_t curve, double from, double to, loops *l)
{
    obj_net n;
    if (c->all[curve].count[0] > c->points_left) return "the trims repeat their curves too often";
    c->points_left -= c->all[curve].count[0];
    if (!copy(&n, &c->all[curve])) return out_of_memory;
    const char *problem = obj_net_cut(&n, 0, fmin(from, to), fmax(from, to));
    if (!problem && from > to) turn_round(&n);
    if (!problem) problem = add_runs(&n, l);
    obj_net_free(&n);
    return problem;
}

void obj_curves_free(obj_curves *c)
{
    for (size_t i = 0; i < c->count; ++i) obj_net_free(&c->all[i]);
    free(c->all);
    *c = (obj_curves){0};
}
