/* json_trim.c - regions and their segments, as the scene format writes them. See json_trim.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A region is read twice at once: for the library, and as it is written, for the reference that `epatch verify` holds
 * the library against. Only the shape of the JSON is checked here. What points, weights, knots and trees may be is the
 * library's business; its messages are given the place of the node that they are about. */
#include "tools/json_trim.h"
#include "tools/args.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool check(const json_reader *r, const json_node *n, EPRegion region, EPStatus status)
{
    if (status == EP_OK) return true;
    if (status == EP_NO_MEMORY) return json_no_memory(r);
    return json_wrong(r, n, "%s", epGetRegionMessage(region));
}

/* Of an object with exactly one of `keys` besides, perhaps, "transform": which. False after a message. */
static bool find_key(const json_reader *r, const json_node *n, const char *what, const char *const *keys, size_t count,
                     size_t *found)
{
    size_t matches = 0;
    if (!json_is(r, n, JSON_OBJECT, what) || !json_only_keys(r, n, what, keys, count)) return false;
    for (size_t i = 0; i < count; ++i)
        if (json_object_get(n->json, keys[i]) && strcmp(keys[i], "transform")) *found = i, ++matches;
    if (matches == 1) return true;
    return json_wrong(r, n, matches ? "%s is only one thing" : "%s is nothing", what);
}

/* `count` lists of 2 numbers, or of 2 or 3 when `weights`: then 3 doubles each. NULL after a message. */
static double *read_points(const json_reader *r, const json_node *n, bool weights, size_t *count)
{
    if (!json_is(r, n, JSON_ARRAY, "a list of points")) return NULL;
    const size_t each = weights ? 3 : 2;
    *count = json_array_size(n->json);
    double *points = malloc((*count + 1) * each * sizeof *points);
    if (!points) return json_no_memory(r), NULL;
    for (size_t i = 0; i < *count; ++i) {
        const json_node e = json_element(n, i);
        double *p = points + each * i;
        const size_t numbers = json_array_size(e.json);
        const bool weighted = weights && numbers == 3;
        if (weights && json_is_array(e.json) && numbers != 2 && numbers != 3) {
            json_wrong(r, &e, "a point has 2 or 3 numbers, not %zu", numbers);
            return free(points), NULL;
        }
        if (!json_read_numbers(r, &e, "a point", weighted ? 3 : 2, p)) return free(points), NULL;
        if (weights && !weighted) p[2] = 1;
    }
    return points;
}

/* The segment for the reference; `each` numbers a point. */
static bool keep_segment(const json_reader *r, trim_shape *polygon, segment_kind kind, unsigned degree, size_t count,
                         const double *points, size_t each, const double *knots)
{
    return shape_add_points(polygon, kind, degree, knots, count, points, each) || json_no_memory(r);
}

static bool read_line(const json_reader *r, const json_node *n, EPRegion region, trim_shape *polygon)
{
    size_t count;
    double *points = read_points(r, n, false, &count);
    if (!points) return false;
    const bool done = check(r, n, region, epAddRegionLine(region, count, points)) &&
                      keep_segment(r, polygon, SEGMENT_LINE, 1, count, points, 2, NULL);
    free(points);
    return done;
}

static double *read_curve_points(const json_reader *r, const json_node *n, const char *what, size_t *count)
{
    const json_node points = json_member(n, "points");
    if (!points.json) return json_wrong(r, n, "%s has no 'points'", what), NULL;
    return read_points(r, &points, true, count);
}

static bool read_bezier(const json_reader *r, const json_node *n, EPRegion region, trim_shape *polygon)
{
    static const char *const keys[] = {"points"};
    static const char what[] = "a Bézier curve";
    if (!json_is(r, n, JSON_OBJECT, what) || !json_only_keys(r, n, what, keys, ARG_COUNT(keys))) return false;
    size_t count;
    double *points = read_curve_points(r, n, what, &count);
    if (!points) return false;
    const bool done = check(r, n, region, epAddRegionBezier(region, count, points)) &&
                      keep_segment(r, polygon, SEGMENT_BEZIER, (unsigned)count - 1, count, points, 3, NULL);
    free(points);
    return done;
}

static bool read_nurbs(const json_reader *r, const json_node *n, EPRegion region, trim_shape *polygon)
{
    static const char *const keys[] = {"degree", "knots", "points"};
    static const char what[] = "a spline";
    if (!json_is(r, n, JSON_OBJECT, what) || !json_only_keys(r, n, what, keys, ARG_COUNT(keys))) return false;
    const json_node d = json_member(n, "degree"), k = json_member(n, "knots");
    double degree;
    if (!d.json) return json_wrong(r, n, "%s has no 'degree'", what);
    if (!k.json) return json_wrong(r, n, "%s has no 'knots'", what);
    if (!json_read_number(r, &d, "a degree", &degree)) return false;
    if (degree != floor(degree) || !(degree >= 1 && degree <= EP_MAX_DEGREE))
        return json_wrong(r, &d, "a degree is %g, not a whole number from 1 to %d", degree, EP_MAX_DEGREE);
    size_t count = 0, knot_count = 0;
    double *points = read_curve_points(r, n, what, &count);
    double *knots = points ? json_read_list(r, &k, "'knots'", &knot_count) : NULL;
    const unsigned p = (unsigned)degree;
    const bool done = knots && check(r, n, region, epAddRegionNURBS(region, p, knot_count, knots, count, points)) &&
                      keep_segment(r, polygon, SEGMENT_NURBS, p, count, points, 3, knots);
    free(points);
    free(knots);
    return done;
}

static bool read_segment(const json_reader *r, const json_node *n, EPRegion region, trim_shape *polygon)
{
    static const char *const keys[] = {"line", "bezier", "bspline", "nurbs"};
    static bool (*const read[])(const json_reader *, const json_node *, EPRegion,
                                trim_shape *) = {read_line, read_bezier, read_nurbs, read_nurbs};
    size_t kind = 0;
    if (!find_key(r, n, "a segment", keys, ARG_COUNT(keys), &kind)) return false;
    const json_node value = json_member(n, keys[kind]);
    return read[kind](r, &value, region, polygon);
}

/* Each element of a list. */
static bool read_all(const json_reader *r, const json_node *n, const char *what, EPRegion region, trim_shape *parent,
                     bool (*read)(const json_reader *, const json_node *, EPRegion, trim_shape *))
{
    if (!json_is(r, n, JSON_ARRAY, what)) return false;
    for (size_t i = 0; i < json_array_size(n->json); ++i) {
        const json_node e = json_element(n, i);
        if (!read(r, &e, region, parent)) return false;
    }
    return true;
}

/* A square, a circle: nothing is to be said of them. */
static bool check_empty(const json_reader *r, const json_node *n, const char *what)
{
    return json_is(r, n, JSON_OBJECT, what) && json_only_keys(r, n, what, NULL, 0);
}

static bool read_polygon(const json_reader *r, const json_node *n, EPRegion region, trim_shape *polygon)
{
    static const char *const keys[] = {"segments"};
    if (!json_is(r, n, JSON_OBJECT, "a polygon") || !json_only_keys(r, n, "a polygon", keys, ARG_COUNT(keys)))
        return false;
    const json_node segments = json_member(n, "segments");
    if (!segments.json) return json_wrong(r, n, "a polygon has no 'segments'");
    return read_all(r, &segments, "'segments'", region, polygon, read_segment);
}

/* The node for the reference. NULL after a message. */
static trim_shape *keep_shape(const json_reader *r, trim_shape *parent, shape_kind kind, const double *transform)
{
    trim_shape *s = shape_new(kind);
    if (s && transform) {
        s->transformed = true;
        memcpy(s->transform, transform, sizeof s->transform);
    }
    if (shape_add(parent, s)) return s;
    json_no_memory(r);
    return NULL;
}

/* A loop that is written without the word "polygon", which it has to be: {"segments": [...]}. */
static bool read_bare_loop(const json_reader *r, const json_node *n, EPRegion region, trim_shape *parent)
{
    trim_shape *shape = keep_shape(r, parent, SHAPE_POLYGON, NULL);
    return shape && check(r, n, region, epBeginRegion(region, EP_POLYGON, NULL)) && read_polygon(r, n, region, shape) &&
           check(r, n, region, epEndRegion(region));
}

static bool read_region(const json_reader *r, const json_node *n, EPRegion region, trim_shape *parent);

static bool read_loop(const json_reader *r, const json_node *n, EPRegion region, trim_shape *parent)
{
    return (json_object_get(n->json, "segments") ? read_bare_loop : read_region)(r, n, region, parent);
}

static bool read_region(const json_reader *r, const json_node *n, EPRegion region, trim_shape *parent)
{
    /* in the order of shape_kind, and those before "square" in that of EPRegionKind */
    static const char *const keys[] = {"union",   "intersection", "difference", "loops",
                                       "polygon", "square",       "circle",     "transform"};
    enum { SQUARE = EP_POLYGON + 1 };
    size_t kind = 0;
    if (!find_key(r, n, "a region", keys, ARG_COUNT(keys), &kind)) return false;
    const json_node value = json_member(n, keys[kind]), t = json_member(n, "transform");
    double six[6];
    if (t.json && !json_read_numbers(r, &t, "a transform", 6, six)) return false;
    const double *transform = t.json ? six : NULL;
    trim_shape *shape = keep_shape(r, parent, (shape_kind)kind, transform);
    if (!shape) return false;
    if (kind >= SQUARE) {
        if (!check_empty(r, &value, kind == SQUARE ? "a square" : "a circle")) return false;
        return check(r, n, region,
                     kind == SQUARE ? epAddRegionSquare(region, transform) : epAddRegionCircle(region, transform));
    }
    if (!check(r, n, region, epBeginRegion(region, (EPRegionKind)kind, transform))) return false;
    if (kind == EP_POLYGON
            ? !read_polygon(r, &value, region, shape)
            : !read_all(r, &value, keys[kind], region, shape, kind == EP_LOOPS ? read_loop : read_region))
        return false;
    return check(r, n, region, epEndRegion(region));
}

bool json_read_trim(const json_reader *r, const json_node *n, EPRegion *region, trim_shape **shape)
{
    *region = epNewRegion();
    *shape = shape_new(SHAPE_UNION); /* of one */
    if (!*region || !*shape) json_no_memory(r);
    else if (read_region(r, n, *region, *shape)) return true;
    epReleaseRegion(*region);
    shape_free(*shape);
    return false;
}
