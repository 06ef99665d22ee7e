/* outline.c - points on the surfaces for framing, control points for bounds.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/outline.h"

#include <math.h>
#include <stdlib.h>

/* Enough to know a model's outline when the camera is placed; more would only take time. */
#define OUTLINE_POINTS 200000
#define OUTLINE_GRID 6

/* Added where less is left of an object than one patch has: what a trim keeps may be small. */
#define BOX_CORNERS 8

static void transform(const double m[12], const double p[3], double r[3])
{
    for (int x = 0; x < 3; ++x) r[x] = m[x] * p[0] + m[3 + x] * p[1] + m[6 + x] * p[2] + m[9 + x];
}

/* Points of a chart that its trim keeps. Returns their number. */
static size_t add_chart(const world *w, const scene_object *o, const chart *c, double (*points)[3])
{
    const EPRegion trim = w->scene->geometries[o->geometry].patches[c->first].trim;
    size_t count = 0;
    for (int sample = 0; sample < OUTLINE_GRID * OUTLINE_GRID; ++sample) {
        double u = (sample % OUTLINE_GRID) / (OUTLINE_GRID - 1.0), p[3];
        double v = (sample / OUTLINE_GRID) / (OUTLINE_GRID - 1.0);
        if (c->kind == PATCH_TRIANGLE) v *= 1 - u;
        chart_place(c, u, v, &u, &v);
        if (trim && !epIsInRegion(trim, u, v)) continue;
        if (epEvaluate(w->geometries[o->geometry], c->face, u, v, p, NULL, NULL, NULL) == EP_OK)
            transform(o->transform, p, points[count++]);
    }
    return count;
}

/* The corners of the box of an object, of which nothing is outside that is trimmed away. */
static size_t add_corners(const world *w, const scene_object *o, double (*points)[3])
{
    float b[6];
    epGetGeometryBounds(w->geometries[o->geometry], b);
    if (!(b[0] <= b[3])) return 0;
    for (unsigned k = 0; k < BOX_CORNERS; ++k) {
        const double p[3] = {(double)b[k & 1 ? 3 : 0], (double)b[k & 2 ? 4 : 1], (double)b[k & 4 ? 5 : 2]};
        transform(o->transform, p, points[k]);
    }
    return BOX_CORNERS;
}

double (*outline_new(const world *w, size_t *count))[3]
{
    const scene *s = w->scene;
    size_t charts = 0;
    for (size_t i = 0; i < s->object_count; ++i) charts += chart_count(&s->geometries[s->objects[i].geometry]);
    const size_t each = OUTLINE_GRID * OUTLINE_GRID, step = 1 + each * charts / OUTLINE_POINTS;
    double(*points)[3] = malloc(sizeof *points * (each * (charts / step) + (each + BOX_CORNERS) * s->object_count + 1));
    *count = 0;
    for (size_t i = 0; points && i < s->object_count; ++i) {
        const scene_object *o = &s->objects[i];
        const scene_geometry *g = &s->geometries[o->geometry];
        const size_t before = *count;
        for (size_t k = 0; k < chart_count(g); k += step) {
            const chart c = chart_at(g, k);
            *count += add_chart(w, o, &c, points + *count);
        }
        if (*count - before < each) *count += add_corners(w, o, points + *count);
    }
    return points;
}

/* An eye that frames the scene is no farther from it than a few of its diameters, or 2^-15 of its distance from the
 * origin. */
double outline_reach(const scene *s, const camera *c)
{
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < s->object_count; ++i) {
        const scene_geometry *g = &s->geometries[s->objects[i].geometry];
        for (size_t k = 0; k < g->point_count; ++k) {
            double p[3];
            transform(s->objects[i].transform, g->points + 4 * k, p);
            for (int x = 0; x < 3; ++x) lower[x] = fmin(lower[x], p[x]), upper[x] = fmax(upper[x], p[x]);
        }
    }
    double corner = 0, diameter = 0, eye = 0;
    for (int x = 0; x < 3 && lower[0] <= upper[0]; ++x) {
        corner += fmax(lower[x] * lower[x], upper[x] * upper[x]);
        diameter += (upper[x] - lower[x]) * (upper[x] - lower[x]);
    }
    if (!c) return (1 + 0x1p-14) * sqrt(corner) + 8 * sqrt(diameter);
    for (int x = 0; x < 3; ++x) eye += c->eye[x] * c->eye[x];
    return sqrt(fmax(corner, eye));
}
