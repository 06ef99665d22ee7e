/* cage_merge.c - see cage_merge.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Refinement halves faces along a semi-sharp crease once for each unit of its sharpness, although the limit surface
 * there is only a few polynomials: up to some distance that of a sharp crease, beyond the last level that of a smooth
 * surface. So 2^s patches in a row are one, and so are the rows. A patch over both of two parameter intervals is the
 * cubic through four of their points in each direction; evaluated at points of theirs it has to be what they are, to
 * the rounding of their coordinates. Interpolation at even points magnifies errors of the values by less than 2, so
 * that ten merges in a row leave some hundred units in the last place of a double. */
#include "tools/cage_merge.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What rounding may have made of points that should be equal, in units of the last place: of refinement over ten
 * levels, and of merges. Polynomials that differ do so by far more: their third derivatives do. */
#define ROUNDING (0x1p10 * DBL_EPSILON)

static void bernstein(double s, double b[4])
{
    const double r = 1 - s;
    b[0] = r * r * r, b[1] = 3 * s * r * r, b[2] = 3 * s * s * r, b[3] = s * s * s;
}

/* A row (along = 0) or column (along = 1) of points: index k along it, `other` across. */
static size_t at(int along, size_t k, size_t other)
{
    return along ? 4 * k + other : 4 * other + k;
}

/* The curve of control points `other`, at s. */
static void evaluate(const cage_patch *p, int along, size_t other, double s, double x[3])
{
    double b[4];
    bernstein(s, b);
    for (int c = 0; c < 3; ++c) {
        x[c] = 0;
        for (size_t k = 0; k < 4; ++k) x[c] += b[k] * p->points[at(along, k, other)][c];
    }
}

/* The patch over [0, first) and [first, 1], where `a` and `b` are. */
static void join(const cage_patch *a, const cage_patch *b, double first, int along, cage_patch *to)
{
    *to = *a;
    for (size_t other = 0; other < 4; ++other) {
        double x[4][3];
        for (int k = 0; k < 4; ++k) {
            const double s = k / 3.0;
            if (s < first) evaluate(a, along, other, s / first, x[k]);
            else evaluate(b, along, other, (s - first) / (1 - first), x[k]);
        }
        /* the inverse of the cubic Bernstein polynomials at 0, 1/3, 2/3, 1 */
        for (int c = 0; c < 3; ++c) {
            to->points[at(along, 0, other)][c] = x[0][c];
            to->points[at(along, 1, other)][c] = (-5 * x[0][c] + 18 * x[1][c] - 9 * x[2][c] + 2 * x[3][c]) / 6;
            to->points[at(along, 2, other)][c] = (2 * x[0][c] - 9 * x[1][c] + 18 * x[2][c] - 5 * x[3][c]) / 6;
            to->points[at(along, 3, other)][c] = x[3][c];
        }
    }
}

/* Is the part [from, from + size] of `whole` the patch? Cubics that agree in four points do everywhere. */
static bool has(const cage_patch *whole, double from, double size, const cage_patch *part, int along)
{
    double largest = 0;
    for (int k = 0; k < 16; ++k)
        for (int c = 0; c < 3; ++c) largest = fmax(largest, fabs(part->points[k][c]));
    for (size_t other = 0; other < 4; ++other)
        for (int k = 0; k < 4; ++k) {
            double x[3], y[3];
            evaluate(whole, along, other, from + size * k / 3, x);
            evaluate(part, along, other, k / 3.0, y);
            for (int c = 0; c < 3; ++c)
                if (!(fabs(x[c] - y[c]) <= ROUNDING * largest)) return false;
        }
    return true;
}

/* Where a patch begins along u (along = 0) or v, and how far it goes; its place is a rectangle. */
static double begin_of(const cage_patch *p, int along)
{
    return p->place[4 + along];
}

static double size_of(const cage_patch *p, int along)
{
    return p->place[3 * along];
}

/* Appends b to a, if b follows a and is the same polynomial. */
static bool append(cage_patch *a, const cage_patch *b, int along)
{
    const int across = !along;
    if (begin_of(a, across) != begin_of(b, across) || size_of(a, across) != size_of(b, across)) return false;
    if (begin_of(a, along) + size_of(a, along) != begin_of(b, along)) return false; /* powers of two: exact */
    const double size = size_of(a, along) + size_of(b, along), first = size_of(a, along) / size;
    cage_patch both;
    join(a, b, first, along, &both);
    if (!has(&both, 0, first, a, along) || !has(&both, first, 1 - first, b, along)) return false;
    both.place[3 * along] = size;
    *a = both;
    return true;
}

static int compare(double x, double y)
{
    return (x > y) - (x < y);
}

/* So that what may follow a patch along u (or v) comes next. */
static int compare_along(const cage_patch *a, const cage_patch *b, int along)
{
    const int across = !along;
    int order = compare(begin_of(a, across), begin_of(b, across));
    if (!order) order = compare(size_of(a, across), size_of(b, across));
    return order ? order : compare(begin_of(a, along), begin_of(b, along));
}

static int compare_along_u(const void *a, const void *b)
{
    return compare_along(a, b, 0);
}

static int compare_along_v(const void *a, const void *b)
{
    return compare_along(a, b, 1);
}

size_t cage_merge(cage_patch *patches, size_t count)
{
    for (int along = 0, idle = 0; count > 1 && idle < 2; along = !along) {
        qsort(patches, count, sizeof *patches, along ? compare_along_v : compare_along_u);
        size_t kept = 0;
        for (size_t i = 1; i < count; ++i)
            if (!append(&patches[kept], &patches[i], along)) patches[++kept] = patches[i];
        idle = kept + 1 == count ? idle + 1 : 0;
        count = kept + 1;
    }
    return count;
}
