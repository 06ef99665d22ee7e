/* obj_net.c - see obj_net.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_net.h"
#include "embree_patch/knots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ORDER_MAX (EP_MAX_DEGREE + 1)

static const char out_of_memory[] = "out of memory";

/* The points along one axis of a net. */
typedef struct lines {
    size_t count;  /* of lines                     */
    size_t next;   /* from one line to the next    */
    size_t stride; /* from one point to the next   */
} lines;

/* With so many points each. */
static lines lines_of(const obj_net *n, int axis, size_t count)
{
    return axis ? (lines){n->count[0], 1, n->count[0]} : (lines){n->count[1], count, 1};
}

void obj_net_free(obj_net *n)
{
    free(n->knots[0]);
    free(n->knots[1]);
    free(n->points);
    *n = (obj_net){0};
}

/* From Euclidean points to homogeneous ones, which can be combined, and back. */
static void multiply(obj_net *n)
{
    for (size_t i = 0; i < n->count[0] * n->count[1]; ++i)
        for (int c = 0; c < 3; ++c) n->points[i][c] *= n->points[i][3];
}

static const char *divide(obj_net *n)
{
    for (size_t i = 0; i < n->count[0] * n->count[1]; ++i) {
        double *p = n->points[i];
        if (!n->rational) p[3] = 1;
        if (!(p[3] > 0)) return "a weight is not positive where a segment becomes a Bézier curve";
        for (int c = 0; c < 3; ++c) p[c] /= p[3];
    }
    return NULL;
}

static size_t step_of(const obj_basis *b)
{
    switch (b->form) {
    case OBJ_BEZIER: return b->degree;
    case OBJ_TAYLOR: return b->degree + 1;
    case OBJ_MATRIX: return b->step;
    default: return 1;
    }
}

size_t obj_points_of(const obj_basis *b, size_t parameters)
{
    const size_t order = b->degree + 1;
    if (b->form == OBJ_BSPLINE) return parameters < 2 * order ? 0 : parameters - order;
    return parameters < 2 ? 0 : (parameters - 2) * step_of(b) + order;
}

/* Row j: Bézier point j in terms of a segment's points. */
static void to_bezier(const obj_basis *b, double m[][ORDER_MAX])
{
    static const double cardinal[4][4] = {
        {0, 1, 0, 0}, {-1 / 6.0, 1, 1 / 6.0, 0}, {0, 1 / 6.0, 1, -1 / 6.0}, {0, 0, 1, 0}};
    const unsigned p = b->degree;
    for (unsigned j = 0; j <= p; ++j)
        for (unsigned i = 0; i <= p; ++i) {
            if (b->form == OBJ_BEZIER) m[j][i] = i == j;
            if (b->form == OBJ_CARDINAL) m[j][i] = cardinal[j][i];
            if (b->form != OBJ_TAYLOR && b->form != OBJ_MATRIX) continue;
            double ratio = 1; /* of j over k to p over k: t^k has it at point j */
            m[j][i] = 0;
            for (unsigned k = 0; k <= j; ++k) {
                m[j][i] += ratio * (b->form == OBJ_TAYLOR ? i == k : b->matrix[i * (p + 1) + k]);
                if (k < p) ratio *= (double)(j - k) / (p - k);
            }
        }
}

static void convert_line(const double m[][ORDER_MAX], unsigned p, size_t step, size_t segments, const double (*from)[4],
                         size_t stride, double (*to)[4], size_t to_stride)
{
    for (size_t s = 0; s < segments; ++s, from += step * stride)
        for (unsigned j = 0; j <= p; ++j, to += to_stride)
            for (int c = 0; c < 4; ++c) {
                (*to)[c] = 0;
                for (unsigned i = 0; i <= p; ++i) (*to)[c] += m[j][i] * from[i * stride][c];
            }
}

/* Points and knots of one axis are replaced. */
static void replace(obj_net *n, int axis, size_t count, double (*points)[4], double *knots)
{
    free(n->points);
    free(n->knots[axis]);
    n->points = points;
    n->knots[axis] = knots;
    n->count[axis] = count;
}

static const char *to_segments(obj_net *n, int axis, const obj_basis *b, const double *parameters, size_t count)
{
    const bool combines = b->form != OBJ_BEZIER;
    const size_t order = b->degree + 1, segments = count - 1, across = n->count[1 - axis];
    double m[ORDER_MAX][ORDER_MAX];
    double(*points)[4] = malloc(segments * order * across * sizeof *points);
    double *knots = malloc(count * order * sizeof *knots);
    if (!points || !knots) return free(points), free(knots), out_of_memory;

    to_bezier(b, m);
    if (combines) multiply(n);
    const lines from = lines_of(n, axis, n->count[axis]), to = lines_of(n, axis, segments * order);
    const double(*old)[4] = (const double(*)[4])n->points;
    for (size_t i = 0; i < from.count; ++i)
        convert_line(m, b->degree, step_of(b), segments, old + i * from.next, from.stride, points + i * to.next,
                     to.stride);
    for (size_t i = 0; i < count * order; ++i) knots[i] = parameters[i / order];
    replace(n, axis, segments * order, points, knots);
    return combines ? divide(n) : NULL;
}

const char *obj_net_convert(obj_net *n, int axis, const obj_basis *b, const double *parameters, size_t count)
{
    static _Thread_local ep_message why;
    n->degree[axis] = b->degree;
    if (b->form != OBJ_BSPLINE) {
        for (size_t i = 1; i < count; ++i)
            if (parameters[i] <= parameters[i - 1]) {
                ep_fail(&why, EP_BAD_DATA, "parameter %zu is %g, not above the one before it, %g", i + 1, parameters[i],
                        parameters[i - 1]);
                return why.text;
            }
        return to_segments(n, axis, b, parameters, count);
    }
    n->knots[axis] = malloc(count * sizeof *n->knots[axis]);
    if (!n->knots[axis]) return out_of_memory;
    memcpy(n->knots[axis], parameters, count * sizeof *parameters);
    return ep_knots_check(b->degree, count, parameters, n->count[axis], b->degree + 1, &why) ? why.text : NULL;
}

/* The span that x lies in, or begins; for the last knot, the last one. */
static size_t span_of(const obj_net *n, int axis, double x)
{
    const double *knots = n->knots[axis];
    size_t low = n->degree[axis], high = n->count[axis];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (knots[middle] <= x) low = middle;
        else high = middle;
    }
    return low;
}

/* Point i after a knot x in span k has been inserted [Boehm 1980]. */
static void inserted(const double *knots, unsigned p, size_t k, double x, const double (*line)[4], size_t stride,
                     size_t i, double to[4])
{
    const size_t before = i <= k - p ? i : i - 1;
    memcpy(to, line[before * stride], sizeof *line);
    if (i <= k - p || i > k) return;
    const double t = (x - knots[i]) / (knots[i + p] - knots[i]);
    for (int c = 0; c < 4; ++c) to[c] = (1 - t) * line[before * stride][c] + t * line[i * stride][c];
}

/* Afterwards x is a knot. */
static const char *insert(obj_net *n, int axis, double x)
{
    const size_t k = span_of(n, axis, x), count = n->count[axis] + 1;
    const double *old = n->knots[axis];
    if (old[k] == x || old[k + 1] == x) return NULL;
    double(*points)[4] = malloc(count * n->count[1 - axis] * sizeof *points);
    double *knots = malloc((count + n->degree[axis] + 1) * sizeof *knots);
    if (!points || !knots) return free(points), free(knots), out_of_memory;

    const lines from = lines_of(n, axis, n->count[axis]), to = lines_of(n, axis, count);
    for (size_t i = 0; i < from.count; ++i)
        for (size_t j = 0; j < count; ++j)
            inserted(old, n->degree[axis], k, x, (const double(*)[4])n->points + i * from.next, from.stride, j,
                     points[i * to.next + j * to.stride]);
    memcpy(knots, old, (k + 1) * sizeof *knots);
    knots[k + 1] = x;
    memcpy(knots + k + 2, old + k + 1, (count + n->degree[axis] - k - 1) * sizeof *knots);
    replace(n, axis, count, points, knots);
    return NULL;
}

/* Keeps `count` of the points from `first` on. They move forwards, in order. */
static void keep(obj_net *n, int axis, size_t first, size_t count)
{
    const size_t old_columns = n->count[0];
    const double(*from)[4] = (const double(*)[4])n->points + first * (axis ? old_columns : 1);
    n->count[axis] = count;
    for (size_t j = 0; j < n->count[1]; ++j)
        memmove(n->points + j * n->count[0], from + j * old_columns, n->count[0] * sizeof *from);
    memmove(n->knots[axis], n->knots[axis] + first, (count + n->degree[axis] + 1) * sizeof *n->knots[axis]);
}

const char *obj_net_cut(obj_net *n, int axis, double from, double to)
{
    static _Thread_local ep_message why;
    const unsigned p = n->degree[axis];
    const double *knots = n->knots[axis], low = knots[p], high = knots[n->count[axis]];
    if (!(low <= from && from < to && to <= high)) {
        ep_fail(&why, EP_BAD_DATA, "%.10g to %.10g is no part of %.10g to %.10g, where it is defined", from, to, low,
                high);
        return why.text;
    }
    if (from == low && to == high) return NULL;
    multiply(n);
    const char *problem = insert(n, axis, from);
    if (!problem) problem = insert(n, axis, to);
    if (problem) return problem;
    const size_t first = span_of(n, axis, from);
    size_t end = span_of(n, axis, to);
    if (n->knots[axis][end] != to) ++end; /* the last knot */
    while (n->knots[axis][end - 1] == to) --end;
    keep(n, axis, first - p, end - first + p);
    return divide(n);
}
