/* region.c - see region.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Everything becomes Bézier curves in the domain's coordinates at once: transforms are applied to control points, and
 * splines are cut at their knots. */
#include "trim/region.h"
#include "embree_patch/knots.h"

#include <string.h>

typedef struct level {
    double transform[6]; /* to the domain */
    uint32_t node;
    uint32_t children;
    ep_region_kind kind;
} level;

struct ep_region {
    ep_region_node *nodes;
    ep_region_curve *curves;
    ep_point2h *points;
    size_t node_count, curve_count, point_count, node_room, curve_room, point_room;
    double scale;
    level *stack; /* what has been begun and not ended */
    size_t stack_room;
    unsigned depth;
    bool complete;
    /* the polygon that is being written */
    ep_point2 start, at;
    size_t segments;
};

static const char *const kind_name[] = {"union", "intersection", "difference", "loops", "polygon", "square", "circle"};

ep_region *ep_region_new(void)
{
    ep_region *r = ep_alloc(1, sizeof *r);
    if (r) memset(r, 0, sizeof *r);
    return r;
}

void ep_region_free(ep_region *r)
{
    if (!r) return;
    ep_free(r->nodes);
    ep_free(r->curves);
    ep_free(r->points);
    ep_free(r->stack);
    ep_free(r);
}

size_t ep_region_bytes(const ep_region *r)
{
    return sizeof *r + r->node_room * sizeof *r->nodes + r->curve_room * sizeof *r->curves +
           r->point_room * sizeof *r->points + r->stack_room * sizeof *r->stack;
}

static EPStatus no_memory(ep_message *m)
{
    return ep_fail(m, EP_NO_MEMORY, "no memory for a trim region");
}

static bool is_contour(ep_region_kind k)
{
    return k >= EP_REGION_LOOPS;
}

/* The transform of a node inside those around it. */
static EPStatus find_transform(const ep_region *r, const double t[6], double out[6], ep_message *m)
{
    static const double identity[6] = {1, 0, 0, 1, 0, 0};
    const double *o = r->depth ? r->stack[r->depth - 1].transform : identity;
    if (!t) {
        memcpy(out, o, sizeof identity);
        return EP_OK;
    }
    for (int i = 0; i < 6; i += 2) {
        const double shift = i == 4;
        out[i] = o[0] * t[i] + o[2] * t[i + 1] + shift * o[4];
        out[i + 1] = o[1] * t[i] + o[3] * t[i + 1] + shift * o[5];
    }
    for (int i = 0; i < 6; ++i)
        if (!isfinite(t[i]) || !isfinite(out[i]))
            return ep_fail(m, EP_BAD_DATA, "number %d of the transform is %g, too large or not finite", i + 1, t[i]);
    return EP_OK;
}

/* Is there a place for a node of this kind? */
static EPStatus check_place(const ep_region *r, ep_region_kind kind, ep_message *m)
{
    if (r->complete) return ep_fail(m, EP_INVALID, "a %s after the end of the region", kind_name[kind]);
    if (r->depth == EP_REGION_DEPTH)
        return ep_fail(m, EP_BAD_DATA, "regions are nested more than %d deep", EP_REGION_DEPTH);
    if (!r->depth) return EP_OK;
    const level *l = &r->stack[r->depth - 1];
    if (l->kind == EP_REGION_POLYGON || (l->kind == EP_REGION_LOOPS && kind != EP_REGION_POLYGON))
        return ep_fail(m, EP_INVALID, "a %s cannot be a part of %s", kind_name[kind],
                       l->kind == EP_REGION_LOOPS ? "loops" : "a polygon");
    if (l->kind == EP_REGION_DIFFERENCE && l->children == 2)
        return ep_fail(m, EP_BAD_DATA, "a difference of more than two regions");
    return EP_OK;
}

EPStatus ep_region_begin(ep_region *r, ep_region_kind kind, const double transform[6], ep_message *m)
{
    if (kind > EP_REGION_POLYGON) return ep_fail(m, EP_INVALID, "a %s has no parts", kind_name[kind]);
    EPStatus s = check_place(r, kind, m);
    if (s) return s;
    if (!ep_reserve((void **)&r->stack, &r->stack_room, r->depth, 1, sizeof *r->stack)) return no_memory(m);
    level *l = &r->stack[r->depth];
    if ((s = find_transform(r, transform, l->transform, m))) return s;
    const bool part = r->depth && l[-1].kind == EP_REGION_LOOPS;
    if (!part) {
        if (r->node_count >= UINT32_MAX) return ep_fail(m, EP_BAD_DATA, "too many regions");
        if (!ep_reserve((void **)&r->nodes, &r->node_room, r->node_count, 1, sizeof *r->nodes)) return no_memory(m);
        r->nodes[r->node_count++] = (ep_region_node){kind, 0, (uint32_t)r->curve_count, 0};
    }
    if (r->depth) ++l[-1].children;
    l->node = (uint32_t)r->node_count - 1;
    l->children = 0;
    l->kind = kind;
    r->segments = 0;
    ++r->depth;
    return EP_OK;
}

/* Curves are counted in 30 bits further on. */
static EPStatus reserve(ep_region *r, size_t curves, size_t points, ep_message *m)
{
    if (curves > (1u << 30) - r->curve_count) return ep_fail(m, EP_BAD_DATA, "too many trim curves");
    if (!ep_reserve((void **)&r->curves, &r->curve_room, r->curve_count, curves, sizeof *r->curves) ||
        !ep_reserve((void **)&r->points, &r->point_room, r->point_count, points, sizeof *r->points))
        return no_memory(m);
    return EP_OK;
}

/* What follows needs no memory: reserve() was called. */

static void put_curve(ep_region *r, unsigned degree, const ep_point2 from, const ep_point2 to, const ep_point2h *points)
{
    ep_region_curve *c = &r->curves[r->curve_count++];
    memcpy(c->end[0], from, sizeof(ep_point2));
    memcpy(c->end[1], to, sizeof(ep_point2));
    c->first = r->point_count;
    c->degree = degree;
    memcpy(r->points + r->point_count, points, (degree + 1) * sizeof *points);
    r->point_count += degree + 1;
}

static void put_line(ep_region *r, const ep_point2 from, const ep_point2 to)
{
    put_curve(r, 1, from, to, (const ep_point2h[]){{from[0], from[1], 1}, {to[0], to[1], 1}});
}

/* Joins the next segment to what there is. */
static void go_to(ep_region *r, const ep_point2 p)
{
    if (r->segments == 0) memcpy(r->start, p, sizeof r->start);
    else if (p[0] != r->at[0] || p[1] != r->at[1]) put_line(r, r->at, p);
    memcpy(r->at, p, sizeof r->at);
}

static EPStatus end_polygon(ep_region *r, ep_message *m)
{
    if (!r->segments) return ep_fail(m, EP_BAD_DATA, "a polygon needs at least one segment");
    EPStatus s = reserve(r, 1, 2, m);
    if (s) return s;
    go_to(r, r->start);
    return EP_OK;
}

EPStatus ep_region_end(ep_region *r, ep_message *m)
{
    if (!r->depth) return ep_fail(m, EP_INVALID, "nothing to end");
    level *l = &r->stack[r->depth - 1];
    if (l->kind == EP_REGION_POLYGON) {
        EPStatus s = end_polygon(r, m);
        if (s) return s;
    } else if (l->kind == EP_REGION_DIFFERENCE && l->children != 2) {
        return ep_fail(m, EP_BAD_DATA, "a difference needs two regions, not %u", l->children);
    } else if (!l->children && l->kind == EP_REGION_LOOPS) {
        return ep_fail(m, EP_BAD_DATA, "loops of nothing");
    } else if (!l->children) {
        return ep_fail(m, EP_BAD_DATA, "%s %s of nothing", l->kind == EP_REGION_INTERSECTION ? "an" : "a",
                       kind_name[l->kind]);
    }
    --r->depth;
    if (r->depth && l[-1].kind == EP_REGION_LOOPS) return EP_OK;
    ep_region_node *node = &r->nodes[l->node];
    node->next = (uint32_t)r->node_count;
    if (is_contour(l->kind)) node->curve_count = (uint32_t)(r->curve_count - node->curves);
    r->complete = !r->depth;
    if (r->complete) {
        ep_free(r->stack);
        r->stack = NULL;
        r->stack_room = 0;
    }
    return EP_OK;
}

static EPStatus check_point(const double *p, size_t i, ep_message *m)
{
    for (int c = 0; c < 2; ++c)
        if (!isfinite(p[c])) return ep_fail(m, EP_BAD_DATA, "%c of point %zu is %g", "xy"[c], i + 1, p[c]);
    return EP_OK;
}

/* Transforms a point into the domain. */
static EPStatus place_point(ep_region *r, const double *p, size_t i, ep_point2 out, ep_message *m)
{
    const double *t = r->stack[r->depth - 1].transform;
    out[0] = t[0] * p[0] + t[2] * p[1] + t[4];
    out[1] = t[1] * p[0] + t[3] * p[1] + t[5];
    /* Products of differences are formed later; they must not overflow. */
    const double most = fmax(fabs(out[0]), fabs(out[1]));
    if (!(most < 0x1p500))
        return ep_fail(m, EP_BAD_DATA, "point %zu lies too far out, at (%g, %g)", i + 1, out[0], out[1]);
    r->scale = fmax(r->scale, most);
    return EP_OK;
}

/* Checks and transforms points; weights are divided by the largest. `out` has the type of `points`. */
static EPStatus place_points(ep_region *r, size_t count, const ep_point2w *points, ep_point2w *out, ep_message *m)
{
    double least = INFINITY, most = 0;
    for (size_t i = 0; i < count; ++i) {
        const double w = points[i][2];
        EPStatus s = check_point(points[i], i, m);
        if (s) return s;
        if (!(w > 0) || !isfinite(w))
            return ep_fail(m, EP_BAD_DATA, "weight of point %zu is %g; weights are positive", i + 1, w);
        least = fmin(least, w), most = fmax(most, w);
    }
    /* products of two weights and a coordinate must not vanish */
    if (least / most < 0x1p-200) return ep_fail(m, EP_BAD_DATA, "weights from %g to %g differ too much", least, most);
    for (size_t i = 0; i < count; ++i) {
        EPStatus s = place_point(r, points[i], i, out[i], m);
        if (s) return s;
        out[i][2] = points[i][2] / most;
    }
    return EP_OK;
}

static EPStatus check_segment(const ep_region *r, ep_message *m)
{
    if (!r->depth || r->stack[r->depth - 1].kind != EP_REGION_POLYGON)
        return ep_fail(m, EP_INVALID, "a segment outside of a polygon");
    return EP_OK;
}

EPStatus ep_region_line(ep_region *r, size_t count, const ep_point2 *points, ep_message *m)
{
    EPStatus s = check_segment(r, m);
    if (s) return s;
    if (count < 2) return ep_fail(m, EP_BAD_DATA, "a line needs at least two points, not %zu", count);
    const double scale = r->scale;
    for (size_t i = 0; i < count; ++i) {
        ep_point2 p;
        if ((s = check_point(points[i], i, m)) || (s = place_point(r, points[i], i, p, m))) {
            r->scale = scale;
            return s;
        }
    }
    if (count > 1u << 30) return ep_fail(m, EP_BAD_DATA, "too many trim curves");
    if ((s = reserve(r, count, 2 * count, m))) return s;
    for (size_t i = 0; i < count; ++i) {
        ep_point2 p;
        place_point(r, points[i], i, p, m);
        go_to(r, p);
        ++r->segments;
    }
    return EP_OK;
}

static void homogeneous(const ep_point2w p, ep_point2h out)
{
    out[0] = p[0] * p[2], out[1] = p[1] * p[2], out[2] = p[2];
}

/* Puts the spans of a NURBS curve; the points are in the domain. `knots` runs from 0 to count+degree. */
static void put_spline(ep_region *r, unsigned degree, const double *knots, size_t count, const ep_point2w *points,
                       const ep_point2h *h)
{
    bool begun = false;
    for (size_t i = degree; (i = ep_knots_next_span(knots, count, i)) < count; ++i) {
        ep_point2h span[EP_CURVE_POINTS];
        ep_knots_bezier(h[0], 3, 3, degree, knots, i, span[0], 3);
        ep_point2 from, to;
        for (int c = 0; c < 2; ++c) {
            /* a clamped end is a control point */
            from[c] = knots[i - degree + 1] == knots[i] ? points[i - degree][c] : span[0][c] / span[0][2];
            to[c] = knots[i + degree] == knots[i + 1] ? points[i][c] : span[degree][c] / span[degree][2];
        }
        if (!begun) go_to(r, from);
        begun = true;
        put_curve(r, degree, r->at, to, span);
        memcpy(r->at, to, sizeof to);
    }
    ++r->segments;
}

/* A curve and, at most, the line that leads to its beginning. */
static EPStatus put_segment(ep_region *r, unsigned degree, const double *knots, size_t count, const ep_point2w *points,
                            ep_message *m)
{
    const double scale = r->scale;
    const size_t spans = count - degree;
    ep_point2w *placed = ep_alloc(count, sizeof *placed);
    ep_point2h *h = ep_alloc(count, sizeof *h);
    EPStatus s = placed && h ? EP_OK : no_memory(m);
    if (!s) s = place_points(r, count, points, placed, m);
    if (!s) s = reserve(r, spans + 1, spans * (degree + 1) + 2, m);
    if (!s) {
        for (size_t i = 0; i < count; ++i) homogeneous(placed[i], h[i]);
        put_spline(r, degree, knots, count, placed, h);
    } else {
        r->scale = scale;
    }
    ep_free(placed);
    ep_free(h);
    return s;
}

EPStatus ep_region_bezier(ep_region *r, size_t count, const ep_point2w *points, ep_message *m)
{
    EPStatus s = check_segment(r, m);
    if (s) return s;
    if (count < 2 || count > EP_CURVE_POINTS)
        return ep_fail(m, EP_BAD_DATA, "a Bézier curve has 2 to %d points, not %zu", EP_CURVE_POINTS, count);
    double knots[2 * EP_CURVE_POINTS];
    for (size_t i = 0; i < 2 * count; ++i) knots[i] = i >= count;
    return put_segment(r, (unsigned)count - 1, knots, count, points, m);
}

EPStatus ep_region_nurbs(ep_region *r, unsigned degree, size_t knot_count, const double *knots, size_t count,
                         const ep_point2w *points, ep_message *m)
{
    EPStatus s = check_segment(r, m);
    /* more repetitions than the degree would tear the curve */
    if (!s) s = ep_knots_check(degree, knot_count, knots, count, degree, m);
    if (!s && count > 1u << 30) s = ep_fail(m, EP_BAD_DATA, "too many trim curves");
    return s ? s : put_segment(r, degree, knots, count, points, m);
}

static EPStatus put_primitive(ep_region *r, ep_region_kind kind, const double transform[6], size_t count,
                              const ep_point2w (*curves)[3], unsigned degree, ep_message *m)
{
    EPStatus s = check_place(r, kind, m);
    if (s) return s;
    const size_t nodes = r->node_count, n_curves = r->curve_count, n_points = r->point_count;
    const double scale = r->scale;
    if ((s = ep_region_begin(r, EP_REGION_POLYGON, transform, m))) return s;
    const double knots[6] = {0, 0, degree == 1 ? 1 : 0, 1, 1, 1};
    for (size_t i = 0; i < count && !s; ++i) s = put_segment(r, degree, knots, degree + 1, curves[i], m);
    if (!s) s = ep_region_end(r, m);
    if (!s) {
        r->nodes[nodes].kind = kind;
        return EP_OK;
    }
    --r->depth;
    if (r->depth) --r->stack[r->depth - 1].children;
    r->node_count = nodes, r->curve_count = n_curves, r->point_count = n_points;
    r->scale = scale;
    return s;
}

EPStatus ep_region_square(ep_region *r, const double transform[6], ep_message *m)
{
    static const ep_point2w side[4][3] = {
        {{0, 0, 1}, {1, 0, 1}}, {{1, 0, 1}, {1, 1, 1}}, {{1, 1, 1}, {0, 1, 1}}, {{0, 1, 1}, {0, 0, 1}}};
    return put_primitive(r, EP_REGION_SQUARE, transform, 4, side, 1, m);
}

EPStatus ep_region_circle(ep_region *r, const double transform[6], ep_message *m)
{
    static const double c = 0.70710678118654752440; /* cos 45°: the middle weight of a quarter */
    const ep_point2w quarter[4][3] = {{{1, 0, 1}, {1, 1, c}, {0, 1, 1}},
                                      {{0, 1, 1}, {-1, 1, c}, {-1, 0, 1}},
                                      {{-1, 0, 1}, {-1, -1, c}, {0, -1, 1}},
                                      {{0, -1, 1}, {1, -1, c}, {1, 0, 1}}};
    return put_primitive(r, EP_REGION_CIRCLE, transform, 4, quarter, 2, m);
}

EPStatus ep_region_look(const ep_region *r, ep_region_view *view, ep_message *m)
{
    if (!r->complete)
        return ep_fail(m, EP_INVALID, "%s", r->depth ? "a region was begun and not ended" : "the region is empty");
    *view = (ep_region_view){r->nodes, r->curves, r->points, r->node_count, r->curve_count, r->point_count, r->scale};
    return EP_OK;
}
