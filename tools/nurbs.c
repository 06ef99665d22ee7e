/* nurbs.c - see nurbs.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/nurbs.h"
#include "embree_patch/nurbs.h"
#include "tools/model.h"

#include <stdlib.h>
#include <string.h>

static const char out_of_memory[] = "out of memory";

static const char *check_points(const nurbs *n, ep_message *m)
{
    for (size_t i = 0; i < n->count[0] * n->count[1]; ++i) {
        const char *problem = point_problem(n->points[i]);
        if (!problem) continue;
        ep_fail(m, EP_BAD_DATA, "point %zu: %s", i + 1, problem);
        return m->text;
    }
    return NULL;
}

static void homogeneous(const nurbs *n, ep_point *to)
{
    for (size_t i = 0; i < n->count[0] * n->count[1]; ++i) {
        const double *p = n->points[i];
        for (int c = 0; c < 3; ++c) to[i][c] = p[3] * p[c];
        to[i][3] = p[3];
    }
}

/* One of the patches, `from` being its homogeneous points. */
static bool add_patch(scene_geometry *g, uint32_t face, const nurbs *n, const ep_point *from, const double place[6])
{
    double *to = geometry_add_patch(g, PATCH_TENSOR, n->degree[0], n->degree[1]);
    const size_t each = patch_point_count(PATCH_TENSOR, n->degree[0], n->degree[1]);
    for (size_t i = 0; to && i < each; ++i, to += 4) {
        for (int c = 0; c < 3; ++c) to[c] = from[i][c] / from[i][3];
        to[3] = from[i][3];
    }
    const chart at = {PATCH_TENSOR, face, place[4], place[5], place[0], place[3], g->patch_count - 1, 1};
    return to && geometry_place_patch(g, place) && geometry_add_chart(g, &at);
}

const char *geometry_add_nurbs(scene_geometry *g, uint32_t face, const nurbs *n, EPRegion trim,
                               struct trim_shape *shape)
{
    static _Thread_local ep_message why;
    const ep_nurbs s = {.degree = {n->degree[0], n->degree[1]},
                        .count = {n->count[0], n->count[1]},
                        .knot_count = {n->knot_count[0], n->knot_count[1]},
                        .knots = {n->knots[0], n->knots[1]}};
    const char *problem = ep_nurbs_check(&s, &why) == EP_OK ? check_points(n, &why) : why.text;
    if (problem) return problem;

    const size_t patches = ep_nurbs_patches(&s), first = g->patch_count;
    const size_t each = patch_point_count(PATCH_TENSOR, n->degree[0], n->degree[1]);
    ep_point *net = malloc(n->count[0] * n->count[1] * sizeof *net), *points = malloc(patches * each * sizeof *points);
    double(*places)[6] = malloc(patches * sizeof *places);
    problem = net && points && places ? NULL : out_of_memory;
    if (!problem) {
        homogeneous(n, net);
        if (ep_nurbs_split(&s, (const ep_point *)net, points, places, &why) != EP_OK) problem = why.text;
        for (size_t i = 0; i < patches && !problem; ++i)
            if (!add_patch(g, face, n, (const ep_point *)points + i * each, places[i])) problem = out_of_memory;
    }
    for (size_t i = first; i < g->patch_count && trim; ++i) {
        epRetainRegion(trim);
        g->patches[i].trim = trim;
        g->patches[i].shape = shape;
    }
    free(net);
    free(points);
    free(places);
    return problem;
}
