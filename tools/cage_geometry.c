/* cage_geometry.c - a cage's limit surface as a geometry: patches in their places, faces, charts.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A chart is a face, or a quadrilateral of a polygon: its patches come one after the other and are merged where they
 * are one polynomial. */
#include "tools/array.h"
#include "tools/cage_merge.h"
#include "tools/model.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/shim/cage_osd.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct filling {
    const cage *cage;
    scene_geometry *g;
    cage_patch *patches; /* of the chart that is being read */
    size_t count, capacity;
    const char *problem;
} filling;

/* Where a face's parameters have a quadrilateral of a polygon; see cage.h. */
static chart chart_of_patch(const cage *c, const cage_patch *p)
{
    const bool divided = c->scheme == CAGE_CATMULL_CLARK && c->sizes[p->face] != 4;
    return (chart){.kind = c->scheme == CAGE_LOOP ? PATCH_TRIANGLE : PATCH_TENSOR,
                   .face = p->face,
                   .u0 = divided ? 2 * (p->quad % 4) + 0.5 : 0,
                   .v0 = divided ? 2 * (p->quad / 4) + 0.5 : 0,
                   .du = 1,
                   .dv = 1};
}

static const char *add_patch(scene_geometry *g, const chart *at, const cage_patch *p)
{
    const unsigned degree = at->kind == PATCH_TRIANGLE ? 4 : 3;
    double *points = geometry_add_patch(g, at->kind, degree, degree);
    const double *m = p->place, place[6] = {m[0], m[1], m[2], m[3], m[4] + at->u0, m[5] + at->v0};
    if (!points || !geometry_place_patch(g, place)) return "out of memory";
    const char *problem = NULL;
    for (size_t i = 0; i < patch_point_count(at->kind, degree, degree) && !problem; ++i, points += 4) {
        memcpy(points, p->points[i], sizeof p->points[i]);
        points[3] = 1;
        problem = point_problem(points);
    }
    return problem;
}

static double area_of(const cage_patch *p)
{
    return fabs(p->place[0] * p->place[3] - p->place[1] * p->place[2]);
}

/* Large ones first: who looks for the patch at some u, v mostly finds it soon. */
static int compare_areas(const void *a, const void *b)
{
    const cage_patch *p = a, *q = b;
    const double x = area_of(p), y = area_of(q);
    if (x != y) return x < y ? 1 : -1;
    for (int k = 5; k >= 4; --k)
        if (p->place[k] != q->place[k]) return p->place[k] < q->place[k] ? -1 : 1;
    return 0;
}

/* The chart that has been read. */
static void add_chart(filling *f)
{
    scene_geometry *g = f->g;
    if (!f->count || f->problem) return;
    chart here = chart_of_patch(f->cage, f->patches);
    if (here.kind == PATCH_TENSOR) f->count = cage_merge(f->patches, f->count);
    qsort(f->patches, f->count, sizeof *f->patches, compare_areas);
    here.first = g->patch_count;
    here.count = f->count;
    if (!geometry_add_chart(g, &here)) f->problem = "out of memory";
    for (size_t i = 0; i < f->count && !f->problem; ++i) f->problem = add_patch(g, &here, &f->patches[i]);
    f->count = 0;
}

static bool take(void *user, const cage_patch *p)
{
    filling *f = user;
    if (f->count && (p->face != f->patches->face || p->quad != f->patches->quad)) add_chart(f);
    if (!f->problem && !array_grow((void **)&f->patches, &f->capacity, f->count, 1, sizeof *f->patches))
        f->problem = "out of memory";
    if (f->problem) return false;
    f->patches[f->count++] = *p;
    return true;
}

/* The vertices go where transforms find them, behind the patches' points. */
static bool keep_cage(scene_geometry *g, cage *c)
{
    g->cage = c;
    g->cage_first = g->point_count;
    double *points = geometry_add_points(g, c->vertex_count);
    if (!points) return false;
    for (size_t i = 0; i < c->vertex_count; ++i, points += 4) {
        memcpy(points, c->vertices[i], sizeof c->vertices[i]);
        points[3] = 1;
    }
    free(c->vertices);
    c->vertices = NULL;
    return true;
}

bool cage_to_geometry(const char *path, cage *c, scene_geometry *g)
{
    const double start = wall_seconds();
    filling f = {.cage = c, .g = g};
    const char *note, *problem = cage_patches(c, take, &f, &note);
    if (!problem) add_chart(&f);
    if (!problem) problem = f.problem;
    free(f.patches);
    if (problem) {
        report_file(path, "%s", problem);
        cage_free(c);
        return false;
    }
    g->cage_seconds = wall_seconds() - start;
    if (*note) report_file(path, "%s; ignored", note);
    return keep_cage(g, c) || (report_no_memory(path), false);
}
