/* nurbs.c - see nurbs.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/nurbs.h"

#include <float.h>
#include <string.h>

static size_t spans_of(const ep_nurbs *n, int axis)
{
    size_t spans = 0;
    for (size_t i = n->degree[axis]; (i = ep_knots_next_span(n->knots[axis], n->count[axis], i)) < n->count[axis]; ++i)
        ++spans;
    return spans;
}

size_t ep_nurbs_patches(const ep_nurbs *n)
{
    return spans_of(n, 0) * spans_of(n, 1);
}

/* The narrowest span, and the knot that is farthest from zero. */
static void measure(const ep_nurbs *n, int axis, double *least, double *far)
{
    const double *k = n->knots[axis];
    const size_t first = n->degree[axis], end = n->count[axis];
    *least = INFINITY;
    *far = fmax(fabs(k[first]), fabs(k[end]));
    for (size_t i = first; (i = ep_knots_next_span(k, end, i)) < end; ++i) *least = fmin(*least, k[i + 1] - k[i]);
}

EPStatus ep_nurbs_check(const ep_nurbs *n, ep_message *m)
{
    for (int axis = 0; axis < 2; ++axis) {
        ep_message why;
        const EPStatus s = ep_knots_check(n->degree[axis], n->knot_count[axis], n->knots[axis], n->count[axis],
                                          n->degree[axis] + 1, &why);
        if (s) return ep_fail(m, s, "in %c: %s", "uv"[axis], why.text);
    }
    /* what a patch's place needs: epJoinPatches */
    double least[2], far[2];
    for (int axis = 0; axis < 2; ++axis) measure(n, axis, &least[axis], &far[axis]);
    if (!(fmax(far[0], far[1]) <= FLT_MAX) || !isfinite(1 / (least[0] * least[1])))
        return ep_fail(m, EP_BAD_DATA, "knots that reach to %g, or spans of %g by %g, are beyond floats",
                       fmax(far[0], far[1]), least[0], least[1]);
    /* so many, each with all its points, are counted in 64 bits wherever bytes are */
    if (spans_of(n, 0) > UINT32_MAX / spans_of(n, 1) || n->count[0] > SIZE_MAX / 4096 / n->count[1])
        return ep_fail(m, EP_INVALID, "a NURBS surface of %zu x %zu control points is too large", n->count[0],
                       n->count[1]);
    return EP_OK;
}

/* The spans of one row of control points, each p+1 points `out_stride` points apart. At a knot the last point of one
 * span and the first of the next are the same blossom, by the same steps of de Boor's algorithm, so the same bits; but
 * where the knot repeats degree + 1 times, and the surface is torn. */
static void split_row(const ep_nurbs *n, int axis, const ep_point *row, size_t stride, ep_point *out, size_t out_stride,
                      size_t span_stride)
{
    const double *knots = n->knots[axis];
    size_t i = n->degree[axis];
    for (; (i = ep_knots_next_span(knots, n->count[axis], i)) < n->count[axis]; ++i, out += span_stride)
        ep_knots_bezier(row[0], 4, 4 * stride, n->degree[axis], knots, i, out[0], 4 * out_stride);
}

static void place_patches(const ep_nurbs *n, double (*places)[6])
{
    for (size_t j = n->degree[1]; (j = ep_knots_next_span(n->knots[1], n->count[1], j)) < n->count[1]; ++j)
        for (size_t i = n->degree[0]; (i = ep_knots_next_span(n->knots[0], n->count[0], i)) < n->count[0]; ++i) {
            const double *u = n->knots[0] + i, *v = n->knots[1] + j;
            const double place[6] = {u[1] - u[0], 0, 0, v[1] - v[0], u[0], v[0]};
            memcpy(*places++, place, sizeof place);
        }
}

EPStatus ep_nurbs_split(const ep_nurbs *n, const ep_point *points, ep_point *out, double (*places)[6], ep_message *m)
{
    const size_t columns = n->degree[0] + 1, rows = n->degree[1] + 1, spans = spans_of(n, 0);
    const size_t width = spans * columns; /* of all rows, split in u */
    ep_point *split = ep_alloc(n->count[1] * width, sizeof *split);
    if (!split)
        return ep_fail(m, EP_NO_MEMORY, "no memory for a NURBS surface of %zu points", n->count[0] * n->count[1]);
    for (size_t j = 0; j < n->count[1]; ++j)
        split_row(n, 0, points + j * n->count[0], 1, split + j * width, 1, columns);
    for (size_t i = 0; i < spans; ++i)
        for (size_t k = 0; k < columns; ++k)
            split_row(n, 1, split + i * columns + k, width, out + i * columns * rows + k, columns,
                      spans * columns * rows);
    place_patches(n, places);
    ep_free(split);
    return EP_OK;
}
