/* added.c - patches as a caller adds them: points, NURBS surfaces, faces, trims.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Everything is checked before anything is changed. */
#include "embree_patch/geometry.h"
#include "embree_patch/nurbs.h"
#include "trim/within.h"

#include <string.h>

static size_t format_bytes(EPFormat f)
{
    static const size_t bytes[] = {3 * sizeof(float), 4 * sizeof(float), 3 * sizeof(double), 4 * sizeof(double)};
    return (unsigned)f < EP_ARRAY_LEN(bytes) ? bytes[f] : 0;
}

static void read_point(EPFormat format, const char *at, double p[4])
{
    const bool weighted = format == EP_FORMAT_FLOAT4 || format == EP_FORMAT_DOUBLE4;
    const int n = weighted ? 4 : 3;
    p[3] = 1;
    for (int c = 0; c < n; ++c) {
        if (format == EP_FORMAT_FLOAT3 || format == EP_FORMAT_FLOAT4) {
            float f;
            memcpy(&f, at + (size_t)c * sizeof f, sizeof f);
            p[c] = f;
        } else {
            memcpy(&p[c], at + (size_t)c * sizeof(double), sizeof(double));
        }
    }
}

/* Points as a caller has them. */
typedef struct given_points {
    EPFormat format;
    const char *at;
    size_t stride;
} given_points;

static EPStatus check_layout(EPGeometry g, EPFormat format, size_t stride)
{
    const size_t bytes = format_bytes(format);
    if (!bytes) return ep_fail(&g->message, EP_INVALID, "%d is no point format", (int)format);
    if (stride < bytes)
        return ep_fail(&g->message, EP_INVALID, "a stride of %zu bytes is shorter than a point of %zu", stride, bytes);
    return EP_OK;
}

/* Coordinates and weights beyond these overflow when they are multiplied or squared in float. */
static const double largest_coordinate = 0x1p60, largest_weight = 0x1p40;

/* The next `count` points, of `what` number `index`; `to` may be NULL, *rational is set when a weight is not one. */
static EPStatus read_net(EPGeometry g, const char *what, size_t index, size_t count, given_points *from, ep_point *to,
                         uint8_t *rational)
{
    *rational = 0;
    for (size_t i = 0; i < count; ++i, from->at += from->stride) {
        double p[4];
        read_point(from->format, from->at, p);
        for (int c = 0; c < 3; ++c)
            if (!(fabs(p[c]) <= largest_coordinate))
                return ep_fail(&g->message, EP_BAD_DATA, "%s %zu, point %zu: %c is %g, not within +-2^60", what, index,
                               i, "xyz"[c], p[c]);
        if (!(p[3] > 0 && p[3] <= largest_weight && p[3] >= 1 / largest_weight))
            return ep_fail(&g->message, EP_BAD_DATA, "%s %zu, point %zu: the weight is %g, not in 2^-40..2^40", what,
                           index, i, p[3]);
        if (p[3] != 1) *rational = 1;
        if (!to) continue;
        for (int c = 0; c < 3; ++c) to[i][c] = p[3] * p[c];
        to[i][3] = p[3];
    }
    return EP_OK;
}

static size_t points_of(const ep_added *a)
{
    return ep_kinds[a->kind].point_count(a->degree_u, a->degree_v);
}

/* The committed leaves' patches are among those that were added, wherever these are now. */
static void follow_points(EPGeometry g)
{
    for (size_t i = 0; i < g->hierarchy.patch_count; ++i)
        g->hierarchy.patches[i].points = g->points + g->added[i].first;
}

bool ep_added_shrink(EPGeometry g)
{
    const bool done = ep_shrink((void **)&g->added, &g->added_capacity, g->added_count, sizeof *g->added) &&
                      ep_shrink((void **)&g->points, &g->point_capacity, g->point_count, sizeof *g->points) &&
                      ep_faces_shrink(&g->faces);
    follow_points(g);
    return done;
}

static EPStatus check_degrees(EPGeometry g, unsigned m, unsigned n)
{
    const bool first = m < 1 || m > EP_MAX_DEGREE;
    if (!first && n >= 1 && n <= EP_MAX_DEGREE) return EP_OK;
    return ep_fail(&g->message, EP_INVALID, "degree %u is not in 1..%d", first ? m : n, EP_MAX_DEGREE);
}

/* Room for `count` more patches of `each` points, and as many faces. */
static EPStatus reserve(EPGeometry g, size_t count, size_t each)
{
    if (count > UINT32_MAX - g->added_count || count > SIZE_MAX / 64 / each)
        return ep_fail(&g->message, EP_INVALID, "%zu patches are too many", count);
    if (!ep_reserve((void **)&g->added, &g->added_capacity, g->added_count, count, sizeof *g->added) ||
        !ep_reserve((void **)&g->points, &g->point_capacity, g->point_count, count * each, sizeof *g->points) ||
        (ep_faces_exist(&g->faces) && !ep_faces_reserve(&g->faces, count)))
        return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", count);
    follow_points(g);
    return EP_OK;
}

/* The next `count` patches, which are complete behind those that there are. */
static void append(EPGeometry g, size_t count, size_t each)
{
    if (ep_faces_exist(&g->faces)) ep_faces_add(&g->faces, count);
    g->added_count += count;
    g->point_count += count * each;
    g->committed = false;
}

static EPStatus add(EPGeometry g, ep_kind_id kind, unsigned m, unsigned n, size_t count, EPFormat format,
                    const void *points, size_t stride)
{
    EPStatus status = check_degrees(g, m, n);
    if (status == EP_OK) status = check_layout(g, format, stride);
    if (status != EP_OK || !count) return status;
    if (!points) return ep_fail(&g->message, EP_INVALID, "no points");

    const size_t each = ep_kinds[kind].point_count(m, n);
    given_points from = {format, points, stride};
    status = reserve(g, count, each);
    for (size_t k = 0; k < count && status == EP_OK; ++k) {
        ep_added *a = &g->added[g->added_count + k];
        *a = (ep_added){g->point_count + k * each, (uint8_t)kind, (uint8_t)m, (uint8_t)n, 0, NULL, NULL};
        status = read_net(g, "patch", k, each, &from, g->points + a->first, &a->rational);
    }
    if (status == EP_OK) append(g, count, each);
    return status;
}

EPStatus epAddBezierTriangles(EPGeometry g, unsigned degree, size_t count, EPFormat format, const void *points,
                              size_t stride)
{
    return add(g, EP_KIND_TRIANGLE, degree, degree, count, format, points, stride);
}

EPStatus epAddBezierPatches(EPGeometry g, unsigned m, unsigned n, size_t count, EPFormat format, const void *points,
                            size_t stride)
{
    return add(g, EP_KIND_TENSOR, m, n, count, format, points, stride);
}

EPStatus epJoinPatches(EPGeometry g, uint32_t first, size_t count, const double (*transforms)[6])
{
    const char *problem = ep_faces_problem(&g->faces, g->added_count, first, count, transforms);
    for (size_t i = first; !problem && i < g->added_count; ++i)
        if (g->added[i].region) problem = "a patch is trimmed";
    if (problem) return ep_fail(&g->message, EP_INVALID, "joining patches from %u on: %s", first, problem);
    if (!ep_faces_join(&g->faces, g->added_count, first, count, transforms))
        return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", count);
    g->committed = false;
    return EP_OK;
}

/* The patches of a surface whose control points are `net`, joined to a face. */
static EPStatus add_spans(EPGeometry g, const ep_nurbs *n, const ep_point *net, uint8_t rational)
{
    const size_t count = ep_nurbs_patches(n), first = g->added_count;
    const size_t each = ep_kinds[EP_KIND_TENSOR].point_count(n->degree[0], n->degree[1]);
    const uint8_t m = (uint8_t)n->degree[0], k = (uint8_t)n->degree[1];
    double(*places)[6] = ep_alloc(count, sizeof *places);
    EPStatus status = EP_OK;
    if (!places || !ep_faces_begin(&g->faces, first))
        status = ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu patches", count);
    if (status == EP_OK) status = reserve(g, count, each);
    ep_point *points = g->points + g->point_count;
    if (status == EP_OK) status = ep_nurbs_split(n, net, points, places, &g->message);
    for (size_t i = 0; i < count && status == EP_OK; ++i)
        g->added[first + i] = (ep_added){g->point_count + i * each, EP_KIND_TENSOR, m, k, rational, NULL, NULL};
    if (status == EP_OK) {
        append(g, count, each);
        ep_faces_join(&g->faces, g->added_count, first, count, (const double(*)[6])places);
    }
    ep_free(places);
    return status;
}

EPStatus epAddNURBSSurface(EPGeometry g, unsigned degreeU, unsigned degreeV, size_t knotCountU, const double *knotsU,
                           size_t knotCountV, const double *knotsV, EPFormat format, const void *points, size_t stride)
{
    EPStatus status = check_degrees(g, degreeU, degreeV);
    if (status == EP_OK) status = check_layout(g, format, stride);
    if (status != EP_OK) return status;
    if (!points || !knotsU || !knotsV) return ep_fail(&g->message, EP_INVALID, "no points, or no knots");
    if (knotCountU < degreeU + 1 || knotCountV < degreeV + 1)
        return ep_fail(&g->message, EP_INVALID, "%zu and %zu knots are too few", knotCountU, knotCountV);
    const ep_nurbs n = {.degree = {degreeU, degreeV},
                        .count = {knotCountU - degreeU - 1, knotCountV - degreeV - 1},
                        .knot_count = {knotCountU, knotCountV},
                        .knots = {knotsU, knotsV}};
    status = ep_nurbs_check(&n, &g->message);
    if (status != EP_OK) return status;

    const size_t count = n.count[0] * n.count[1];
    ep_point *net = ep_alloc(count, sizeof *net);
    if (!net) return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu points", count);
    uint8_t rational;
    given_points from = {format, points, stride};
    status = read_net(g, "NURBS surface", ep_face_count(g), count, &from, net, &rational);
    if (status == EP_OK) status = add_spans(g, &n, net, rational);
    ep_free(net);
    return status;
}

static EPStatus check_patches(EPGeometry g, uint32_t first, size_t count)
{
    if (first > g->added_count || count > g->added_count - first)
        return ep_fail(&g->message, EP_INVALID, "there are no %zu patches from %u on", count, first);
    return EP_OK;
}

EPStatus epSetPatchPoints(EPGeometry g, uint32_t first, size_t count, EPFormat format, const void *points,
                          size_t stride)
{
    EPStatus status = check_patches(g, first, count);
    if (status == EP_OK) status = check_layout(g, format, stride);
    if (status != EP_OK || !count) return status;
    if (!points) return ep_fail(&g->message, EP_INVALID, "no points");
    uint8_t rational;
    given_points from = {format, points, stride};
    for (size_t k = 0; k < count; ++k) {
        status = read_net(g, "patch", k, points_of(&g->added[first + k]), &from, NULL, &rational);
        if (status != EP_OK) return status;
    }
    from.at = points;
    for (size_t k = 0; k < count; ++k) {
        ep_added *a = &g->added[first + k];
        read_net(g, "patch", k, points_of(a), &from, g->points + a->first, &a->rational);
    }
    g->moved = true;
    return EP_OK;
}

/* How much of a region's box a patch may cover. */
static double share_of(const ep_place *place, const ep_trim *whole)
{
    const double box = (whole->hi[0] - whole->lo[0]) * (whole->hi[1] - whole->lo[1]);
    return box > 0 ? fmin(1, 1 / fabs(place->scale) / box) : 1;
}

/* A patch's own trim: that of its face as it is seen from the patch. NULL where the region itself will do. */
static EPStatus new_trim(EPGeometry g, size_t patch, EPRegion region, ep_trim **trim)
{
    *trim = NULL;
    const ep_place *place = ep_faces_exist(&g->faces) ? &g->faces.places[patch] : NULL;
    if (!region || !place || ep_place_is_identity(place)) return EP_OK;
    double to_patch[6];
    ep_region *within;
    ep_place_invert(place, to_patch);
    EPStatus status =
        ep_region_within(region->region, to_patch, g->added[patch].kind == EP_KIND_TRIANGLE, &within, &g->message);
    if (status == EP_OK) status = ep_trim_new(within, trim, &g->message);
    if (status == EP_OK) (*trim)->share = share_of(place, region->trim);
    ep_region_free(within);
    return status;
}

EPStatus epSetPatchTrim(EPGeometry g, uint32_t first, size_t count, EPRegion region)
{
    EPStatus status = check_patches(g, first, count);
    if (status != EP_OK) return status;
    if (region && !region->trim) return ep_fail(&g->message, EP_INVALID, "a trim's region is not complete");
    ep_trim **trims = ep_alloc(count, sizeof *trims);
    if (!trims) return ep_fail(&g->message, EP_NO_MEMORY, "no memory for %zu trims", count);
    size_t made = 0;
    for (; made < count && status == EP_OK; ++made) status = new_trim(g, first + made, region, &trims[made]);
    for (size_t i = 0; i < made && status != EP_OK; ++i) ep_trim_free(trims[i]);
    for (size_t i = 0; i < count && status == EP_OK; ++i) {
        ep_added *a = &g->added[first + i];
        epRetainRegion(region);
        epReleaseRegion(a->region);
        ep_trim_free(a->trim);
        a->region = region;
        a->trim = trims[i];
        g->committed = false;
    }
    ep_free(trims);
    return status;
}

const ep_trim *ep_added_trim(const ep_added *a)
{
    return a->trim ? a->trim : a->region ? a->region->trim : NULL;
}

void ep_added_free(EPGeometry g)
{
    for (size_t i = 0; i < g->added_count; ++i) {
        epReleaseRegion(g->added[i].region);
        ep_trim_free(g->added[i].trim);
    }
    ep_faces_free(&g->faces);
    ep_free(g->added);
    ep_free(g->points);
}
