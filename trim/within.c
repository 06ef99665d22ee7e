/* within.c - see within.h.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A contour's curves that lie on the far side of one of the lines that bound the part can be pulled straight there
 * without passing over any of its points, which then have as many crossings on their way out as before, or two less or
 * more. So of a chain of curves that are all beyond one line the two ends are enough. */
#include "trim/within.h"

#include <string.h>

/* A chain of curves that was not written yet: from its beginning to its end all is beyond the lines in `beyond`. */
typedef struct chain {
    ep_point2 from, to;
    unsigned beyond; /* 0: there is none */
} chain;

typedef struct writer {
    ep_region_view view;
    const double *transform;
    bool triangle;
    ep_region *out;
    ep_message *message;
    chain waiting;
} writer;

/* Beyond which of the part's lines is (x, y)? */
static unsigned lines_before(const writer *w, double x, double y)
{
    const double *t = w->transform, s = t[0] * x + t[2] * y + t[4], u = t[1] * x + t[3] * y + t[5];
    if (w->triangle) return (s <= 0) | (unsigned)(u <= 0) << 1 | (unsigned)(s + u >= 1) << 2;
    return (s <= 0) | (unsigned)(u <= 0) << 1 | (unsigned)(s >= 1) << 2 | (unsigned)(u >= 1) << 3;
}

/* ... all of a curve, which is in the hull of its points. */
static unsigned lines_before_curve(const writer *w, const ep_region_curve *c)
{
    unsigned beyond = lines_before(w, c->end[0][0], c->end[0][1]) & lines_before(w, c->end[1][0], c->end[1][1]);
    for (unsigned i = 1; i < c->degree && beyond; ++i) {
        const double *h = w->view.points[c->first + i];
        beyond &= lines_before(w, h[0] / h[2], h[1] / h[2]);
    }
    return beyond;
}

static EPStatus write_line(writer *w, const ep_point2 from, const ep_point2 to)
{
    ep_point2 ends[2];
    memcpy(ends[0], from, sizeof ends[0]);
    memcpy(ends[1], to, sizeof ends[1]);
    return ep_region_line(w->out, 2, (const ep_point2 *)ends, w->message);
}

static EPStatus write_curve(writer *w, const ep_region_curve *c)
{
    if (c->degree == 1) return write_line(w, c->end[0], c->end[1]);
    ep_point2w p[EP_CURVE_POINTS];
    for (unsigned i = 0; i <= c->degree; ++i) {
        const double *h = w->view.points[c->first + i];
        p[i][0] = h[0] / h[2], p[i][1] = h[1] / h[2], p[i][2] = h[2];
    }
    memcpy(p[0], c->end[0], sizeof c->end[0]);
    memcpy(p[c->degree], c->end[1], sizeof c->end[1]);
    return ep_region_bezier(w->out, c->degree + 1, (const ep_point2w *)p, w->message);
}

static EPStatus write_waiting(writer *w)
{
    if (!w->waiting.beyond) return EP_OK;
    w->waiting.beyond = 0;
    return write_line(w, w->waiting.from, w->waiting.to);
}

static EPStatus add_curve(writer *w, const ep_region_curve *c)
{
    const unsigned beyond = lines_before_curve(w, c);
    if (w->waiting.beyond & beyond) {
        w->waiting.beyond &= beyond;
        memcpy(w->waiting.to, c->end[1], sizeof c->end[1]);
        return EP_OK;
    }
    const EPStatus s = write_waiting(w);
    if (s || !beyond) return s ? s : write_curve(w, c);
    memcpy(w->waiting.from, c->end[0], sizeof c->end[0]);
    memcpy(w->waiting.to, c->end[1], sizeof c->end[1]);
    w->waiting.beyond = beyond;
    return EP_OK;
}

static bool follows(const ep_region_curve *before, const ep_region_curve *c)
{
    return before->end[1][0] == c->end[0][0] && before->end[1][1] == c->end[0][1];
}

/* The first curve from c on that does not begin where the one before it ends. */
static const ep_region_curve *end_of_polygon(const ep_region_curve *c, const ep_region_curve *end)
{
    const ep_region_curve *before = c;
    while (c < end && (c == before || follows(before, c))) before = c++;
    return c;
}

static EPStatus write_polygon(writer *w, const ep_region_curve *c, const ep_region_curve *end, const double *transform)
{
    static const ep_point2 nowhere = {0, 0};
    EPStatus s = ep_region_begin(w->out, EP_REGION_POLYGON, transform, w->message);
    if (!s && c == end) s = write_line(w, nowhere, nowhere); /* what has no extent has no inside */
    for (; !s && c < end; ++c) s = add_curve(w, c);
    if (!s) s = write_waiting(w);
    return s ? s : ep_region_end(w->out, w->message);
}

/* As one polygon, if it is one: loops would be a level deeper. */
static EPStatus write_contour(writer *w, const ep_region_node *n, const double *transform)
{
    const ep_region_curve *c = w->view.curves + n->curves, *end = c + n->curve_count, *next = end_of_polygon(c, end);
    if (next == end) return write_polygon(w, c, end, transform);
    EPStatus s = ep_region_begin(w->out, EP_REGION_LOOPS, transform, w->message);
    for (; !s && c < end; c = next, next = end_of_polygon(c, end)) s = write_polygon(w, c, next, NULL);
    return s ? s : ep_region_end(w->out, w->message);
}

/* Node i and what is below it. */
static EPStatus write_node(writer *w, uint32_t i)
{
    const ep_region_node *n = &w->view.nodes[i];
    const double *transform = i == 0 ? w->transform : NULL;
    if (n->kind >= EP_REGION_LOOPS) return write_contour(w, n, transform);
    EPStatus s = ep_region_begin(w->out, n->kind, transform, w->message);
    for (uint32_t child = i + 1; !s && child < n->next; child = w->view.nodes[child].next) s = write_node(w, child);
    return s ? s : ep_region_end(w->out, w->message);
}

EPStatus ep_region_within(const ep_region *region, const double transform[6], bool triangle, ep_region **out,
                          ep_message *m)
{
    *out = NULL;
    writer w = {.transform = transform, .triangle = triangle, .message = m};
    EPStatus s = ep_region_look(region, &w.view, m);
    if (s) return s;
    w.out = ep_region_new();
    if (!w.out) return ep_fail(m, EP_NO_MEMORY, "no memory for a trim region");
    s = write_node(&w, 0);
    if (s) ep_region_free(w.out);
    else *out = w.out;
    return s;
}
