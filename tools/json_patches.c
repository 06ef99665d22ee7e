/* json_patches.c - see json_patches.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/json_patches.h"
#include "tools/args.h"
#include "tools/json_trim.h"
#include "tools/model.h"
#include "tools/nurbs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool read_degree(const json_reader *r, const json_node *n, unsigned *to)
{
    double x = 0;
    if (!json_read_number(r, n, "a degree", &x)) return false;
    if (x != floor(x) || x < 1 || x > EP_MAX_DEGREE)
        return json_wrong(r, n, "a degree is %g, not a whole number from 1 to %d", x, EP_MAX_DEGREE);
    *to = (unsigned)x;
    return true;
}

static bool read_point(const json_reader *r, const json_node *n, double p[4])
{
    if (!json_is(r, n, JSON_ARRAY, "a point")) return false;
    size_t count = json_array_size(n->json);
    if (count != 3 && count != 4) return json_wrong(r, n, "a point has 3 or 4 numbers, not %zu", count);
    p[3] = 1;
    for (size_t i = 0; i < count; ++i) {
        json_node e = json_element(n, i);
        if (!json_read_number(r, &e, "a coordinate", &p[i])) return false;
    }
    const char *problem = point_problem(p);
    return !problem || json_wrong(r, n, "%s", problem);
}

/* The next trim of a geometry. */
static bool read_trim(const json_reader *r, const json_node *n, scene_geometry *g, EPRegion *region)
{
    trim_shape *shape;
    if (!json_read_trim(r, n, region, &shape)) return false;
    if (geometry_add_shape(g, shape)) return true;
    epReleaseRegion(*region);
    shape_free(shape);
    return json_no_memory(r);
}

/* By the trim that was read last. */
static void set_trim(scene_geometry *g, size_t patch, EPRegion region)
{
    epRetainRegion(region);
    g->patches[patch].trim = region;
    g->patches[patch].shape = g->shapes[g->shape_count - 1];
}

/* A patch is its list of points, or an object with the list and a trim. */
static bool read_patch(const json_reader *r, const json_node *n, patch_kind kind, const unsigned degree[2],
                       scene_geometry *g)
{
    json_node points = *n;
    if (json_is_object(n->json)) {
        static const char *const keys[] = {"points", "trim"};
        if (!json_only_keys(r, n, "a patch", keys, ARG_COUNT(keys))) return false;
        points = json_member(n, "points");
        if (!points.json) return json_wrong(r, n, "a patch has no points");
    }
    if (!json_is(r, &points, JSON_ARRAY, "a patch")) return false;

    size_t have = json_array_size(points.json), need = patch_point_count(kind, degree[0], degree[1]);
    if (have != need) return json_wrong(r, &points, "a patch of this degree has %zu points, not %zu", need, have);
    double *p = geometry_add_patch(g, kind, degree[0], degree[1]);
    if (!p) return json_no_memory(r);
    for (size_t i = 0; i < need; ++i) {
        json_node e = json_element(&points, i);
        if (!read_point(r, &e, p + 4 * i)) return false;
    }
    const json_node trim = json_member(n, "trim");
    if (!trim.json) return true;
    EPRegion region;
    if (!read_trim(r, &trim, g, &region)) return false;
    set_trim(g, g->patch_count - 1, region);
    epReleaseRegion(region);
    return true;
}

bool json_read_patches(const json_reader *r, const json_node *n, patch_kind kind, const unsigned degree[2],
                       scene_geometry *g)
{
    json_node patches = json_member(n, "patches");
    if (!patches.json) return json_wrong(r, n, "a geometry of patches needs 'patches'");
    if (!json_is(r, &patches, JSON_ARRAY, "'patches'")) return false;
    for (size_t i = 0; i < json_array_size(patches.json); ++i) {
        json_node e = json_element(&patches, i);
        if (!read_patch(r, &e, kind, degree, g)) return false;
    }
    return true;
}

bool json_read_bezier_triangles(const json_reader *r, const json_node *n, scene_geometry *g)
{
    unsigned degree[2] = {0, 0};
    json_node d = json_member(n, "degree");
    if (!d.json) return json_wrong(r, n, "a geometry of Bézier triangles needs 'degree'");
    if (!read_degree(r, &d, &degree[0])) return false;
    degree[1] = degree[0];
    return json_read_patches(r, n, PATCH_TRIANGLE, degree, g);
}

/* "degree": [in u, in v] of `what`. */
static bool read_degrees(const json_reader *r, const json_node *n, const char *what, unsigned degree[2])
{
    const json_node d = json_member(n, "degree");
    if (!d.json) return json_wrong(r, n, "%s needs 'degree'", what);
    if (!json_is(r, &d, JSON_ARRAY, "'degree'")) return false;
    if (json_array_size(d.json) != 2) return json_wrong(r, &d, "'degree' has two numbers: in u and in v");
    for (size_t i = 0; i < 2; ++i) {
        const json_node e = json_element(&d, i);
        if (!read_degree(r, &e, &degree[i])) return false;
    }
    return true;
}

bool json_read_bezier(const json_reader *r, const json_node *n, scene_geometry *g)
{
    unsigned degree[2] = {0, 0};
    return read_degrees(r, n, "a geometry of Bézier patches", degree) &&
           json_read_patches(r, n, PATCH_TENSOR, degree, g);
}

/* The points that go with the knots. */
static bool read_net(const json_reader *r, const json_node *n, const nurbs *s, scene_geometry *g)
{
    if (!json_is(r, n, JSON_ARRAY, "'points'")) return false;
    const size_t have = json_array_size(n->json);
    if (have / s->count[0] != s->count[1] || have % s->count[0])
        return json_wrong(r, n, "these knots go with %zu x %zu points, not %zu", s->count[0], s->count[1], have);
    double(*points)[4] = malloc((have + 1) * sizeof *points);
    if (!points) return json_no_memory(r);
    bool done = true;
    for (size_t i = 0; i < have && done; ++i) {
        const json_node e = json_element(n, i);
        done = read_point(r, &e, points[i]);
    }
    nurbs whole = *s;
    whole.points = (const double(*)[4])points;
    const char *problem = done ? geometry_add_nurbs(g, 0, &whole, NULL, NULL) : NULL;
    free(points);
    return done && (!problem || json_wrong(r, n, "%s", problem));
}

static bool read_surface(const json_reader *r, const json_node *n, nurbs *s, double *knots[2], scene_geometry *g)
{
    const json_node k = json_member(n, "knots"), points = json_member(n, "points");
    if (!read_degrees(r, n, "a NURBS surface", s->degree)) return false;
    if (!k.json) return json_wrong(r, n, "a NURBS surface needs 'knots'");
    if (!points.json) return json_wrong(r, n, "a NURBS surface needs 'points'");
    if (!json_is(r, &k, JSON_ARRAY, "'knots'")) return false;
    if (json_array_size(k.json) != 2) return json_wrong(r, &k, "'knots' has two lists: for u and for v");
    for (size_t i = 0; i < 2; ++i) {
        const json_node e = json_element(&k, i);
        s->knots[i] = knots[i] = json_read_list(r, &e, "a knot vector", &s->knot_count[i]);
        if (!knots[i]) return false;
        if (s->knot_count[i] < 2 * (s->degree[i] + 1))
            return json_wrong(r, &e, "a surface of degree %u has at least %u knots, not %zu", s->degree[i],
                              2 * (s->degree[i] + 1), s->knot_count[i]);
        s->count[i] = s->knot_count[i] - s->degree[i] - 1;
    }
    return read_net(r, &points, s, g);
}

bool json_read_nurbs(const json_reader *r, const json_node *n, scene_geometry *g)
{
    nurbs s = {.points = NULL};
    double *knots[2] = {NULL, NULL};
    const bool done = read_surface(r, n, &s, knots, g);
    free(knots[0]);
    free(knots[1]);
    return done;
}

bool json_trim_all(const json_reader *r, const json_node *n, scene_geometry *g)
{
    EPRegion region;
    if (!read_trim(r, n, g, &region)) return false;
    for (size_t i = 0; i < g->patch_count; ++i)
        if (!g->patches[i].trim) set_trim(g, i, region);
    epReleaseRegion(region);
    return true;
}
