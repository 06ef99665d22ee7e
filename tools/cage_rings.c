/* cage_rings.c - see cage_rings.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Each subdivision leaves a mesh of the same kind, half as large in the parameters, and around it three quadrilaterals
 * a sector whose vertices are regular: bicubic B-splines [Stam, "Exact evaluation of Catmull-Clark subdivision surfaces
 * at arbitrary parameter values", 1998]. What is left in the end is a patch that continues its neighbours' borders and
 * has the limit's point and tangents in the corner. Its distance to the surface falls with that from the tangent plane,
 * by four a level where the surface is round. */
#include "tools/cage_rings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* What is left then is as small as floats tell apart, in u and v and, but where dozens of faces meet, in space. */
enum { MOST_LEVELS = 14 };

/* One level. */
typedef struct mesh {
    size_t n;
    const double *centre;
    const double (*point)[3][4][3];
} mesh;

static mesh mesh_of(const cage_rings *r, int level)
{
    return (mesh){r->n, r->centre[level], r->point + (size_t)level * r->n};
}

/* The point a steps along edge i and b along edge i + 1, of which one may be -1. */
static const double *point(const mesh *m, size_t i, int a, int b)
{
    if (a == 0 && b == 0) return m->centre;
    if (b < 0) return point(m, (i + m->n - 1) % m->n, -b, a);
    if (a < 0) return point(m, (i + 1) % m->n, b, -a);
    if (a == 0) return m->point[(i + 1) % m->n][b - 1][0];
    return m->point[i][a - 1][b];
}

static void add(double to[3], double weight, const double p[3])
{
    for (int c = 0; c < 3; ++c) to[c] += weight * p[c];
}

/* Vertex, edge and face points where all is regular: the vertex counts 9/16, its edges' ends 3/32, the others 1/64; an
 * edge's ends 3/8, the four beside it 1/16. */
static void refine(const mesh *m, size_t i, int a, int b, double to[3])
{
    const int x = a / 2, y = b / 2, odd_x = a % 2, odd_y = b % 2;
    memset(to, 0, 3 * sizeof *to);
    for (int dy = -1; dy <= 1 + odd_y; ++dy)
        for (int dx = -1; dx <= 1 + odd_x; ++dx) {
            static const double even[3] = {1.0 / 8, 3.0 / 4, 1.0 / 8}, odd[4] = {0, 1.0 / 2, 1.0 / 2, 0};
            const double w = (odd_x ? odd[dx + 1] : even[dx + 1]) * (odd_y ? odd[dy + 1] : even[dy + 1]);
            if (w != 0) add(to, w, point(m, i, x + dx, y + dy));
        }
}

/* [Catmull and Clark 1978] */
static void refine_centre(const mesh *m, double to[3])
{
    const double n = (double)m->n;
    for (int c = 0; c < 3; ++c) to[c] = (1 - 7 / (4 * n)) * m->centre[c];
    for (size_t i = 0; i < m->n; ++i) {
        add(to, 3 / (2 * n * n), point(m, i, 1, 0));
        add(to, 1 / (4 * n * n), point(m, i, 1, 1));
    }
}

/* Room for one level more. */
static bool grow(cage_rings *r, int levels)
{
    const size_t count = (size_t)levels + 1;
    double(*centre)[3] = realloc(r->centre, count * sizeof *centre);
    if (centre) r->centre = centre;
    double(*point)[3][4][3] = realloc(r->point, count * r->n * sizeof *point);
    if (point) r->point = point;
    if (!centre || !point) return false;
    r->levels = levels;
    return true;
}

bool cage_rings_begin(cage_rings *r, size_t n)
{
    *r = (cage_rings){.n = n};
    return grow(r, 0);
}

void cage_rings_free(cage_rings *r)
{
    free(r->centre);
    free(r->point);
}

/* From two rings to three of half the width. */
static bool subdivide(cage_rings *r)
{
    const int level = r->levels;
    if (!grow(r, level + 1)) return false;
    const mesh m = mesh_of(r, level);
    double(*finer)[3][4][3] = r->point + (size_t)r->levels * r->n;
    for (size_t i = 0; i < r->n; ++i)
        for (int a = 1; a <= 3; ++a)
            for (int b = 0; b <= 3; ++b) refine(&m, i, a, b, finer[i][a - 1][b]);
    refine_centre(&m, r->centre[r->levels]);
    return true;
}

/* The uniform cubic B-spline's Bézier points, of which k needs its points 0..3 with these weights. */
static const double to_bezier[4][4] = {
    {1.0 / 6, 4.0 / 6, 1.0 / 6, 0}, {0, 4.0 / 6, 2.0 / 6, 0}, {0, 2.0 / 6, 4.0 / 6, 0}, {0, 1.0 / 6, 4.0 / 6, 1.0 / 6}};

static void bezier_point(const mesh *m, size_t i, int x, int y, int j, int k, double to[3])
{
    memset(to, 0, 3 * sizeof *to);
    for (int b = 0; b < 4; ++b)
        for (int a = 0; a < 4; ++a) {
            const double w = to_bezier[j][a] * to_bezier[k][b];
            if (w != 0) add(to, w, point(m, i, x + a - 1, y + b - 1));
        }
}

/* The patch of the quadrilateral x, y steps from the centre, of which one is 1 at least. */
static void regular(const mesh *m, size_t i, int x, int y, cage_ring_patch *p)
{
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j) bezier_point(m, i, x, y, j, k, p->points[4 * k + j]);
}

static void limit_point(const mesh *m, double to[3])
{
    const double n = (double)m->n, w = 1 / (n * (n + 5));
    for (int c = 0; c < 3; ++c) to[c] = n * n * w * m->centre[c];
    for (size_t i = 0; i < m->n; ++i) {
        add(to, 4 * w, point(m, i, 1, 0));
        add(to, w, point(m, i, 1, 1));
    }
}

/* Cosine and sine of the angle from edge 0 to edge i. The sine is zero where it should be: of two edges, the tangents
 * are opposite to the bit, and no plane is taken for theirs. */
static void direction(size_t i, size_t n, double to[2])
{
    const double angle = 2 * PI / (double)n * (double)i;
    to[0] = cos(angle);
    to[1] = 2 * i % n ? sin(angle) : 0;
}

/* As long as a Bézier patch takes them where four edges meet [Halstead, Kass, DeRose, "Efficient, fair interpolation
 * using Catmull-Clark surfaces", 1993]. Along edge i the weights are cosines of angles from there; those are sums of
 * cosines and sines of angles from edge 0. */
static void limit_tangents(const mesh *m, double to[2][3])
{
    const double n = (double)m->n, step = 2 * PI / n;
    const double edges = 1 + cos(step) + cos(step / 2) * sqrt(2 * (9 + cos(step))), scale = 1 / (9 * n);
    memset(to, 0, 2 * sizeof *to);
    for (size_t k = 0; k < m->n; ++k) {
        double along[2], next[2];
        direction(k, m->n, along);
        direction(k + 1, m->n, next);
        for (int x = 0; x < 2; ++x) {
            add(to[x], scale * edges * along[x], point(m, k, 1, 0));
            add(to[x], scale * (along[x] + next[x]), point(m, k, 1, 1));
        }
    }
}

static void find_limit(cage_rings *r)
{
    const mesh m = mesh_of(r, r->levels);
    limit_point(&m, r->limit);
    limit_tangents(&m, r->tangent);
}

static void tangent_along(const cage_rings *r, size_t i, double to[3])
{
    double along[2];
    direction(i, r->n, along);
    for (int c = 0; c < 3; ++c) to[c] = along[0] * r->tangent[0][c] + along[1] * r->tangent[1][c];
}

static double length_of(const double a[3])
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* How far something is from a point and, if it is regular there, from its tangent plane. */
typedef struct extent {
    double point, plane;
} extent;

/* What is left in the corner of the sector. */
static extent corner(const cage_rings *r, size_t i, cage_ring_patch *p)
{
    const mesh m = mesh_of(r, r->levels);
    const double *at = r->limit;
    double s[3], t[3], n[3], off_plane = 0, off_point = 0;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j)
            if (j > 1 || k > 1) bezier_point(&m, i, 0, 0, j, k, p->points[4 * k + j]);
    tangent_along(r, i, s);
    tangent_along(r, (i + 1) % r->n, t);
    for (int c = 0; c < 3; ++c) {
        p->points[0][c] = at[c];
        p->points[1][c] = at[c] + s[c];
        p->points[4][c] = at[c] + t[c];
        p->points[5][c] = at[c] + s[c] + t[c];
        n[c] = s[(c + 1) % 3] * t[(c + 2) % 3] - s[(c + 2) % 3] * t[(c + 1) % 3];
    }
    for (int k = 0; k < 16; ++k) {
        double d[3];
        for (int c = 0; c < 3; ++c) d[c] = p->points[k][c] - at[c];
        off_plane = fmax(off_plane, fabs(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]));
        off_point = fmax(off_point, length_of(d));
    }
    return (extent){off_point, off_plane / length_of(n)};
}

static bool is_enough(const cage_rings *r, double flat, double tiny)
{
    cage_ring_patch p;
    for (size_t i = 0; i < r->n; ++i) {
        const extent e = corner(r, i, &p);
        if (!(e.plane <= flat || e.point <= tiny)) return false;
    }
    return true;
}

bool cage_rings_subdivide(cage_rings *r, int levels)
{
    while (r->levels < levels)
        if (!subdivide(r)) return false;
    find_limit(r);
    return true;
}

bool cage_rings_flatten(cage_rings *r, double flat, double tiny)
{
    for (find_limit(r); r->levels < MOST_LEVELS && !is_enough(r, flat, tiny); find_limit(r))
        if (!subdivide(r)) return false;
    return true;
}

void cage_rings_cut(const cage_rings *r, size_t sector, bool (*take)(void *user, const cage_ring_patch *p), void *user)
{
    static const int places[3][2] = {{1, 0}, {1, 1}, {0, 1}};
    cage_ring_patch p = {.size = 1};
    for (int level = 1; level <= r->levels; ++level) {
        const mesh m = mesh_of(r, level);
        p.size /= 2;
        for (int k = 0; k < 3; ++k) {
            p.x = p.size * places[k][0];
            p.y = p.size * places[k][1];
            regular(&m, sector, places[k][0], places[k][1], &p);
            if (!take(user, &p)) return;
        }
    }
    p.x = p.y = 0;
    corner(r, sector, &p);
    take(user, &p);
}
