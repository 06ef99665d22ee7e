/* tessellate.c - grids of triangles, and the way back from a triangle to its patch.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Numbering within a patch, n = 3. Vertices run along u first. Triangles come in pairs, one a cell of the grid
 * (lower, upper) for tensor patches; for triangular ones in rows of 1, 3, 5, ... from the corner v = 1, so that the row
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

static void fill_patch(EPGeometry surface, uint32_t index, const patch *p, uint32_t n, float *vertices,
                       size_t first_vertex, uint32_t *triangles)
{
    const patch_kind kind = p->kind;
    float *to = vertices + 3 * first_vertex;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= (kind == PATCH_TENSOR ? n : n - j); ++i) {
            double p[3] = {0, 0, 0};
            epEvaluate(surface, index, (double)i / n, (double)j / n, p, NULL, NULL, NULL);
            for (int k = 0; k < 3; ++k) *to++ = (float)p[k];
        }

    size_t count = triangles_of(kind, n);
    for (size_t k = 0; k < count; ++k, triangles += 3) {
        cell c = cell_of(kind, n, (uint32_t)k);
        if (left_out(p->trim, c, n)) { /* a triangle without area is never hit, and the others keep their numbers */
            triangles[0] = triangles[1] = triangles[2] = (uint32_t)first_vertex;
            continue;
        }
        uint32_t a = c.upper, b = !c.upper; /* an upper triangle starts at the far corner and goes back */
        triangles[0] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + a, c.j + a));
        triangles[1] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + b, c.j + a));
        triangles[2] = (uint32_t)(first_vertex + vertex_of(kind, n, c.i + a, c.j + b));
    }
}

bool tessellate(const char *path, const scene_geometry *g, EPGeometry surface, unsigned n, int threads, tessellation *t)
{
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < g->patch_count; ++i) {
        vertices += vertices_of(g->patches[i].kind, n);
        triangles += triangles_of(g->patches[i].kind, n);
    }
    *t = (tessellation){.n = n, .vertex_count = vertices, .triangle_count = triangles};
    if (vertices >= UINT32_MAX || triangles >= UINT32_MAX) {
        report_file(path, "%zu triangles and %zu vertices are too many for 32-bit indices", triangles, vertices);
        return false;
    }
    size_t *first_vertex = malloc((g->patch_count + 1) * sizeof *first_vertex);
    t->vertices = malloc((3 * vertices + VERTEX_PADDING) * sizeof *t->vertices);
    t->triangles = malloc((3 * triangles + 1) * sizeof *t->triangles);
    t->first = malloc((g->patch_count + 1) * sizeof *t->first);
    if (!first_vertex || !t->vertices || !t->triangles || !t->first) {
        report_no_memory(path);
        free(first_vertex);
        tessellation_free(t);
        return false;
    }
    t->bytes = (3 * vertices + VERTEX_PADDING + 3 * triangles + g->patch_count + 1) * 4;

    t->first[0] = 0;
    first_vertex[0] = 0;
    for (size_t i = 0; i < g->patch_count; ++i) {
        t->first[i + 1] = t->first[i] + (uint32_t)triangles_of(g->patches[i].kind, n);
        first_vertex[i + 1] = first_vertex[i] + vertices_of(g->patches[i].kind, n);
    }
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t i = 0; i < g->patch_count; ++i)
        fill_patch(surface, (uint32_t)i, &g->patches[i], n, t->vertices, first_vertex[i],
                   t->triangles + 3 * (size_t)t->first[i]);
    free(first_vertex);
    return true;
}

void tessellation_free(tessellation *t)
{
    free(t->vertices);
    free(t->triangles);
    free(t->first);
    *t = (tessellation){0};
}

RTCGeometry tessellation_geometry(const tessellation *t, RTCDevice device)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!g) return NULL;
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, t->vertices, 0, 3 * sizeof(float),
                               t->vertex_count);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->triangles, 0, 3 * sizeof(uint32_t),
                               t->triangle_count);
    return g;
}

void tessellation_hit(const tessellation *t, const scene_geometry *g, world_hit *hit)
{
    size_t low = 0, high = g->patch_count; /* first[low] <= primID < first[high] */
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(t->first[middle] <= hit->primID ? &low : &high) = middle;
    }
    float n = (float)t->n;
    cell c = cell_of(g->patches[low].kind, t->n, hit->primID - t->first[low]);
    hit->u = (c.upper ? (float)(c.i + 1) - hit->u : (float)c.i + hit->u) / n;
    hit->v = (c.upper ? (float)(c.j + 1) - hit->v : (float)c.j + hit->v) / n;
    for (int k = 0; k < 3; ++k) hit->Ng[k] *= n * n;
    hit->primID = (uint32_t)low;
}
