/* tessellate.c - grids of points, and the way back from a triangle to its chart.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Numbering within a chart, n = 3. Vertices run along u first. Triangles come in pairs, one a cell of the grid
 * (lower, upper) for rectangles; for triangular ones in rows of 1, 3, 5, ... from the corner v = 1, so that the row
 * of triangle k is floor(sqrt(k)).
 *
 *     v  12--13--14--15         9            every triangle (a, b, c) has b - a along +u and c - a along +v, or both
 *        | \ | \ | \ |          | \          reversed: Ng = dP/du x dP/dv / n^2 either way
 *        8---9--10--11          7---8
 *        | \ | \ | \ |          | \ | \
 *        4---5---6---7          4---5---6
 *        | \ | \ | \ |          | \ | \ | \
 *        0---1---2---3  u       0---1---2---3  u */
#include "tools/tessellate.h"
#include "tools/cage_embree.h"
#include "tools/report.h"

#include <math.h>
#include <stdlib.h>

/* Embree reads 16 bytes for the last vertex of 12. */
#define VERTEX_PADDING 4

/* A triangle of the grid: its lower left corner in steps; an upper one is the other half of the cell. */
typedef struct cell {
    uint32_t i, j;
    bool upper;
} cell;

static cell cell_of(patch_kind kind, uint32_t n, uint32_t k)
{
    if (kind == PATCH_TENSOR) return (cell){k / 2 % n, k / 2 / n, k & 1};
    uint32_t row = (uint32_t)sqrt((double)k), in_row = k - row * row;
    return (cell){in_row / 2, n - 1 - row, in_row & 1};
}

static size_t vertex_of(patch_kind kind, size_t n, size_t i, size_t j)
{
    return kind == PATCH_TENSOR ? j * (n + 1) + i : j * (n + 1) - j * (j - 1) / 2 + i;
}

static size_t vertices_of(patch_kind kind, size_t n)
{
    return kind == PATCH_TENSOR ? (n + 1) * (n + 1) : (n + 1) * (n + 2) / 2;
}

static size_t triangles_of(patch_kind kind, size_t n)
{
    return (kind == PATCH_TENSOR ? 2 : 1) * n * n;
}

/* Is the triangle's middle outside of the trim? */
static bool left_out(EPRegion trim, cell c, uint32_t n)
{
    const double third = c.upper ? 2.0 / 3 : 1.0 / 3;
    return trim && !epIsInRegion(trim, (c.i + third) / n, (c.j + third) / n);
}

static void fill_vertices(EPGeometry surface, const chart *at, uint32_t n, float *to)
{
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= (at->kind == PATCH_TENSOR ? n : n - j); ++i) {
            double p[3] = {0, 0, 0}, u, v;
            chart_place(at, (double)i / n, (double)j / n, &u, &v);
            epEvaluate(surface, at->face, u, v, p, NULL, NULL, NULL);
            for (int k = 0; k < 3; ++k) *to++ = (float)p[k];
        }
}

static void fill_triangles(patch_kind kind, EPRegion trim, uint32_t n, size_t first_vertex, uint32_t *triangles)
{
    size_t count = triangles_of(kind, n);
    for (size_t k = 0; k < count; ++k, triangles += 3) {
        cell c = cell_of(kind, n, (uint32_t)k);
        if (left_out(trim, c, n)) { /* a triangle without area is never hit, and the others keep their numbers */
            triangles[0] = triangles[1] = triangles[2] = (uint32_t)first_vertex;
            continue;
        }
        uint32_t a = c.upper, b = !c.upper; /* an upper triangle starts at the far corner and goes back */
        triangles[0] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + a, c.j + a));
        triangles[1] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + b, c.j + a));
        triangles[2] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + a, c.j + b));
    }
}

static bool allocate(tessellation *t, size_t charts)
{
    const bool triangles = t->form == WORLD_TRIANGLES;
    t->first_vertex = malloc((charts + 1) * sizeof *t->first_vertex);
    t->vertices = malloc((3 * t->vertex_count + VERTEX_PADDING) * sizeof *t->vertices);
    t->first = malloc((charts + 1) * sizeof *t->first);
    if (triangles) t->triangles = malloc((3 * t->triangle_count + 1) * sizeof *t->triangles);
    t->bytes = (3 * t->vertex_count + VERTEX_PADDING + 2 * charts + 2 + (triangles ? 3 * t->triangle_count : 0)) * 4;
    return t->first_vertex && t->vertices && t->first && (t->triangles || !triangles);
}

bool tessellate(const char *path, const scene_geometry *g, EPGeometry surface, world_form form, unsigned n, int threads,
                tessellation *t)
{
    *t = (tessellation){.form = form, .n = n};
    if (form == WORLD_SUBDIVISION) return true;
    const size_t charts = chart_count(g);
    for (size_t i = 0; i < charts; ++i) {
        t->vertex_count += vertices_of(chart_at(g, i).kind, n);
        t->triangle_count += triangles_of(chart_at(g, i).kind, n);
    }
    if (t->vertex_count >= UINT32_MAX || t->triangle_count >= UINT32_MAX) {
        report_file(path, "%zu triangles and %zu vertices are too many for 32-bit indices", t->triangle_count,
                    t->vertex_count);
        return false;
    }
    if (!allocate(t, charts)) {
        report_no_memory(path);
        tessellation_free(t);
        return false;
    }
    t->first[0] = t->first_vertex[0] = 0;
    for (size_t i = 0; i < charts; ++i) {
        t->first[i + 1] = t->first[i] + (uint32_t)triangles_of(chart_at(g, i).kind, n);
        t->first_vertex[i + 1] = t->first_vertex[i] + (uint32_t)vertices_of(chart_at(g, i).kind, n);
    }
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t i = 0; i < charts; ++i) {
        const chart c = chart_at(g, i);
        fill_vertices(surface, &c, n, t->vertices + 3 * (size_t)t->first_vertex[i]);
        if (t->triangles)
            fill_triangles(c.kind, g->patches[c.first].trim, n, t->first_vertex[i],
                           t->triangles + 3 * (size_t)t->first[i]);
    }
    return true;
}

void tessellation_free(tessellation *t)
{
    free(t->vertices);
    free(t->triangles);
    free(t->first);
    free(t->first_vertex);
    *t = (tessellation){0};
}

static void set_grids(RTCGeometry to, const tessellation *t, size_t charts)
{
    struct RTCGrid *grids =
        rtcSetNewGeometryBuffer(to, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof *grids, charts);
    for (size_t i = 0; grids && i < charts; ++i)
        grids[i] =
            (struct RTCGrid){t->first_vertex[i], t->n + 1, (unsigned short)(t->n + 1), (unsigned short)(t->n + 1)};
}

RTCGeometry tessellation_geometry(const tessellation *t, const scene_geometry *g, RTCDevice device)
{
    if (t->form == WORLD_SUBDIVISION) return cage_embree_geometry(g, device, t->n);
    const bool triangles = t->form == WORLD_TRIANGLES;
    RTCGeometry to = rtcNewGeometry(device, triangles ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_GRID);
    if (!to) return NULL;
    rtcSetSharedGeometryBuffer(to, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, t->vertices, 0, 3 * sizeof(float),
                               t->vertex_count);
    if (triangles)
        rtcSetSharedGeometryBuffer(to, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->triangles, 0,
                                   3 * sizeof(uint32_t), t->triangle_count);
    else set_grids(to, t, chart_count(g));
    return to;
}

/* Where in its chart the hit is: of a grid Embree says so itself. */
static size_t chart_hit(const tessellation *t, const scene_geometry *g, const world_hit *hit, double *u, double *v)
{
    *u = (double)hit->u, *v = (double)hit->v;
    if (t->form == WORLD_GRIDS) return hit->primID;
    size_t low = 0, high = chart_count(g); /* first[low] <= primID < first[high] */
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(t->first[middle] <= hit->primID ? &low : &high) = middle;
    }
    const double n = t->n;
    const cell c = cell_of(chart_at(g, low).kind, t->n, hit->primID - t->first[low]);
    *u = (c.upper ? c.i + 1 - *u : c.i + *u) / n;
    *v = (c.upper ? c.j + 1 - *v : c.j + *v) / n;
    return low;
}

void tessellation_hit(const tessellation *t, const scene_geometry *g, world_hit *hit)
{
    if (t->form == WORLD_SUBDIVISION) return;
    double u, v;
    const chart at = chart_at(g, chart_hit(t, g, hit, &u, &v));
    chart_place(&at, u, v, &u, &v);
    hit->u = (float)u;
    hit->v = (float)v;
    for (int k = 0; k < 3; ++k) hit->Ng[k] *= (float)((double)t->n * t->n / (at.du * at.dv));
    hit->primID = at.face;
}
